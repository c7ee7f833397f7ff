# SPDX-License-Identifier: Apache-2.0
"""Circles, ellipses and rectangles: written as such where a layer is one, and read back as the very drawing."""

from __future__ import annotations

import re

import numpy as np
import pytest

from livecl.drawing import Drawing, Fills
from livecl.geometry.outlines import reversed_path
from livecl.rendering.single import render
from livecl.svg import format_svg, quantize, read_svg
from livecl.svg.primitives import ellipse, primitive_of, rectangle

SHAPES = {
    "circle": (lambda: ellipse(np.array([20.125, 17.5]), (9.3333, 9.3333)), 'cx="20.125" cy="17.5" r="9.333"'),
    "ellipse": (lambda: ellipse(np.array([20.0, 17.5]), (12.0, 9.25)), 'cx="20" cy="17.5" rx="12" ry="9.25"'),
    "turned": (
        lambda: ellipse(np.array([20.0, 17.5]), (12.0, 9.25), 33.5),
        'cx="20" cy="17.5" rx="12" ry="9.25" transform="rotate(33.5 20 17.5)"',
    ),
    "rect": (lambda: rectangle(np.array([3.0, 4.0]), np.array([31.5, 24.0])), 'x="3" y="4" width="28.5" height="20"'),
    "rounded": (
        lambda: rectangle(np.array([3.0, 4.0]), np.array([31.5, 24.0]), 4.5),
        'x="3" y="4" width="28.5" height="20" rx="4.5"',
    ),
    "pill": (
        lambda: rectangle(np.array([3.0, 4.0]), np.array([31.5, 10.001]), 3.0005),
        'x="3" y="4" width="28.5" height="6.001" rx="3.0005"',
    ),
}


def layer_of(outline: np.ndarray, **values: object) -> Drawing:
    return Drawing.from_outlines([[outline]], (1, 0, 0, 1), (30, 40), **values)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", SHAPES)
def test_is_written_as_an_element_whichever_way_it_runs_and_read_back(kind: str) -> None:
    make, text = SHAPES[kind]
    points = make().points
    ways = [np.roll(way, -first, axis=0) for way in (points, reversed_path(points)) for first in range(len(points))]
    texts = {format_svg(layer_of(way)) for way in ways}
    assert len(texts) == 1
    (svg,) = texts
    assert f" {text}/>" in svg and "<path" not in svg
    back = read_svg(svg.encode())
    np.testing.assert_array_equal(back.points, quantize(layer_of(points)).points)
    assert format_svg(back) == svg
    assert np.abs(render(back) - render(layer_of(points))).max() < 2e-3


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("moved", [(0, 0), (1, 1), (2, 2)])
def test_any_other_outline_stays_a_path(kind: str, moved: tuple[int, int]) -> None:
    points = SHAPES[kind][0]().points.copy()
    points[moved] += (0.01, -0.01)
    assert primitive_of(points, 3) is None
    assert "<path" in format_svg(layer_of(points))


@pytest.mark.parametrize("precision", range(10))
def test_round_trip_at_every_precision(precision: int) -> None:
    rng = np.random.default_rng(precision)
    shapes = []
    for _ in range(40):
        center, radii = rng.uniform(-50, 50, 2), tuple(rng.uniform(1, 30, 2).tolist())
        low, high = center, center + rng.uniform(2, 40, 2)
        shapes += [
            ellipse(center, (radii[0], radii[0])),
            ellipse(center, radii),
            ellipse(center, radii, round(float(rng.uniform(1, 179)), 3)),
            rectangle(low, high),
            rectangle(low, high, float(rng.uniform(0, 30))),
        ]
    drawn = [shape for shape in shapes if shape is not None]
    assert len(drawn) == len(shapes)
    drawing = Drawing.from_outlines([[shape.points] for shape in drawn], (1, 0, 0, 1), (30, 40))
    held, svg = quantize(drawing, precision), format_svg(drawing, precision)
    np.testing.assert_array_equal(read_svg(svg.encode()).points, held.points)
    np.testing.assert_array_equal(quantize(held, precision).points, held.points)
    elements = re.findall(r"<(circle|ellipse|path|rect) ", svg.split("background", 1)[1])
    assert precision < 2 or elements == [shape.tag for shape in drawn]


def test_rings_strokes_and_animations_are_paths() -> None:
    disc, hole = (ellipse(np.array([20.0, 15.0]), (r, r)).points for r in (9.0, 5.0))  # type: ignore[union-attr]
    ring = Drawing.from_outlines([[disc, reversed_path(hole)]], (1, 0, 0, 1), (30, 40))
    assert "<circle" not in format_svg(ring) and "<path" in format_svg(ring)
    assert "<circle" in format_svg(layer_of(disc)) and "<circle" not in format_svg(layer_of(disc), cubics=True)


def test_gradients_are_not_turned_with_an_ellipse() -> None:
    points = SHAPES["turned"][0]().points
    fills = Fills(
        kinds=[1],
        geometry=[[[5, 5], [30, 20], [0, 0]]],
        stop_offsets=[0, 2],
        stop_positions=[0.0, 1.0],
        stop_colors=[[1, 0, 0, 1], [0, 0, 1, 1]],
    )
    drawing = layer_of(points, fills=fills)
    svg = format_svg(drawing)
    assert "<path" in svg and "transform" not in svg
    assert np.abs(render(read_svg(svg.encode())) - render(drawing)).max() < 5e-3


def test_names_are_kept_in_plain_files() -> None:
    drawing = layer_of(SHAPES["circle"][0]().points, names=["the sun's"])
    svg = format_svg(drawing, layers="plain")
    assert re.search("<circle [^>]*><title>the sun's</title></circle>", svg)
    assert read_svg(svg.encode()).names == ("the sun's",)


@pytest.mark.parametrize("kind", SHAPES)
def test_stretched_by_nearly_equal_factors_it_is_the_same_shape(kind: str) -> None:
    shape = SHAPES[kind][0]()
    factors = np.array([2.0, 2.004])
    larger = shape.scaled(factors)
    assert larger is not None and larger.tag == shape.tag
    np.testing.assert_allclose(larger.points, shape.points * factors, atol=0.1)
    assert primitive_of(larger.points, 3) is not None
