# SPDX-License-Identifier: Apache-2.0
"""Outlines that cross themselves, found by their winding.

Around the point where two strands of a closed outline cross, the winding takes three consecutive values, as each strand
changes it by one. So an outline crosses itself exactly if some area has a winding other than 0 and that of the whole
outline's turn. Where strands touch, go back on each other or meet in a cusp, that area is zero; so the area, measured
exactly on the flattened outline, tells crossings from contacts by one tolerance in px^2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.geometry import bezier

#: Largest distance between the outline and the lines that stand for it, px.
FLATTENING = 0.01
#: Area px^2 of other winding up to which an outline does not count as crossing itself: that of a loop 0.03 px wide.
#: Strands that touch along 2 px or more can reach it by rounding to three decimals, and then count as crossing.
CROSSING_AREA = 1e-3
#: Numbers worked on at a time.
_BLOCK = 1 << 20
#: How far beyond its ends a line still meets another, as a share of its length: more than rounding loses.
_SLACK = 1e-9

FloatArray = NDArray[np.float64]


def crossing_area(cubics: ArrayLike, tolerance: float = FLATTENING) -> float:
    """Return the area that a closed outline winds around otherwise than a simple outline does.

    Parameters
    ----------
    cubics : (M, 4, 2) array_like
        One closed subpath, px.
    tolerance : float
        Distance px within which it is flattened.

    Returns
    -------
    float
        Area of all points, px^2, whose winding is neither 0 nor the sign of the outline's signed area. It is above zero
        exactly if the flattened outline crosses itself.
    """
    start = flatten(cubics, tolerance)
    end = np.roll(start, -1, axis=0)
    meetings = _heights_of_meetings(start, end)
    if not len(meetings):
        return 0.0
    # Between two consecutive heights no lines meet: what is between them are trapezoids, whose area is the width at
    # half height times the height.
    heights = np.unique(np.concatenate([start[:, 1], meetings]))
    middles, steps = (heights[1:] + heights[:-1]) / 2, np.diff(heights)
    turn = 1 if np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]) >= 0 else -1
    rows = max(1, _BLOCK // len(start))
    return float(
        sum(
            steps[row : row + rows] @ _widths_of_other_winding(start, end, middles[row : row + rows], turn)
            for row in range(0, len(middles), rows)
        )
    )


def flatten(cubics: ArrayLike, tolerance: float = FLATTENING) -> FloatArray:
    """Return the corners of the polygon that a closed outline (M, 4, 2) is flattened into: (K, 2), px."""
    cubics = np.asarray(cubics, dtype=np.float64)
    counts = bezier.pieces_for(cubics, tolerance)
    return np.concatenate(
        [bezier.evaluate(cubic, np.arange(count) / count) for cubic, count in zip(cubics, counts, strict=True)]
    )


def _heights_of_meetings(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return y of all points where two lines that are no neighbours cross or touch; parallel lines do not."""
    count = len(start)
    low, high = np.minimum(start, end), np.maximum(start, end)
    index = np.arange(count)
    found = []
    rows = max(1, _BLOCK // count)
    for first in range(0, count, rows):
        own = slice(first, min(first + rows, count))
        near = index[None, :] > index[own, None] + 1
        for axis in (0, 1):
            near &= low[None, :, axis] <= high[own, None, axis]
            near &= high[None, :, axis] >= low[own, None, axis]
        if first == 0:
            near[0, -1] = False
        i, j = np.nonzero(near)
        i += first
        along, other, between = end[i] - start[i], end[j] - start[j], start[j] - start[i]
        cross = _cross(along, other)
        meets = cross != 0
        i, along, other, between, cross = i[meets], along[meets], other[meets], between[meets], cross[meets]
        s, t = _cross(between, other) / cross, _cross(between, along) / cross
        meets = (np.minimum(s, t) >= -_SLACK) & (np.maximum(s, t) <= 1 + _SLACK)
        found.append(start[i[meets], 1] + s[meets] * along[meets, 1])
    return np.concatenate(found)


def _widths_of_other_winding(start: FloatArray, end: FloatArray, heights: FloatArray, turn: int) -> FloatArray:
    """Return how much of each horizontal line y = `heights` has a winding other than 0 and `turn`, px."""
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


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product
