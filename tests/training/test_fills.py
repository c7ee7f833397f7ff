# SPDX-License-Identifier: Apache-2.0
"""Gradient fills in training: how far points and stops move, what stays, and which moments go on."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.drawing.fills import LINEAR, RADIAL, SOLID, Fills
from livecl.rendering.fills import FillGradients
from livecl.training.fills import FillMoments, hold_fills

POINT_RATE, COLOR_RATE = 1.0, 0.01


def fills(middle: float = 0.5, colors: float = 0.5) -> Fills:
    """Return those of a linear gradient of three stops, a solid layer and a radial gradient of two."""
    return Fills(
        kinds=[LINEAR, SOLID, RADIAL],
        geometry=np.arange(18.0).reshape(3, 3, 2),
        stop_offsets=[0, 3, 3, 5],
        stop_positions=[0.1, middle, 0.9, 0.0, 0.8],
        stop_colors=np.full((5, 4), colors),
    )


def gradients(geometry: float = 0.0, positions: float | list[float] = 0.0, colors: float = 0.0) -> FillGradients:
    return FillGradients(np.full((3, 3, 2), geometry), np.full(5, positions), np.full((5, 4), colors))


def moved(before: Fills, by: FillGradients) -> Fills:
    """Return fills after the first step of Adam, which is the rate, against the gradient."""
    return FillMoments.start(before).step(before, by, lambda _: POINT_RATE, lambda _: COLOR_RATE)


def test_geometry_moves_like_points_and_stops_like_colors() -> None:
    before = fills()
    after = moved(before, gradients(geometry=3.0, positions=[1.0, 1.0, 1.0, -1.0, -1.0], colors=-2.0))
    used = np.array([[True, True, False], [False] * 3, [True] * 3])
    np.testing.assert_allclose(after.geometry[used], before.geometry[used] - POINT_RATE, atol=1e-6)
    np.testing.assert_allclose(after.stop_colors, before.stop_colors + COLOR_RATE, atol=1e-6)
    np.testing.assert_allclose(after.stop_positions, [0.1, 0.5 - COLOR_RATE, 0.9, 0.0, 0.8], atol=1e-6)


def test_colors_stay_within_their_range() -> None:
    for colors, sign in ((0.995, -1.0), (0.005, 1.0)):
        np.testing.assert_array_equal(moved(fills(colors=colors), gradients(colors=sign)).stop_colors, round(colors))


@pytest.mark.parametrize(("middle", "sign", "end"), [(0.105, 1.0, 0.1), (0.895, -1.0, 0.9)])
def test_stops_stay_in_their_order(middle: float, sign: float, end: float) -> None:
    after = moved(fills(middle), gradients(positions=sign))
    np.testing.assert_allclose(after.stop_positions, [0.1, end, 0.9, 0.0, 0.8], atol=1e-12)


def test_what_is_locked_has_no_gradient() -> None:
    found = gradients(1.0, 1.0, 1.0)
    hold_fills(fills(), found, np.array([True, False, False]))
    assert not found.geometry[0].any() and found.geometry[1:].all()
    assert found.stop_positions.tolist() == [0, 0, 0, 1, 1]
    assert found.stop_colors.any(axis=1).tolist() == [False] * 3 + [True] * 2


@pytest.mark.parametrize(
    ("sources", "kept"),
    [([0, 1, 2], [True, True]), ([0, 1, -1], [True, False]), ([2, 1, 0], [False, False])],
    ids=["the same", "one new", "other kinds"],
)
def test_moments_follow_layers_of_the_same_kind(sources: list[int], kept: list[bool]) -> None:
    before = FillMoments.start(fills())
    before.geometry.ages += 7
    before.stops.ages += 7
    before.geometry.mean += 2.0
    before.stops.square += 3.0
    after = before.followed(fills(), fills(), np.array(sources))
    expected = np.where(kept, 7, 0)
    assert after.geometry.ages[[0, 2]].tolist() == after.stops.ages[[0, 3]].tolist() == expected.tolist()
    np.testing.assert_array_equal(after.geometry.mean[[0, 2], 0, 0], np.where(kept, 2.0, 0))
    np.testing.assert_array_equal(after.stops.square[[1, 4], 2], np.where(kept, 3.0, 0))


def test_moments_of_other_numbers_of_stops_are_new() -> None:
    two = Fills.linear((0, 0), (8, 0), [(1, 0, 0, 1), (0, 0, 1, 1)])
    before = FillMoments.start(two)
    before.stops.ages += 7
    before.geometry.ages += 7
    after = before.followed(two, fills().subset([0]), np.array([0]))
    assert after.stops.ages.tolist() == [0, 0, 0] and after.geometry.ages.tolist() == [0]
