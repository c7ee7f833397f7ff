# SPDX-License-Identifier: Apache-2.0
"""When a phase of training ends, by losses whose course is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from livecl import Options
from livecl.drawing.assembly import empty_drawing
from livecl.training.ending import judge_progress
from livecl.training.state import State

LENGTH = 200
#: What the module says of itself: the first step after which a phase may end, and what the rest must be worth.
EARLIEST, SHARE, NOTHING = 30, 0.01, 1 / 72


def ended(loss_at: Callable[[int], float], limit: float = np.inf) -> tuple[int, int]:
    """Return the step at which the phase was shortened, and the steps that it then had; those planned if never."""
    state = State.start(empty_drawing((10, 10), np.ones(3)), Options(iterations=LENGTH), 0)
    while state.iteration < state.length:
        loss = loss_at(state.iteration)
        state.iteration += 1
        judge_progress(state, loss, limit)
        if state.length != LENGTH:
            return state.iteration, state.length
    return LENGTH, LENGTH


def test_what_does_not_change_ends_as_soon_as_it_may_and_settles_as_long() -> None:
    assert ended(lambda i: 0.25) == (EARLIEST, 2 * EARLIEST)


def test_what_gets_worse_ends_too() -> None:
    assert ended(lambda i: 0.25 + 0.001 * i) == (EARLIEST, 2 * EARLIEST)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_rest_of_the_first_half_must_be_worth_a_share_of_the_loss(factor: float) -> None:
    slope = factor * SHARE / (LENGTH / 2 - EARLIEST)  # of a loss of about 1
    step, length = ended(lambda i: 1 - slope * (i - EARLIEST + 5.5))
    assert (step == EARLIEST) == (factor < 1) and length == 2 * step


def test_a_fall_that_nobody_sees_is_worth_nothing_however_small_the_loss() -> None:
    seen = NOTHING / 300 / (LENGTH / 2 - EARLIEST)  # each step, on 10 x 10 pixels
    for factor, early in ((0.5, True), (2.0, False)):
        assert (ended(lambda i, f=factor: 300 * f * seen - f * seen * i)[0] == EARLIEST) == early  # type: ignore[misc]


def test_a_phase_that_cannot_come_below_its_limit_is_given_up_at_once() -> None:
    falling = lambda i: 1 - 0.001 * i  # noqa: E731
    assert ended(falling, limit=0.2) == (EARLIEST, EARLIEST)
    assert ended(falling, limit=0.95) == (LENGTH, LENGTH)
    assert ended(falling, limit=0.87) == (EARLIEST, EARLIEST)  # it comes to .89 if half of the way is as steep


def test_steps_of_long_ago_do_not_count() -> None:
    assert ended(lambda i: 1 - 0.05 * min(i, 9)) == (EARLIEST, 2 * EARLIEST)


def test_nothing_ends_in_the_second_half() -> None:
    assert ended(lambda i: 1 - 0.01 * min(i, 99)) == (LENGTH, LENGTH)
