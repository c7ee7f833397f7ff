# SPDX-License-Identifier: Apache-2.0
"""New layers: where they start, what they look like and in which colour, for each rule of placement."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.measure import points_in_poly

from livecl import Drawing, Options
from livecl.bezier import evaluate, signed_area
from livecl.outline import circle
from livecl.placement import SMALL_REGION, place_paths

FloatArray = NDArray[np.float64]
Coverage = Callable[[FloatArray], FloatArray]

RED, GREEN, BLUE = (0.9, 0.1, 0.2), (0.1, 0.8, 0.3), (0.2, 0.3, 0.9)


def _coverage_on(size: tuple[int, int], samples: int = 4) -> Coverage:
    """Return a function that counts the samples of each pixel within an outline: near enough to judge regions by."""

    def coverage(path: FloatArray) -> FloatArray:
        cubics = np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)
        corners = evaluate(cubics, np.arange(16) / 16).reshape(-1, 2)
        rows, columns = (np.indices((size[0] * samples, size[1] * samples)) + 0.5) / samples
        inside = points_in_poly(np.stack([columns.ravel(), rows.ravel()], axis=1), corners)
        return inside.reshape(size[0], samples, size[1], samples).mean(axis=(1, 3))

    return coverage


def _no_coverage(path: FloatArray) -> FloatArray:
    raise AssertionError("only the rule 'region' looks at coverage")


def _place(target: FloatArray, count: int, options: Options, image: FloatArray | None = None, seed: int = 0) -> Drawing:
    image = np.ones_like(target) if image is None else image
    coverage = _coverage_on(target.shape[:2]) if options.placement == "region" else _no_coverage
    return place_paths(target, image, count, options, np.random.default_rng(seed), coverage)


def _painted(drawing: Drawing, image: FloatArray) -> FloatArray:
    """Return the picture with the drawing's opaque layers on it."""
    coverage = _coverage_on(drawing.size)
    for layer in range(drawing.num_layers):
        share = coverage(drawing.layer_subset([layer]).points)[..., None] * drawing.colors[layer, 3]
        image = image + share * (drawing.colors[layer, :3] - image)
    return image


def _error(target: FloatArray, image: FloatArray) -> float:
    return float(np.square(target - image).sum())


def _three_shapes() -> FloatArray:
    """Return a disc of 317 px, a bar of 80 and a square of 25 on white; the error is in the same order."""
    rows, columns = np.indices((36, 48)) + 0.5
    target = np.ones((36, 48, 3))
    target[np.hypot(columns - 14, rows - 16) < 10] = RED
    target[28:32, 20:40] = BLUE
    target[5:10, 36:41] = GREEN
    return target


def test_components_become_circles_of_the_target_s_color() -> None:
    options = Options.paper(radius=3.5, segments=5)
    drawing = _place(_three_shapes(), 3, options)
    assert drawing.num_layers == 3 and drawing.size == (36, 48)
    assert np.array_equal(drawing.segment_offsets, [0, 5, 10, 15]) and np.array_equal(drawing.layer_offsets, range(4))
    np.testing.assert_allclose(drawing.colors, [(*RED, 1), (*BLUE, 1), (*GREEN, 1)])
    for layer, center in enumerate([(14, 16), (30, 30), (38.5, 7.5)]):
        path = drawing.layer_subset([layer]).points
        np.testing.assert_allclose(path, circle(center, 3.5, 5), atol=1e-9)


def test_the_color_is_the_target_s_where_the_circle_is_put() -> None:
    # Not the mean of the component, as a slope of colours shows; for a ring, the colour of its own pixel.
    rows, columns = np.indices((24, 24))
    distance = np.hypot(rows - 12, columns - 12)
    target = np.where((distance < 9)[..., None], np.stack([rows / 23, columns / 23, 0 * rows], axis=-1), 1)
    one_bin = Options.paper(bins=1)
    drawing = _place(target, 1, one_bin)
    np.testing.assert_allclose(drawing.colors[0], (12 / 23, 12 / 23, 0, 1))
    target[distance < 6] = 1
    drawing = _place(target, 1, one_bin)
    column, row = np.floor(drawing.points.reshape(-1, 2).mean(axis=0)).astype(int)
    assert 6 <= distance[row, column] < 9
    np.testing.assert_allclose(drawing.colors[0], (*target[row, column], 1))


def test_components_with_fitted_outlines_cover_their_pixels() -> None:
    target = _three_shapes()
    drawing = _place(target, 3, Options.paper(shape="outline"))
    coverage = _coverage_on(target.shape[:2])
    for layer, color in enumerate((RED, BLUE, GREEN)):
        mask = (target == color).all(axis=-1)
        wrong = np.abs(coverage(drawing.layer_subset([layer]).points) - mask).sum()
        # The fit leaves the region by less than a pixel along its border.
        assert wrong < 0.5 * 4 * np.sqrt(mask.sum())


def test_random_outlines_start_at_the_components() -> None:
    drawing = _place(_three_shapes(), 2, Options.paper(shape="random"))
    np.testing.assert_allclose(drawing.points[[0, 4], 0], [(14, 16), (30, 30)], atol=1e-9)
    again = _place(_three_shapes(), 2, Options.paper(shape="random"))
    other = _place(_three_shapes(), 2, Options.paper(shape="random"), seed=1)
    assert np.array_equal(drawing.points, again.points) and not np.array_equal(drawing.points, other.points)


def test_random_places_are_uniform_and_take_the_target_s_color() -> None:
    target = np.random.default_rng(0).uniform(size=(20, 50, 3))
    drawing = _place(target, 400, Options.paper(placement="random", segments=2))
    centers = drawing.points.reshape(400, 6, 2).mean(axis=1)
    assert np.all(centers >= 0) and np.all(centers < (50, 20))
    # 100 are expected in each quarter, with a deviation of 8.7.
    quarters = np.histogram2d(*centers.T, bins=2, range=[[0, 50], [0, 20]])[0]
    assert np.all(np.abs(quarters - 100) < 4 * 8.7)
    columns, rows = np.floor(centers).astype(int).T
    np.testing.assert_allclose(drawing.colors, np.concatenate([target[rows, columns], np.ones((400, 1))], axis=1))


def test_the_baseline_s_paths_are_random_in_all() -> None:
    drawing = _place(_three_shapes(), 200, Options.diffvg())
    assert drawing.colors.min() >= 0 and drawing.colors.max() <= 1
    np.testing.assert_allclose(drawing.colors.mean(axis=0), 0.5, atol=4 * np.sqrt(1 / 12 / 200))
    assert np.array_equal(drawing.points, _place(_three_shapes(), 200, Options.diffvg()).points)
    assert not np.array_equal(drawing.colors, _place(_three_shapes(), 200, Options.diffvg(), seed=1).colors)


@pytest.mark.parametrize("placement", ["component", "region"])
def test_rules_without_chance_leave_the_random_source_alone(placement: str) -> None:
    rng = np.random.default_rng(3)
    before = rng.bit_generator.state
    target, options = _three_shapes(), Options(placement=placement, shape="outline")
    place_paths(target, np.ones_like(target), 2, options, rng, _coverage_on((36, 48)))
    assert rng.bit_generator.state == before


def test_regions_are_painted_in_the_order_of_their_error() -> None:
    target = _three_shapes()
    drawing = _place(target, 3, Options(placement="region"))
    np.testing.assert_allclose(drawing.colors, [(*RED, 1), (*BLUE, 1), (*GREEN, 1)], atol=1e-9)
    before = _error(target, np.ones_like(target))
    for count in (1, 2, 3):
        error = _error(target, _painted(drawing.layer_subset(range(count)), np.ones_like(target)))
        assert error < before
        before = error
    # What is left is on the borders: the target's pixels are whole, those of an outline are not, and are off by up to
    # one half on about as many pixels as the borders are long, 63 + 48 + 20.
    assert before < 131 * 3 / 4


def test_later_paths_see_what_earlier_ones_painted() -> None:
    # A disc within a disc: the second path paints the inner one, on the first.
    rows, columns = np.indices((32, 32)) + 0.5
    distance = np.hypot(rows - 16, columns - 16)
    target = np.ones((32, 32, 3))
    target[distance < 13], target[distance < 6] = (0.1, 0.1, 0.1), (0.9, 0.5, 0.1)
    drawing = _place(target, 2, Options(placement="region"))
    np.testing.assert_allclose(drawing.colors[:, :3], [(0.1, 0.1, 0.1), (0.9, 0.5, 0.1)], atol=1e-9)
    for layer, radius in enumerate((13, 6)):
        path = drawing.layer_subset([layer]).points
        cubics = np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)
        assert abs(signed_area(cubics)) == pytest.approx(np.pi * radius**2, rel=0.05)


def test_a_region_gets_more_segments_where_its_outline_needs_them() -> None:
    rows, columns = np.indices((40, 40)) + 0.5
    cross = np.ones((40, 40, 3))
    cross[16:24, 4:36] = cross[4:36, 16:24] = 0.1
    disc = np.ones((40, 40, 3))
    disc[np.hypot(columns - 20, rows - 20) < 14] = 0.1
    assert _place(disc, 1, Options()).num_segments == 4
    more = _place(cross, 1, Options(max_segments=8))
    assert 4 < more.num_segments <= 8
    four = _place(cross, 1, Options(max_segments=4))
    assert four.num_segments == 4
    white = np.ones_like(cross)
    assert _error(cross, _painted(more, white)) < _error(cross, _painted(four, white))
    assert _place(cross, 1, Options(segments=6, max_segments=4)).num_segments == 6


def test_circles_for_regions_lie_at_their_center() -> None:
    drawing = _place(_three_shapes(), 1, Options(placement="region", shape="circle", radius=4.0, segments=3))
    center = drawing.points.reshape(-1, 2).mean(axis=0)
    np.testing.assert_allclose(center, (14, 16), atol=0.2)  # of parts of the disc that would gain as much
    np.testing.assert_allclose(drawing.points, circle(center, 4, 3), atol=1e-9)


def test_random_outlines_for_regions() -> None:
    options = Options(placement="region", shape="random")
    drawing = _place(_three_shapes(), 1, options)
    center = drawing.points.reshape(-1, 2).mean(axis=0)
    assert np.ptp(np.hypot(*(drawing.points.reshape(-1, 2) - center).T)) > 1e-3, "a circle"
    assert not np.array_equal(drawing.points, _place(_three_shapes(), 1, options, seed=1).points)


def test_random_colors_for_regions() -> None:
    options = Options(placement="region", new_color="random")
    first, second = (_place(_three_shapes(), 1, options, seed=seed).colors for seed in (0, 1))
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("placement", ["component", "region"])
def test_the_smallest_regions_become_circles_of_their_area(placement: str) -> None:
    target = np.ones((20, 20, 3))
    target[4:7, 9:12] = 0.0
    drawing = _place(target, 1, Options(placement=placement, shape="outline", max_segments=4))
    assert (target == 0).all(axis=-1).sum() < SMALL_REGION
    np.testing.assert_allclose(drawing.points, circle((10.5, 5.5), np.sqrt(9 / np.pi), 4), atol=1e-12)


@pytest.mark.parametrize("size", [(12, 17), (1, 1), (1, 9)])
@pytest.mark.parametrize("shape", ["outline", "circle"])
@pytest.mark.parametrize("placement", ["component", "region"])
def test_a_perfect_picture_still_gets_the_paths_asked_for(placement: str, shape: str, size: tuple[int, int]) -> None:
    target = np.random.default_rng(4).uniform(size=(*size, 3))
    drawing = _place(target, 5, Options(placement=placement, shape=shape), image=target)
    assert drawing.num_layers == 5 and drawing.size == size
    centers = np.array([drawing.layer_subset([k]).points.reshape(-1, 2).mean(axis=0) for k in range(5)])
    assert np.all(centers >= 0) and np.all(centers <= size[::-1])


def test_an_error_that_no_region_would_lessen_gets_a_circle() -> None:
    # Whatever region of noise is painted in its mean colour, more is lost than the one wrong pixel is off.
    target = np.random.default_rng(5).uniform(size=(20, 30, 3))
    image = target.copy()
    image[14, 21], image[3, 5] = 1 - target[14, 21].round(), target[3, 5] * 0.9
    drawing = _place(target, 1, Options(placement="region", radius=2.5), image=image)
    np.testing.assert_allclose(drawing.points, circle((21.5, 14.5), 2.5, 4), atol=1e-12)
    np.testing.assert_allclose(drawing.colors, [(*target[14, 21], 1)])


@pytest.mark.parametrize("options", [Options.paper(), Options.released(), Options(), Options.diffvg()])
def test_pictures_in_single_precision_give_the_same_places(options: Options) -> None:
    target = _three_shapes()
    double = _place(target, 2, options)
    single = _place(target.astype(np.float32), 2, options, image=np.ones(target.shape, np.float32))
    np.testing.assert_allclose(single.points, double.points, atol=1e-5)
    np.testing.assert_allclose(single.colors, double.colors, atol=1e-6)
