# SPDX-License-Identifier: Apache-2.0
"""Fit an editable outline, the one of least description length, to a traced outline.

Nodes lie at corners, at extremes and where one segment does not suffice. Segments are lines or cubics, joins other than
corners are smooth, and nearly level or plumb sides become level or plumb. The nodes of a whole outline are optimized by
dynamic programming over the candidate nodes of the trace: the price of the numbers written plus that of the distance
from the trace.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.editing.trace import SURE, SampledOutline
from livecl.geometry import cyclic
from livecl.geometry.bezier import cross, meeting_point
from livecl.geometry.least_path import SHARES, SegmentPrices, Segments, Tangents, cheapest_way, fit_curves
from livecl.geometry.polylines import unit


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fit(SegmentPrices):
    """Prices of an outline's numbers, as SVG writes them, and its tolerances to the trace."""

    line: float = 2.0
    curve: float = 6.0
    straying: float = 7.0
    straight: float = 0.25
    tolerance: float = 0.25
    corner: float = 1.0  # numbers that a corner costs
    #: Numbers saved by a smooth node, as one segment gives the direction of the next; twice as many at an extreme,
    #: whose direction is known.
    smooth: float = 1.0
    flat: float = 4.0  # extra cost of a corner that hardly turns: nobody draws such ones
    side: float = 3.0  # extra cost of a curve for each straight side that it includes
    level: float = 0.3  # largest deviation, px, of a line that is made level or plumb


#: Largest angle, radians, between a line and the outline at its smooth ends, and between a line and an axis for it to
#: be made level.
ALIGNED, TILT = 0.12, 0.06
#: Largest move, px, of a corner to the intersection of its sides; least sine of the angle between sides that intersect.
APEX, MEETING = 1.2, 0.3
#: Length, px, at corners that is affected by their rounding; weight of the samples there.
ROUNDING, ROUNDED = 1.25, 0.1
#: Rounds of fitting the handles when nodes are chosen.
ROUNDS = 2
#: Share of a straight side from which a curve includes it.
TAKEN = 0.5
#: Longest segment, as a share of the outline, and longest one between smooth ends (half a circle is no cubic); most
#: pairs of candidate nodes compared.
LONGEST, LONGEST_SMOOTH, MOST_PAIRS = 0.6, 0.4, 2500


def editable_outline(trace: SampledOutline, fit: Fit) -> FloatArray | None:
    """Fit the closed path (s, 3, 2) of least price to a trace, px; None if none fits."""
    return editable_outlines(trace, [fit])[0]


def editable_outlines(trace: SampledOutline, fits: Sequence[Fit]) -> list[FloatArray | None]:
    """Fit paths as :func:`editable_outline` does, for several prices: segments are fitted once for all."""
    choice = _Choice(trace, *_places(trace))
    found: list[FloatArray | None] = []
    for fit in fits:
        interruption.check()
        chosen = choice.cheapest(fit)
        if chosen is None or len(chosen[0]) < 2:
            found.append(None)
            continue
        nodes, straight = chosen
        samples = choice.places[nodes] % len(trace.points)
        found.append(_Assembly(trace, samples, choice.corner[nodes], straight, fit).path())
    return found


def _places(trace: SampledOutline) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the samples of all places, from a node in any case up to it again a round later; and which are corners.

    Where there may be a corner, there are two places: one as a corner, one as a smooth node.
    """
    count = len(trace.points)
    if len(trace.corners):
        strongest = int(np.argmax(trace.turning))
        first, sure = int(trace.corners[strongest]), bool(trace.turning[strongest] > SURE)
    else:
        extremes = trace.places[trace.extreme[trace.places]]
        first, sure = int(next(iter([*extremes, *trace.places]))), False
    smooth = np.setdiff1d((trace.places - first) % count, [0])
    bends = np.setdiff1d((trace.corners - first) % count, [0])
    samples = np.concatenate([smooth, bends])
    corner = np.concatenate([np.zeros(len(smooth), bool), np.ones(len(bends), bool)])
    order = np.argsort(samples, kind="stable")
    samples = np.concatenate([[0], samples[order], [count]]) + first
    return samples, np.concatenate([[sure], corner[order], [sure]])


class _Choice:
    """Choice of nodes among the candidates of a trace.

    Parameters
    ----------
    trace : SampledOutline
        The outline.
    places : (n,) int64
        Samples that a node may stand at, from one up to it again a round later.
    corner : (n,) bool
        Which of them are corners.
    """

    def __init__(self, trace: SampledOutline, places: IntArray, corner: NDArray[np.bool_]) -> None:
        self.trace, self.places, self.corner = trace, places, corner
        count, num = len(trace.points), len(places)
        i, j = np.triu_indices(num, 1)
        span = places[j] - places[i]
        near = (span > 0) & (span <= LONGEST * count) & (j - i <= max(8, MOST_PAIRS // num))
        near &= (span <= LONGEST_SMOOTH * count) | corner[i] | corner[j]
        sure = np.sort(np.concatenate([lap * count + trace.corners[trace.turning > SURE] for lap in (0, 1, 2)]))
        passed = np.searchsorted(sure, places[j]) - np.searchsorted(sure, places[i], side="right")
        near &= passed <= 0  # a sure corner is always a node
        i, j = i[near], j[near]
        starts, ends = places[i], places[j]
        runs, at = _runs(trace, starts, ends)
        weights = _unrounded(trace, at, starts, ends, corner[i], corner[j])
        tangents = trace.tangent(places % count) @ (1, 1j)
        free = np.stack([corner[i], corner[j]], axis=1)
        lengths = np.asarray((ends - starts) * trace.step, np.float64)
        self._segments = Segments(runs, lengths, weights, Tangents(tangents[i], tangents[j], free))
        self._ends = i, j
        self._taken = [  # straight sides that a segment takes in
            np.minimum(ends, last) - np.maximum(starts, first) >= TAKEN * (last - first)
            for first, last in np.concatenate([trace.sides, trace.sides + count])
        ]
        chord = runs[:, -1] - runs[:, 0]
        self._flat = np.sort(np.abs([chord.real, chord.imag]), axis=0)
        bends = [np.abs((chord * tangents[side].conj()).imag) > ALIGNED * np.abs(chord) for side in (i, j)]
        self._bent = (~corner[i] & bends[0]) | (~corner[j] & bends[1])

    def cheapest(self, fit: Fit) -> tuple[IntArray, NDArray[np.bool_]] | None:
        """Return the places of the cheapest path's nodes, and whether the segment after each is a line."""
        (i, j), num, corner = self._ends, len(self.places), self.corner
        lined, curved = self._segments.costs(fit)
        for taken in self._taken:
            curved = curved + fit.side * taken
        lined -= self._flat[0] <= np.minimum(fit.level, TILT * self._flat[1])
        lined[self._bent] = np.inf
        known = np.where(self.trace.extreme[self.places % len(self.trace.points)], 2.0, 1.0)
        joins = np.where(corner, fit.corner, [-fit.smooth * known, np.full(num, -fit.smooth), np.full(num, np.inf)])
        # Way and outline begin at one node: its price is parted between the segments that meet there.
        half = joins[0, 0] / 2, joins[1, 0] - joins[0, 0] / 2
        at_node = (i == 0).astype(int) + (j == num - 1)
        tables = np.full((2, num, num), np.inf)
        tables[:, i, j] = lined + half[1] * at_node, curved + half[0] * at_node
        way, straight, price = cheapest_way(tables[0], tables[1], joins)
        return (np.array(way[:-1]), np.array(straight)) if np.isfinite(price) else None


def _runs(
    trace: SampledOutline, starts: IntArray, ends: IntArray
) -> tuple[NDArray[np.complexfloating[Any, Any]], FloatArray]:
    """Return points x + iy of runs of a trace at SHARES of their lengths, and where they are, in samples.

    `starts` and `ends`, (n,), are their first and last samples, ends counted on past the last of the trace.
    """
    at = starts[:, None] + (ends - starts)[:, None] * SHARES
    whole = np.floor(at).astype(np.int64)
    points, count = trace.points @ (1, 1j), len(trace.points)
    return points[whole % count] + (at - whole) * (points[(whole + 1) % count] - points[whole % count]), at


def _unrounded(
    trace: SampledOutline,
    at: FloatArray,
    starts: IntArray,
    ends: IntArray,
    first: NDArray[np.bool_],
    last: NDArray[np.bool_],
) -> FloatArray:
    """Return the weights of the inner ones of samples `at` (n, k) of runs, less where a corner rounds them."""
    at = at[:, 1:-1]
    weights = trace.weights[np.rint(at).astype(np.int64) % len(trace.points)]
    for flags, edge in ((first, starts), (last, ends)):
        near = flags[:, None] & (np.abs(at - edge[:, None]) * trace.step < ROUNDING)
        weights = np.where(near, ROUNDED * weights, weights)
    return weights


class _Assembly:
    """Assembly of the segments between chosen nodes.

    Parameters
    ----------
    trace : SampledOutline
        The outline.
    nodes : (s,) int64
        Samples of the nodes, in order round the outline.
    corner : (s,) bool
        Which nodes are corners.
    straight : (s,) bool
        Whether the segment from each node to the next is a line.
    """

    def __init__(
        self, trace: SampledOutline, nodes: IntArray, corner: NDArray[np.bool_], straight: NDArray[np.bool_], fit: Fit
    ) -> None:
        self.trace, self.nodes, self.straight, self.fit = trace, nodes, straight, fit
        count = len(trace.points)
        self.ends = cyclic.following(nodes)
        self.ends = np.where(self.ends <= nodes, self.ends + count, self.ends)
        self.corner = corner | (straight & cyclic.preceding(straight))
        self.lines = [self._line(k) if straight[k] else None for k in range(len(nodes))]

    def path(self) -> FloatArray:
        """Return the path, (s, 3, 2)."""
        anchors = np.array([self._node(k) for k in range(len(self.nodes))])
        for k, line in enumerate(self.lines):
            if line is not None and 0.0 in line[1]:
                axis = int(line[1][1] == 0.0)  # the coordinate that a level or plumb line keeps
                anchors[[k, (k + 1) % len(anchors)], axis] = line[0][axis]
        return np.concatenate([anchors[:, None], self._handles(anchors)], axis=1)

    def _line(self, k: int) -> tuple[FloatArray, FloatArray]:
        """Return a point and the direction of the line along segment k, level or plumb where it nearly is."""
        trace = self.trace
        cut = round(ROUNDING / trace.step)
        start, end = int(self.nodes[k]), int(self.ends[k])
        if end - start > 4 * cut:
            start, end = start + cut * int(self.corner[k]), end - cut * int(self.corner[(k + 1) % len(self.nodes)])
        samples = np.arange(start, end + 1) % len(trace.points)
        points, weights = trace.points[samples], trace.weights[samples][:, None]
        center = (weights * points).sum(axis=0) / weights.sum()
        spread = (weights * (points - center)).T @ (points - center)
        along = np.linalg.eigh(spread)[1][:, -1]
        if along @ (points[-1] - points[0]) < 0:
            along = -along
        for axis in (0, 1):  # plumb, level
            off = np.abs(points[:, axis] - center[axis]) * weights[:, 0]
            if abs(along[axis]) < TILT and off.max() <= self.fit.level:
                along = np.where(np.arange(2) == axis, 0.0, np.sign(along))
        return center, along

    def _node(self, k: int) -> FloatArray:
        """Return where node k stands: where its sides meet if it is a corner, else on the line beside it, if any."""
        sample = int(self.nodes[k])
        point = self.trace.points[sample]
        before, after = self.lines[k - 1], self.lines[k]
        if self.corner[k]:
            sides = [before or self.trace.side(sample, -1), after or self.trace.side(sample, 1)]
            met = _meeting(*sides)
            if met is not None and np.hypot(*(met - point)) <= APEX:
                return met
        known = [line for line in (before, after) if line is not None]
        if known:
            point = np.mean([base + along * ((point - base) @ along) for base, along in known], axis=0)
        return point

    def _handles(self, anchors: FloatArray) -> FloatArray:
        """Return the two handles of each segment: (s, 2, 2)."""
        count = len(anchors)
        following = cyclic.following(anchors)
        handles = np.stack([anchors + (following - anchors) / 3, following - (following - anchors) / 3], axis=1)
        curved = np.flatnonzero(~self.straight)
        if not len(curved):
            return handles
        runs, at = _runs(self.trace, self.nodes[curved], self.ends[curved])
        directions = self._tangents(anchors) @ (1, 1j)
        after = (curved + 1) % count
        free = np.stack([self.corner[curved], self.corner[after]], axis=1)
        weights = _unrounded(self.trace, at, self.nodes[curved], self.ends[curved], free[:, 0], free[:, 1])
        runs[:, 0], runs[:, -1] = anchors[curved] @ (1, 1j), following[curved] @ (1, 1j)
        fitted, _ = fit_curves(runs, weights, Tangents(directions[curved], directions[after], free), ROUNDS)
        handles[curved] = np.stack([fitted.real, fitted.imag], axis=-1)
        return handles

    def _tangents(self, anchors: FloatArray) -> FloatArray:
        """Return the unit tangent at each node: of the line beside it, else the trace's, level or plumb if nearly."""
        tangents = self.trace.tangent(self.nodes)
        for k in range(len(anchors)):
            known = [n for n in (k - 1, k) if self.straight[n]]
            if known:
                n = known[0] % len(anchors)
                tangents[k] = unit(anchors[(n + 1) % len(anchors)] - anchors[n])
            elif np.abs(tangents[k]).min() < TILT:
                tangents[k] = np.where(np.abs(tangents[k]) < TILT, 0.0, np.sign(tangents[k]))
        return tangents


def _meeting(first: tuple[FloatArray, FloatArray], second: tuple[FloatArray, FloatArray]) -> FloatArray | None:
    """Return the intersection of two lines (point, unit direction); None if they are nearly parallel."""
    (p, u), (q, v) = first, second
    return None if abs(cross(u, v)) < MEETING else meeting_point(p, u, q, v)
