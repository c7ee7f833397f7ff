# SPDX-License-Identifier: Apache-2.0
"""Take the loops out of outlines that cross themselves.

Where two strands of a closed outline cross, the outline falls into two closed parts that meet in the crossing. The
larger is kept, with an anchor there: at a corner whose curves overshoot this leaves the corner, sharp, and the rest as
it was.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.geometry.bezier import bernstein, evaluate, pieces_for, signed_area
from livecl.geometry.crossings import CROSSING_AREA, crossing_area

FloatArray = NDArray[np.float64]

#: Distance px between curve and lines that crossings are looked for on.
TOLERANCE = 0.02
#: Lines of a segment at most: pairs of lines are looked at, all of them at once.
MOST_PIECES = 64
#: Crossings that are taken out of one outline at most.
MOST_CROSSINGS = 24
#: Newton steps from a crossing of lines to that of the curves.
NEWTON_STEPS = 4


@dataclasses.dataclass(frozen=True)
class Crossing:
    """Segment and parameter of the two strands, in the order of the outline."""

    first: int
    t: float
    second: int
    u: float


def untangle(cubics: FloatArray) -> FloatArray:
    """Return a closed outline without its crossings.

    Parameters
    ----------
    cubics : (s, 4, 2) float64
        Control points of a closed outline, px.

    Returns
    -------
    (s, 4, 2) float64
        As many segments, of which those far from the crossings are unchanged and in their place; the very array that
        was given where nothing crosses.
    """
    for _ in range(MOST_CROSSINGS):
        crossing = find_crossing(cubics)
        if crossing is None:
            break
        cubics = _trim(cubics, crossing)
    return cubics


def find_crossing(cubics: FloatArray) -> Crossing | None:
    """Return a crossing of a closed outline (s, 4, 2) with itself, or None."""
    counts = np.minimum(pieces_for(cubics, TOLERANCE), MOST_PIECES)
    segments = np.repeat(np.arange(len(cubics)), counts)
    steps = np.concatenate([np.arange(count) / count for count in counts])
    start = np.einsum("lk,lkd->ld", bernstein(steps), cubics[segments])
    end = np.roll(start, -1, axis=0)
    num_lines = len(start)
    (low_x, low_y), (high_x, high_y) = np.minimum(start, end).T, np.maximum(start, end).T
    near = (low_x[:, None] <= high_x) & (low_x <= high_x[:, None])
    near &= (low_y[:, None] <= high_y) & (low_y <= high_y[:, None])
    i, j = np.nonzero(near)
    apart = (j - i >= 2) & (j - i < num_lines - 1)  # lines that follow each other meet, and do not cross
    i, j = i[apart], j[apart]
    along, other, between = end[i] - start[i], end[j] - start[j], start[j] - start[i]
    cross = _cross(along, other)
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = _cross(between, other) / cross, _cross(between, along) / cross
        hits = np.flatnonzero((cross != 0) & (s > 0) & (s < 1) & (t > 0) & (t < 1))
        if not len(hits):  # a meeting at a corner of the lines is a crossing or a contact: the winding tells
            hits = np.flatnonzero((cross != 0) & (s >= 0) & (s < 1) & (t >= 0) & (t < 1))
            if not len(hits) or crossing_area(cubics) <= CROSSING_AREA:
                return None
    k = hits[np.argmin((j - i)[hits])]  # the tightest loop first
    a, b = i[k], j[k]
    first, second = int(segments[a]), int(segments[b])
    crossing = Crossing(first, steps[a] + s[k] / counts[first], second, steps[b] + t[k] / counts[second])
    return _refined(cubics, crossing)


def _refined(cubics: FloatArray, crossing: Crossing) -> Crossing:
    """Newton's method on P(t) = Q(u); the crossing of the lines where it leads astray."""
    t, u = crossing.t, crossing.u
    p, q = cubics[crossing.first], cubics[crossing.second]
    for _ in range(NEWTON_STEPS):
        miss = evaluate(q, [u])[0] - evaluate(p, [t])[0]
        dp, dq = _derivative(p, t), _derivative(q, u)
        determinant = _cross(dp, dq)
        if determinant == 0:
            return crossing
        t += float(_cross(miss, dq) / determinant)
        u += float(_cross(miss, dp) / determinant)
    near = abs(t - crossing.t) < 0.1 and abs(u - crossing.u) < 0.1
    inside = 0 <= t <= 1 and 0 <= u <= 1
    return Crossing(crossing.first, t, crossing.second, u) if near and inside else crossing


def _trim(cubics: FloatArray, crossing: Crossing) -> FloatArray:
    """Keep the larger of the two parts that meet in the crossing, with as many segments as before."""
    count, i, j = len(cubics), crossing.first, crossing.second
    if i == j:
        inner = [_part(cubics[i], crossing.t, crossing.u)]
    else:
        inner = [_part(cubics[i], crossing.t, 1), *cubics[i + 1 : j], _part(cubics[j], 0, crossing.u)]
    outer = [
        _part(cubics[j], crossing.u, 1),
        *cubics[j + 1 :],
        *cubics[:i],
        _part(cubics[i], 0, crossing.t),
    ]
    kept = inner if abs(signed_area(np.array(inner))) > abs(signed_area(np.array(outer))) else outer
    point = (kept[0][0] + kept[-1][3]) / 2
    kept[0] = np.concatenate([point[None], kept[0][1:]])
    kept[-1] = np.concatenate([kept[-1][:3], point[None]])
    if len(kept) > count:  # a loop of one segment: its two ends become one segment again
        kept = [*kept[1:-1], _joined(kept[-1], kept[0])]
    while len(kept) < count:
        k = int(np.argmax([np.hypot(*(cubic[3] - cubic[0])) for cubic in kept]))
        kept[k : k + 1] = [_part(kept[k], 0, 0.5), _part(kept[k], 0.5, 1)]
    turns = [np.roll(kept, turn, axis=0) for turn in range(count)]
    return max(turns, key=lambda turned: int((turned == cubics).all(axis=(1, 2)).sum()))  # as many in place as can be


def _part(cubic: FloatArray, begin: float, end: float) -> FloatArray:
    """Return the cubic that runs along another from parameter `begin` to `end` (its blossom at the two)."""

    def blossom(*ts: float) -> FloatArray:
        points = cubic
        for t in ts:
            points = (1 - t) * points[:-1] + t * points[1:]
        return points[0]

    b, e = begin, end
    return np.stack([blossom(b, b, b), blossom(b, b, e), blossom(b, e, e), blossom(e, e, e)])


def _joined(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cubic from the start of one to the end of the next that is the least-squares fit to both."""
    steps = np.linspace(0, 1, 17)
    points = np.concatenate([evaluate(first, steps[:-1]), evaluate(second, steps)])
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    weights = bernstein(lengths / max(lengths[-1], 1e-12))
    ends = points[[0, -1]]
    handles = np.linalg.lstsq(weights[:, 1:3], points - weights[:, [0, 3]] @ ends, rcond=None)[0]
    return np.stack([ends[0], *handles, ends[1]])


def _derivative(cubic: FloatArray, t: float) -> FloatArray:
    steps = np.diff(cubic, axis=0)
    return np.asarray(3 * ((1 - t) ** 2 * steps[0] + 2 * t * (1 - t) * steps[1] + t * t * steps[2]))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
