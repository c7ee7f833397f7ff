# SPDX-License-Identifier: Apache-2.0
"""A shape on a larger one of even width around it becomes one shape with a stroke, where that is cheaper."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import arc, polygon
from support.outlined_drawings import DRAWINGS, INK, RED, SIZE, WHITE, YELLOW, outlined

from livecl import Drawing, Options, Rasterizer, render, vectorize
from livecl.drawing.borders import border_pairs
from livecl.editing import bordered
from livecl.layering.context import Context
from livecl.svg import format_svg, read_svg


def _filled(*shapes: tuple[np.ndarray, tuple[float, float, float]]) -> Drawing:
    return Drawing.from_outlines([[rows] for rows, _ in shapes], [(*color, 1) for _, color in shapes], SIZE)


def _bordered(drawing: Drawing, target: Drawing | None = None) -> Drawing:
    image = render(drawing if target is None else target)
    context = Context(Rasterizer(SIZE), image, Options(strokes="auto"))
    return bordered(context, drawing, np.ones(drawing.num_layers, bool))[0]


def test_two_discs_are_one_with_a_stroke() -> None:
    found = _bordered(_filled((arc(80, 80, 60)[0], INK), (arc(80, 80, 52)[0], YELLOW)))

    assert border_pairs(found).tolist() == [[0, 1]]
    np.testing.assert_allclose(found.strokes.widths, [0, 8], atol=0.02)
    np.testing.assert_allclose(found.points[:4], arc(80, 80, 56)[0], atol=0.02)
    np.testing.assert_allclose(found.colors[:, :3], [YELLOW, INK])


@pytest.mark.parametrize(
    "inner",
    [
        arc(80, 80, 30)[0] + (12, 0),  # not in the middle
        arc(80, 80, 30, squeeze=0.5)[0],
        polygon((60, 60), (100, 60), (100, 100), (60, 100))[0],
    ],
)
def test_rings_of_uneven_width_stay(inner: np.ndarray) -> None:
    drawing = _filled((arc(80, 80, 45)[0], INK), (inner, YELLOW))

    assert _bordered(drawing) is drawing


def test_a_shape_beneath_several_stays_where_strokes_are_more_numbers() -> None:
    cells = [polygon((x, y), (x + 50, y), (x + 50, y + 50), (x, y + 50))[0] for x in (25, 81) for y in (25, 81)]
    drawing = _filled((polygon((19, 19), (137, 19), (137, 137), (19, 137))[0], INK), *((cell, RED) for cell in cells))

    assert _bordered(drawing) is drawing


def test_locked_layers_stay() -> None:
    drawing = _filled((arc(80, 80, 60)[0], INK), (arc(80, 80, 52)[0], YELLOW))
    context = Context(Rasterizer(SIZE), render(drawing), Options(strokes="auto"))

    for locked in (0, 1):
        assert bordered(context, drawing, np.arange(2) != locked)[0] is drawing


def test_sources_tell_which_layer_each_was() -> None:
    drawing = _filled(
        (polygon((2, 2), (12, 2), (12, 12), (2, 12))[0], RED), (arc(80, 80, 60)[0], INK), (arc(80, 80, 52)[0], YELLOW)
    )
    context = Context(Rasterizer(SIZE), render(drawing), Options(strokes="auto"))

    found, sources = bordered(context, drawing, np.ones(3, bool))

    assert sources.tolist() == [0, 2, 2]
    np.testing.assert_array_equal(found.points[:4], drawing.points[:4])


@pytest.mark.parametrize("name", ["badge", "hexagon", "shield", "sign"])
def test_outlined_shapes_of_a_picture_are_one_element_each(name: str) -> None:
    true = DRAWINGS[name]
    image = render(true)

    plain = vectorize(image, paths="auto", options=Options(strokes="off"))
    found = vectorize(image, paths="auto", options=Options(strokes="auto"))

    pairs, wanted = border_pairs(found.drawing), border_pairs(true)
    assert len(pairs) == len(wanted)
    np.testing.assert_allclose(found.drawing.strokes.widths[pairs[:, 1]], true.strokes.widths[wanted[:, 1]], rtol=0.01)
    assert found.mse <= 1.05 * plain.mse
    text = format_svg(found.drawing)
    assert text.count(' stroke="') == len(wanted)
    assert 'fill="none"' not in text
    again = read_svg(text.encode())
    np.testing.assert_array_equal(again.points, found.drawing.points)
    assert format_svg(again) == text


def test_a_gradient_may_fill_what_is_stroked() -> None:
    from livecl.drawing import Fills
    from livecl.drawing.fills import concatenate_fills

    drawing = _filled((arc(80, 80, 60)[0], INK), (arc(80, 80, 52)[0], YELLOW))
    ramp = Fills.linear((30, 80), (130, 80), [[1, 0.8, 0.2, 1], [0.9, 0.3, 0.2, 1]])
    drawing = drawing.replace(fills=concatenate_fills([Fills.solid(1), ramp]))

    found = _bordered(drawing)

    assert border_pairs(found).tolist() == [[0, 1]]
    assert found.fills.gradient_layers.tolist() == [0]
    assert "url(#" in format_svg(found)


def test_stroked_shapes_of_the_drawings_are_one_element_each() -> None:
    true = outlined((arc(80, 80, 50)[0], WHITE, RED, 6))

    assert format_svg(true).count("<circle") == 1
