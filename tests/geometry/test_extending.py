# SPDX-License-Identifier: Apache-2.0
"""Polylines are extended to corners and junctions: straight or bent, as they come."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.geometry.extending import extended, meeting_of


def test_a_straight_side_is_extended_straight() -> None:
    points = np.linspace((10, 5), (30, 5), 20) + np.random.default_rng(0).normal(0, 0.05, (20, 2))

    place, direction = extended(points, np.array([0.0, 5.0]))

    assert direction == pytest.approx((1, 0), abs=0.02)
    assert place[1] == pytest.approx(5, abs=0.05)


def test_an_arc_is_extended_along_its_bend() -> None:
    angles = np.linspace(0.3, 0.8, 40)
    points = 100 * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    place, direction = extended(points, np.array([100.0, 0.0]))

    assert np.hypot(*place) == pytest.approx(100, abs=1)  # by a line 105
    assert direction == pytest.approx((0, 1), abs=0.12)


def test_lines_meet_where_they_cross() -> None:
    directions = [np.array([np.cos(angle), np.sin(angle)]) for angle in (0.2, 1.0, 2.5)]

    assert meeting_of([(np.array([3, 4]) + 7 * way, way) for way in directions]) == pytest.approx((3, 4))


def test_parallel_lines_do_not_meet() -> None:
    way = np.array([1.0, 0.0])

    assert meeting_of([(np.array([0.0, 0.0]), way), (np.array([0.0, 2.0]), way)]) is None
