# SPDX-License-Identifier: Apache-2.0
"""Strokes of an SVG: read as pens along lines, cut into dashes, and written so that they are read back equal."""

from __future__ import annotations

import numpy as np
import pytest
from support.svg_documents import left_out, read

from livecl.drawing import Drawing, Strokes
from livecl.errors import SvgError
from livecl.geometry.strokes import CAPS, JOINS
from livecl.svg import format_svg, quantize, read_svg

STROKE = 'fill="none" stroke="#f00"'


def _pen(drawing: Drawing, layer: int = 0) -> tuple[float, str, str, float]:
    strokes = drawing.strokes
    return (
        float(strokes.widths[layer]),
        CAPS[strokes.caps[layer]],
        JOINS[strokes.joins[layer]],
        float(strokes.miter_limits[layer]),
    )


def _ends(drawing: Drawing) -> list[list[list[float]]]:
    """First and last anchor of each subpath."""
    return [drawing.points[[rows.start, rows.stop - 1], 0].tolist() for rows in drawing.subpaths()]


def test_a_pen_is_read() -> None:
    style = 'stroke-width="3" stroke-linecap="round" stroke-linejoin="bevel" stroke-opacity="0.2" stroke-miterlimit="9"'
    drawing = read(f'<path d="M10 10H50V40" {STROKE} {style}/>')

    assert _pen(drawing) == (3.0, "round", "bevel", 9.0)
    np.testing.assert_allclose(drawing.colors, [[1, 0, 0, 0.2]])
    assert drawing.strokes.is_open.tolist() == [True]
    assert drawing.points[:, 0].tolist() == [[10, 10], [50, 10], [50, 40]]


def test_defaults_and_inheritance() -> None:
    drawing = read(f'<g stroke-width="7"><path d="M1 1L2 2" {STROKE}/></g><path d="M1 1L2 2" {STROKE}/>')

    assert _pen(drawing, 0) == (7.0, "butt", "miter", 4.0)
    assert _pen(drawing, 1) == (1.0, "butt", "miter", 4.0)


@pytest.mark.parametrize(
    ("body", "is_open"),
    [
        ('<path d="M1 2L9 2L9 9z"', False),
        ('<path d="M1 2L9 2L9 9"', True),
        ('<line x1="1" y1="2" x2="9" y2="9"', True),
        ('<polyline points="1 2 9 2 9 9"', True),
        ('<polygon points="1 2 9 2 9 9"', False),
        ('<rect x="1" y="2" width="8" height="7"', False),
        ('<circle cx="5" cy="5" r="4"', False),
        ('<path d="M1 2z"', False),
        ('<path d="M1 2h0"', True),
    ],
)
def test_shapes_are_open_or_closed(body: str, is_open: bool) -> None:
    assert read(f"{body} {STROKE}/>").strokes.is_open.tolist() == [is_open]


def test_a_move_alone_draws_nothing() -> None:
    assert read(f'<path d="M5 5M1 1L9 9M7 7" {STROKE}/>').strokes.is_open.tolist() == [True]


@pytest.mark.parametrize(("order", "first"), [("normal", 0.0), ("stroke", 3.0), ("markers stroke", 3.0), ("fill", 0.0)])
def test_fill_and_stroke_are_two_layers_in_paint_order(order: str, first: float) -> None:
    drawing = read(
        f'<rect id="box" width="9" height="9" fill="#0f0" stroke="#f00" stroke-width="3" paint-order="{order}"/>'
    )

    assert drawing.strokes.widths.tolist() == ([0, 3] if first == 0 else [3, 0])
    assert drawing.names == ("box", "box")


@pytest.mark.parametrize(
    ("transform", "effect", "width"),
    [
        ("scale(2)", "none", 6.0),
        ("rotate(30) scale(-2 2)", "none", 6.0),
        ("scale(2)", "non-scaling-stroke", 3.0),
        ("scale(2 3)", "non-scaling-stroke", 3.0),
    ],
)
def test_transforms_scale_the_pen(transform: str, effect: str, width: float) -> None:
    drawing = read(f'<path d="M1 1L9 9" {STROKE} stroke-width="3" vector-effect="{effect}" transform="{transform}"/>')

    assert drawing.strokes.widths[0] == pytest.approx(width)


def test_a_stretched_stroke_is_its_outline() -> None:
    drawing = read(f'<path d="M10 10H30" {STROKE} stroke-width="4" transform="scale(1 3)"/>')

    assert not drawing.strokes.any
    np.testing.assert_allclose(drawing.points[..., 0].min(), 10)
    assert drawing.points[..., 1].min() == pytest.approx(24)
    assert drawing.points[..., 1].max() == pytest.approx(36)


def test_dashes_are_open_paths() -> None:
    drawing = read(f'<path d="M0 5H20" {STROKE} stroke-dasharray="4 2" stroke-dashoffset="1"/>')

    starts_and_ends = [[0, 3], [5, 9], [11, 15], [17, 20]]
    np.testing.assert_allclose(np.array(_ends(drawing))[..., 0], starts_and_ends, atol=1e-9)
    assert drawing.strokes.is_open.all()


def test_dashes_that_meet_at_the_start_of_a_closed_path_are_one() -> None:
    drawing = read(
        f'<rect x="10" y="10" width="10" height="10" {STROKE} stroke-dasharray="5 5" stroke-dashoffset="2"/>'
    )

    # From 38 on around the corner at (10, 10), to 3 along the upper side.
    np.testing.assert_allclose(_ends(drawing)[0], [[10, 12], [13, 10]], atol=1e-9)
    assert len(_ends(drawing)) == 4


def test_odd_dashes_repeat_and_negative_ones_are_none() -> None:
    odd = read(f'<path d="M0 5H12" {STROKE} stroke-dasharray="3"/>')
    none = read(f'<path d="M0 5H12" {STROKE} stroke-dasharray="3 -1"/>')

    np.testing.assert_allclose(np.array(_ends(odd))[..., 0], [[0, 3], [6, 9]], atol=1e-9)
    assert np.array(_ends(none))[..., 0].tolist() == [[0, 12]]


def test_too_many_dashes_are_refused() -> None:
    with pytest.raises(SvgError, match="dashes"):
        read(f'<path d="M0 5H90" {STROKE} stroke-dasharray="0.0001"/>')


@pytest.mark.parametrize("style", ['stroke-width="0"', 'stroke-width="-2"', 'stroke-miterlimit="0"'])
def test_pens_that_draw_nothing(style: str) -> None:
    assert read(f'<path d="M1 1L9 9" {STROKE} {style}/>').num_layers == 0


def test_invisible_strokes_are_layers_where_there_is_nothing_else() -> None:
    """As saved layers are, which all come back; beside a fill, such a stroke is none."""
    drawing = read(f'<path d="M1 1L9 9" {STROKE} stroke-opacity="0"/>')
    assert drawing.num_layers == 1 and drawing.colors[0, 3] == 0
    assert read_svg(format_svg(drawing).encode()).num_layers == 1
    assert read('<path d="M1 1L9 9L1 9Z" fill="red" stroke="blue" stroke-opacity="0"/>').num_layers == 1


@pytest.mark.parametrize("transform", ["", 'transform="skewX(20)"', 'transform="scale(1 -3)"'])
def test_strokes_too_far_away_are_refused_at_once(transform: str) -> None:
    """Outlining them where they are stretched unevenly would make hundreds of millions of lines."""
    with pytest.raises(SvgError, match=r"all numbers must be finite and within \[-1e\+06, 1e\+06\]"):
        read(f'<path d="M0 0C1e15 0 1e15 1e15 5 5" {STROKE} {transform}/>')


def test_joins_of_svg_2_are_named() -> None:
    drawing, names = left_out(f'<path d="M1 1L9 9L1 20" {STROKE} stroke-linejoin="arcs"/>')

    assert names == "joins of SVG 2, read as miters (1)"
    assert _pen(drawing)[2] == "miter"


def test_opacity_of_a_filled_and_stroked_shape_is_named() -> None:
    _, names = left_out('<rect width="9" height="9" fill="#0f0" stroke="#f00" opacity="0.5"/>')

    assert names == "group opacity over overlapping shapes (1)"


def test_gradients_paint_strokes() -> None:
    drawing = read(
        '<linearGradient id="g" gradientUnits="userSpaceOnUse" x2="20"><stop stop-color="red"/>'
        '<stop offset="1" stop-color="blue"/></linearGradient>'
        '<path d="M0 5H20" fill="none" stroke="url(#g)" stroke-width="2"/>'
    )

    assert drawing.fills.gradient_layers.tolist() == [0]
    assert drawing.strokes.widths.tolist() == [2]


@pytest.mark.parametrize("layers", ["inkscape", "plain"])
def test_written_strokes_are_read_back_equal(layers: str) -> None:
    rng = np.random.default_rng(4)
    outlines = [[rng.uniform(0, 50, (rows, 3, 2))] for rows in (3, 4, 2, 5)]
    strokes = Strokes(
        widths=[2.3456, 0, 1e-7, 5],
        caps=[2, 0, 1, 0],
        joins=[0, 0, 1, 2],
        miter_limits=[7.5, 4, 4, 4],
        is_open=np.array([True, False, True, False]),
    )
    drawing = quantize(Drawing.from_outlines(outlines, rng.uniform(size=(4, 4)), (50, 50), strokes=strokes))

    back = read_svg(format_svg(drawing, layers=layers).encode())  # type: ignore[arg-type]

    np.testing.assert_array_equal(back.points, drawing.points)
    np.testing.assert_allclose(back.colors, drawing.colors, rtol=0, atol=1e-12)
    assert drawing.strokes.widths.tolist() == [2.346, 0, 0.001, 5]
    for name in ("widths", "caps", "joins", "is_open"):
        np.testing.assert_array_equal(getattr(back.strokes, name), getattr(drawing.strokes, name))
    assert back.strokes.miter_limits[0] == 7.5


@pytest.mark.parametrize("order", ["normal", "stroke"])
@pytest.mark.parametrize(
    "shape",
    [
        '<path d="M10 10h40v30l-9 9z"',
        '<rect x="10" y="10" width="40" height="30" rx="5"',
        '<circle cx="30" cy="30" r="20"',
        '<polygon points="10 10 50 10 50 40"',
    ],
)
def test_a_fill_and_its_stroke_are_written_as_one_element(shape: str, order: str) -> None:
    drawing = read(f'{shape} id="a" fill="#0f0" stroke="#f00" stroke-width="3" paint-order="{order}"/>')

    text = format_svg(drawing)

    assert text.count('stroke="#ff0000"') == text.count('fill="#00ff00"') == 1
    assert 'fill="none"' not in text
    assert ('paint-order="stroke"' in text) == (order == "stroke")
    again = read_svg(text.encode())
    np.testing.assert_array_equal(again.points, quantize(drawing).points)
    np.testing.assert_array_equal(again.strokes.widths, drawing.strokes.widths)
    assert format_svg(again) == text


def test_two_outlined_shapes_of_one_look_keep_their_names() -> None:
    circles = "".join(f'<circle cx="32" cy="32" r="{r}" fill="#fff" stroke="#000" stroke-width="2"/>' for r in (20, 10))
    text = format_svg(read(circles))

    assert format_svg(read_svg(text.encode())) == text
