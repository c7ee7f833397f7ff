# SPDX-License-Identifier: Apache-2.0
"""Good continuation: ends of outlines have directions, and go on by lines, arcs and corners where they relate."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.outlines.continuations import bridges, curves, direction_at_end, smooth, straight_line, tangent

FloatArray = NDArray[np.float64]


def at(*places: tuple[float, float]) -> FloatArray:
    return np.array(places, dtype=np.float64)


def arc(radius: float, count: int) -> FloatArray:
    """Points a px apart on a circle around the origin, to its rightmost one, from the x axis towards the y axis."""
    angles = (np.arange(count) - count + 1) / radius
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_a_straight_run_ends_in_its_direction() -> None:
    for count in (2, 3, 6, 7, 12):
        found = tangent(np.arange(count)[:, None] * at((3, 4)))
        assert found is not None
        np.testing.assert_allclose(found[0], (0.6, 0.8), atol=1e-9)
        assert found[1] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("turned", "sign"), [(1, 1), (-1, -1)])
def test_a_run_on_a_circle_has_its_curvature(turned: int, sign: int) -> None:
    """A parabola through n px of a radius r misses the direction by n^2 / r^2 of a turn of n / r, and less."""
    found = tangent(arc(30, 10) * (1, turned))
    assert found is not None
    np.testing.assert_allclose(found[0], (0, turned), atol=0.02)
    assert found[1] == pytest.approx(sign / 30, rel=0.1)
    few = tangent(arc(30, 6) * (1, turned))
    assert few is not None and few[1] == 0, "too short to tell"


def test_runs_without_extent_have_no_direction() -> None:
    for points in (at((2, 3)), at((2, 3), (2, 3)), np.full((9, 2), 4.0)):
        assert direction_at_end(points) is None


def test_lines_have_points_a_pixel_apart_without_their_ends() -> None:
    np.testing.assert_allclose(straight_line(*at((2, 1), (6, 1))), at((3, 1), (4, 1), (5, 1)))
    assert len(straight_line(*at((2, 1), (2, 1)))) == 1


def test_smooth_curves_between_alike_turns_are_arcs() -> None:
    """Of a quarter of a circle: the cubic of the usual handles, 0.5523 of the radius, is off by 2.8e-4 of it."""
    start, enter, end, leave = at((20, 0), (0, 1), (0, 20), (-1, 0))
    radii = np.hypot(*smooth(start, enter, end, leave).T)
    np.testing.assert_allclose(radii, 20, atol=20 * 3e-4)


@pytest.mark.parametrize(
    ("enter", "leave", "corner"),
    [
        ((1, 0), (0, 1), (10, 0)),  # two sides of a square
        ((1, 0), (1, 0), None),  # parallel
        ((-1, 0), (0, 1), None),  # behind
        ((1, 0), (0, -1), None),
    ],
)
def test_gaps_are_closed_by_a_line_a_curve_and_the_corner_ahead(
    enter: tuple[float, float], leave: tuple[float, float], corner: tuple[float, float] | None
) -> None:
    found = list(curves((at((0, 0))[0], np.array(enter), at((10, 10))[0], np.array(leave))))
    assert len(found) == 2 + (corner is not None)
    np.testing.assert_allclose(found[0][:, 0], found[0][:, 1])
    if corner is not None:
        assert (found[2] == corner).all(axis=1).any()
        assert set(np.flatnonzero(found[2].min(axis=1))) <= set(np.flatnonzero(found[2][:, 0] == 10))


def test_a_corner_far_off_is_none() -> None:
    enter, near, far = np.array((1.0, 0.0)), np.array((-0.94, 0.3412)), np.array((-0.95, 0.3122))
    gap = at((0, 0), (0, 30))
    assert len(list(curves((gap[0], enter, gap[1], near)))) == 3  # 88 px away; three times the gap and 3 are 93
    assert len(list(curves((gap[0], enter, gap[1], far)))) == 2  # 96 px


def test_an_end_without_direction_goes_on_straight() -> None:
    start, end = at((0, 0), (10, 10))
    assert len(list(curves((start, None, end, np.array((0.0, 1.0)))))) == 1
    assert len(list(curves((start, np.array((0.0, 1.0)), end, None)))) == 1


def bars(across: float, shift: float, longest: float = 100.0) -> list[tuple[FloatArray, FloatArray]]:
    """Bridges between two bars of a width of 4 px that a strip parts, `across` px wide, one `shift` px lower."""
    right, left = np.array((1.0, 0.0)), np.array((-1.0, 0.0))
    first = at((10, 0))[0], right, at((10, 4))[0], left
    second = at((10 + across, 4 + shift))[0], left, at((10 + across, shift))[0], right
    return list(bridges(first, second, longest))


def test_parts_are_bridged_where_their_ends_see_each_other() -> None:
    lines, smooths = bars(10, 0)
    for pair in (lines, smooths):
        for bridge, y in zip(pair, (0, 4), strict=True):
            np.testing.assert_allclose(bridge[:, 1], y, atol=1e-9)
            assert bridge[:, 0].min() > 10 and bridge[:, 0].max() < 20
    assert lines[0][0, 0] < lines[0][-1, 0] and lines[1][0, 0] > lines[1][-1, 0], "there and back"


def test_bridges_are_neither_long_nor_far_from_the_direction_of_their_ends() -> None:
    assert len(bars(10, 1, longest=20.1)) == 2 and not bars(10, 1, longest=20)  # two of the root of 101
    assert len(bars(10, 0, longest=1)) == 2, "ends in one line may be far"
    assert len(bars(10, 8)) == 2  # the cosine is .78
    assert not bars(10, 10)  # .71
    assert len(bars(2, 3)) == 2, "short gaps need not comply"
