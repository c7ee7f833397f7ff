# SPDX-License-Identifier: Apache-2.0
"""Traces of outlines by known shapes: equal steps, corners and how they turn, extremes, tangents, sides."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import circle, rectangle

from livecl.editing.trace import EVENED, LEAST, STEP, SampledOutline, sampled, turning
from livecl.svg.shapes import rectangle_outline

FloatArray = NDArray[np.float64]
CENTER, RADIUS = np.array((30.0, 26.0)), 20.0


def traced(rows: FloatArray) -> SampledOutline:
    found = sampled(np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], axis=1))
    assert found is not None
    return found


def test_a_circle_has_equal_steps_four_extremes_and_no_corner() -> None:
    found = traced(circle(tuple(CENTER), RADIUS))
    spokes = found.points - CENTER
    # Evening by a deviation of s takes s^2 / 2 r off the radius.
    np.testing.assert_allclose(np.hypot(*spokes.T), RADIUS - EVENED**2 / (2 * RADIUS), atol=0.01)
    assert found.step == pytest.approx(STEP, rel=0.01)
    steps = np.hypot(*(np.roll(found.points, -1, axis=0) - found.points).T)
    np.testing.assert_allclose(steps, found.step, rtol=0.01)
    assert not (np.abs(found.turning) > 0.4).any()
    angles = np.degrees(np.arctan2(*spokes[found.extreme].T[::-1]))
    assert len(angles) >= 4 and (np.abs((angles + 45) % 90 - 45) < 180 * STEP / RADIUS).all()


def test_tangents_of_a_circle_stand_on_its_spokes() -> None:
    found = traced(circle(tuple(CENTER), RADIUS))
    samples = np.arange(0, len(found.points), 7)
    tangents = found.tangent(samples)
    np.testing.assert_allclose(np.hypot(*tangents.T), 1)
    spokes = found.points[samples] - CENTER
    np.testing.assert_allclose((tangents * spokes).sum(axis=1) / RADIUS, 0, atol=0.01)


def test_a_rectangle_turns_at_its_corners() -> None:
    found = traced(rectangle(10, 8, 50, 32))
    assert len(found.corners) == 4
    shares = np.abs(found.turning) / (np.pi / 2)
    assert (shares > 0.7).all() and (shares <= 1).all(), "within its reach, less what evening spreads farther"
    corners = {tuple(np.rint(point / 2).astype(int) * 2) for point in found.points[found.corners]}
    assert corners == {(10, 8), (50, 8), (50, 32), (10, 32)}
    assert not np.isin(found.corners, found.places).any(), "a sharp corner is no smooth node"


def test_sides_beside_a_corner_run_straight_to_and_from_it() -> None:
    found = traced(rectangle(10, 8, 50, 32))
    for corner in found.corners.tolist():
        (before, way_in), (after, way_out) = found.side(corner, -1), found.side(corner, 1)
        assert np.abs(way_in @ way_out) < 0.02
        for point, way in ((before, way_in), (after, way_out)):
            np.testing.assert_allclose(np.abs(way).max(), 1, atol=1e-3)
            assert 0.5 < np.hypot(*(point - found.points[corner])) < 3.5
        ahead = found.points[(corner + 8) % len(found.points)] - found.points[corner]
        assert way_out @ ahead > 0.9 * np.hypot(*ahead)


def test_an_outline_of_a_few_steps_has_no_shape() -> None:
    rows = rectangle(10, 10, 10 + STEP / 2, 10 + STEP / 2)
    assert sampled(np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], axis=1)) is None
    assert len(traced(rectangle(10, 10, 10 + 2 * STEP, 10 + 2 * STEP)).points) == LEAST


def test_turning_is_the_angle_between_chords() -> None:
    points = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (0, 2)], float)
    found = turning(points, 1)
    np.testing.assert_allclose(found[[1, 3]], 0, atol=1e-12)
    assert abs(found[2]) == pytest.approx(np.pi / 2) and abs(found.sum()) == pytest.approx(2 * np.pi)
    np.testing.assert_allclose(turning(points[::-1], 1)[::-1], -found)


def test_straight_sides_are_those_between_arcs_and_corners() -> None:
    box = rectangle_outline(10, 8, 60, 40, 12, 12)[0][:, :3]
    found = traced(box)
    lengths = found.step * (found.sides[:, 1] - found.sides[:, 0])
    np.testing.assert_allclose(np.sort(lengths), [16, 16, 36, 36], atol=3)
    assert np.isin(found.sides % len(found.points), found.places).all(), "nodes may stand at their ends"
    assert len(traced(rectangle(10, 8, 50, 32)).sides) == 4
    assert not len(traced(circle(tuple(CENTER), RADIUS)).sides)
