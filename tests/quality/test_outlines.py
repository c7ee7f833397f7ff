# SPDX-License-Identifier: Apache-2.0
"""Scores of outlines by those of the true drawing, and the count of an SVG's numbers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import build, polygon, rectangle

from livecl.drawing.drawing import Drawing
from livecl.quality import OutlineScores, count_numbers, score_outlines
from livecl.svg.shapes import ellipse_outline, rectangle_outline

RED, BLUE, GREEN = (0.9, 0.1, 0.1, 1.0), (0.1, 0.1, 0.9, 1.0), (0.1, 0.6, 0.2, 1.0)
SIZE = (80, 120)


def disc(x: float, y: float, r: float) -> NDArray[np.float64]:
    return ellipse_outline(x, y, r, r)[0][:, :3]


def scores(*ours: NDArray[np.float64], true: tuple[NDArray[np.float64], ...] | None = None) -> OutlineScores:
    """Score outlines of red layers by true ones: by default a disc, a rounded rectangle and a triangle."""
    true = true or (disc(25, 30, 15), rectangle_outline(50, 10, 30, 20, 6, 6)[0][:, :3], triangle())
    return score_outlines(drawing_of(*true), drawing_of(*ours))


def drawing_of(*outlines: NDArray[np.float64]) -> Drawing:
    return build([([outline], RED) for outline in outlines], SIZE)


def triangle() -> NDArray[np.float64]:
    return polygon([(60.0, 50.0), (100.0, 50.0), (80.0, 75.0)])


def test_a_drawing_has_the_best_scores_by_itself() -> None:
    true = disc(25, 30, 15), rectangle_outline(50, 10, 30, 20, 6, 6)[0][:, :3], triangle()
    found = scores(*true, true=true)
    assert (found.shapes, found.shapes_found, found.shapes_drawn) == (2, 2, 2)
    assert (found.shapes_written, found.shapes_false) == (2, 0)
    assert found.joins == found.joins_smooth == 12 and found.corners == found.corners_kept == 3
    assert found.sides == found.sides_straight == 7 and found.level == found.level_exact == 5
    assert found.displacement == pytest.approx(0, abs=1e-3) and found.edge == pytest.approx(294, abs=15)


def test_what_is_lost_is_not_counted_as_found() -> None:
    bent = disc(25, 30, 15)
    bent[0, 1] += (1.0, 0.0)  # its join turns by 7 degrees
    bowed = triangle()
    bowed[0, 1:, 1] += 1.0
    tilted = rectangle_outline(50, 10, 30, 20, 6, 6)[0][:, :3]
    tilted[0, 0, 1] += 0.3
    tilted[0, 1, 1] += 0.2
    tilted[0, 2, 1] += 0.1
    found = scores(bent, tilted, bowed)
    assert (found.shapes_drawn, found.shapes_written) == (0, 0)
    assert found.joins - found.joins_smooth == 2
    assert (found.sides_straight, found.sides) == (6, 7) and (found.level, found.level_exact) == (4, 3)


def test_corners_count_within_half_a_pixel_and_edges_by_their_distance() -> None:
    true = rectangle(20, 20, 60, 60)
    near, far = (scores(rectangle(20 + by, 20, 60, 60), true=(true,)) for by in (0.4, 0.8))
    assert (near.corners_kept, far.corners_kept, far.corners) == (4, 2, 4)
    assert far.displacement == pytest.approx(0.8 / 4, abs=0.01)


def test_shapes_written_for_others_are_false_and_hidden_corners_do_not_count() -> None:
    blob = polygon([(10.0, 30.0), (25.0, 14.0), (40.0, 30.0), (25.0, 46.0)])
    found = scores(disc(25, 30, 14), true=(blob,))
    assert (found.shapes, found.shapes_written, found.shapes_false) == (0, 1, 1)
    covered = build([([rectangle(10, 10, 50, 50)], RED), ([rectangle(40, 0, 80, 60)], BLUE)], SIZE)
    assert score_outlines(covered, covered).corners == 4  # two are hidden, two at the picture's border
    assert score_outlines(covered, covered).sides == 6  # one is hidden, one at the border; two on three quarters


def test_what_no_picture_shows_does_not_count() -> None:
    touching = build([([rectangle(20, 20, 60, 60)], RED), ([rectangle(40, 30, 80, 50)], RED)], SIZE)
    found = score_outlines(touching, touching)
    assert (found.corners, found.sides) == (4 + 2, 3 + 1)  # of three sides, only half is not within the other
    assert found.edge == pytest.approx(160 - 20 + 60, abs=4)


def test_nodes_that_nobody_tells_apart_are_one() -> None:
    cut = polygon([(20.0, 20.0), (60.0, 20.0), (60.1, 20.1), (60.0, 60.0), (20.0, 60.0)])
    found = scores(rectangle(20, 20, 60, 60), true=(cut,))
    assert (found.corners, found.corners_kept) == (4, 4)
    spike = polygon([(20.0, 20.0), (40.0, 20.0), (40.0, 20.1), (39.9, 20.1), (39.9, 20.0), (60.0, 20.0), (40.0, 60.0)])
    assert scores(spike, true=(spike,)).corners == 3


def test_edges_farther_than_a_pixel_are_missed_and_not_displaced() -> None:
    found = scores(rectangle(22, 20, 60, 60), true=(rectangle(20, 20, 60, 60),))
    assert found.edge_missed / found.edge == pytest.approx(1 / 4, abs=0.02)
    assert found.displacement < 0.02


def test_joins_off_the_true_outline_do_not_count() -> None:
    true = (disc(25, 30, 15),)
    near, far = (scores(disc(25 + by, 30, 15), true=true) for by in (0.0, 0.9))
    assert (near.joins, far.joins) == (4, 2)


def test_missing_things_are_shapes_not_drawn() -> None:
    found = scores(triangle())
    assert (found.shapes, found.shapes_found, found.shapes_drawn) == (2, 0, 0)
    assert score_outlines(drawing_of(triangle()), build([([disc(25, 30, 15)], GREEN)], SIZE)).edge == 0


def test_what_is_not_found_counts_among_all() -> None:
    """A square of which half is drawn keeps the corners and sides that are there, but is not found."""
    true, half = rectangle(20, 20, 60, 60), rectangle(20, 20, 60, 44)
    found = scores(half, triangle(), true=(true, triangle()))
    assert (found.corners, found.corners_kept, found.sides, found.sides_straight) == (3, 3, 3, 3)
    assert (found.corners_all, found.corners_all_kept) == (7, 5)
    assert (found.sides_all, found.sides_all_straight) == (7, 4)  # of two sides, half is there
    assert (found.joins, found.joins_smooth, found.joins_all, found.joins_all_smooth) == (0, 0, 2, 0)
    alone = scores(triangle(), true=(true, triangle()))
    assert (alone.corners_all, alone.corners_all_kept, alone.joins_all) == (7, 3, 0)


def test_numbers_are_those_of_shapes_and_transforms() -> None:
    svg = """<svg width="9" height="9" viewBox="0 0 9 9"><g transform="scale(2)">
    <path d="M1 2h3v4z" fill="#123456"/><path d="M0 0a5 5 0 013 4.5-1"/>
    <ellipse cx="1" cy="2" rx="3" ry="4" transform="rotate(30 1 2)"/></g></svg>"""
    assert count_numbers(svg) == 4 + (2 + 7 + 1) + 7
