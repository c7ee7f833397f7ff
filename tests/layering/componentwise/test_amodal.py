# SPDX-License-Identifier: Apache-2.0
"""Things that others lie across, joined behind them; and not where too little of them is seen."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl import Options, vectorize
from livecl.layering.componentwise.amodal import amodally_completed

BoolArray = NDArray[np.bool_]

ROWS, COLUMNS = (np.indices((40, 40)) + 0.5).astype(float)
DISC = np.hypot(ROWS - 20, COLUMNS - 20) < 12


def _bar(half_height: float) -> NDArray[np.bool_]:
    return np.asarray((np.abs(ROWS - 20) < half_height) & (COLUMNS > 4) & (COLUMNS < 38))


def _joined(region: BoolArray, alike: BoolArray, hidden: BoolArray) -> BoolArray | None:
    """Return what a region is joined to, on the whole picture."""
    found = amodally_completed(region, alike, hidden)
    if found.mask is None:
        return None
    whole = np.zeros_like(region)
    whole[found.window] = found.mask
    return whole


def test_two_parts_of_a_disc_are_joined_behind_a_bar() -> None:
    bar = _bar(3)
    upper = DISC & ~bar & (ROWS < 20)
    joined = _joined(upper, DISC & ~bar, bar)
    assert joined is not None
    assert np.all(joined[DISC & ~bar]) and not np.any(joined & ~(DISC | bar))
    # The hull is straight between the parts: of the disc's six rows behind the bar it leaves out less than half a
    # pixel, the sagitta of a chord of 6 px, at either side.
    assert not np.any(joined & ~DISC) and np.sum(DISC & ~joined) <= 2 * 6


def test_nothing_is_joined_where_nothing_hides_or_too_much() -> None:
    bar = _bar(3)
    upper, seen = DISC & ~bar & (ROWS < 20), DISC & ~bar
    assert amodally_completed(upper, seen, np.zeros_like(bar)).mask is None  # two things, nothing between them
    assert amodally_completed(upper, upper, bar).mask is None  # one thing
    wide = _bar(9)
    assert (
        amodally_completed(DISC & ~wide & (ROWS < 20), DISC & ~wide, wide).mask is None
    )  # more is hidden than is seen


def test_a_region_keeps_what_does_not_lie_behind_anything() -> None:
    # Two discs of one colour, far from the bar that hides part of one of them: the other is a thing of its own.
    bar = _bar(2)
    spot = np.hypot(ROWS - 36, COLUMNS - 36) < 3
    joined = _joined(DISC & ~bar & (ROWS < 20), (DISC & ~bar) | spot, bar)
    assert joined is not None and not np.any(joined & spot)


@pytest.mark.parametrize("across", [_bar(3), _bar(3).T])
def test_three_things_take_three_paths(across: NDArray[np.bool_], device: int) -> None:
    picture = np.ones((40, 40, 3))
    picture[DISC] = (0.85, 0.2, 0.1)
    picture[across] = (0.1, 0.2, 0.7)
    picture[np.hypot(ROWS - 35, COLUMNS - 33) < 4] = (0.2, 0.7, 0.2)
    result = vectorize(picture, 3, options=Options(iterations=80, revisions=0), device=device)
    assert result.drawing.num_layers == 3
    # Half of the disc missing is .03, the spot .01; the rest is the steps of unsmoothed edges.
    assert result.mse < 2e-3
