# SPDX-License-Identifier: Apache-2.0
"""Regions of one colour that may be parts of one shape, and mirror twins beside what covers their middle.

Symmetry groups (the Gestalt laws; Wagemans, Acta Psychologica 90, 1995): the two halves of a jacket are one below the
shirt, the tie and the lapels, although no single one of these covers its middle.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from livecl import interruption
from livecl.layering.outlines.completion import joined_contours
from livecl.layering.outlines.contours import Contour, Outlines
from livecl.layering.outlines.prices import Prices, outline_price

Pairs = dict[tuple[int, int], float]

#: Most regions of one colour that are compared as parts of an occluded shape.
MOST_ALIKE = 60
#: Mean distance, px, of an outline from the mirror image of its twin, at most: a constant, and a share of the root of
#: the area; pixels of the smaller one.
MIRRORED, MIRRORED_SHARE, LEAST_TWIN = 1.0, 0.02, 100
#: Share of the points at which a region faces another, that a join takes away: it goes on below that one.
TAKEN = 0.5


def same_color(outlines: Outlines, a: int, b: int) -> bool:
    """Whether two regions have one colour."""
    return outlines.regions.alike(a, b)


def few_alike(outlines: Outlines, nodes: list[int]) -> list[int]:
    """Return the regions whose colour is shared by at most `MOST_ALIKE` regions, in their order.

    More are letters, pixels or the spaces between lines: comparing all their pairs would be in vain.
    """
    counts = [int(np.count_nonzero(outlines.regions.near(outlines.regions.colors[k])[nodes])) for k in nodes]
    return [k for k, count in zip(nodes, counts, strict=True) if count <= MOST_ALIKE]


def twins(
    outlines: Outlines, nodes: list[int], touching: Pairs, prices: Prices
) -> Iterator[tuple[int, int, int, float]]:
    """Yield (cover, region, region, saving): mirror images of one colour that are one shape below several others.

    A single one that covers both tells it already. `touching` has the pairs that touch.
    """
    sizes = outlines.regions.sizes
    few = [k for k in few_alike(outlines, nodes) if sizes[k] >= LEAST_TWIN]
    beside: dict[int, set[int]] = {}
    for k, other in touching:
        beside.setdefault(k, set()).add(other)
    for a, b in itertools.combinations(few, 2):
        if not same_color(outlines, a, b) or not (a in beside and b in beside):
            continue
        first, second = outlines.outer(a), outlines.outer(b)
        if not _mirrored(first, second):
            continue
        interruption.check()
        below = outlines.covers(k for k in nodes if k not in (a, b))
        found = joined_contours(first, second, below, outlines.room((a, b), below), outlines, prices)
        if found is None:
            continue
        saved = outline_price(first.points, prices) + outline_price(second.points, prices) + prices.layer - found[1]
        if saved <= prices.saving:
            continue
        covers = []
        for cover in sorted(beside[a] | beside[b]):
            facing = np.count_nonzero(first.across == cover) + np.count_nonzero(second.across == cover)
            if np.count_nonzero(found[0].across == cover) < (1 - TAKEN) * facing:
                covers.append(cover)
        if len(covers) > 1:
            yield from ((cover, a, b, saved) for cover in covers)


def _mirrored(first: Contour, second: Contour) -> bool:
    """Whether two outlines are mirror images about the line in the middle of their centres."""
    if not 0.5 < abs(first.area / second.area) < 2:
        return False
    centers = first.points.mean(axis=0), second.points.mean(axis=0)
    way = centers[1] - centers[0]
    length = float(np.hypot(*way))
    if length < 1:
        return False
    way /= length
    away = (first.points - (centers[0] + centers[1]) / 2) @ way
    image = first.points - 2 * away[:, None] * way
    distance = max(cKDTree(one).query(other)[0].mean() for one, other in itertools.permutations((image, second.points)))
    return bool(distance <= MIRRORED + MIRRORED_SHARE * np.sqrt(abs(first.area)))
