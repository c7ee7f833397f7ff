# SPDX-License-Identifier: Apache-2.0
"""Outlines of strokes: closed forms of their areas, and their gradients."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike

from livecl.geometry.strokes import (
    BEVEL,
    BUTT,
    CAPS,
    JOINS,
    MITER,
    ROUND,
    SQUARE,
    Pens,
    StrokeOutlines,
    outline_strokes,
)

CORNER = [[0, 0], [10, 0], [10, 10]]
SQUARE_PATH = [[0, 0], [10, 0], [10, 10], [0, 10]]
#: Bound of the area lost to the lines of a half disc of radius 1: its arc is kept within the tolerance.
FINE = 1e-5


def _stroke(
    vertices: ArrayLike,
    cap: int = BUTT,
    join: int = MITER,
    width: float = 2.0,
    closed: bool = False,
    limit: float = 4.0,
) -> StrokeOutlines:
    return outline_strokes(
        vertices,
        [0, len(np.asarray(vertices))],
        Pens([width], [cap], [join], [limit]),
        closed=[closed],
        tolerance=FINE,
    )


def _area(outlines: StrokeOutlines) -> float:
    """Signed area, the sum over all loops: that of the stroke where it does not overlap itself."""
    total = 0.0
    for first, last in zip(outlines.loop_offsets[:-1], outlines.loop_offsets[1:], strict=True):
        x, y = outlines.points[first:last].T
        total += float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    return total


@pytest.mark.parametrize(("cap", "ends"), [(BUTT, 0), (ROUND, np.pi), (SQUARE, 4)])
@pytest.mark.parametrize("end", [[10, 0], [-10, 0], [6, 8], [-8, 6]])
def test_caps_of_a_line(cap: int, ends: float, end: list[float]) -> None:
    assert _area(_stroke([[0, 0], end], cap)) == pytest.approx(20 + ends, abs=2 * np.pi * FINE)


@pytest.mark.parametrize(("join", "corner"), [(MITER, 1), (ROUND, np.pi / 4), (BEVEL, 1 / 2)])
@pytest.mark.parametrize("turned", [False, True])
def test_joins_of_a_right_angle(join: int, corner: float, turned: bool) -> None:
    vertices = CORNER[::-1] if turned else CORNER
    # Two rectangles of 10 x 2 share a square of 1 x 1 inside the corner.
    assert _area(_stroke(vertices, BUTT, join)) == pytest.approx(40 - 1 + corner, abs=np.pi * FINE)


def test_miters_beyond_the_limit_are_bevels() -> None:
    # The miter of a right angle is as long as sqrt(2) widths.
    assert _area(_stroke(CORNER, limit=1.42)) == pytest.approx(40)
    assert _area(_stroke(CORNER, limit=1.41)) == pytest.approx(39.5)


@pytest.mark.parametrize("vertices", [SQUARE_PATH, SQUARE_PATH[::-1], [*SQUARE_PATH, SQUARE_PATH[0]]])
def test_closed_strokes_are_rings(vertices: list[list[float]]) -> None:
    outlines = _stroke(vertices, closed=True)

    assert len(outlines.loop_offsets) == 3
    assert _area(outlines) == pytest.approx(12**2 - 8**2)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize(("cap", "area"), [(BUTT, 0), (ROUND, np.pi), (SQUARE, 4)])
def test_strokes_of_no_length_are_dots(cap: int, area: float, closed: bool) -> None:
    assert _area(_stroke([[3, 4], [3, 4]], cap, closed=closed)) == pytest.approx(area, abs=2 * np.pi * FINE)


def test_a_stroke_wider_than_its_curve_cancels_nothing() -> None:
    # A full turn around a circle of radius 1 by a pen of half width 3: the winding number is positive all over a disc
    # of radius 4, though the inner side runs backwards.
    angles = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    outlines = _stroke(np.stack([np.cos(angles), np.sin(angles)], axis=1), width=6, closed=True)
    x, y = np.meshgrid(np.linspace(-3.9, 3.9, 14), np.linspace(-3.9, 3.9, 14))
    inside = x**2 + y**2 < 3.9**2
    winding = np.zeros(x.shape)
    for first, last in zip(outlines.loop_offsets[:-1], outlines.loop_offsets[1:], strict=True):
        corners = outlines.points[first:last, :, None, None]
        seen = np.arctan2(corners[:, 1] - y, corners[:, 0] - x)
        steps = np.diff(seen, axis=0, append=seen[:1])
        winding += ((steps + np.pi) % (2 * np.pi) - np.pi).sum(axis=0) / (2 * np.pi)

    assert np.all(np.rint(winding[inside]) >= 1)


def test_repeated_vertices_change_nothing() -> None:
    once, twice = (
        _stroke(CORNER, ROUND, ROUND),
        _stroke([CORNER[0], CORNER[0], CORNER[1], CORNER[1], CORNER[2]], ROUND, ROUND),
    )

    np.testing.assert_array_equal(once.points, twice.points)


@pytest.mark.parametrize("cap", range(len(CAPS)))
@pytest.mark.parametrize("join", range(len(JOINS)))
@pytest.mark.parametrize("closed", [False, True])
def test_gradients_are_central_differences(cap: int, join: int, closed: bool) -> None:
    step = 1e-6
    for seed in range(12):
        rng = np.random.default_rng(seed)
        vertices, width = rng.uniform(0, 30, (rng.integers(3 if closed else 1, 8), 2)), rng.uniform(0.2, 6)
        outlines = _stroke(vertices, cap, join, width, closed)
        d_points = rng.normal(size=outlines.points.shape)

        def loss(vertices: np.ndarray, width: float, d_points: np.ndarray = d_points) -> float:
            return float((_stroke(vertices, cap, join, width, closed).points * d_points).sum())

        d_vertices, d_widths = outlines.pull_back(d_points)
        expected = np.zeros(vertices.shape)
        for index in np.ndindex(vertices.shape):
            change = np.zeros(vertices.shape)
            change[index] = step
            expected[index] = (loss(vertices + change, width) - loss(vertices - change, width)) / (2 * step)
        # Differences round the loss, a sum of terms of some hundred px, at 1e-16, and divide by the step.
        scale = 1e-6 * (1 + np.abs(expected).max())
        np.testing.assert_allclose(d_vertices, expected, rtol=0, atol=scale)
        difference = (loss(vertices, width + step) - loss(vertices, width - step)) / (2 * step)
        assert d_widths[0] == pytest.approx(difference, abs=1e-6 * (1 + abs(difference)))
