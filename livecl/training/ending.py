# SPDX-License-Identifier: Apache-2.0
"""Early stopping (`Options.end_early`): a phase ends once further steps gain too little, or cannot gain enough.

A phase has two halves. In the first, steps have their full length, in the second they settle (`Options.settle`). With f
the mean decrease of the loss in the last steps, n more steps lower it by n f at most, as decreases get smaller:

    f (length / 2 - iteration) < worth      the first half ends, and the second takes as many steps as it has taken;
    loss - f (length - iteration) / 2 > limit      the phase is given up.

The factor 1/2 in the last line is the share of n f that successful revisions gain.
"""

from __future__ import annotations

import numpy as np

from livecl.training.state import State

#: Number of steps over which a loss is averaged, before which no phase ends, and between two checks.
WINDOW, EARLIEST, PERIOD = 10, 30, 10
#: Least decrease of the loss over the rest of a first half, as a share of the loss; and squared error, in channels of a
#: pixel, that is negligible: a sixth of the price of an outline's number.
SHARE, NOTHING = 0.01, 1 / 72


def judge_progress(state: State, loss: float, limit: float = np.inf) -> None:
    """Record the loss before the step just taken, and shorten the phase (`State.length`) if it should end early.

    A phase is worthwhile if its loss falls below `limit`.
    """
    state.losses = (*state.losses[1 - 2 * WINDOW :], loss)
    if state.iteration < EARLIEST or state.iteration % PERIOD or 2 * state.iteration >= state.length:
        return
    before, now = np.mean(state.losses[:WINDOW]), np.mean(state.losses[WINDOW:])
    fall = max(float(before - now), 0.0) / WINDOW
    height, width = state.drawing.size
    worth = SHARE * float(now) + NOTHING / (3 * height * width)
    if now - fall * (state.length - state.iteration) / 2 > limit:
        state.length = state.iteration
    elif fall * (state.length / 2 - state.iteration) < worth:
        state.length = 2 * state.iteration
