# SPDX-License-Identifier: Apache-2.0
"""Paint order of flat regions: the one that agrees best with the evidence, revised where whole shapes become cheaper.

Evidence looks at two regions alone. Below all that lies in front of it at once a shape may go on as below none of its
covers alone: where two regions would be cheaper the other way round, each below all its covers, they change places.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.layering.structure.completion import completed_contour
from livecl.layering.structure.contours import Outlines
from livecl.layering.structure.depth import Pairs, Screen
from livecl.layering.structure.prices import Prices

#: Rounds in which pairs change places.
ROUNDS = 3


def settled(
    outlines: Outlines,
    front: Pairs,
    markings: Pairs,
    nodes: list[int],
    seen_through: list[Screen],
    prices: Prices,
) -> tuple[Pairs, list[int]]:
    """Return the evidence, with the pairs turned round that are cheaper so, and the regions, the lowest first.

    Arguments as of :func:`~livecl.layering.structure.depth.evidence` and what that returned.
    """
    groups = [screen.behind for screen in seen_through]
    sizes = outlines.regions.sizes
    costs = _Costs(outlines, markings, prices)
    front, order = dict(front), paint_order(front, nodes, sizes, groups)
    turned: set[frozenset[int]] = set()
    for _ in range(ROUNDS):
        depth = {k: i for i, k in enumerate(order)}
        found = []
        for (a, b), weight in front.items():
            if weight < prices.decided and frozenset((a, b)) not in turned and depth[a] > depth[b]:
                interruption.check()
                saved = costs.saved(a, b, depth)
                if saved > prices.turn:
                    found.append((saved, a, b))
        if not found:
            break
        moved: set[int] = set()
        for _, a, b in sorted(found, key=lambda item: (-item[0], item[1:])):
            if not {a, b} & moved:
                moved |= {a, b}
                turned.add(frozenset((a, b)))
                front[b, a] = max(front.pop((a, b)), prices.sure + 0.01)
        order = paint_order(front, nodes, sizes, groups)
    return front, order


class _Costs:
    """Prices of regions' whole shapes below others."""

    def __init__(self, outlines: Outlines, markings: Pairs, prices: Prices) -> None:
        self.outlines, self.prices = outlines, prices
        self._markings: dict[int, set[int]] = {}
        for k, marking in markings:
            self._markings.setdefault(k, set()).add(marking)
        self._known: dict[tuple[int, frozenset[int]], float] = {}

    def saved(self, a: int, b: int, depth: dict[int, int]) -> float:
        """Return what it saves that one region lies below another, above which it lies now."""
        above_a, above_b = ({o for o in depth if depth[o] > depth[k]} for k in (a, b))
        now = self._price(a, above_a) + self._price(b, above_b)
        return now - self._price(a, above_a | {b}) - self._price(b, above_b - {a})

    def _price(self, k: int, above: set[int]) -> float:
        """Return the price of a region completed below some others, the markings on it included."""
        outlines = self.outlines
        around = {k} | (self._markings.get(k, set()) & above)
        key = k, frozenset(above & (outlines.neighbors(k).keys() | around))
        if key not in self._known:
            contours, below = outlines.of(around), outlines.covers(above)
            room = outlines.room(around, below)
            self._known[key] = sum(
                completed_contour(contour, below, room, outlines, self.prices)[1]
                for contour in contours
                if not (contour.is_hole_of(contours[0]) and below[contour.across].all())
            )
        return self._known[key]


def paint_order(front: Pairs, nodes: list[int], sizes: NDArray[np.int64], one: list[tuple[int, ...]]) -> list[int]:
    """Return the regions, the lowest first: again and again the one with least evidence of lying in front of the rest.

    Those of each tuple of `one` count as one, and follow each other.
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
