# SPDX-License-Identifier: Apache-2.0
"""Outlines read from SVG: commands of paths and basic shapes, against values worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.svg_documents import (
    SQUARE,
    assert_points,
    lines,
    quarter,
    read,
    read_path,
    shifted,
)

from livecl.geometry import bezier


@pytest.mark.parametrize(
    "data",
    [
        "M1 2L4 2L4 6L1 6Z",
        "M1,2 4,2 4,6 1,6z",
        "m1 2 3 0 0 4-3 0z",
        "M1 2H4V6H1Z",
        "m1 2h3v4h-3z",
        "M1 2h3v4h-3",
        "M1 2h3v4h-3v-4",
        "M1 2h3v4h-3L1 2z",
        "  M 1e0 .2e1 h +3. v 4 h -3 z M 50 50 z M 60 60",
    ],
)
def test_lines(data: str) -> None:
    drawing = read_path(data)
    assert drawing.num_layers == 1
    assert_points(drawing, SQUARE)


@pytest.mark.parametrize("data", ["M1 2C1 3 2 4 3 4C4 4 5 3 5 2C5 1 2 1 1 2z", "m1 2c0 1 1 2 2 2s2-1 2-2c0-1-3-1-4 0"])
def test_cubics(data: str) -> None:
    assert_points(read_path(data), [[[1, 2], [1, 3], [2, 4]], [[3, 4], [4, 4], [5, 3]], [[5, 2], [5, 1], [2, 1]]])


@pytest.mark.parametrize("data", ["M0 0Q3 6 6 0Q9-6 12 0z", "m0 0q3 6 6 0t6 0z"])
def test_quadratics_are_raised(data: str) -> None:
    """Handles at two thirds of the way to the quadratic's handle."""
    closing = [[12, 0], [8, 0], [4, 0]]
    assert_points(read_path(data), [[[0, 0], [2, 4], [4, 4]], [[6, 0], [8, -4], [10, -4]], closing])


def test_smooth_commands_reflect_handles_of_their_own_kind_only() -> None:
    cubic = read_path("M0 0Q3 6 6 0S9 9 9 0z").points[1]
    np.testing.assert_allclose(cubic, [[6, 0], [6, 0], [9, 9]])
    quadratics = read_path("M0 0C1 1 2 2 6 0T9 0T12 3z").points[1:3]
    np.testing.assert_allclose(quadratics, [[[6, 0], [6, 0], [7, 0]], [[9, 0], [11, 0], [12, 1]]], atol=1e-12)


def test_arcs() -> None:
    half = read_path("M10 20A5 5 0 0 1 20 20z")
    chord = lines((20, 20), (10, 20))[:1]
    assert_points(half, [quarter(0.5, (15, 20), (5, 5)), quarter(0.75, (15, 20), (5, 5))], chord)
    small = read_path("M10 20a5 3 0 015 3L10 23z")
    assert_points(small, quarter(0.75, (10, 23), (5, 3))[None], lines((15, 23), (10, 23), (10, 20))[:2])


@pytest.mark.parametrize(("flags", "share"), [("0 0", 0.25), ("0 1", 0.25), ("1 0", 0.75), ("1 1", 0.75)])
def test_arc_flags(flags: str, share: float) -> None:
    """A quarter and three quarters of a circle of radius 10 on a chord, on either side of it."""
    cubics = read_path(f"M30 30A10 10 0 {flags} 40 40z").cubics
    segment = math.pi * 100 * share - 50 * (1 if share < 0.5 else -1)
    turns = 1 if flags.endswith("1") else -1
    assert bezier.signed_area(cubics) == pytest.approx(turns * segment, rel=2e-3)


def test_rotated_arc_whose_radii_are_too_small_is_scaled_up() -> None:
    cubics = read_path("M10 10A1 2 30 0 1 10 40z").cubics
    on_arc = bezier.evaluate(cubics[:-1], np.linspace(0, 1, 9)).reshape(-1, 2) - (10, 25)
    angle = math.radians(30)
    across = on_arc @ [math.cos(angle), math.sin(angle)]
    along = on_arc @ [-math.sin(angle), math.cos(angle)]
    size = across**2 + (along / 2) ** 2
    np.testing.assert_allclose(size, size[0], rtol=1e-3)


@pytest.mark.parametrize("data", ["M1 2A0 5 0 0 1 4 2V6H1z", "M1 2h3v4H1A3 3 0 1 1 1 6z"])
def test_arc_without_a_radius_or_a_way_is_a_line_or_nothing(data: str) -> None:
    assert_points(read_path(data), SQUARE)


def test_subpaths() -> None:
    """Relative moves start at the subpath's start; a drawing command after Z does too."""
    drawing = read_path("M1 2h3v4h-3z m10 0h3v4h-3z h-3v-4h3")
    assert_points(drawing, SQUARE, shifted(SQUARE, 10, 0), lines((11, 2), (8, 2), (8, -2), (11, -2)))
    assert drawing.num_layers == 1
    assert drawing.subpath_offsets.tolist() == [0, 4, 8, 12]


@pytest.mark.parametrize("data", ["", "none", "M5 5", "M5 5z", "M1 1L5 5", "M1 1L5 5z", "M1 1h0v0z"])
def test_what_encloses_nothing_is_dropped(data: str) -> None:
    assert read_path(data).num_layers == 0


def test_basic_shapes() -> None:
    drawing = read(
        '<rect x="1" y="2" width="3" height="4"/><circle cx="10" cy="20" r="5"/>'
        '<ellipse cx="10" cy="20" rx="5" ry="3"/>'
        '<polygon points="1,2 4,2 4,6 1,6"/><polyline points="1 2,4 2,4 6 1 6"/>'
    )
    circle = [quarter(i / 4, (10, 20), (5, 5)) for i in range(4)]
    ellipse = [quarter(i / 4, (10, 20), (5, 3)) for i in range(4)]
    assert_points(drawing, SQUARE, circle, ellipse, SQUARE, SQUARE)
    assert drawing.num_layers == 5
    np.testing.assert_array_equal(drawing.colors, [[0, 0, 0, 1]] * 5)


def test_rounded_rectangle() -> None:
    """One radius given stands for both; a radius over half the side is that half, which leaves no line there."""
    drawing = read('<rect x="10" y="20" width="30" height="10" rx="20" ry="2"/><rect width="10" height="10" ry="2"/>')
    assert drawing.num_segments == 6 + 8
    area = bezier.signed_area(drawing.cubics[:6])
    assert area == pytest.approx(30 * 10 - (4 - math.pi) * 15 * 2, rel=1e-4)
    assert bezier.signed_area(drawing.cubics[6:]) == pytest.approx(100 - (4 - math.pi) * 4, rel=1e-4)


def test_shapes_without_area_are_dropped() -> None:
    rounds = '<circle/><ellipse rx="0" ry="5"/>'
    straight = '<rect width="5"/><rect width="-5" height="5"/><polygon points="1 1 2 2"/><line x2="9"/>'
    assert read(rounds + straight).num_layers == 0
