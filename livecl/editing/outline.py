# SPDX-License-Identifier: Apache-2.0
"""Editable outline: the description of least price that follows a traced outline.

Nodes stand at corners, extremes and where one segment does not do. Segments are lines or cubics, joins that are no
corners are smooth, sides that are nearly level or plumb become so. Which nodes are best for a whole outline is found by
dynamic programming over the places of the trace: the price of the numbers written and of the distance from the trace.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.editing import cubics
from livecl.editing.trace import SURE, Trace, unit

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fit:
    """What a description costs, in numbers that SVG writes, and how far it may stray.

    Attributes
    ----------
    tolerance, straight : float
        Largest distance of a cubic, and of a line, from the visible part of the outline, px.
    straying : float
        Numbers that straying costs, for a distance of 1 px over a length of 1 px; it grows by the square.
    cubic, line : float
        Numbers of a cubic and of a line.
    corner : float
        Numbers that a corner costs.
    smooth : float
        Numbers that a smooth node saves, as a segment tells the direction of the next; twice as many at an extreme,
        whose direction is known.
    level : float
        Largest distance, px, of a line that is made level or plumb.
    """

    tolerance: float = 0.4
    straight: float = 0.25
    straying: float = 3.5
    cubic: float = 6.0
    line: float = 2.0
    corner: float = 1.0
    smooth: float = 1.0
    level: float = 0.3


#: Largest angle, radians, of a line with the outline at its smooth ends, and with an axis where it is made level.
ALIGNED, TILT = 0.12, 0.06
#: How far a corner may move to where its sides meet, px, and sine of the angle from which on they are taken to meet.
APEX, MEETING = 1.2, 0.3
#: Length at corners that their rounding takes, px, and how much samples there count.
ROUNDING, ROUNDED = 1.25, 0.1
#: Longest run of one segment, as a share of the outline, and most pairs of places that are compared.
LONGEST, MOST_PAIRS = 0.6, 2500


def editable_outline(trace: Trace, fit: Fit) -> FloatArray | None:
    """Return the closed path (s, 3, 2) of least price that follows a trace, px; None where none does."""
    samples, corner = _places(trace)
    chosen = _cheapest(trace, samples, corner, fit)
    if chosen is None or len(chosen[0]) < 2:
        return None
    nodes, straight = chosen
    return _Assembly(trace, samples[nodes] % len(trace.points), corner[nodes], straight, fit).path()


def _places(trace: Trace) -> tuple[IntArray, NDArray[np.bool_]]:
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


def _cheapest(
    trace: Trace, places: IntArray, corner: NDArray[np.bool_], fit: Fit
) -> tuple[IntArray, NDArray[np.bool_]] | None:
    """Return the places of the cheapest path's nodes, and whether the segment after each is a line."""
    count, num = len(trace.points), len(places)
    i, j = np.triu_indices(num, 1)
    span = places[j] - places[i]
    near = (span > 0) & (span <= LONGEST * count) & (j - i <= max(8, MOST_PAIRS // num))
    i, j = i[near], j[near]
    starts, ends = places[i], places[j]
    runs, at = cubics.runs_between(trace.points, starts, ends)
    weights = _unrounded(trace, at, starts, ends, corner[i], corner[j])
    tangents = trace.tangent(places % count)
    _, distances = cubics.fit(runs, tangents[i], tangents[j], np.stack([corner[i], corner[j]], axis=1), weights)
    length = np.asarray((ends - starts) * trace.step, dtype=np.float64)
    curved = fit.cubic + _straying(distances, weights, length, fit.tolerance, fit.straying)
    flat = np.abs(runs[:, -1] - runs[:, 0])
    level = flat.min(axis=1) <= np.minimum(fit.level, TILT * flat.max(axis=1))
    lined = fit.line - level + _straying(_from_chords(runs), weights, length, fit.straight, fit.straying)
    along = unit(runs[:, -1] - runs[:, 0])
    for side in (i, j):
        bend = np.abs(along[:, 0] * tangents[side][:, 1] - along[:, 1] * tangents[side][:, 0])
        lined = np.where(~corner[side] & (bend > ALIGNED), np.inf, lined)
    known = np.where(trace.extreme[places % count], 2.0, 1.0)
    joins = np.where(corner, fit.corner, [-fit.smooth * known, np.full(num, -fit.smooth), np.full(num, np.inf)])
    # Way and outline begin at one node: its price is parted between the segments that meet there.
    half = joins[0, 0] / 2, joins[1, 0] - joins[0, 0] / 2
    joins[:, 0] = 0.0
    at_node = (i == 0).astype(int) + (j == num - 1)
    return _shortest_way(num, i, j, (curved + half[0] * at_node, lined + half[1] * at_node), joins)


def _unrounded(
    trace: Trace, at: FloatArray, starts: IntArray, ends: IntArray, first: NDArray[np.bool_], last: NDArray[np.bool_]
) -> FloatArray:
    """Return the weights of samples `at` (n, k) of runs, less where a corner at either end rounds them: (n, k)."""
    weights = trace.weights[np.rint(at).astype(np.int64) % len(trace.points)]
    for flags, edge in ((first, starts), (last, ends)):
        near = flags[:, None] & (np.abs(at - edge[:, None]) * trace.step < ROUNDING)
        weights = np.where(near, ROUNDED * weights, weights)
    return weights


def _straying(
    distances: FloatArray, weights: FloatArray, length: FloatArray, tolerance: float, price: float
) -> FloatArray:
    """Return the price of distances (n, k) over lengths (n,), infinite beyond the tolerance."""
    weighted = distances * weights
    cost = price * length * (weighted * distances).mean(axis=1)
    return np.where(weighted.max(axis=1) > tolerance, np.inf, cost)


def _from_chords(runs: FloatArray) -> FloatArray:
    """Return the distances of points from the chords of their runs: (n, k)."""
    along = unit(runs[:, -1] - runs[:, 0])
    rest = runs - runs[:, :1]
    return np.asarray(np.abs(rest[..., 0] * along[:, None, 1] - rest[..., 1] * along[:, None, 0]))


def _shortest_way(
    num: int, i: IntArray, j: IntArray, costs: tuple[FloatArray, FloatArray], joins: FloatArray
) -> tuple[IntArray, NDArray[np.bool_]] | None:
    """Return the nodes on the cheapest way from the first place to the last, and which segments are lines.

    Parameters
    ----------
    num : int
        Number of places.
    i, j : (n,) int64
        First and last place of each segment.
    costs : ((n,), (n,)) float64
        What a cubic and a line cost.
    joins : (3, num) float64
        What a node costs between two cubics, at a line, and between two lines.
    """
    tables = np.full((2, num, num), np.inf)
    tables[:, i, j] = costs
    best, before = np.full((2, num), np.inf), np.zeros((2, num), np.int64)
    best[:, 0] = 0.0
    for end in range(1, num):
        for kind in (0, 1):
            steps = best[:, :end] + joins[kind : kind + 2, :end] + tables[kind, :end, end]
            before[kind, end] = int(np.argmin(steps))
            best[kind, end] = steps.flat[before[kind, end]]
    kind = int(np.argmin(best[:, -1]))
    if not np.isfinite(best[kind, -1]):
        return None
    place, way, straight = num - 1, [], []
    while place:
        straight.append(bool(kind))
        kind, place = divmod(int(before[kind, place]), place)
        way.append(place)
    return np.array(way[::-1]), np.array(straight[::-1], bool)


class _Assembly:
    """Puts the segments between chosen nodes together.

    Parameters
    ----------
    trace : Trace
        The outline.
    nodes : (s,) int64
        Samples of the nodes, in order round the outline.
    corner : (s,) bool
        Which nodes are corners.
    straight : (s,) bool
        Whether the segment from each node to the next is a line.
    """

    def __init__(
        self, trace: Trace, nodes: IntArray, corner: NDArray[np.bool_], straight: NDArray[np.bool_], fit: Fit
    ) -> None:
        self.trace, self.nodes, self.straight, self.fit = trace, nodes, straight, fit
        count = len(trace.points)
        self.ends = np.roll(nodes, -1)
        self.ends = np.where(self.ends <= nodes, self.ends + count, self.ends)
        self.corner = corner | (straight & np.roll(straight, 1))
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
        following = np.roll(anchors, -1, axis=0)
        handles = np.stack([anchors + (following - anchors) / 3, following - (following - anchors) / 3], axis=1)
        curved = np.flatnonzero(~self.straight)
        if not len(curved):
            return handles
        runs, at = cubics.runs_between(self.trace.points, self.nodes[curved], self.ends[curved])
        tangents = self._tangents(anchors)
        free = np.stack([self.corner[curved], self.corner[(curved + 1) % count]], axis=1)
        weights = _unrounded(self.trace, at, self.nodes[curved], self.ends[curved], free[:, 0], free[:, 1])
        runs[:, 0], runs[:, -1] = anchors[curved], following[curved]
        fitted, _ = cubics.fit(runs, tangents[curved], tangents[(curved + 1) % count], free, weights)
        handles[curved] = fitted[:, 1:3]
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
    """Return where two lines (point, unit direction) meet; None where they are nearly parallel."""
    (p, u), (q, v) = first, second
    sine = u[0] * v[1] - u[1] * v[0]
    if abs(sine) < MEETING:
        return None
    gap = q - p
    return np.asarray(p + u * ((gap[0] * v[1] - gap[1] * v[0]) / sine))
