# SPDX-License-Identifier: Apache-2.0
"""Paths of fewest segments along polylines."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from livecl.geometry.bezier import evaluate
from livecl.geometry.open_fitting import fit_line


def _dense(*corners: tuple[float, float], step: float = 0.3) -> np.ndarray:
    parts = [
        np.linspace(a, b, 2 + int(np.hypot(*np.subtract(b, a)) / step))[:-1] for a, b in itertools.pairwise(corners)
    ]
    return np.concatenate([*parts, [corners[-1]]]).astype(float)


def _farthest(rows: np.ndarray, points: np.ndarray, closed: bool = False) -> float:
    """Largest distance of the points from the path."""
    cubics = np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], axis=1)[: None if closed else -1]
    curve = evaluate(cubics, np.linspace(0, 1, 200)).reshape(-1, 2)
    return float(np.hypot(*(points[:, None] - curve).transpose(2, 0, 1)).min(axis=1).max())


def test_a_straight_line_is_one_segment() -> None:
    noise = np.random.default_rng(0).normal(0, 0.08, (400, 2))
    rows = fit_line(np.linspace((5, 5), (90, 40), 400) + noise, 0.35, 5.0)

    assert len(rows) == 2
    np.testing.assert_allclose(rows[0, 1], rows[0, 0] + (rows[1, 0] - rows[0, 0]) / 3)


@pytest.mark.parametrize("angle", [50, 90, 130])
def test_corners_are_anchors(angle: float) -> None:
    turn = np.radians(angle)
    tip = (50.0, 50.0)
    points = _dense((5, 50), tip, (50 + 45 * np.cos(turn), 50 + 45 * np.sin(turn)))

    rows = fit_line(points, 0.35, 5.0)

    assert len(rows) == 3
    np.testing.assert_allclose(rows[1, 0], tip, atol=0.05)


def test_an_arc_stays_within_the_tolerance() -> None:
    angles = np.linspace(0, 4.5, 500)
    points = 50 + 40 * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    rows = fit_line(points, 0.2, 5.0)

    assert len(rows) <= 5
    assert _farthest(rows, points) <= 0.2


def test_a_closed_circle_has_no_end() -> None:
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    points = 50 + 30 * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    rows = fit_line(points, 0.2, 5.0, closed=True)

    assert 3 <= len(rows) <= 5
    assert _farthest(rows, points, closed=True) <= 0.25  # measured by the curve's parameter, the fit sees 0.2


def test_two_points_are_a_line() -> None:
    rows = fit_line(np.array([[1.0, 2.0], [7.0, 8.0]]), 0.3, 2.0)

    np.testing.assert_allclose(rows[:, 0], [[1, 2], [7, 8]])


def test_a_turn_is_round_where_its_ink_says_so() -> None:
    angles = np.linspace(-np.pi / 2, 0, 40)
    arc = np.array([60, 30]) + 20 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.concatenate([np.linspace((10, 10), (59, 10), 50), arc, np.linspace((80, 31), (80, 80), 50)])
    asked = []

    def is_sharp(tip: np.ndarray, outwards: np.ndarray, half: float) -> bool:
        asked.append((*tip, *outwards, half))
        return False

    rows = fit_line(points, 0.35, 26.0, is_sharp=is_sharp)

    np.testing.assert_allclose(asked, [(80, 10, 0.5**0.5, -(0.5**0.5), 0.5**0.5)], atol=0.6)
    assert 4 <= len(rows) <= 5  # a line, an arc of one or two segments, a line, and the end
    assert len(fit_line(points, 0.35, 26.0)) == 3  # without asking it is a corner
