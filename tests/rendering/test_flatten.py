# SPDX-License-Identifier: Apache-2.0
"""Flatten: curves rendered as the polylines they are meant to become, and the gradient that goes back through them."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from reference.flatten import flatten, flatten_backward
from support import drawings, shapes

from livecl import Drawing
from livecl.geometry import bezier

CURVED = ["holes", "tangles", "1 to 9 segments", "across the canvas's borders", "outside and around"]


def _as_polygons(case: drawings.Case) -> Drawing:
    """The drawing with each flattened line as a segment of its own."""
    layers: list[drawings.Layer] = [
        ([drawings.polygon(vertices) for vertices in outlines], tuple(color))
        for outlines, color in zip(flatten(case.drawing, case.pieces), case.drawing.colors, strict=True)
    ]
    return drawings.build(layers, case.drawing.size, case.drawing.background)


@pytest.mark.parametrize("name", CURVED)
def test_curve_is_rendered_as_its_polyline(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.CASES[name]()
    rasterizer = rasterizer_for(case.drawing.size, np.float64)
    polygons = _as_polygons(case)
    expected = rasterizer.forward(polygons, pieces=np.ones(polygons.num_segments, dtype=int)).copy()
    np.testing.assert_allclose(rasterizer.forward(case.drawing, pieces=case.pieces), expected, atol=1e-11)


@pytest.mark.parametrize("name", CURVED)
def test_gradient_goes_back_through_the_weights(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.CASES[name]()
    rasterizer = rasterizer_for(case.drawing.size, np.float64)
    d_image = np.random.default_rng(1).normal(size=(*case.drawing.size, 3))
    polygons = _as_polygons(case)
    rasterizer.forward(polygons, pieces=np.ones(polygons.num_segments, dtype=int))
    d_polygons = rasterizer.backward(d_image).points
    assert not np.any(d_polygons[:, 1:]), "with one piece, a segment does not depend on its handles"
    rasterizer.forward(case.drawing, pieces=case.pieces)
    d_points = rasterizer.backward(d_image).points
    expected = flatten_backward(case.drawing, case.pieces, d_polygons[:, 0])
    np.testing.assert_allclose(d_points, expected, atol=1e-9 * np.linalg.norm(expected))


def test_handles_count_only_between_the_ends(rasterizer_for: RasterizerFor) -> None:
    triangle = drawings.polygon([(2.2, 3.1), (12.7, 4.4), (6.1, 11.9)])
    bent = triangle.copy()
    bent[:, 1:] += np.random.default_rng(2).normal(size=(3, 2, 2))
    rasterizer = rasterizer_for((14, 15), np.float64)
    images = [
        rasterizer.forward(drawings.build([([path], drawings.RED)], (14, 15)), pieces=np.ones(3, dtype=int)).copy()
        for path in (triangle, bent)
    ]
    np.testing.assert_array_equal(*images)


def test_none_chooses_pieces_by_tolerance(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.CASES["translucent"]().drawing
    rasterizer = rasterizer_for(drawing.size, np.float32)
    chosen = rasterizer.forward(drawing).copy()
    np.testing.assert_array_equal(chosen, rasterizer.forward(drawing, pieces=bezier.pieces_for(drawing.cubics, 0.02)))


def test_tolerance_bounds_the_change_of_area(rasterizer_for: RasterizerFor) -> None:
    # Curve and chords are at most 0.02 px apart, so they enclose at most 0.02 times the outline's length between them,
    # and the outline, of 2 pi 9 px, is longer than its chords.
    drawing = drawings.build([([shapes.circle((12, 11), 9)], shapes.WHITE)], (24, 25), (0, 0, 0))
    rasterizer = rasterizer_for((24, 25), np.float64)
    coarse = rasterizer.forward(drawing).copy()
    fine = rasterizer.forward(drawing, pieces=np.full(4, 400))
    assert 0 < np.sum(np.abs(coarse - fine)[..., 0]) < 0.02 * 2 * np.pi * 9


def test_many_pieces_approach_the_area_of_the_curve(rasterizer_for: RasterizerFor) -> None:
    # The area between a chord and its curve falls as 1 / n^2.
    drawing = drawings.build([([drawings.blob(3, (12, 11), 8)], shapes.WHITE)], (24, 25), (0, 0, 0))
    rasterizer = rasterizer_for((24, 25), np.float64)
    area = abs(bezier.signed_area(drawing.cubics))
    errors = [rasterizer.forward(drawing, pieces=np.full(4, n))[..., 0].sum() - area for n in (20, 40, 80)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.01)
    assert abs(errors[2]) < 0.01


@pytest.mark.parametrize(
    "pieces",
    [np.ones(3, dtype=int), np.ones((4, 1), dtype=int), np.array([1, 1, 0, 1]), np.array([2, -1, 3, 4]), 5],
    ids=["too few", "two axes", "zero", "negative", "scalar"],
)
def test_wrong_pieces(rasterizer_for: RasterizerFor, pieces: np.ndarray) -> None:
    drawing = drawings.build([([shapes.circle((5, 5), 3)], drawings.RED)], (10, 11))
    rasterizer = rasterizer_for((10, 11), np.float32)
    target, weight = np.zeros((10, 11, 3)), np.ones((10, 11))
    with pytest.raises(ValueError, match="pieces"):
        rasterizer.forward(drawing, pieces=pieces)
    with pytest.raises(ValueError, match="pieces"):
        rasterizer.loss_and_gradients(drawing, target, weight, pieces=pieces)
    with pytest.raises(ValueError, match="pieces"):
        rasterizer.distance_weight(drawing, pieces=pieces)
