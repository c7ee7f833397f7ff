# SPDX-License-Identifier: Apache-2.0
"""Lines of polygons that meet, and areas of outlines that cross themselves, against known values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings, shapes
from support.drawings import polygon, rectangle

from livecl.geometry import crossings
from livecl.geometry.bezier import bernstein
from livecl.geometry.crossings import crossing_area, following, line_meetings


def _by_trying(corners: NDArray[Any], owners: NDArray[Any]) -> list[tuple[int, int, float, float]]:
    found = []
    for i in range(len(corners)):
        own = np.flatnonzero(owners == owners[i])
        for j in own[own > i + 1]:
            if (i, j) == (own[0], own[-1]):
                continue
            (a, b), (c, d) = ((corners[k], corners[own[(k - own[0] + 1) % len(own)]]) for k in (i, j))
            apart = np.any(np.maximum(a, b) < np.minimum(c, d)) or np.any(np.maximum(c, d) < np.minimum(a, b))
            turn = (b - a)[0] * (d - c)[1] - (b - a)[1] * (d - c)[0]
            if not apart and turn != 0:
                s = ((c - a)[0] * (d - c)[1] - (c - a)[1] * (d - c)[0]) / turn
                t = ((c - a)[0] * (b - a)[1] - (c - a)[1] * (b - a)[0]) / turn
                found.append((i, int(j), s, t))
    return found


@pytest.mark.parametrize("block", [1, 7, 1 << 20])
@pytest.mark.parametrize("levels", [3, 1000])
def test_meetings(block: int, levels: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crossings, "_BLOCK", block)
    rng = np.random.default_rng(levels)
    owners = np.repeat(np.arange(5), [1, 2, 9, 3, 14])
    corners = rng.integers(levels, size=(len(owners), 2)).astype(np.float64)  # of three levels, many lines touch
    i, j, s, t = line_meetings(corners, corners[following(owners)], owners)
    wanted = _by_trying(corners, owners)
    assert list(zip(i.tolist(), j.tolist(), strict=True)) == [pair[:2] for pair in wanted]
    np.testing.assert_allclose(np.stack([s, t], axis=1), [pair[2:] for pair in wanted], rtol=1e-12)
    assert len(wanted) > 10


def test_no_lines() -> None:
    assert [len(array) for array in line_meetings(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.int64))] == [0] * 4


def cubics(path: shapes.Path) -> NDArray[Any]:
    return np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)


SIMPLE = {
    "circle": shapes.circle((8, 6), 5),
    "circle, the other way": drawings.reverse(shapes.circle((8, 6), 5)),
    "square": rectangle(1, 1, 5, 5),
    "notch whose tip touches the other side": polygon([(0, 0), (8, 0), (8, 8), (5, 8), (4, 0), (3, 8), (0, 8)]),
    "there and back on one line": polygon([(1, 1), (9, 5)]),
    "spike of no width": polygon([(0, 0), (8, 0), (8, 4), (12, 4), (8, 4), (8, 8), (0, 8)]),
    "cusp": np.array([[(2, 2), (10, 10), (2, 10)], [(10, 2), (8, 0), (4, 0)]], dtype=float),
    "lobes that touch at their corners": polygon([(0, 0), (4, 4), (8, 0), (8, 8), (4, 4), (0, 8)]),
    "one point": np.full((4, 3, 2), 3.0),
}


@pytest.mark.parametrize("name", SIMPLE)
def test_outlines_that_do_not_cross(name: str) -> None:
    # Nothing but rounding of areas below 100 px^2.
    assert crossing_area(cubics(SIMPLE[name])) <= 1e-12


BOW_TIE = [(0, 0), (8, 8), (8, 0), (0, 8)]
#: Outlines and the area of their other winding, px^2.
CROSSING = {
    "bow tie": (BOW_TIE, 16),
    "bow tie with corners in the crossing": ([(0, 0), (4, 4), (8, 8), (8, 0), (4, 4), (0, 8)], 16),
    "loop inside, winding 2": ([(0, 0), (9, 0), (9, 6), (4, 6), (4, 3), (6, 3), (6, 9), (0, 9)], 2 * 3),
    "loop outside, winding of the other sign": ([(0, 4), (9, 4), (9, 0), (6, 0), (6, 12), (0, 12)], 3 * 4),
    "strands that overlap for a while": ([(0, 0), (4, 4), (8, 4), (12, 8), (12, 0), (8, 4), (4, 4), (0, 8)], 16),
}


@pytest.mark.parametrize("name", CROSSING)
def test_area_of_other_winding(name: str) -> None:
    corners, area = CROSSING[name]
    assert crossing_area(cubics(polygon(corners))) == pytest.approx(area, rel=1e-9)
    assert crossing_area(cubics(polygon(corners[::-1]))) == pytest.approx(area, rel=1e-9)


def test_blocks_make_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    tangle = cubics(polygon(np.random.default_rng(0).uniform(0, 12, (40, 2))))
    whole = crossing_area(tangle)
    monkeypatch.setattr("livecl.geometry.crossings._BLOCK", 100)
    assert crossing_area(tangle) == pytest.approx(whole, rel=1e-9)
    assert whole > 1


def test_loop_of_a_single_cubic() -> None:
    cubic = np.array([(0.0, 0.0), (9.0, 6.0), (-3.0, 6.0), (6.0, 0.0)])
    closed = np.stack([cubic, np.linspace(cubic[3], cubic[0], 4)])
    # x(t) = x(1 - t) at the crossing, by symmetry x = 3 there: 27 t (1 - t)^2 - 9 t^2 (1 - t) + 6 t^3 = 3.
    times = np.roots([27 + 9 + 6, -54 - 9, 27, -3])
    first = float(np.sort(times[np.abs(times.imag) < 1e-9].real)[0])
    points = bernstein(np.linspace(first, 1 - first, 20001)) @ cubic
    following = np.roll(points, -1, axis=0)
    area = abs(np.sum(points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0])) / 2
    assert area > 0.1
    # The flattening of 0.01 px along the loop's outline, some 4 px long.
    assert crossing_area(closed) == pytest.approx(area, abs=0.04)
    assert crossing_area(closed, tolerance=1e-5) == pytest.approx(area, abs=4e-5)
