# SPDX-License-Identifier: Apache-2.0
"""Straight segments and smooth joins stay so while points move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import livecl
from livecl import Options
from livecl.drawing import Drawing, empty_drawing
from livecl.geometry.bezier import cross
from livecl.run.beginning import placed_by
from livecl.training.ties import Ties

FloatArray = NDArray[np.float64]


def drawing_of(*paths: FloatArray) -> Drawing:
    return Drawing.from_outlines([[path] for path in paths], np.ones((len(paths), 4)), (40, 40))


def polygon(corners: FloatArray) -> FloatArray:
    end = np.roll(corners, -1, axis=0)
    return np.stack([corners, (2 * corners + end) / 3, (corners + 2 * end) / 3], axis=1)


def slot() -> FloatArray:
    """Two lines, joined smoothly by two curves of one segment each."""
    return np.array(
        [
            [(10, 10), (14, 10), (18, 10)],
            [(22, 10), (30, 10), (30, 20)],
            [(22, 20), (18, 20), (14, 20)],
            [(10, 20), (2, 20), (2, 10)],
        ],
        dtype=np.float64,
    )


def drop() -> FloatArray:
    """Curves with one smooth join, at (20, 30), and a corner."""
    return np.array([[(20, 10), (30, 20), (28, 30)], [(20, 30), (14, 30), (10, 20)]], dtype=np.float64)


TRIANGLE = np.array([(5.0, 5.0), (30.0, 8.0), (12.0, 33.0)])


def off_line(points: FloatArray) -> FloatArray:
    """Largest distance of handles from the places that make their segment straight: (M,)."""
    start, end = points[:, 0], np.roll(points[:, 0], -1, axis=0)
    thirds = np.stack([(2 * start + end) / 3, (start + 2 * end) / 3], axis=1)
    return np.asarray(np.abs(points[:, 1:] - thirds).max(axis=(1, 2)))


def turn(points: FloatArray) -> FloatArray:
    """Angle at each anchor, radians: (M,)."""
    out, back = points[:, 1] - points[:, 0], points[:, 0] - np.roll(points[:, 2], 1, axis=0)
    return np.asarray(np.abs(np.arctan2(cross(out, back), (out * back).sum(axis=1))))


def test_ties_are_seen_in_the_drawing() -> None:
    ties = Ties.of(drawing_of(polygon(TRIANGLE), slot(), drop()))
    assert ties.straight.tolist() == [True] * 3 + [True, False, True, False] + [False] * 2
    assert ties.smooth.tolist() == [False] * 3 + [True] * 4 + [False, True]
    assert ties.following.tolist() == [1, 2, 0, 4, 5, 6, 3, 8, 7]
    empty = Ties.of(drawing_of())
    assert len(empty.straight) == len(empty.smooth) == 0


def test_a_curve_that_starts_or_ends_like_a_line_is_none() -> None:
    for handle in (1, 2):
        path = polygon(TRIANGLE)
        path[1, handle] += (3, -2)
        ties = Ties.of(drawing_of(path))
        assert ties.straight.tolist() == [True, False, True]
        moved = path + 0.0
        ties.restore(moved)
        np.testing.assert_allclose(moved, path, atol=1e-12)


def test_a_handle_that_a_step_took_across_its_anchor_is_not_put_back_onto_the_other() -> None:
    points = drop()
    ties = Ties.of(drawing_of(points))
    points[1, 1] = (21, 30)  # beyond the anchor at (20, 30), as the handle before it, at (28, 30)
    moved = points.copy()
    ties.restore(moved)
    assert np.array_equal(moved, points)


def test_ties_outlast_any_step() -> None:
    rng = np.random.default_rng(0)
    for path in (polygon(TRIANGLE), slot(), drop()):
        drawing = drawing_of(path)
        ties = Ties.of(drawing)
        points = drawing.points + rng.uniform(-0.5, 0.5, drawing.points.shape)
        moved = points.copy()
        ties.restore(moved)
        assert off_line(moved)[ties.straight].max(initial=0) < 1e-12
        assert turn(moved)[ties.smooth].max(initial=0) < 1e-12
        assert np.array_equal(moved[:, 0], points[:, 0])  # anchors are where the step has put them
        again = Ties.of(drawing.moved(moved, drawing.colors, drawing.background))
        assert np.array_equal(again.straight, ties.straight) and np.array_equal(again.smooth, ties.smooth)
    assert not turn(points)[1] < 1e-3  # the step had bent the join


def test_what_is_not_tied_moves_as_it_does() -> None:
    drawing = drawing_of(drop())
    points = drawing.points + np.random.default_rng(1).uniform(-0.5, 0.5, drawing.points.shape)
    moved = points.copy()
    Ties.of(drawing).restore(moved)
    assert np.array_equal(moved[0, :2], points[0, :2]) and np.array_equal(moved[1, 2], points[1, 2])


def test_gradients_of_lines_are_those_of_their_ends() -> None:
    rng = np.random.default_rng(2)
    drawing = drawing_of(polygon(TRIANGLE), drop())
    ties, weight = Ties.of(drawing), rng.normal(size=drawing.points.shape)
    gathered = weight.copy()
    ties.gather(gathered)
    assert not gathered[:3, 1:].any() and np.array_equal(gathered[3:], weight[3:])
    for k in range(3):
        for axis in (0, 1):
            change = np.zeros((3, 2))
            change[k, axis] = 1e-3
            difference = polygon(TRIANGLE + change) - polygon(TRIANGLE - change)
            assert np.isclose((weight[:3] * difference).sum() / 2e-3, gathered[k, 0, axis], rtol=1e-9)


def test_a_run_keeps_lines_straight_and_joins_smooth(device: int) -> None:
    rows, columns = np.indices((64 * 8, 64 * 8))
    x, y = (columns + 0.5) / 8, (rows + 0.5) / 8
    inside = np.hypot(np.maximum(np.abs(x - 32.3) - 18, 0), np.maximum(np.abs(y - 31.2) - 12, 0)) < 6
    cover = inside.reshape(64, 8, 64, 8).mean(axis=(1, 3))[..., None]
    image = np.asarray(1 - cover * (0.1, 0.7, 0.8), np.float32)
    result = livecl.vectorize(image, paths=1, options=Options(iterations=30), device=device)
    points = result.drawing.points
    assert len(points) == 8 and (off_line(points) < 2e-3).sum() == 4  # coordinates are rounded to .001
    assert turn(points).max() < 2e-3
    assert result.mse < 1e-5


def test_outlines_that_are_known_take_small_steps() -> None:
    image = np.ones((32, 32, 3), np.float32)
    image[8:20, 6:25] = (0.9, 0.1, 0.2)
    drawing = empty_drawing((32, 32), np.ones(3))
    for rate, found in ((1.0, 0.3), (0.1, 0.1)):
        assert placed_by(Options(learning_rate=rate), image, drawing, 1).learning_rate == found
    assert placed_by(Options(placement="region"), image, drawing, 1).learning_rate == 1
