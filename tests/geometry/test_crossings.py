# SPDX-License-Identifier: Apache-2.0
"""Lines of polygons that meet are found as by trying each pair."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.geometry import crossings
from livecl.geometry.crossings import following, line_meetings


def _by_trying(corners: NDArray[Any], owners: NDArray[Any]) -> list[tuple[int, int, float, float]]:
    found = []
    for i in range(len(corners)):
        own = np.flatnonzero(owners == owners[i])
        for j in own[own > i + 1]:
            if (i, j) == (own[0], own[-1]):
                continue
            (a, b), (c, d) = ((corners[k], corners[own[(k - own[0] + 1) % len(own)]]) for k in (i, j))
            apart = np.any(np.maximum(a, b) < np.minimum(c, d)) or np.any(np.maximum(c, d) < np.minimum(a, b))
            turn = (b - a)[0] * (d - c)[1] - (b - a)[1] * (d - c)[0]
            if not apart and turn != 0:
                s = ((c - a)[0] * (d - c)[1] - (c - a)[1] * (d - c)[0]) / turn
                t = ((c - a)[0] * (b - a)[1] - (c - a)[1] * (b - a)[0]) / turn
                found.append((i, int(j), s, t))
    return found


@pytest.mark.parametrize("block", [1, 7, 1 << 20])
@pytest.mark.parametrize("levels", [3, 1000])
def test_meetings(block: int, levels: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crossings, "_BLOCK", block)
    rng = np.random.default_rng(levels)
    owners = np.repeat(np.arange(5), [1, 2, 9, 3, 14])
    corners = rng.integers(levels, size=(len(owners), 2)).astype(np.float64)  # of three levels, many lines touch
    i, j, s, t = line_meetings(corners, corners[following(owners)], owners)
    wanted = _by_trying(corners, owners)
    assert list(zip(i.tolist(), j.tolist(), strict=True)) == [pair[:2] for pair in wanted]
    np.testing.assert_allclose(np.stack([s, t], axis=1), [pair[2:] for pair in wanted], rtol=1e-12)
    assert len(wanted) > 10


def test_no_lines() -> None:
    assert [len(array) for array in line_meetings(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.int64))] == [0] * 4
