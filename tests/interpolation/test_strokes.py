# SPDX-License-Identifier: Apache-2.0
"""Strokes between two drawings: lines and widths that correspond, caps that change half-way, lines cut and added."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from support.drawings import RED, build, rectangle
from support.line_art import BLACK, BLUE, DRAWINGS, SIZE, arc, curve, drawing, line, polygon

import livecl
from livecl.geometry.bezier import evaluate
from livecl.interpolation.blending import collapsed, correspond, interpolate
from livecl.interpolation.lines import StrokeLine, align_lines

#: Mean square by which a line that waits on another may be seen: pixels of both edges, half covered, that are counted
#: twice (docs/strokes.md) along a pen's width of 6 px, by colours that differ by .9.
TWICE = 2 * 6 * (0.5 * 0.9) ** 2 / (SIZE[0] * SIZE[1])


def _difference(a: livecl.Drawing, b: livecl.Drawing) -> float:
    return float(np.mean((livecl.render(a) - livecl.render(b)) ** 2))


@pytest.mark.parametrize(("first", "second"), list(itertools.pairwise([*DRAWINGS, "house"])))
@pytest.mark.parametrize("match", ["order", "nearest"])
def test_both_ends_look_as_they_are(first: str, second: str, match: str) -> None:
    a, b = DRAWINGS[first], DRAWINGS[second]

    start, end = correspond(a, b, match=match)  # type: ignore[arg-type]

    assert start.same_structure(end)
    assert _difference(start, a) < TWICE
    assert _difference(end, b) < TWICE


def test_lines_and_widths_are_mixed_and_pens_change_half_way() -> None:
    a = drawing((BLACK, 4, [line((20, 40), (140, 40))]), cap=0, join=0)
    b = drawing((BLUE, 8, [line((140, 80), (20, 60))]), cap=1, join=2)

    frames = interpolate(a, b, [0, 0.25, 0.5, 1])

    np.testing.assert_allclose([frame.strokes.widths[0] for frame in frames], [4, 5, 6, 8])
    assert [frame.strokes.caps[0] for frame in frames] == [0, 0, 1, 1]
    assert [frame.strokes.joins[0] for frame in frames] == [0, 0, 2, 2]
    np.testing.assert_allclose(frames[2].points[[0, 1], 0], [(20, 50), (140, 60)])  # the second one is turned
    assert all(frame.same_structure(frames[0]) for frame in frames)


def test_circles_stay_closed_and_move_without_turning() -> None:
    a, b = drawing((BLACK, 4, [arc(40, 80, 20)])), drawing((BLACK, 4, [arc(110, 80, 20, 0.25, 1.25)]))

    middle = interpolate(a, b, 0.5)

    assert not middle.strokes.is_open.any()
    assert _difference(middle, drawing((BLACK, 4, [arc(75, 80, 20)]))) < 1e-4


def test_a_closed_line_is_cut_where_it_lies_best_on_an_open_one() -> None:
    """An arc three quarters round becomes a circle: its gap closes, and nothing goes round the other way."""
    a, b = drawing((BLACK, 4, [arc(80, 80, 40, 0.125, 0.875)])), drawing((BLACK, 4, [arc(80, 80, 40)]))

    start, end = correspond(a, b)
    middle = interpolate(a, b, 0.5)

    assert start.strokes.is_open.all()
    assert _difference(end, b) < TWICE
    radii = np.hypot(*(middle.points[:, 0] - 80).T)
    assert 35 < radii.min() < radii.max() < 45


def test_cuts_are_not_at_corners() -> None:
    square = drawing((BLACK, 8, [polygon((40, 40), (120, 40), (120, 120), (40, 120))]), cap=0, join=0)
    for corner in ((40, 40), (120, 40), (120, 120), (40, 120)):
        bent = drawing((BLACK, 8, [line(corner, (80, 80), corner)]), cap=0, join=0)

        assert _difference(correspond(bent, square)[1], square) < 1e-7


def test_a_line_without_a_partner_waits_on_another() -> None:
    a = drawing((BLACK, 6, [line((20, 40), (140, 45))]), cap=2)
    b = drawing((BLACK, 6, [line((20, 40), (140, 45)), arc(80, 110, 25), line((30, 140), (60, 150))]), cap=2)

    start, end = correspond(a, b)

    assert len(start.subpaths()) == 3
    assert _difference(start, a) < 2 * TWICE
    assert _difference(end, b) < TWICE  # the circle is cut


def test_lone_strokes_fade_or_grow() -> None:
    a, nothing = DRAWINGS["face"], DRAWINGS["face"].layer_subset([False, False])
    for lone in ("fade", "grow"):
        frames = interpolate(a, nothing, [0, 0.5, 1], lone=lone)
        assert _difference(frames[0], a) == 0
        assert _difference(frames[2], nothing) < 1e-6
        assert _difference(frames[1], a) > 1e-3
    assert _difference(collapsed(a), nothing) < 1e-6


@pytest.mark.parametrize("match", ["order", "nearest"])
def test_strokes_and_fills_do_not_become_each_other(match: str) -> None:
    filled = build([([rectangle(20, 20, 140, 140)], RED)], SIZE, (1, 1, 1))
    stroked = DRAWINGS["star"]

    frames = interpolate(filled, stroked, [0, 0.5, 1], match=match)  # type: ignore[call-overload]

    assert (frames[0].strokes.widths > 0).tolist() == [False, True]
    np.testing.assert_allclose(frames[1].colors[:, 3], 0.5)
    assert _difference(frames[0], filled) == 0
    assert _difference(frames[2], stroked) == 0


def test_nodes_at_the_same_place_belong_together() -> None:
    """A corner moves along; what one line alone has is made on the other; dots and doubled nodes do no harm."""
    a = StrokeLine(_cubics(line((0, 0), (50, 0), (100, 0))), True)
    b = StrokeLine(_cubics(line((0, 0), (48, 0), (48, 52), (48, 52), (48, 70))), True)
    dot = StrokeLine(_cubics(line((5, 5), (5, 5))), True)

    for one, other in itertools.product((a, b, dot), repeat=2):
        (first,), (second,) = align_lines([one], [other])
        assert len(first.cubics) == len(second.cubics) <= len(one.cubics) + len(other.cubics)
        for own, given in ((first, one), (second, other)):
            points = evaluate(own.cubics, np.linspace(0, 1, 9)).reshape(-1, 2)
            course = evaluate(given.cubics, np.linspace(0, 1, 2001)).reshape(-1, 2)
            assert np.abs(points[:, None] - course).max(axis=2).min(axis=1).max() < 0.03
            for place in given.cubics[:, 0]:
                assert np.abs(own.cubics[:, 0] - place).max(axis=1).min() < 1e-9
    straight, bent = align_lines([a], [StrokeLine(b.cubics[:2], True)])
    np.testing.assert_allclose(straight[0].cubics[1, 0], (50, 0))
    np.testing.assert_allclose(bent[0].cubics[1, 0], (48, 0))


def test_aligned_lines_keep_their_course() -> None:
    a = [StrokeLine(_cubics(arc(50, 50, 20)), False), StrokeLine(_cubics(line((0, 0), (9, 3), (7, 30))), True)]
    b = [StrokeLine(_cubics(curve((0, 0), (30, 9), (50, 3), (60, 60))), True)]

    first, second = align_lines(a, b)

    assert [len(own.cubics) for own in first] == [len(own.cubics) for own in second]
    assert [own.is_open for own in first] == [own.is_open for own in second]
    for own in (first, second):
        for cubics, is_open in own:
            np.testing.assert_array_equal(cubics[:-1, 3], cubics[1:, 0])
            assert is_open or (cubics[-1, 3] == cubics[0, 0]).all()


def _cubics(subpath: tuple[np.ndarray, bool]) -> np.ndarray:
    rows, is_open = subpath
    cubics = np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], axis=1)
    return cubics[: -1 if is_open else None]
