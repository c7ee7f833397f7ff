# SPDX-License-Identifier: Apache-2.0
"""The state follows its layers: layers added, taken out, replaced or taken back keep moments, holds and fills."""

from __future__ import annotations

import numpy as np
from support.shapes import build, rectangle

from livecl import Drawing, Options
from livecl.training.adam import Adam
from livecl.training.state import FREE, KEPT, LOCKED, State


def _drawing(*xs: float) -> Drawing:
    return build([([rectangle(x, 4, x + 3, 8)], (x / 24, 0, 0, 1)) for x in xs], (24, 24))


def _numbered(adam: Adam) -> None:
    """Give each row moments and an age of its own."""
    for values in (adam.mean, adam.square, adam.ages):
        values[:] = np.arange(1, len(values) + 1).reshape(-1, *[1] * (values.ndim - 1))


def _state() -> State:
    """Return a state of three layers, locked, kept and free, whose moments are their numbers from 1 on."""
    state = State.start(_drawing(1, 5, 9), Options(), 0)
    state.holds = np.array([LOCKED, KEPT, FREE], np.int8)
    _numbered(state.points)
    _numbered(state.colors)
    _numbered(state.widths)
    return state


def test_a_drawing_to_start_from_is_kept_or_locked() -> None:
    state = State.start(_drawing(1, 5, 9), Options(), 0, np.array([False, True, False]))
    assert state.holds.tolist() == [KEPT, LOCKED, KEPT]
    assert not state.free.any() and state.locked.tolist() == [False, True, False]
    assert state.locked_segments.tolist() == [False] * 4 + [True] * 4 + [False] * 4


def test_added_layers_are_free_and_new_for_adam() -> None:
    state = _state()
    state.add(_drawing(13, 17), np.array([3, 0, 1, 4, 2]))
    assert np.allclose(state.drawing.colors[:, 0] * 24, [13, 1, 5, 17, 9])
    assert state.holds.tolist() == [FREE, LOCKED, KEPT, FREE, FREE]
    assert state.colors.ages.tolist() == state.widths.ages.tolist() == [0, 1, 2, 0, 3]
    assert state.points.ages.tolist() == [0] * 4 + list(range(1, 9)) + [0] * 4 + list(range(9, 13))


def test_layers_taken_out_take_theirs_along() -> None:
    state = _state()
    state.keep_layers(np.array([0, 2]))
    assert np.allclose(state.drawing.colors[:, 0] * 24, [1, 9])
    assert state.holds.tolist() == [LOCKED, FREE]
    assert state.colors.ages.tolist() == state.widths.ages.tolist() == [1, 3]
    assert state.points.ages.tolist() == [1, 2, 3, 4, 9, 10, 11, 12]
    assert len(state.pieces) == 8


def test_a_layer_made_of_others_is_free_and_new_for_adam() -> None:
    state = _state()
    state.replace_layers(_drawing(13, 5), np.array([-1, 1]))
    assert state.holds.tolist() == [FREE, KEPT]
    assert state.colors.ages.tolist() == state.widths.ages.tolist() == [0, 2]
    assert not state.colors.mean[0].any() and state.colors.mean[1].all()
    assert state.points.ages.tolist() == [0] * 4 + [5, 6, 7, 8] and not state.points.square[:4].any()
    assert len(state.pieces) == 8


def test_hidden_points_follow_their_layers_and_new_layers_have_none() -> None:
    state = _state()
    state.hidden = np.repeat([False, True, True], 4)[:, None].repeat(3, axis=1)
    state.replace_layers(_drawing(13, 5), np.array([-1, 1]))
    assert state.hidden is not None and state.hidden[:, 0].tolist() == [False] * 4 + [True] * 4


def test_colors_of_a_palette_stay_and_are_new_for_adam() -> None:
    state = _state()
    state.recolor(_drawing(2, 6, 10))
    assert state.keeps_colors and np.allclose(state.drawing.colors[:, 0] * 24, [2, 6, 10])
    assert not state.colors.ages.any() and not state.colors.mean.any()
    assert state.points.ages.tolist() == list(range(1, 13))


def test_what_is_taken_back_is_as_it_was() -> None:
    state = _state()
    before = state.drawing
    fallback = state.fall_back(0.5)
    state.keep_layers(np.array([2]))
    state.add(_drawing(13), np.array([1, 0]))
    state.points.ages += 5
    state.restore(fallback)
    assert state.drawing is before and state.holds.tolist() == [LOCKED, KEPT, FREE]
    assert state.points.ages.tolist() == list(range(1, 13))
    assert state.colors.ages.tolist() == state.widths.ages.tolist() == [1, 2, 3]


def test_a_copy_does_not_change_with_the_state() -> None:
    state = _state()
    copy = state.copy()
    state.points.ages += 5
    state.colors.mean += 5
    state.rng.uniform()
    assert copy.points.ages.tolist() == list(range(1, 13)) and copy.colors.mean[:, 0].tolist() == [1, 2, 3]
    assert copy.rng.bit_generator.state != state.rng.bit_generator.state
