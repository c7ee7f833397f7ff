# SPDX-License-Identifier: Apache-2.0
"""Path data: lines, level and plumb ones, symmetric joins; and that a reader has the very points of the drawing."""

from __future__ import annotations

import re

import numpy as np
import pytest

from livecl.drawing import Drawing
from livecl.drawing.strokes import Strokes
from livecl.geometry.outlines import circle
from livecl.svg import format_svg, quantize, read_svg
from livecl.svg.outline_data import format_outline
from livecl.svg.shapes import ellipse_outline


def polygon(corners: list[list[float]]) -> np.ndarray:
    """Return lines as segments (m, 3, 2)."""
    starts = np.array(corners, dtype=float)
    steps = np.roll(starts, -1, axis=0) - starts
    return np.stack([starts, starts + steps / 3, starts + 2 * steps / 3], axis=1)


def drawing_of(outline: np.ndarray) -> Drawing:
    return Drawing.from_outlines([[outline]], (1, 0, 0, 1), (40, 50))


def data_of(drawing: Drawing, precision: int = 3) -> str:
    return re.findall(' d="([^"]*)"', format_svg(drawing, precision))[0]


def test_sides_are_lines_level_and_plumb_ones_as_such_and_the_last_is_the_closing_one() -> None:
    assert data_of(drawing_of(polygon([[1, 2], [11, 2], [11, 8], [4, 12.5]]))) == "M1 2h10v6l-7 4.5Z"


def test_a_bend_of_two_thousandths_stays_a_cubic() -> None:
    outline = polygon([[1, 2], [11, 2], [11, 8]])
    outline[0, 1, 1] += 0.002
    assert re.sub("[^a-zA-Z]", "", data_of(drawing_of(outline))) == "McvZ"
    outline[0, 1, 1] -= 0.001
    assert re.sub("[^a-zA-Z]", "", data_of(drawing_of(outline))) == "MhvZ"


def test_symmetric_joins_need_no_handle() -> None:
    kinked = ellipse_outline(20, 20, 7.3, 7.3)[0][:, :3]
    assert re.sub("[^a-zA-Z]", "", format_outline(quantize(drawing_of(kinked)).points, 3)) == "McsZ"
    kinked[2, 1] += (0.003, 0)
    assert re.sub("[^a-zA-Z]", "", data_of(drawing_of(kinked))) == "McscsZ"


@pytest.mark.parametrize("precision", range(10))
def test_reader_has_the_points_of_the_drawing(precision: int) -> None:
    """Of polygons and round shapes with and without level sides, short and far ones, and cubics among them."""
    rng = np.random.default_rng(precision)
    for _ in range(60):
        size = 10.0 ** rng.uniform(-1, 4)
        corners = rng.uniform(-size, size, (int(rng.integers(1, 7)), 2))
        if rng.random() < 0.5:
            corners = np.round(corners / size * 3) * size / 3
        outline = polygon(corners.tolist())
        bent = rng.random(len(outline)) < 0.3
        outline[bent, 1:] += rng.normal(0, size / 5, (int(bent.sum()), 2, 2))
        round_shape = circle(tuple(corners[0]), size, int(rng.integers(2, 9)))
        drawing = Drawing.from_outlines([[outline], [round_shape, outline]], (0, 0, 0, 1), (40, 50))
        held, back = quantize(drawing, precision), read_svg(format_svg(drawing, precision).encode())
        np.testing.assert_array_equal(back.points, held.points)
        np.testing.assert_array_equal(back.subpath_offsets, held.subpath_offsets)
        np.testing.assert_array_equal(quantize(held, precision).points, held.points)
        assert np.abs(held.points[:, 0] - drawing.points[:, 0]).max() <= 0.5 * 10.0**-precision + 1e-9 * size
        assert np.abs(held.points - drawing.points).max() <= 1.6 * 10.0**-precision + 1e-9 * size


def test_points_nowhere_apart_stay_as_they_are() -> None:
    drawing = drawing_of(np.concatenate([np.zeros((2, 3, 2)), polygon([[0, 0], [5, 0], [5, 5]]), np.zeros((1, 3, 2))]))
    np.testing.assert_array_equal(read_svg(format_svg(drawing).encode()).points, quantize(drawing).points)


@pytest.mark.parametrize("precision", range(5))
def test_two_lines_to_and_fro_stay_cubics(precision: int) -> None:
    """Rounded to whole numbers, a handle is within a unit of its neighbour's reflection, and both are lines."""
    there, back = [[0.5, 0], [0.5, 0], [7 / 12, 0]], [[0.75, 0], [2 / 3, 0], [7 / 12, 0]]
    drawing = drawing_of(np.array([there, back]))
    got = read_svg(format_svg(drawing, precision).encode())
    np.testing.assert_array_equal(got.points, quantize(drawing, precision).points)


def test_a_reflected_handle_makes_no_line() -> None:
    """Rounded to whole numbers, (125, 31) would make its cubic a line to within a unit; (126, 32) does not."""
    third = [[125.3, 28.3], [126, 32.3], [123.3, 35.3]]
    rows = [[[121.7, 20.3], [122.4, 20.3], [123.2, 20.3]], [[124, 20.3], [123.7, 23.7], [125.3, 25.3]], third]
    drawing = drawing_of(np.array([*rows, [[123, 38.3], [122.3, 36.7], [121.7, 34.7]]]))
    held = quantize(drawing, 0)
    np.testing.assert_array_equal(read_svg(format_svg(drawing, 0).encode()).points, held.points)
    assert held.points[2].tolist() == [[125, 28], [126, 32], [123, 35]]


def test_open_subpaths_are_not_closed_and_their_last_line_is_written() -> None:
    outline = polygon([[1, 2], [11, 2], [11, 8]])
    assert format_outline(outline, 3, is_open=True) == "M1 2h10v6"
    drawing = Drawing.from_outlines([[outline]], (1, 0, 0, 1), (40, 50), strokes=Strokes(widths=[2.0], is_open=[True]))
    assert data_of(drawing) == "M1 2h10v6"


def test_all_segments_can_be_cubics() -> None:
    letters = re.sub("[^a-zA-Z]", "", format_outline(circle((20, 20), 5, 4), 3, cubics=True))
    assert letters == "McZ"
