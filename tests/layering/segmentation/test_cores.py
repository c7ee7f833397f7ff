# SPDX-License-Identifier: Apache-2.0
"""Cores of shaded pictures by known ramps: one ramp stays whole, two are cut from each other, blots are in none."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.segmentation.cores import CUT_PIXELS, cut_cores

SIZE = (40, 60)
PRICE, KINDS = 1e-3, ("linear",)


def ramps(*ends: tuple[float, float]) -> NDArray[np.float64]:
    """Return linear ramps of red side by side, from one level to another in each."""
    width = SIZE[1] // len(ends)
    red = np.concatenate([np.linspace(low, high, width) for low, high in ends])
    return np.stack([np.broadcast_to(red, SIZE), np.full(SIZE, 0.3), np.full(SIZE, 0.6)], axis=2)


def test_one_ramp_is_one_core() -> None:
    assert (cut_cores(ramps((0.2, 0.8)), np.ones(SIZE, np.int64), PRICE, KINDS)[0] == 1).all()


def test_two_ramps_are_cut_from_each_other() -> None:
    labels, _ = cut_cores(ramps((0.2, 0.6), (0.9, 0.3)), np.ones(SIZE, np.int64), PRICE, KINDS)
    shares = [np.bincount(half.ravel(), minlength=9) / half.size for half in np.hsplit(labels, 2)]
    assert shares[0].argmax() != shares[1].argmax()
    assert min(share.max() for share in shares) > 0.5, "most of each half is one core"
    assert shares[0] @ shares[1] < 0.1, "no core lies on both"


@pytest.mark.parametrize(("side", "own"), [(4, False), (6, True)])
def test_blots_are_cores_of_their_own_where_they_are_large_enough(side: int, own: bool) -> None:
    image = ramps((0.2, 0.8))
    places = [(row, column) for row in (4, 16, 28) for column in (4, 20, 36, 50)]
    for row, column in places:
        image[row : row + side, column : column + side] = (0.9, 0.9, 0.1)
    assert own == (side**2 >= CUT_PIXELS)
    labels, _ = cut_cores(image, np.ones(SIZE, np.int64), PRICE, KINDS)
    found = {int(labels[row + 2, column + 2]) for row, column in places}
    assert len(found) == len(places) and 0 not in found if own else found == {0}
    assert labels[0, 0] == labels[-1, -1] > 0 and labels[0, 0] not in found


def test_a_core_cut_apart_has_a_number_for_each_part() -> None:
    """A band of another colour, in no core, between two parts of one label."""
    labels = np.ones(SIZE, np.int64)
    labels[:, 28:32] = 0
    found, _ = cut_cores(ramps((0.2, 0.8)), labels, PRICE, KINDS)
    assert sorted(np.unique(found).tolist()) == [0, 1, 2]
    assert (found[:, 28:32] == 0).all() and found[0, 0] != found[0, -1]
