# SPDX-License-Identifier: Apache-2.0
"""Self-intersections of outlines, measured by winding numbers.

Around the point where two strands of a closed outline cross, the winding number takes three consecutive values, as each
strand changes it by one. So an outline crosses itself exactly if some area has a winding number other than 0 and the
sign of the outline's signed area. Where strands touch, go back on each other or meet in a cusp, that area is zero; so
the area, measured exactly on the flattened outline, tells crossings from contacts by one tolerance in px^2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.geometry import bezier, cyclic

#: Flattening tolerance, px.
FLATTENING = 0.01
#: Area px^2 of other winding above which an outline crosses itself: that of a loop 0.03 px wide. Strands that touch
#: along 2 px or more can exceed it when rounded to three decimals, and then count as crossing.
CROSSING_AREA = 1e-3
#: Numbers in one block of work.
_BLOCK = 1 << 20
#: Extension of lines beyond their ends when they are intersected, as a share of their length: more than rounding loses.
_SLACK = 1e-9


def crossing_area(cubics: ArrayLike, tolerance: float = FLATTENING) -> float:
    """Return the area in which the winding number of a closed outline (M, 4, 2) px is not that of a simple outline.

    Returns
    -------
    float
        Area of all points, px^2, whose winding is neither 0 nor the sign of the outline's signed area. It is above zero
        exactly if the flattened outline crosses itself.
    """
    return polygon_crossing_area(bezier.flatten(cubics, tolerance).corners)


def polygon_crossing_area(start: FloatArray) -> float:
    """Return :func:`crossing_area` of a closed polygon of corners (n, 2), px^2."""
    end = cyclic.following(start)
    meetings = _heights_of_meetings(start, end)
    if not len(meetings):
        return 0.0
    # Between two consecutive heights no lines meet: the shapes there are trapezoids, whose area is the width at half
    # height times the height.
    heights = np.unique(np.concatenate([start[:, 1], meetings]))
    middles, steps = (heights[1:] + heights[:-1]) / 2, np.diff(heights)
    turn = 1 if np.sum(bezier.cross(start, end)) >= 0 else -1
    rows = max(1, _BLOCK // len(start))
    area = 0.0
    for row in range(0, len(middles), rows):
        interruption.check()
        area += float(steps[row : row + rows] @ _widths_of_other_winding(start, end, middles[row : row + rows], turn))
    return area


def following(owners: IntArray) -> IntArray:
    """Return the line after each, (L,), in the closed polygon that it belongs to; `owners` (L,) rise."""
    found = np.arange(1, len(owners) + 1)
    ends = np.flatnonzero(np.diff(owners, append=-1))
    found[ends] = np.concatenate([[0], ends[:-1] + 1])
    return found


def line_meetings(
    start: FloatArray, end: FloatArray, owners: IntArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Intersect the lines of closed polygons with others of the same polygon, neighbours and parallel ones left out.

    Parameters
    ----------
    start, end : (L, 2) float64
        Ends of the lines, px: those of a polygon in its order, polygon after polygon.
    owners : (L,) int
        Polygon of each line, rising.

    Returns
    -------
    i, j : (K,) int
        Pairs of lines, i < j, whose boxes meet, sorted.
    s, t : (K,) float64
        Place of the intersection as a share of line i and of line j; outside [0, 1] only their extensions meet.

    Notes
    -----
    A sweep: the lines of a polygon sorted by their upper ends, each is paired with those that begin before it ends.
    """
    count = len(start)
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((low[:, 1], owners))
    # Place of each lower end among the upper ends of its polygon, those at the same height before it.
    is_end = np.repeat([False, True], count)
    ranks = np.lexsort((is_end, np.concatenate([low[:, 1], high[:, 1]]), np.tile(owners, 2)))
    begun = np.cumsum(~is_end[ranks])
    ends = np.empty(count, np.int64)
    ends[ranks[is_end[ranks]] - count] = begun[is_end[ranks]]
    numbers = ends[order] - np.arange(1, count + 1)
    after = following(owners)
    total = np.concatenate([[0], np.cumsum(numbers)])
    found = []
    first = 0
    while first < count:
        stop = max(first + 1, int(np.searchsorted(total, total[first] + _BLOCK, side="right")) - 1)
        own = np.repeat(np.arange(first, stop), numbers[first:stop])
        later = np.arange(len(own)) + total[first] - total[own] + own + 1
        i, j = np.minimum(order[own], order[later]), np.maximum(order[own], order[later])
        near = (j != after[i]) & (i != after[j]) & (low[i, 0] <= high[j, 0]) & (low[j, 0] <= high[i, 0])
        found.append(np.stack([i[near], j[near]]))
        first = stop
    i, j = np.concatenate([np.zeros((2, 0), np.int64), *found], axis=1)
    i, j = np.stack([i, j])[:, np.lexsort((j, i))]
    along, other, between = end[i] - start[i], end[j] - start[j], start[j] - start[i]
    product = bezier.cross(along, other)
    meets = product != 0
    s, t = (bezier.cross(between, way)[meets] / product[meets] for way in (other, along))
    return i[meets], j[meets], s, t


def _heights_of_meetings(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return y of all points where two lines that are not neighbours or parallel cross or touch."""
    i, _, s, t = line_meetings(start, end, np.zeros(len(start), np.int64))
    meets = (np.minimum(s, t) >= -_SLACK) & (np.maximum(s, t) <= 1 + _SLACK)
    i, s = i[meets], s[meets]
    return np.asarray(start[i, 1] + s * (end[i, 1] - start[i, 1]))


def _widths_of_other_winding(start: FloatArray, end: FloatArray, heights: FloatArray, turn: int) -> FloatArray:
    """Return the length of each horizontal line y = `heights` with a winding number other than 0 and `turn`, px."""
    y = heights[:, None]
    change = (end[:, 1] <= y).astype(np.int32) - (start[:, 1] <= y)  # +1 where the outline goes up, seen from the left
    rise = end[:, 1] - start[:, 1]
    slope = (end[:, 0] - start[:, 0]) / np.where(rise == 0, 1, rise)
    x = np.where(change != 0, start[:, 0] + slope * (y - start[:, 1]), start[:, 0].max())
    order = np.argsort(x, axis=1)
    winding = np.cumsum(np.take_along_axis(change, order, axis=1), axis=1)[:, :-1]
    widths = np.diff(np.take_along_axis(x, order, axis=1), axis=1)
    sums: FloatArray = np.sum(widths * ((winding != 0) & (winding != turn)), axis=1)
    return sums
