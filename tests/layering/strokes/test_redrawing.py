# SPDX-License-Identifier: Apache-2.0
"""Strokes redrawn with fewer nodes: ends that meet are joined, split curves are whole, where that shows little."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import BLACK, DRAWINGS, SIZE, Subpath, arc, drawing, line, match, polygon

from livecl import Drawing, Options, Rasterizer, render
from livecl.drawing import Strokes
from livecl.geometry.bezier import subsegment
from livecl.layering.context import Context
from livecl.layering.strokes.redrawing import redrawn


def _redrawn(found: Drawing, target: Drawing) -> Drawing:
    return redrawn(Context(Rasterizer(SIZE), render(target), Options()), found)


def _split(subpath: Subpath, times: int) -> Subpath:
    """Cut each segment of a line into equal parts."""
    rows, is_open = subpath
    ends = np.concatenate([rows[1:, 0], rows[-1:, 0] if is_open else rows[:1, 0]])
    cubics = np.concatenate([rows, ends[:, None]], axis=1)[: -1 if is_open else None]
    edges = np.linspace(0, 1, times + 1)
    parts = [subsegment(cubic, *edges[k : k + 2])[:3] for cubic in cubics for k in range(times)]
    return np.array([*parts, rows[-1]] if is_open else parts), is_open


@pytest.mark.parametrize(
    ("subpath", "times"),
    [(arc(80, 80, 50), 3), (arc(80, 80, 50, 0.1, 0.6), 2), (line((20, 30), (80, 120), (140, 40)), 3)],
)
def test_split_segments_are_whole_again(subpath: Subpath, times: int) -> None:
    true, found = drawing((BLACK, 5, [subpath])), drawing((BLACK, 5, [_split(subpath, times)]))

    result = _redrawn(found, true)

    assert result.num_segments <= true.num_segments < found.num_segments
    assert match(result, true).distance < 0.2


def test_closed_lines_begin_at_a_corner() -> None:
    square = polygon((40, 40), (120, 40), (120, 120), (40, 120))
    rows = _split(square, 2)[0]
    found = drawing((BLACK, 5, [(np.roll(rows, -1, axis=0), False)]))

    result = _redrawn(found, drawing((BLACK, 5, [square])))

    assert result.num_segments == 4
    assert not result.strokes.is_open.any()


def test_ends_that_meet_are_joined_in_their_corner() -> None:
    true = drawing((BLACK, 6, [line((20, 30), (80, 120), (140, 40))]), join=0)
    found = drawing((BLACK, 6, [line((20, 30), (78, 117)), line((140, 40), (81.5, 118))]), join=0)

    result = _redrawn(found, true)

    assert len(result.subpaths()) == 1
    assert match(result, true).distance < 0.1
    assert np.hypot(*(result.points[:, 0] - (80, 120)).T).min() < 0.1


def test_the_ends_of_one_line_close_it() -> None:
    true = drawing((BLACK, 6, [polygon((30, 30), (130, 30), (80, 120))]), join=0)
    found = drawing((BLACK, 6, [line((80, 117), (30, 30), (130, 30), (81, 118.3))]), join=0)

    result = _redrawn(found, true)

    assert not result.strokes.is_open.any()
    assert result.num_segments == 3


def test_lines_that_cost_more_together_stay_apart() -> None:
    """Two lines with butt caps, a gap between them: joined, they would cover the gap."""
    apart = drawing((BLACK, 8, [line((20, 80), (77, 80)), line((83, 80), (140, 80))]), cap=0)

    assert _redrawn(apart, apart) is apart


@pytest.mark.parametrize("first", [True, False])
def test_hooks_at_ends_are_straightened(first: bool) -> None:
    """A stem with a hook, as where a skeleton turns aside near a bar."""
    bar = line((30, 20), (30, 140))
    stem = [(30.0, 80.0), (90, 80), (140, 110)]
    hooked = [(35.0, 76.0), (36.0, 80.0), *stem[1:]]
    if not first:
        stem, hooked = stem[::-1], hooked[::-1]
    true = drawing((BLACK, 10, [bar, line(*stem)]))
    found = drawing((BLACK, 10, [bar, line(*hooked)]))

    result = _redrawn(found, true)

    assert result.num_segments == true.num_segments < found.num_segments
    assert match(result, true).distance < 0.1


def test_a_hook_that_ends_early_is_straightened_and_made_longer() -> None:
    """The skeleton of a wide stem turns into a corner half a width before its end."""
    true = drawing((BLACK, 24, [line((20, 80), (90, 80), (140, 110))]), cap=0)
    found = drawing((BLACK, 24, [line((32, 74), (35, 80), (90, 80), (140, 110))]), cap=0)

    result = _redrawn(found, true)

    assert result.num_segments == true.num_segments < found.num_segments
    assert match(result, true).distance < 0.2


def test_bends_that_are_drawn_are_no_hooks() -> None:
    true = drawing((BLACK, 6, [line((30, 60), (36, 80), (90, 80), (140, 110))]))

    assert _redrawn(true, true) is true


def test_filled_layers_and_pens_stay() -> None:
    true = DRAWINGS["cup"]
    pens = Strokes(
        widths=[5, 0, 3], caps=[1, 0, 2], joins=[1, 0, 0], is_open=np.array([True, False, False, True, True])
    )
    mixed = true.replace(strokes=pens, names=["a", "b", "c"])

    result = _redrawn(mixed, mixed)

    assert result.strokes.widths.tolist() == [5, 0, 3]
    assert result.names == ("a", "b", "c")
    first, last = mixed.segment_offsets[1:3]
    start, end = result.segment_offsets[1:3]
    np.testing.assert_array_equal(result.points[start:end], mixed.points[first:last])
