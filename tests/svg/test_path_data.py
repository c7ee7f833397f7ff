# SPDX-License-Identifier: Apache-2.0
"""Path data: its grammar, its errors, and arcs, against values worked out by hand."""

from __future__ import annotations

import cmath
import math
import random

import numpy as np
import pytest
from support.svg_documents import SQUARE, assert_points, left_out, lines, read

from livecl.geometry import bezier
from livecl.svg.path_data import number_list, path_outline, plain_data

TRIANGLE = "M1 2H4V6"


@pytest.mark.parametrize(
    "rest",
    [
        "L",
        "L 5",
        "L 5 5,",
        "x",
        "C1 2 3 4 5",
        "z 5",
        "h",
        "A5 5 0 2 0 9 9",
        "L 5#5",
        "a5 5 0 0",
        "L.",
        "V",
    ],
)
def test_errors_in_path_data_end_the_drawing(rest: str) -> None:
    """What is whole before the error is drawn (SVG 1.1, F.2), and a warning says so."""
    for data in (TRIANGLE + rest, f"{TRIANGLE}{rest}M50 50h9v9"):
        drawing, names = left_out(f'<path d="{data}"/>')
        wanted = lines((1, 2), (4, 2), (4, 6), (5, 5)) if rest == "L 5 5," else lines((1, 2), (4, 2), (4, 6))
        assert_points(drawing, wanted)
        assert names == "errors in path data, drawn up to them (1)"


@pytest.mark.parametrize("data", ["v-8", "L5 5 6 7z", "garbage", "z"])
def test_data_that_does_not_begin_with_a_move_draws_nothing(data: str) -> None:
    drawing, names = left_out(f'<path d="{data}"/>')
    assert drawing.num_layers == 0
    assert names == "errors in path data, drawn up to them (1)"


def test_paths_without_data_draw_nothing() -> None:
    for attribute in ("", 'd=""', 'd="none"', 'd=" "'):
        assert read(f"<path {attribute}/>").num_layers == 0


def test_points_of_polygons_end_at_an_error_too() -> None:
    for rest in (" 9", " x 9 9", ",", " 9,,9"):
        drawing, names = left_out(f'<polygon points="1,2 4,2 4,6 1,6{rest}"/>')
        assert_points(drawing, SQUARE)
        assert names == "errors in path data, drawn up to them (1)"


def test_data_in_css() -> None:
    assert plain_data('path("M0 0")') == plain_data("path( 'M0 0' )") == plain_data("M0 0") == "M0 0"
    assert_points(read("""<path d="M9 9h9v9" style="d:path('M1 2h3v4h-3')"/>"""), SQUARE)


def test_number_lists() -> None:
    for text in ("1,2 3", "1 2,3", " 1-2e0.5e1", "+1 , 2\n3"):
        numbers, whole = number_list(text)
        assert whole
        assert len(numbers) == 3
    for text in ("1,,2", ",1", "1,", "1 x 2", "1 ٢"):
        assert number_list(text) == ([] if text == ",1" else [1.0], False)


def test_arcs_are_on_their_ellipse() -> None:
    """For random radii, turns and flags: ends where it is to end, near the ellipse, on the side that the flags say."""
    rng = random.Random(1)
    for _ in range(200):
        rx, ry, turn = rng.uniform(5, 40), rng.uniform(5, 40), rng.uniform(-400, 400)
        large, sweep = rng.randint(0, 1), rng.randint(0, 1)
        end = complex(rng.uniform(-30, 30), rng.uniform(-30, 30))
        (subpath,), whole = path_outline(f"M0 0A{rx} {ry} {turn} {large}{sweep}{end.real} {end.imag}")
        assert whole
        arc = subpath[:-1]
        np.testing.assert_allclose(arc[-1, 3], (end.real, end.imag))
        points = bezier.evaluate(arc, np.linspace(0, 1, 9)).reshape(-1, 2)
        z = (points[:, 0] + 1j * points[:, 1]) * cmath.exp(-1j * math.radians(turn))
        circle = z.real / rx + 1j * z.imag / ry
        chord = abs(circle[-1] - circle[0])
        radius = max(1.0, chord / 2)
        middle, half = (circle[0] + circle[-1]) / 2, (circle[-1] - circle[0]) / 2
        beside = 1j * half / abs(half) * math.sqrt(max(0.0, radius**2 - abs(half) ** 2))
        center = middle + beside if large != sweep else middle - beside
        np.testing.assert_allclose(abs(circle - center), radius, rtol=3e-4)
        turned = np.unwrap(np.angle(circle - center))
        assert (turned[-1] > turned[0]) == bool(sweep)
        if radius == 1:
            assert (abs(turned[-1] - turned[0]) > math.pi) == bool(large)
