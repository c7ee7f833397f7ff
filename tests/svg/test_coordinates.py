# SPDX-License-Identifier: Apache-2.0
"""Coordinates of foreign SVG: lengths, units, transforms, the canvas."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import ArrayLike
from support.svg_documents import (
    SQUARE,
    assert_points,
    document,
    left_out,
    lines,
    quarter,
    read,
    shifted,
)

from livecl.svg import read_svg


def test_lengths() -> None:
    """Percentages are of the viewport: of its width, its height, its diagonal over the root of 2."""
    drawing = read('<rect x="1in" y="72pt" width="10%" height="10%"/><circle r="10%"/>', 'width="300" height="400"')
    assert_points(
        drawing,
        lines((96, 96), (126, 96), (126, 136), (96, 136)),
        [quarter(i / 4, (0, 0), [math.hypot(300, 400) / math.sqrt(2) / 10] * 2) for i in range(4)],
    )


@pytest.mark.parametrize(
    ("transform", "corners"),
    [
        ("translate(10)", [(11, 2), (14, 2), (14, 6), (11, 6)]),
        ("translate(10,-2) scale(2)", [(12, 2), (18, 2), (18, 10), (12, 10)]),
        ("scale(2 -1)", [(2, -2), (8, -2), (8, -6), (2, -6)]),
        ("rotate(90)", [(-2, 1), (-2, 4), (-6, 4), (-6, 1)]),
        ("rotate(90 1 2)", [(1, 2), (1, 5), (-3, 5), (-3, 2)]),
        ("skewX(45)", [(3, 2), (6, 2), (10, 6), (7, 6)]),
        ("matrix(0 1 -1 0 5 6)", [(3, 7), (3, 10), (-1, 10), (-1, 7)]),
    ],
)
def test_transforms(transform: str, corners: Sequence[ArrayLike]) -> None:
    rect = '<rect x="1" y="2" width="3" height="4"{}/>'
    assert_points(read(rect.format(f' transform="{transform}"')), lines(*corners))
    assert_points(read(f'<g transform="{transform}"><g>{rect.format("")}</g></g>'), lines(*corners))


def test_transforms_nest_and_bend_curves() -> None:
    drawing = read('<g transform="translate(7 3)"><circle r="2" transform="scale(3 1)"/></g>')
    assert_points(drawing, [quarter(i / 4, (7, 3), (6, 2)) for i in range(4)])


@pytest.mark.parametrize(
    ("attributes", "size", "scale", "shift"),
    [
        ('width="100" height="50"', (50, 100), (1, 1), (0, 0)),
        ('width="99.2" height="50.0005"', (50, 100), (1, 1), (0, 0)),
        ('width="100" height="50" viewBox="0 0 50 25"', (50, 100), (2, 2), (0, 0)),
        ('width="100" height="50" viewBox="10 20 100 50"', (50, 100), (1, 1), (-10, -20)),
        ('width="100" height="50" viewBox="0 0 20 20"', (50, 100), (2.5, 2.5), (25, 0)),
        ('width="100" height="50" viewBox="0 0 20 20" preserveAspectRatio="none"', (50, 100), (5, 2.5), (0, 0)),
        ('width="100" height="50" viewBox="0 0 20 20" preserveAspectRatio="xMaxYMid"', (50, 100), (2.5, 2.5), (50, 0)),
        ('width="100" height="50" viewBox="0 0 20 20" preserveAspectRatio="xMidYMin slice"', (50, 100), (5, 5), (0, 0)),
        ('viewBox="0 0 40 30"', (30, 40), (1, 1), (0, 0)),
        ('width="100%" height="100%" viewBox="0 0 40 30"', (30, 40), (1, 1), (0, 0)),
        ('width="80" viewBox="0,0,40,30"', (60, 80), (2, 2), (0, 0)),
        ('width="1in" height="25.4mm"', (96, 96), (1, 1), (0, 0)),
    ],
)
def test_canvas(attributes: str, size: tuple[int, int], scale: Sequence[float], shift: Sequence[float]) -> None:
    drawing = read('<rect x="1" y="2" width="3" height="4"/>', attributes)
    assert drawing.size == size
    assert drawing.background is None
    assert_points(drawing, shifted(SQUARE * np.array(scale), *shift))


def test_units_of_the_font_and_the_canvas() -> None:
    drawing = read('<g style="font:bold 20px/1.5 serif"><rect x=".1em" y=".2ex" width=".15em" height=".4ex"/></g>')
    assert_points(drawing, lines((2, 2), (5, 2), (5, 6), (2, 6)))
    drawing = read('<g font-size="xx-large"><g font-size="50%"><rect width="1em" height="2ex"/></g></g>')
    assert_points(drawing, lines((0, 0), (16, 0), (16, 16), (0, 16)))
    drawing, names = left_out('<rect x="1vw" y="2vh" width="3vmin" height="4vmax"/><rect width="1rem" height="1ch"/>')
    assert_points(drawing, SQUARE, lines((0, 0), (16, 0), (16, 8), (0, 8)))
    assert names == "lengths in units of the page or of the font's letters (6)"


@pytest.mark.parametrize(
    ("attributes", "size", "guess"),
    [
        ('height="80"', (80, 300), True),
        ("", (150, 300), True),
        ('width="50%" height="40"', (40, 150), True),
        ('width="2em" height="1em"', (16, 32), False),
        ('width="2em" font-size="10" viewBox="0 0 9 9"', (20, 20), False),
        ('style="width:30px;height:20px"', (20, 30), False),
    ],
)
def test_sizes_by_default(attributes: str, size: tuple[int, int], guess: bool) -> None:
    if guess:
        with pytest.warns(UserWarning, match="sides of the canvas, not stated and taken as 300 by 150 px"):
            assert read_svg(document("", attributes)).size == size
    else:
        assert read("", attributes).size == size


@pytest.mark.parametrize(
    ("style", "shift"),
    [
        ("transform-origin:4px 6px", (3, 4)),
        ("transform-origin:100% 50%", (99, 48)),
        ("transform-origin:top right", (99, -2)),
        ("transform-origin:bottom", (49, 98)),
        ("transform-box:view-box;transform-origin:left 6px", (-1, 4)),
    ],
)
def test_transform_origins(style: str, shift: tuple[float, float]) -> None:
    """Half a turn about the origin takes the square's corner (1, 2), whose shift from it is given, to the far side."""
    drawing = read(f'<rect x="1" y="2" width="3" height="4" style="{style};transform:rotate(.5turn)"/>')
    corner = np.add((1, 2), np.multiply(shift, 2))
    assert_points(
        drawing, lines(*(2 * corner - corner - np.subtract(p, (1, 2)) for p in ((1, 2), (4, 2), (4, 6), (1, 6))))
    )
    names = left_out(
        '<rect width="9" height="9" style="transform-box:fill-box;transform-origin:0 0" transform="scale(2)"/>'
    )
    assert names[1] == "transform origins (1)"
