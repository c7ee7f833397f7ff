# SPDX-License-Identifier: Apache-2.0
"""Centre lines of masks: straight through crossings, from end to end, around loops."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from skimage.draw import disk, polygon2mask

from livecl.geometry import skeleton
from livecl.geometry.skeleton import center_lines


def _bar(mask: np.ndarray, a: tuple[float, float], b: tuple[float, float], radius: float) -> None:
    """Draw a bar with round ends from a to b, (x, y)."""
    y, x = np.indices(mask.shape) + 0.5
    step = np.subtract(b, a)
    share = np.clip(((x - a[0]) * step[0] + (y - a[1]) * step[1]) / (step @ step), 0, 1)
    mask |= np.hypot(x - a[0] - share * step[0], y - a[1] - share * step[1]) <= radius


def _ends(points: np.ndarray) -> list[tuple[float, float]]:
    return sorted((float(x), float(y)) for x, y in points[[0, -1]])


def test_a_bar_is_a_line_of_its_width() -> None:
    mask = np.zeros((60, 100), bool)
    _bar(mask, (15, 20), (80, 40), 5)

    (line,) = center_lines(mask)

    assert not line.closed
    np.testing.assert_allclose(_ends(line.points), [(15, 20), (80, 40)], atol=2)
    assert np.median(line.radii) == pytest.approx(5, abs=0.6)


@pytest.mark.parametrize("angle", [30, 50, 90])
def test_lines_go_straight_on_where_they_cross(angle: float) -> None:
    mask = np.zeros((120, 120), bool)
    ends = []
    for turn in (0, np.radians(angle)):
        step = 50 * np.array([np.cos(turn), np.sin(turn)])
        ends.append(sorted([tuple(60 - step), tuple(60 + step)]))
        _bar(mask, *ends[-1], 4)

    lines = center_lines(mask)

    assert len(lines) == 2
    found = sorted(_ends(line.points) for line in lines)
    np.testing.assert_allclose(found, sorted(ends), atol=3)  # thinning shortens ends
    for line in lines:  # within the steps of pixels of the straight line between the ends
        a, b = line.points[0], line.points[-1]
        off = (line.points - a) @ (np.array([[0, -1], [1, 0]]) @ (b - a) / np.hypot(*(b - a)))
        assert np.abs(off).max() < 2


def test_a_ring_is_a_closed_line() -> None:
    mask = np.zeros((100, 100), bool)
    mask[disk((50, 50), 35)] = True
    mask[disk((50, 50), 27)] = False

    (line,) = center_lines(mask)

    assert line.closed
    np.testing.assert_allclose(np.hypot(*(line.points - 50).T), 31, atol=1.2)


def test_sharp_corners_make_no_spurs() -> None:
    mask = polygon2mask((120, 120), [(10, 10), (10, 110), (110, 60)])
    mask &= ~polygon2mask((120, 120), [(22, 30), (22, 90), (85, 60)])

    lines = center_lines(mask)

    assert [line.closed for line in lines] == [True]


def test_a_branch_ends_in_the_middle_of_the_other_line() -> None:
    mask = np.zeros((100, 100), bool)
    _bar(mask, (10, 30), (90, 30), 4)
    _bar(mask, (50, 30), (50, 90), 4)

    through, branch = center_lines(mask)

    np.testing.assert_allclose(_ends(through.points), [(10, 30), (90, 30)], atol=2)
    np.testing.assert_allclose(_ends(branch.points), [(50, 30), (50, 90)], atol=2)


def test_nothing_has_no_lines() -> None:
    assert center_lines(np.zeros((20, 30), bool)) == []


def test_many_crossings_take_time_in_proportion(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what is drawn together, only branches that meet it are looked at again: 8 times the crossings, 8 times."""
    counts = []
    looked = skeleton._Graph._is_bridge
    for number in (4, 12):  # lines each way
        mask = np.zeros((12 * number, 12 * number), bool)
        mask[6::12], mask[:, 6::12] = True, True
        calls: list[None] = []
        monkeypatch.setattr(skeleton._Graph, "_is_bridge", lambda *a, c=calls: c.append(None) or looked(*a))  # type: ignore[func-returns-value]
        assert len(center_lines(ndimage.binary_dilation(mask, np.ones((2, 2))))) == 2 * number
        counts.append(len(calls))
    assert counts[1] < 2 * 9 * counts[0]


def test_the_lines_of_an_arrow_end_in_its_tip() -> None:
    mask = np.zeros((120, 160), bool)
    for end in ((20, 60), (100, 25), (100, 95)):
        _bar(mask, (135, 60), end, 8)

    lines = center_lines(mask)

    tips = [min(_ends(line.points), key=lambda end: abs(end[0] - 135)) for line in lines]
    assert len(lines) == 3
    np.testing.assert_allclose(tips, [(135, 60)] * 3, atol=2)  # their skeletons meet 14 px behind it
