# SPDX-License-Identifier: Apache-2.0
"""Strokes in the rasterizer: coverage of known shapes, gradients by differences, and beside filled layers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from conftest import RasterizerFor

import livecl
from livecl.drawing import Strokes
from livecl.drawing.assembly import stretched
from livecl.drawing.drawing import Drawing
from livecl.geometry.strokes import BUTT, CAPS, JOINS, ROUND
from livecl.rendering.strokes import filled

SIZE = (40, 40)


def _line(a: list[float], b: list[float]) -> np.ndarray:
    """An open subpath of one straight segment: the last row is its end."""
    return np.array([[a, a, b], [b, b, b]], dtype=float)


def _drawing(cap: int, join: int, seed: int, *, color_rows: int = 4) -> Drawing:
    """Four layers of random curves, the second filled, the others stroked, open or closed."""
    rng = np.random.default_rng(seed)
    outlines = [[rng.uniform(5, 35, (rng.integers(2, 4), 3, 2))] for _ in range(color_rows)]
    widths = np.array([3.0, 0.0, 0.6, 6.0])
    strokes = Strokes(widths=widths, caps=cap, joins=join, is_open=np.array([True, False, True, False]))
    colors = np.concatenate([rng.uniform(size=(4, 3)), rng.uniform(0.4, 1, (4, 1))], axis=1)
    return Drawing.from_outlines(outlines, colors, SIZE, strokes=strokes)


def test_a_level_line_covers_a_rectangle(rasterizer_for: RasterizerFor) -> None:
    drawing = Drawing.from_outlines(
        [[_line([10, 20], [30, 20])]],
        [0, 0, 0, 1],
        SIZE,
        strokes=Strokes(widths=[5], caps=BUTT, is_open=np.array([True])),
    )

    coverage = rasterizer_for(SIZE, np.float64).coverages(drawing)[0]

    expected = np.zeros(SIZE)
    expected[18:22, 10:30] = 1
    expected[[17, 22], 10:30] = 0.5
    np.testing.assert_allclose(coverage, expected, atol=1e-12)


@pytest.mark.parametrize("radius", [6.0, 2.0])
def test_a_stroked_circle_covers_a_ring(rasterizer_for: RasterizerFor, radius: float) -> None:
    k = 4 / 3 * (np.sqrt(2) - 1) * radius
    anchors = 20 + radius * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    tangents = k * np.array([[0, 1], [-1, 0], [0, -1], [1, 0]])
    circle = np.stack([anchors, anchors + tangents, np.roll(anchors - tangents, -1, axis=0)], axis=1)
    width = 8.0
    drawing = Drawing.from_outlines(
        [[circle]], [0, 0, 0, 1], SIZE, strokes=Strokes(widths=[width], joins=ROUND, is_open=np.array([False]))
    )

    area = rasterizer_for(SIZE, np.float64).coverages(drawing)[0].sum()

    hole = max(radius - width / 2, 0)
    assert area == pytest.approx(np.pi * ((radius + width / 2) ** 2 - hole**2), rel=2e-3)


@pytest.mark.parametrize("cap", range(len(CAPS)))
@pytest.mark.parametrize("join", range(len(JOINS)))
def test_gradients_are_central_differences(rasterizer_for: RasterizerFor, cap: int, join: int) -> None:
    rasterizer, step = rasterizer_for(SIZE, np.float64), 1e-6
    drawing = _drawing(cap, join, seed=3 * cap + join)
    pieces = rasterizer.pieces(drawing)
    image, pullback = rasterizer.vjp(drawing, pieces)
    d_image = np.random.default_rng(5).normal(size=image.shape)

    def loss(changed: Drawing) -> float:
        return float((rasterizer.forward(changed, pieces) * d_image).sum())

    gradients = pullback(d_image)
    expected = np.zeros(drawing.points.shape)
    for index in np.ndindex(expected.shape):
        change = np.zeros(expected.shape)
        change[index] = step
        ahead, back = (drawing.replace(points=drawing.points + sign * change) for sign in (1, -1))
        expected[index] = (loss(ahead) - loss(back)) / (2 * step)
    np.testing.assert_allclose(gradients.points, expected, rtol=0, atol=1e-6 * np.abs(expected).max())

    assert gradients.widths is not None
    for layer in drawing.strokes.stroked_layers:
        change = step * (np.arange(4) == layer)
        ahead, back = (
            drawing.replace(strokes=drawing.strokes.with_widths(drawing.strokes.widths + sign * change))
            for sign in (1, -1)
        )
        assert gradients.widths[layer] == pytest.approx((loss(ahead) - loss(back)) / (2 * step), rel=1e-5, abs=1e-6)
    assert gradients.widths[1] == 0  # of the filled layer


def test_an_invisible_end_has_no_gradient(rasterizer_for: RasterizerFor) -> None:
    drawing = _drawing(ROUND, ROUND, seed=1)
    rasterizer = rasterizer_for(SIZE, np.float64)
    image, pullback = rasterizer.vjp(drawing)

    points = pullback(np.ones_like(image)).points

    end = drawing.subpaths(0)[0].stop - 1
    assert not points[end, 1:].any()  # handles of the row that only ends the line
    assert points[end, 0].any()


def test_loss_and_gradients_are_those_of_the_image(rasterizer_for: RasterizerFor) -> None:
    drawing = _drawing(ROUND, BUTT, seed=2)
    rasterizer = rasterizer_for(SIZE, np.float64)
    target, weight = np.random.default_rng(0).uniform(size=(*SIZE, 3)), np.full(SIZE, 0.5)
    image, pullback = rasterizer.vjp(drawing)
    expected = pullback(2 * 0.5 * (image - target))

    loss, gradients = rasterizer.loss_and_gradients(drawing, target, weight)

    assert loss == pytest.approx(0.5 * ((image - target) ** 2).sum())
    scale = np.abs(expected.points).max()
    np.testing.assert_allclose(gradients.points, expected.points, atol=1e-10 * scale)
    assert gradients.widths is not None and expected.widths is not None
    np.testing.assert_allclose(gradients.widths, expected.widths, atol=1e-10 * scale)


def test_the_distance_weight_is_that_of_the_edges(rasterizer_for: RasterizerFor) -> None:
    drawing = Drawing.from_outlines(
        [[_line([10, 20], [30, 20])]], [0, 0, 0, 1], SIZE, strokes=Strokes(widths=[8], is_open=np.array([True]))
    )

    weight = rasterizer_for(SIZE, np.float64).distance_weight(drawing, tau=3.0)

    assert weight[16, 20] > 0  # the edge lies at y = 16
    assert weight[20, 20] == 0  # the centre line is farther from both edges


def test_layers_beside_strokes_are_as_without(rasterizer_for: RasterizerFor) -> None:
    drawing = _drawing(ROUND, ROUND, seed=4)
    rasterizer = rasterizer_for(SIZE, np.float64)

    np.testing.assert_array_equal(rasterizer.coverages(drawing)[1], rasterizer.coverages(drawing.layer_subset([1]))[0])


def test_open_subpaths_need_a_width() -> None:
    outline = [[_line([10, 20], [30, 20])]]

    with pytest.raises(ValueError, match="open subpaths must belong to layers with a width"):
        livecl.Drawing.from_outlines(outline, [0, 0, 0, 1], SIZE, strokes=Strokes(widths=[0], is_open=np.array([True])))
    with pytest.raises(ValueError, match="two or more rows"):
        livecl.Drawing.from_outlines(
            [[outline[0][0][:1]]], [0, 0, 0, 1], SIZE, strokes=Strokes(widths=[1], is_open=np.array([True]))
        )


def _crossing(rng: np.random.Generator) -> list[np.ndarray]:
    """Two lines through the middle."""
    angles, middles = rng.uniform(0, np.pi, 2), 20 + rng.uniform(-1, 1, (2, 2))
    steps = 14 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return [_line(list(at - step), list(at + step)) for at, step in zip(middles, steps, strict=True)]


def _there_and_back(rng: np.random.Generator) -> list[np.ndarray]:
    """A line along which the pen returns."""
    there = _crossing(rng)[0]
    back = there[::-1].copy()
    back[0, 1:] = back[0, :1]
    return [np.stack([there[0], back[0], np.repeat(there[:1, 0], 3, axis=0)])]


@pytest.mark.parametrize("outline", [_crossing, _there_and_back])
def test_overlaps_cover_too_much_by_half_a_pixel_at_most(
    rasterizer_for: RasterizerFor, outline: Callable[[np.random.Generator], list[np.ndarray]]
) -> None:
    """docs/strokes.md: coverage is the sum of the parts within a pixel, at most 1; never too small."""
    rng, fine = np.random.default_rng(3), 16
    size = (SIZE[0] * fine, SIZE[1] * fine)
    excesses = []
    for cap in range(len(CAPS)):
        lines = outline(rng)
        pen = Strokes(widths=[rng.uniform(2, 6)], caps=cap, joins=cap, is_open=np.ones(len(lines), bool))
        drawing = Drawing.from_outlines([lines], [0, 0, 0, 1], SIZE, strokes=pen)
        polygons = filled(drawing, None, 0.02).drawing
        enlarged = rasterizer_for(size, np.float32).coverages(stretched(polygons, fine, size))[0]
        true = enlarged.reshape(SIZE[0], fine, SIZE[1], fine).mean(axis=(1, 3))
        excesses.append(rasterizer_for(SIZE, np.float64).coverages(drawing)[0] - true)
    # The enlarged picture errs likewise, in pixels of 1 / 16 along an edge: by less than half of 2 / 16 of a pixel.
    assert np.min(excesses) > -1 / fine
    assert 0.1 < np.max(excesses) < 0.5
