# SPDX-License-Identifier: Apache-2.0
"""Regions and what painting them would gain, on pictures where both are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import label

from livecl.layering.regions import PARTITIONS, RegionFinder, TargetPartitions

FloatArray = NDArray[np.float64]


def _picture(size: tuple[int, int], *parts: tuple[slice, slice, tuple[float, float, float]]) -> FloatArray:
    picture = np.ones((*size, 3))
    for rows, columns, color in parts:
        picture[rows, columns] = color
    return picture


def _error(target: FloatArray, image: FloatArray) -> FloatArray:
    return np.square(target - image).sum(axis=-1)


def _blobs(seed: int, size: tuple[int, int]) -> FloatArray:
    """Return a picture with soft structure: a few waves in each channel."""
    rng = np.random.default_rng(seed)
    rows, columns = np.indices(size)
    waves = [
        np.sin(rows * rng.uniform(-0.4, 0.4) + columns * rng.uniform(-0.4, 0.4) + rng.uniform(0, 6)) for _ in range(3)
    ]
    return 0.5 + 0.5 * np.stack(waves, axis=-1)


def test_flat_shapes_are_found_whole_in_the_order_of_their_error() -> None:
    # 40 px of a squared error of 3 0.2^2 = 0.12 lose against 9 px of 3, although they are more.
    large = (slice(2, 7), slice(1, 9), (0.8, 0.8, 0.8))
    small = (slice(8, 11), slice(12, 15), (0.0, 0.0, 0.0))
    target, image = _picture((14, 18), large, small), np.ones((14, 18, 3))
    found = list(RegionFinder(TargetPartitions(target), image).best(_error(target, image), 40))
    assert np.array_equal(found[0].mask, (target == 0).all(axis=-1))
    assert found[0].gain == pytest.approx(27, rel=1e-12) and found[0].color.tolist() == [0, 0, 0]
    second = next(region for region in found if np.array_equal(region.mask, (target == 0.8).all(axis=-1)))
    assert second.gain == pytest.approx(40 * 0.12, rel=1e-12)
    np.testing.assert_allclose(second.color, 0.8, rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_gain_is_the_squared_error_that_painting_the_region_removes(seed: int) -> None:
    size = (23, 30)
    target = _blobs(seed, size)
    image = np.clip(target + 0.4 * _blobs(seed + 9, size) - 0.2, 0, 1)
    error = _error(target, image)
    regions = list(RegionFinder(TargetPartitions(target), image).best(error, 25))
    assert len(regions) == 25
    for region in regions:
        painted = np.where(region.mask[..., None], region.color, image)
        # Sums of up to 690 numbers of order 1, differences of which the gain is.
        assert region.gain == pytest.approx(error.sum() - _error(target, painted).sum(), abs=1e-9)
        np.testing.assert_allclose(region.color, target[region.mask].mean(axis=0), rtol=1e-12)
        assert region.gain > 0 and region.mask.sum() >= PARTITIONS.min_pixels


@pytest.mark.parametrize("seed", range(3))
def test_regions_are_connected_and_come_best_first(seed: int) -> None:
    target, image = _blobs(seed, (25, 33)), _blobs(seed + 5, (25, 33))
    regions = list(RegionFinder(TargetPartitions(target), image).best(_error(target, image), 30))
    gains = [region.gain for region in regions]
    assert gains == sorted(gains, reverse=True)
    for region in regions:
        assert region.mask.shape == (25, 33) and label(region.mask)[1] == 1


def test_fewer_are_the_first_of_more() -> None:
    target, image = _blobs(1, (20, 20)), np.ones((20, 20, 3))
    finder, error = RegionFinder(TargetPartitions(target), image), _error(target, image)
    many, few = list(finder.best(error, 12)), list(finder.best(error, 5))
    assert len(few) == 5
    for one, other in zip(few, many, strict=False):
        assert np.array_equal(one.mask, other.mask) and one.gain == other.gain


def test_a_region_that_the_target_does_not_show_is_found_by_the_difference() -> None:
    # The target is a slope without regions of its own; the picture has a wrong square.
    target = np.repeat(np.linspace(0, 1, 40)[None, :, None], 30, axis=0).repeat(3, axis=2)
    image = target.copy()
    image[10:20, 10:20] -= 0.25
    finder = RegionFinder(TargetPartitions(target), image)
    masks = [region.mask for region in finder.best(_error(target, image), 30)]
    square = np.zeros((30, 40), dtype=bool)
    square[10:20, 10:20] = True
    assert any(np.array_equal(mask, square) for mask in masks)


def test_the_error_of_a_better_picture_is_what_counts() -> None:
    black = (0.0, 0.0, 0.0)
    first, second = (slice(1, 7), slice(1, 7), black), (slice(9, 13), slice(9, 13), black)
    target, image = _picture((14, 14), first, second), np.ones((14, 14, 3))
    finder = RegionFinder(TargetPartitions(target), image)
    best = next(iter(finder.best(_error(target, image), 1)))
    assert best.mask.sum() == 36
    better = np.where(best.mask[..., None], best.color, image)
    following = next(iter(finder.best(_error(target, better), 1)))
    assert following.mask.sum() == 16 and following.gain == pytest.approx(48, rel=1e-12)


def test_nothing_is_found_where_all_is_right() -> None:
    target = _blobs(2, (16, 16))
    assert list(RegionFinder(TargetPartitions(target), target).best(np.zeros((16, 16)), 5)) == []


def test_specks_of_fewer_than_three_pixels_are_none() -> None:
    target = _picture((12, 12), (slice(3, 4), slice(3, 5), (0, 0, 0)), (slice(8, 9), slice(2, 5), (0, 0, 0)))
    image = np.ones((12, 12, 3))
    regions = list(RegionFinder(TargetPartitions(target), image).best(_error(target, image), 20))
    assert all(region.mask.sum() >= PARTITIONS.min_pixels for region in regions)
    assert regions[0].mask.sum() == 3 and regions[0].mask[8, 2:5].all()


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (5, 1), (2, 2)])
def test_smallest_pictures(size: tuple[int, int]) -> None:
    target, image = np.zeros((*size, 3)), np.ones((*size, 3))
    regions = list(RegionFinder(TargetPartitions(target), image).best(_error(target, image), 3))
    num_pixels = size[0] * size[1]
    assert bool(regions) == (num_pixels >= PARTITIONS.min_pixels)
    assert all(region.gain == pytest.approx(3 * num_pixels) for region in regions)


def test_a_small_difference_in_alpha_is_a_region() -> None:
    # Of 0.05: less than half a level of those that pictures with a background are sorted by.
    target = np.zeros((30, 40, 4))
    target[..., 3] = 0.5
    image = target.copy()
    image[10:20, 10:20, 3] -= 0.05
    square = np.zeros((30, 40), dtype=bool)
    square[10:20, 10:20] = True
    masks = [region.mask for region in RegionFinder(TargetPartitions(target), image).best(square * 0.05**2, 60)]
    assert any(np.array_equal(mask, square) for mask in masks)
