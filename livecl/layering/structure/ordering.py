# SPDX-License-Identifier: Apache-2.0
"""Paint order of flat regions: the order that agrees best with the evidence."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.layering.structure.twins import Pairs


def paint_order(front: Pairs, nodes: list[int], sizes: NDArray[np.int64], one: list[tuple[int, ...]]) -> list[int]:
    """Return the regions in paint order, the lowest first, greedily by least evidence of lying in front.

    The regions of each tuple in `one` are treated as one, and are consecutive.
    """
    leader = {k: k for k in nodes}
    for group in one:
        members = [k for k in group if k in leader]
        for old in {leader[k] for k in members}:
            for k in leader:
                if leader[k] == old:
                    leader[k] = leader[members[-1]]
    index = {k: i for i, k in enumerate(sorted(set(leader.values())))}
    keys = list(index)
    weights = np.zeros((len(keys), len(keys)))
    for (a, b), weight in front.items():
        if a in leader and b in leader and leader[a] != leader[b]:
            weights[index[leader[a]], index[leader[b]]] += weight
    weights = np.maximum(weights - weights.T, 0)
    left = np.ones(len(keys), bool)
    order: list[int] = []
    while left.any():
        at = np.flatnonzero(left)
        sums = weights[np.ix_(at, at)]
        lowest = at[np.lexsort((-sizes[keys][at], sums.sum(axis=1) - 1e-3 * sums.sum(axis=0)))[0]]
        left[lowest] = False
        order += [keys[lowest], *(k for k in nodes if leader[k] == keys[lowest] and k != keys[lowest])]
    return order
