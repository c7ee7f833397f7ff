# SPDX-License-Identifier: Apache-2.0
"""Depth order, depth cues: evidence for which of two touching flat regions lies in front.

Cues: T-junctions; convexity (the region that bulges into the other lies in front); the saving of each if it continued
behind the other; and enclosure: a region in a hole lies in front, unless it is seen through the hole.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.geometry.polylines import polygon_area
from livecl.layering.outlines.completion import SHORTEST_GAP, completed_contour, joined_contours
from livecl.layering.outlines.contours import AFTER, BEFORE, OWN, Contour, Outlines
from livecl.layering.outlines.prices import Prices, hidden_price, outline_price
from livecl.layering.structure.twins import Pairs, few_alike, same_color, twins

#: Distance from the convex hull, px, up to which a junction lies on it: a constant, and a share of the region's side.
ON_HULL, ON_HULL_SHARE = 2.5, 0.02
#: Least share of a region's outline that faces another one, or what lies on that, for it to lie on it.
LYING = 0.5
#: Markings of a region: (region, marking) to the marking and what lies on it.
Markings = dict[tuple[int, int], frozenset[int]]


def evidence(outlines: Outlines, nodes: list[int], prices: Prices) -> tuple[Pairs, Markings]:
    """Return the evidence of depth order, (front, behind) to a weight, and the markings.

    A marking shares the silhouette of the region that it lies on, as the iris does that of the white of an eye.
    """
    enclosed = {
        (int(o), k)
        for k in nodes
        for hole in outlines.of((k,))[1:]
        if hole.is_hole_of(outlines.outer(k))
        for o in np.unique(hole.across)
        if o >= 0
    }
    known = set(nodes)
    for_one: Pairs = {}
    markings: Markings = {}
    for k in nodes:
        interruption.check()
        contour, hull = outlines.outer(k), _hull(outlines.outer(k).points)
        price = outline_price(contour.points, prices)
        for o, facing in outlines.neighbors(k).items():
            if o not in known or facing < SHORTEST_GAP or {(o, k), (k, o)} & enclosed:
                continue
            saved = price - _price_behind(contour, k, (o,), outlines, prices)
            own = _junctions(contour, o, hull, outlines.regions.sizes[k], prices)
            own += prices.bulge * _bulge(contour, outlines.marks((o,))) - prices.completion * float(
                np.clip(saved, 0, 3)
            )
            found = _marking(contour, k, o, saved, known, outlines, prices)
            if found is not None:
                markings[k, o] = found[0]
                if outlines.regions.sizes[o] < outlines.regions.sizes[k]:
                    own -= prices.marking * float(np.clip(found[1], 0, 3))
            for_one[k, o] = own
    for cover, a, b, saved in itertools.chain(
        _relations(outlines, nodes, for_one, prices), twins(outlines, nodes, for_one, prices)
    ):
        for k in (a, b):
            if (k, cover) in for_one:
                for_one[k, cover] -= min(prices.relation * saved, prices.most_relation)
    front: Pairs = {}
    for (k, o), own in for_one.items():
        if k > o and (o, k) in for_one:
            continue
        sizes = outlines.regions.sizes
        weight = own - for_one.get((o, k), 0.0) + prices.size * float(np.log(sizes[o] / sizes[k]))
        front[(k, o) if weight > 0 else (o, k)] = abs(weight)
    for (k, o), group in markings.items():
        for on_it in group - {o}:  # what lies on a marking lies on what is marked, too
            if not {(k, on_it), (on_it, k)} & front.keys():
                front[on_it, k] = prices.marking
    for inside, around in enclosed:
        if inside in known:
            front[inside, around] = 2 * np.pi
    return front, markings


def _marking(
    contour: Contour, k: int, o: int, saved: float, known: set[int], outlines: Outlines, prices: Prices
) -> tuple[frozenset[int], float] | None:
    """Return a marking with what lies on it, and the saving of one outline around it and its region.

    None where that saves no more than `saved`, the saving of completing the region behind it, or behind all that lies
    on both.
    """
    best = None
    price = outline_price(contour.points, prices)
    for marks in dict.fromkeys((frozenset((o,)), frozenset(known & _lying_on(outlines, o, k)))):
        whole, *holes = outlines.of((k, *marks))
        both = price - outline_price(whole.points, prices) - hidden_price(whole.area, contour.area, prices)
        if both <= saved + prices.saving or (best is not None and both <= best[1]):
            continue
        on_both = known & {int(n) for hole in holes for n in hole.across}
        if both > price - _price_behind(contour, k, marks | on_both, outlines, prices) + prices.saving:
            best = marks, both
    return best


def _lying_on(outlines: Outlines, base: int, beside: int) -> set[int]:
    """Return a region and the smaller ones that lie on it: they face it, or each other, along most of their outline.

    All are apart from the region `beside`.
    """
    sizes, found, untried = outlines.regions.sizes, {base}, [base]
    while untried:
        for k in outlines.neighbors(untried.pop()):
            if k in found or k == beside or sizes[k] >= sizes[base]:
                continue
            facing = outlines.neighbors(k)
            if sum(n for o, n in facing.items() if o in found) >= LYING * sum(map(len, outlines.of((k,)))):
                found.add(k)
                untried.append(k)
    return found


def _price_behind(contour: Contour, k: int, front: Collection[int], outlines: Outlines, prices: Prices) -> float:
    """Return the price of a region's outer outline, completed behind some regions where that is cheaper."""
    below = outlines.covers(front)
    return completed_contour(contour, below, outlines.room((k,), below), outlines, prices)[1]


def _relations(
    outlines: Outlines, nodes: list[int], touching: Pairs, prices: Prices
) -> Iterator[tuple[int, int, int, float]]:
    """Yield (cover, region, region, saving): two regions of one colour with relatable outlines behind a third."""
    few = few_alike(outlines, nodes)
    for cover in nodes:
        below = outlines.covers((cover,))
        beside = [k for k in few if (k, cover) in touching]
        for a, b in itertools.combinations(beside, 2):
            if same_color(outlines, a, b):
                interruption.check()
                first, second = outlines.outer(a), outlines.outer(b)
                found = joined_contours(first, second, below, outlines.room((a, b), below), outlines, prices)
                if found is not None:
                    apart = outline_price(first.points, prices) + outline_price(second.points, prices)
                    saved = apart + prices.layer - found[1]
                    if saved > prices.saving:
                        yield cover, a, b, saved


def _junctions(contour: Contour, other: int, hull: FloatArray | None, size: int, prices: Prices) -> float:
    """Evidence of T-junctions with another region, in favour of the contour's own region."""
    total = 0.0
    for i in np.flatnonzero(contour.straight):
        before, after, kind = int(contour.across[i - 1]), int(contour.across[i]), contour.straight[i]
        if other not in (before, after):
            continue
        if kind == OWN:
            middle = (contour.points[i] + contour.points[i - 1]) / 2
            depth = 0.0 if hull is None else -float((hull[:, :2] @ middle + hull[:, 2]).max())
            total += prices.hull if depth < ON_HULL + ON_HULL_SHARE * np.sqrt(size) else prices.bay
        elif (kind == BEFORE and before == other) or (kind == AFTER and after == other):
            total -= prices.stem
    return total


def _bulge(contour: Contour, below: NDArray[np.bool_]) -> float:
    """Area by which a contour bulges into a neighbour, over the square of its chord, from -1 to 1."""
    total = chord = 0.0
    for start, length in contour.runs(below) or []:
        if length >= SHORTEST_GAP + 1:
            points = contour.points[(start + np.arange(length)) % len(contour)]
            total += polygon_area(points) * np.sign(contour.area)
            chord += float(np.hypot(*(points[-1] - points[0])))
    return float(np.clip(total / max(chord * chord, 1), -1, 1)) if chord else 0.0


def _hull(points: FloatArray) -> FloatArray | None:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(ConvexHull(points).equations)
    except QhullError:
        return None
