# SPDX-License-Identifier: Apache-2.0
"""The paper's component-wise initialization on hand-made pictures, steps a-d, and the authors' program's variant."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import label
from skimage import measure

from livecl.layering.componentwise.components import component_places, components, labels_of
from livecl.options import Options

FloatArray = NDArray[np.float64]
PAPER, RELEASED = Options.paper(), Options.released()


def _pictures(difference: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a target and an image (H, W, 3) whose summed absolute difference is this, in the red channel alone."""
    image = np.zeros((*difference.shape, 3))
    target = image.copy()
    target[..., 0] = difference
    return target, image


def _rectangles(size: tuple[int, int], *parts: tuple[slice, slice, float]) -> FloatArray:
    difference = np.zeros(size)
    for rows, columns, value in parts:
        difference[rows, columns] = value
    return difference


def _centers(difference: FloatArray, count: int, options: Options = PAPER) -> list[list[float]]:
    return [place.center.tolist() for place in component_places(*_pictures(difference), count, options)]


def test_difference_is_summed_over_the_channels() -> None:
    # Three channels off by 0.05 make 0.15, above the threshold of 0.1; one channel off by 0.09 does not.
    target = np.zeros((8, 9, 3))
    image = target.copy()
    target[1:3, 1:3] = 0.05
    image[5:8, 4:9, 1] = 0.09
    places = component_places(target, image, 1, PAPER)
    assert places[0].mask is not None and np.array_equal(places[0].mask, target[..., 0] > 0)
    assert places[0].center.tolist() == [2.0, 2.0]


def test_differences_of_both_signs_do_not_cancel() -> None:
    target, image = np.full((6, 6, 3), 0.5), np.full((6, 6, 3), 0.5)
    image[2:4, 2:4] += (0.2, -0.2, 0.0)
    (place,) = component_places(target, image, 1, PAPER)
    assert place.mask is not None and place.mask.sum() == 4


def test_differences_under_the_threshold_are_dropped() -> None:
    difference = _rectangles((6, 8), (slice(0, 3), slice(0, 8), 0.0999), (slice(4, 6), slice(1, 3), 0.1))
    labels, bins = components(difference, PAPER)
    assert np.array_equal(labels > 0, difference == 0.1) and np.array_equal(bins > 0, difference == 0.1)
    higher = Options.paper(color_threshold=0.2)
    assert not components(difference, higher)[0].any() and not components(difference, higher)[1].any()
    assert components(difference, Options.paper(color_threshold=0.05))[0].astype(bool).sum() == 28


def test_pixels_that_touch_in_a_corner_are_apart() -> None:
    labels, _ = components(0.5 * np.eye(5), PAPER)
    assert sorted(labels[labels > 0]) == [1, 2, 3, 4, 5]
    cross = 0.5 * (np.abs(np.indices((5, 5)) - 2).sum(axis=0) <= 1)
    assert components(cross, PAPER)[0].max() == 1


def test_bins_are_about_equally_full() -> None:
    # 4000 different numbers in 200 bins: 20 each, give or take one where a quantile falls between two numbers.
    # Their spread does not matter: most are small here.
    difference = 0.1 + 3 * np.random.default_rng(0).uniform(size=(50, 80)) ** 4
    assert np.unique(difference).size == difference.size
    _, bins = components(difference, PAPER)
    populations = np.bincount(bins.ravel())[1:]
    assert len(populations) == 200
    assert populations.min() >= 19 and populations.max() <= 21
    assert np.all(np.diff(bins.ravel()[np.argsort(difference, axis=None)]) >= 0)


def test_the_number_of_bins_is_an_option() -> None:
    difference = np.random.default_rng(1).uniform(0.2, 3, size=(20, 30))
    _, bins = components(difference, Options.paper(bins=3))
    assert np.bincount(bins.ravel()).tolist() == [0, 200, 200, 200]
    assert np.array_equal(np.unique(components(difference, Options.paper(bins=1))[1]), [1])


def test_only_what_is_above_the_threshold_is_shared_among_the_bins() -> None:
    difference = np.zeros((20, 30))
    difference[:10] = np.random.default_rng(1).uniform(0.2, 3, size=(10, 30))
    _, bins = components(difference, Options.paper(bins=3))
    assert np.bincount(bins.ravel()).tolist() == [300, 100, 100, 100]


def test_components_are_numbered_by_their_first_pixels() -> None:
    """They are those of scikit-image, which the authors' program uses, through any turns of a component."""
    spiral = np.zeros((12, 9), np.int64)
    spiral[::2], spiral[1::4, -1], spiral[3::4, 0] = 1, 1, 1
    random = np.random.default_rng(3).integers(0, 3, (30, 40))
    for bins in (spiral, random, random.T.copy(), np.ones((1, 1), np.int64)):
        np.testing.assert_array_equal(labels_of(bins), measure.label(bins, background=0, connectivity=1))


def test_components_are_those_of_the_bins() -> None:
    difference = np.random.default_rng(2).uniform(0, 1, size=(24, 31))
    labels, bins = components(difference, Options.paper(bins=4))
    for value in range(1, 5):
        expected, count = label(bins == value)  # SciPy's default structure is that of 4 neighbours
        found = np.unique(labels[bins == value])
        assert len(found) == count
        for component in found:
            assert len(np.unique(expected[labels == component])) == 1


@pytest.mark.parametrize("height", [3, 30])
@pytest.mark.parametrize("widths", [(6, 6), (31, 42), (9, 13, 31)])
def test_flat_parts_of_different_error_that_touch_are_apart(widths: tuple[int, ...], height: int) -> None:
    # 200 bins have room for two or three numbers.
    difference = np.repeat(0.3 * np.arange(1, len(widths) + 1), widths)[None, :] * np.ones((height, 1))
    _, bins = components(difference, PAPER)
    assert len(np.unique(bins)) == len(widths)
    places = component_places(*_pictures(difference), len(widths), PAPER)
    middles = np.cumsum(widths) - np.array(widths) / 2
    assert sorted(place.center[0] for place in places) == middles.tolist()


def test_the_largest_components_come_first() -> None:
    difference = _rectangles(
        (20, 30),
        (slice(1, 4), slice(1, 5), 0.9),  # 12 pixels
        (slice(6, 16), slice(2, 12), 0.3),  # 100
        (slice(3, 9), slice(15, 25), 0.5),  # 60
        (slice(17, 19), slice(20, 21), 2.0),  # 2
    )
    expected = [[7.0, 11.0], [20.0, 6.0], [3.0, 2.5], [20.5, 18.0]]
    assert _centers(difference, 4) == expected
    assert _centers(difference, 2) == expected[:2]


def test_center_of_mass_of_a_lopsided_component() -> None:
    difference = _rectangles((12, 12), (slice(2, 9), slice(2, 5), 0.4), (slice(6, 9), slice(5, 10), 0.4))
    members = np.argwhere(difference > 0)
    assert difference[6, 4] > 0
    (place,) = component_places(*_pictures(difference), 1, PAPER)
    np.testing.assert_allclose(place.center, members.mean(axis=0)[::-1] + 0.5, rtol=1e-14)
    assert place.pixel.tolist() == np.floor(place.center[::-1]).tolist()


def test_a_ring_gets_its_own_pixel_nearest_to_its_center() -> None:
    rows, columns = np.indices((21, 25))
    distance = np.hypot(rows - 10, columns - 12)
    difference = np.where((distance > 5.2) & (distance < 8), 0.7, 0)
    difference[10, 6] = 0  # the nearest of the four pixels on the axes is then one of three
    (place,) = component_places(*_pictures(difference), 1, PAPER)
    assert difference[tuple(place.pixel)] > 0
    members = np.argwhere(difference > 0)
    away = np.hypot(*(members - members.mean(axis=0)).T)
    assert np.hypot(*(place.pixel - members.mean(axis=0))) == pytest.approx(away.min())
    assert np.array_equal(place.center, place.pixel[::-1] + 0.5)


def test_what_the_components_leave_starts_at_the_largest_errors() -> None:
    # Nothing reaches 0.1. The largest error is first; the next is the largest that is a circle's diameter away.
    difference = np.zeros((20, 40))
    difference[10, 20], difference[10, 22], difference[4, 35], difference[17, 3] = 0.09, 0.08, 0.05, 0.06
    assert _centers(difference, 3) == [[20.5, 10.5], [3.5, 17.5], [35.5, 4.5]]
    assert all(place.mask is None for place in component_places(*_pictures(difference), 3, PAPER))


def test_places_for_the_rest_keep_away_from_the_components() -> None:
    difference = np.zeros((20, 40))
    difference[5:8, 5:8], difference[6, 9], difference[15, 30] = 0.9, 0.09, 0.05
    places = component_places(*_pictures(difference), 2, PAPER)
    assert [place.center.tolist() for place in places] == [[6.5, 6.5], [30.5, 15.5]]


@pytest.mark.parametrize("value", [0.0, 0.05])
def test_more_paths_than_there_is_room_for(value: float) -> None:
    # A picture that is equally right everywhere, and smaller than a circle.
    places = component_places(*_pictures(np.full((3, 4), value)), 30, PAPER)
    assert len(places) == 30
    for place in places:
        assert 0 <= place.pixel[0] < 3 and 0 <= place.pixel[1] < 4
        assert np.array_equal(place.center, place.pixel[::-1] + 0.5)


def test_nothing_is_random() -> None:
    difference = np.random.default_rng(5).uniform(0, 0.4, size=(16, 16))
    assert _centers(difference, 20) == _centers(difference, 20)


def test_released_takes_the_squared_difference() -> None:
    # An L1 difference of 0.3 is 0.09 squared in one channel, under the threshold; 0.32 is 0.1024, above it.
    difference = _rectangles((12, 12), (slice(0, 8), slice(0, 8), 0.3), (slice(9, 12), slice(9, 12), 0.32))
    (place,) = component_places(*_pictures(difference), 1, RELEASED)
    assert place.center.tolist() == [10.5, 10.5]
    assert place.mask is not None and place.mask.sum() == 9
    # Three channels of 0.2 make 0.12: the sum is of the squares, and not the square of the sum (0.36) or of one (0.04).
    image, target = np.zeros((6, 6, 3)), np.zeros((6, 6, 3))
    target[1:4, 1:4] = 0.2
    (place,) = component_places(target, image, 1, RELEASED)
    assert place.mask is not None and place.mask.sum() == 9
    (place,) = component_places(target * 0.9, image, 1, RELEASED)  # 0.0972
    assert place.mask is None


def test_released_takes_the_fullest_bin_and_then_its_largest_component() -> None:
    # 9 + 4 + 4 = 17 pixels of one error come before 16 of another, and these before the 8 that are left by then.
    difference = _rectangles(
        (16, 20),
        (slice(1, 4), slice(1, 4), 0.5),
        (slice(1, 3), slice(8, 10), 0.5),
        (slice(1, 3), slice(13, 15), 0.5),
        (slice(8, 12), slice(3, 7), 0.9),
    )
    first, second, third, fourth = [2.5, 2.5], [5.0, 10.0], [9.0, 2.0], [14.0, 2.0]
    # More bins than pixels: the two errors get bins of their own.
    assert _centers(difference, 4, Options.released(bins=400)) == [first, second, third, fourth]
    assert _centers(difference, 4, PAPER)[:2] == [second, first]


def test_released_shares_all_pixels_among_the_bins() -> None:
    # The right ones count as zeros: where they are most of the picture, the few that are wrong fill few bins.
    difference = np.zeros((40, 50))
    difference[:4, :25] = np.sqrt(np.linspace(0.2, 1, 100)).reshape(4, 25)
    _, bins = components(np.square(difference), RELEASED)
    wrong = bins[difference > 0]
    assert np.bincount(wrong)[np.unique(wrong)].max() == pytest.approx(2000 / 200, abs=1.01)
    _, bins = components(difference, PAPER)
    assert len(np.unique(bins[difference > 0])) == pytest.approx(100, abs=1)


def test_released_falls_back_to_the_largest_squared_error() -> None:
    image, target = np.zeros((9, 30, 3)), np.zeros((9, 30, 3))
    target[4, 5] = (0.3, 0, 0)  # squared 0.09
    target[4, 25] = (0.15, 0.15, 0.15)  # squared 0.0675, absolute 0.45
    (place,) = component_places(target, image, 1, RELEASED)
    assert place.center.tolist() == [5.5, 4.5]
