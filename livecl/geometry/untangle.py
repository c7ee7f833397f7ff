# SPDX-License-Identifier: Apache-2.0
"""Untangling: cut the loops out of outlines that cross themselves.

Where two strands of a closed outline cross, the crossing divides it into two closed parts. The larger is kept, with an
anchor at the crossing: where curves overshoot a corner, this leaves a sharp corner and does not change the rest.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from livecl.arrays import FloatArray, IntArray
from livecl.geometry.bezier import bernstein, cross, derivative, evaluate, flatten, signed_area, subsegment
from livecl.geometry.crossings import CROSSING_AREA, crossing_area, following, line_meetings
from livecl.geometry.polylines import lengths_along

#: Flattening tolerance for the search of crossings, px.
TOLERANCE = 0.02
#: Maximum number of lines of a segment: the search works on pairs of lines.
MAX_PIECES = 64
#: Maximum number of crossings removed from one outline.
MAX_CROSSINGS = 24
#: Newton steps from a crossing of lines to that of the curves.
NEWTON_STEPS = 4


@dataclasses.dataclass(frozen=True)
class Crossing:
    """Segment and parameter of the two strands, in the order of the outline; area of its largest loop, px^2."""

    first: int
    t: float
    second: int
    u: float
    largest: float = 0.0


def untangle(outlines: Sequence[FloatArray], largest: float = np.inf) -> list[FloatArray]:
    """Return closed outlines without their crossings.

    Parameters
    ----------
    outlines : sequence of (s, 4, 2) float64
        Control points of each closed outline, px.
    largest : float
        Outlines with a loop of a larger area, px^2, are not changed.

    Returns
    -------
    list of (s, 4, 2) float64
        The numbers of segments do not change, nor do segments far from the crossings and their indices; without
        crossings, the same array.
    """
    found = list(outlines)
    tangled = list(range(len(found)))
    for _ in range(MAX_CROSSINGS):
        crossings = find_crossings([found[k] for k in tangled])
        cuts = {k: crossing for k, crossing in zip(tangled, crossings, strict=True) if crossing is not None}
        for k, crossing in cuts.items():
            found[k] = _trim(found[k], crossing) if crossing.largest <= largest else outlines[k]
        tangled = [k for k, crossing in cuts.items() if crossing.largest <= largest]
        if not tangled:
            break
    return found


def parted(outline: FloatArray) -> list[FloatArray]:
    """Split an outline (n, 4, 2) at its crossings into closed outlines (s, 4, 2).

    None of them crosses itself, except for crossings beyond `MAX_CROSSINGS`. Their winding numbers add up to the
    outline's: the filled area does not change.
    """
    whole, left = [], [outline]
    for _ in range(MAX_CROSSINGS):
        if not left:
            break
        crossing = find_crossings(left[-1:])[0]
        if crossing is None:
            whole.append(left.pop())
        else:
            left[-1:] = _parts(left[-1], crossing)
    return [*whole, *left]


def find_crossings(outlines: Sequence[FloatArray]) -> list[Crossing | None]:
    """Return a crossing of each closed outline (s, 4, 2) with itself, or None: the tightest loop of each."""
    found: list[Crossing | None] = [None] * len(outlines)
    if not outlines:
        return found
    numbers = [len(outline) for outline in outlines]
    cubics = np.concatenate(outlines)
    lines = flatten(cubics, TOLERANCE, MAX_PIECES)
    owners = np.repeat(np.arange(len(outlines)), numbers)[lines.segments]
    i, j, s, t = line_meetings(lines.corners, lines.corners[following(owners)], owners)
    meets = np.flatnonzero((s >= 0) & (s < 1) & (t >= 0) & (t < 1))
    i, j, s, t = i[meets], j[meets], s[meets], t[meets]
    inside = (s > 0) & (t > 0)
    tangled, chosen = [], []
    for k in np.unique(owners[i]):
        hits = np.flatnonzero((owners[i] == k) & inside)
        if not len(hits):  # lines that meet at their ends cross or touch: winding numbers tell
            hits = np.flatnonzero(owners[i] == k)
            if crossing_area(outlines[k]) <= CROSSING_AREA:
                continue
        tangled.append(k)
        chosen.append(hits[np.argmin((j - i)[hits])])
    pairs = np.stack([i[chosen], j[chosen]])
    segments = lines.segments[pairs]
    places = lines.t[pairs] + np.stack([s[chosen], t[chosen]]) / lines.counts[segments]
    places = _refined(cubics[segments], places)
    own = segments - np.cumsum([0, *numbers])[tangled]
    loops = _loop_areas(lines.corners, owners, (i, j), s)
    for k, (first, second), (at, to) in zip(tangled, own.T.tolist(), places.T.tolist(), strict=True):
        found[k] = Crossing(first, at, second, to, float(loops[owners[i] == k].max()))
    return found


def _loop_areas(corners: FloatArray, owners: IntArray, pairs: tuple[IntArray, IntArray], s: FloatArray) -> FloatArray:
    """Return the area, px^2, of the smaller of the two parts that meet in each crossing: (K,).

    Of closed polygons of corners (L, 2), of which the pairs of lines cross at the shares `s` of the first.
    """
    i, j = pairs
    after = following(owners)
    sums = np.concatenate([[0.0], np.cumsum(cross(corners, corners[after]))])
    meeting = corners[i] + s[:, None] * (corners[after[i]] - corners[i])
    inner = sums[j] - sums[i + 1] + cross(corners[j], meeting) + cross(meeting, corners[i + 1])
    ends = np.searchsorted(owners, np.stack([owners[i], owners[i] + 1]))
    outer = sums[ends[1]] - sums[ends[0]] - inner
    return np.asarray(np.minimum(np.abs(inner), np.abs(outer)) / 2)


def _refined(strands: FloatArray, places: FloatArray) -> FloatArray:
    """Refine crossings by Newton's method on P(t) = Q(u), (2, K, 4, 2); those of lines, (2, K), where it diverges."""
    refined = places.copy()
    whole = np.ones(places.shape[1], bool)
    for _ in range(NEWTON_STEPS):
        p, q = np.einsum("skn,sknd->skd", bernstein(refined), strands)
        dp, dq = derivative(strands, refined)
        determinant = cross(dp, dq)
        whole &= determinant != 0
        refined += np.stack([cross(q - p, dq), cross(q - p, dp)]) / np.where(whole, determinant, np.inf)
    near = np.all((np.abs(refined - places) < 0.1) & (refined >= 0) & (refined <= 1), axis=0)
    return np.where(whole & near, refined, places)


def _parts(cubics: FloatArray, crossing: Crossing) -> tuple[FloatArray, FloatArray]:
    """Return the two closed parts of an outline that meet in a crossing: the loop between its strands, and the rest."""
    i, j, t, u = crossing.first, crossing.second, crossing.t, crossing.u
    parts = subsegment(cubics[[i, i, i, j, j]], [0, t, t, 0, u], [t, u, 1, u, 1])
    inner = parts[1:2] if i == j else np.concatenate([parts[2:3], cubics[i + 1 : j], parts[3:4]])
    outer = np.concatenate([parts[4:], cubics[j + 1 :], cubics[:i], parts[:1]])
    for part in (inner, outer):
        part[0, 0] = part[-1, 3] = (part[0, 0] + part[-1, 3]) / 2
    return inner, outer


def _trim(cubics: FloatArray, crossing: Crossing) -> FloatArray:
    """Keep the larger of the two parts that meet in the crossing, with as many segments as before."""
    count, (inner, outer) = len(cubics), _parts(cubics, crossing)
    kept = inner if abs(signed_area(inner)) > abs(signed_area(outer)) else outer
    if len(kept) > count:  # a loop of one segment: its two ends become one segment again
        kept = np.concatenate([kept[1:-1], _one_cubic(kept[-1], kept[0])[None]])
    while len(kept) < count:
        k = int(np.argmax(np.hypot(*(kept[:, 3] - kept[:, 0]).T)))
        kept = np.concatenate([kept[:k], subsegment(kept[k], [0, 0.5], [0.5, 1]), kept[k + 1 :]])
    places = np.arange(count) - np.arange(count)[:, None]  # element at each place, by the turn
    stays = (kept[places] == cubics).all(axis=(2, 3)).sum(axis=1)
    return np.asarray(kept[places[np.argmax(stays)]])  # the turn that keeps most segments' indices


def _one_cubic(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cubic from the start of one to the end of the next that is the least-squares fit to both."""
    steps = np.linspace(0, 1, 17)
    points = np.concatenate([evaluate(first, steps[:-1]), evaluate(second, steps)])
    lengths = lengths_along(points)
    weights = bernstein(lengths / max(lengths[-1], 1e-12))
    ends = points[[0, -1]]
    handles = np.linalg.lstsq(weights[:, 1:3], points - weights[:, [0, 3]] @ ends, rcond=None)[0]
    return np.stack([ends[0], *handles, ends[1]])
