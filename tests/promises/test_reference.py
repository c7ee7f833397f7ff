# SPDX-License-Identifier: Apache-2.0
"""The float64 references against closed forms, sampling and differences, before anything is compared with them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference import differences
from reference.composite import composite_backward, composite_forward
from reference.coverage import coverage, enclosed_area, lines_of, supersampled, winding_area
from reference.distance import distance, distance_weight
from reference.flatten import flatten, flatten_backward, weights
from reference.xing import xing_loss
from support import drawings, shapes

from livecl.geometry import bezier


def test_weights_are_bernstein() -> None:
    np.testing.assert_allclose(weights(7), bezier.bernstein(np.arange(7) / 7), atol=1e-15)


def test_flatten_lies_on_the_curves() -> None:
    case = drawings.CASES["holes"]()
    cubics = case.drawing.cubics
    expected = np.concatenate([bezier.evaluate(cubics[m], np.arange(n) / n) for m, n in enumerate(case.pieces)])
    vertices = np.concatenate([outline for layer in flatten(case.drawing, case.pieces) for outline in layer])
    np.testing.assert_allclose(vertices, expected, atol=1e-13)


def test_flatten_backward_is_the_transpose() -> None:
    case = drawings.CASES["holes"]()
    rng = np.random.default_rng(0)
    d_vertices = rng.normal(size=(case.pieces.sum(), 2))
    moved = rng.normal(size=case.drawing.points.shape)

    def vertices(points: np.ndarray) -> np.ndarray:
        return np.concatenate(
            [outline for layer in flatten(case.drawing.replace(points=points), case.pieces) for outline in layer]
        )

    change = np.sum(d_vertices * (vertices(case.drawing.points + moved) - vertices(case.drawing.points)))
    assert np.sum(flatten_backward(case.drawing, case.pieces, d_vertices) * moved) == pytest.approx(change, rel=1e-12)


def test_coverage_of_a_rectangle_is_a_product_of_overlaps() -> None:
    x_0, y_0, x_1, y_1 = 2.3, -1.4, 7.6, 4.25
    column, row = np.arange(6), np.arange(9)
    across = np.clip(np.minimum(x_1, column + 1) - np.maximum(x_0, column), 0, 1)
    down = np.clip(np.minimum(y_1, row + 1) - np.maximum(y_0, row), 0, 1)
    outline = drawings.rectangle(x_0, y_0, x_1, y_1)[:, 0]
    np.testing.assert_allclose(winding_area([outline], (9, 6)), np.outer(down, across), atol=1e-15)
    np.testing.assert_allclose(winding_area([outline[::-1]], (9, 6)), -np.outer(down, across), atol=1e-15)


def test_coverage_of_a_triangle_in_one_pixel() -> None:
    triangle = np.array([(1.0, 1.0), (2.0, 1.0), (1.25, 1.5)])
    area = winding_area([triangle], (3, 3))
    assert area[1, 1] == pytest.approx(0.25, abs=1e-15)
    assert np.count_nonzero(area) == 1


def test_coverage_cut_by_a_diagonal() -> None:
    # The line y = x / 2 from (0, 0) to (4, 2) cuts the pixels of the first row to 1/4 and 3/4, then 1 and 1.
    below = np.array([(0.0, 0.0), (4.0, 2.0), (4.0, 0.0)])
    np.testing.assert_allclose(coverage([below], (2, 4)), [[0.25, 0.75, 1, 1], [0, 0, 0.25, 0.75]], atol=1e-15)


@pytest.mark.parametrize("slant", [0.0, 1e-15, -4e-16, 1e-12, 1e-9])
def test_coverage_beside_a_line_that_is_almost_vertical(slant: float) -> None:
    outline = np.array([(2 / 3, 0.0), (2 / 3 + slant, 3.0), (2.0, 3.0), (2.0, 0.0)])
    expected = [[1 / 3, 1]] * 3
    np.testing.assert_allclose(coverage([outline], (3, 2)), expected, rtol=0, atol=abs(slant) + 1e-15)
    turned = coverage([outline[:, ::-1]], (2, 3))
    np.testing.assert_allclose(turned.T, expected, rtol=0, atol=abs(slant) + 1e-15)


@pytest.mark.parametrize("name", drawings.CASES)
def test_coverage_sums_to_the_enclosed_area(name: str) -> None:
    case = drawings.CASES[name]()
    for outlines in flatten(case.drawing, case.pieces):
        low = np.floor(np.min(np.concatenate(outlines), axis=0))
        high = np.ceil(np.max(np.concatenate(outlines), axis=0))
        size = (max(1, int(high[1] - low[1])), max(1, int(high[0] - low[0])))
        area = winding_area([outline - low for outline in outlines], size)
        assert area.sum() == pytest.approx(enclosed_area(outlines), abs=1e-10)


@pytest.mark.parametrize("name", ["opaque", "holes", "outside and around", "across the canvas's borders", "slivers"])
def test_coverage_agrees_with_supersampling(name: str) -> None:
    # A straight edge parallel to an axis is the worst: 10 columns of samples see its place to within half a tenth,
    # evenly distributed, so its error has a mean square of 0.1^2 / 12 in each crossed pixel, of which there are at most
    # `crossed`. These outlines are clean (no winding numbers but 0 and 1 in a pixel), with a few edges a pixel at most.
    case = drawings.CASES[name]()
    for outlines in flatten(case.drawing, case.pieces):
        start, end = lines_of(outlines)
        crossed = np.sum(1 + np.sum(np.abs(np.floor(end) - np.floor(start)), axis=1))
        error = coverage(outlines, case.drawing.size) - supersampled(outlines, case.drawing.size)
        assert np.max(np.abs(error)) < 0.1
        assert np.sum(error**2) < crossed * 0.1**2 / 12


def test_composite_of_two_layers_by_hand() -> None:
    share = np.array([[[1.0, 0.5, 0.0]], [[0.5, 0.5, 1.0]]])
    colors = np.array([(1.0, 0.0, 0.0, 0.5), (0.0, 0.0, 1.0, 1.0)])
    image, below = composite_forward(share, colors, np.ones(3))
    np.testing.assert_allclose(image[0], [(0.5, 0.25, 0.75), (0.5, 0.375, 0.875), (0, 0, 1)], atol=1e-15)
    np.testing.assert_allclose(below[1, 0], [(1, 0.5, 0.5), (1, 0.75, 0.75), (1, 1, 1)], atol=1e-15)
    image, _ = composite_forward(share, colors, None)
    np.testing.assert_allclose(image[0], [(0.25, 0, 0.5, 0.75), (0.125, 0, 0.5, 0.625), (0, 0, 1, 1)], atol=1e-15)


@pytest.mark.parametrize("background", [(0.3, 0.9, 0.5), None], ids=["rgb", "rgba"])
def test_composite_backward_against_differences(background: tuple[float, float, float] | None) -> None:
    rng = np.random.default_rng(3)
    share, colors = rng.uniform(size=(4, 3, 5)), drawings.random_colors(4, 4)
    colors[2, 3], share[2, 1], colors[0, 3] = 1.0, 1.0, 0.0
    under = None if background is None else np.array(background)
    d_image = rng.normal(size=(3, 5, 3 if background else 4))

    def loss(share: np.ndarray, colors: np.ndarray, under: np.ndarray | None) -> np.ndarray:
        return np.array([np.sum(composite_forward(share, colors, under)[0] * d_image)])

    d_share, d_colors, d_background = composite_backward(d_image, share, colors, under)
    exact = differences.of_quadratic
    np.testing.assert_allclose(d_share.ravel(), exact(lambda x: loss(x, colors, under), share)[0], atol=1e-12)
    np.testing.assert_allclose(d_colors.ravel(), exact(lambda x: loss(share, x, under), colors)[0], atol=1e-12)
    if under is not None:
        np.testing.assert_allclose(d_background, exact(lambda x: loss(share, colors, x), under)[0], atol=1e-12)


def test_differences_give_the_mean_at_a_kink() -> None:
    def kinked(x: np.ndarray) -> np.ndarray:
        return np.where(x > 0, 3 * x + 5 * x**2, -x + 2 * x**2)

    assert differences.by_small_steps(kinked, np.zeros(1))[0, 0] == pytest.approx(1.0, rel=1e-9)
    assert differences.by_small_steps(np.sin, np.ones(1))[0, 0] == pytest.approx(math.cos(1), rel=1e-9)


def test_distance_to_a_square() -> None:
    found = distance([drawings.rectangle(2.5, 2.5, 5.5, 5.5)[:, 0]], (9, 9))
    x = np.abs(np.arange(9) + 0.5 - 4) - 1.5
    outside = np.hypot(*np.meshgrid(np.maximum(x, 0), np.maximum(x, 0)))
    inside = np.maximum(np.maximum(*np.meshgrid(x, x)), -1.5)
    np.testing.assert_allclose(found, np.where(outside > 0, outside, -np.minimum(inside, 0)), atol=1e-14)


def test_distance_to_a_point_and_the_nearest_of_two() -> None:
    point, other = np.tile((3.0, 1.5), (3, 1)), np.array([(0.5, 0.5), (0.5, 4.5)])
    np.testing.assert_allclose(distance([point], (4, 5))[1], np.abs(np.arange(5) - 2.5))
    np.testing.assert_allclose(distance([point, other], (4, 5))[1], [0, 1, 0.5, 0.5, 1.5])


def test_distance_weight_averages_the_layers_within_reach() -> None:
    near, far = shapes.circle((8, 9), 4), shapes.circle((200, 9), 4)
    both = drawings.build([([near], drawings.RED), ([far], drawings.BLUE)], (16, 18))
    pieces = np.full(8, 6)
    weight = distance_weight(both, 10.0, pieces)
    assert weight.sum() == pytest.approx(1)
    np.testing.assert_array_equal(weight, distance_weight(both.layer_subset([0]), 10.0, pieces[:4]))
    assert not distance_weight(both.layer_subset([1]), 10.0, pieces[:4]).any()


@pytest.mark.parametrize(
    ("b", "c", "d", "expected"),
    [
        ((1, 0), (1, 1), (1, 0), 1.0),  # turns to the right, CD against it: D1 = 1, D2 = -1
        ((1, 0), (1, 1), (0, 1), 0.0),  # D1 = 1, D2 = 0
        ((1, 0), (1, 1), (1, 2), 0.0),  # D1 = 1, D2 = 1
        ((1, 0), (1, -1), (1, 0), 1.0),  # turns to the left: D1 = 0, D2 = 1
        ((1, 0), (1, -1), (1, -2), 0.0),  # D1 = 0, D2 = -1
        ((1, 0), (2, 0), (3, 1), math.sqrt(0.5)),  # straight on: D1 = 0, D2 = sin 45 degrees
        ((0, 0), (1, 1), (1, 0), 0.0),  # AB has no direction
        ((1, 0), (1, 1), (1, 1), 0.0),  # CD has no direction
    ],
)
def test_xing_of_one_segment(b: tuple[int, int], c: tuple[int, int], d: tuple[int, int], expected: float) -> None:
    cubic = np.array([[(0, 0), b, c, d]], dtype=float)
    assert xing_loss(cubic) == pytest.approx(expected, abs=1e-15)
    assert xing_loss(np.concatenate([7 * cubic + 3, np.zeros((1, 4, 2))])) == pytest.approx(expected / 2, abs=1e-14)
