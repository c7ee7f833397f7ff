# SPDX-License-Identifier: Apache-2.0
"""Fit the path of least price to a polyline, open or closed: choose its nodes, lines and cubics.

The price of a segment is that of its description and the integral of its squared distance from the polyline; that of a
node depends on the segments that meet there. The cheapest path is found by dynamic programming over the places: the
best one up to a place, ending in a line or in a cubic, is the best up to some earlier place and one segment more.

The handles of a cubic minimize the squared distances across the polyline; along it the parameter is free to first
order, so that segments are compared without moving the parameters. With axes e_a at its ends (two each: along and
across the tangent), sample weights w, normals n of the polyline, and b_a the Bernstein weight of the handle that axis a
moves, the lengths along the axes solve 4 x 4 normal equations in the metric W = ALONG^2 I + (1 - ALONG^2) n n^T. For
exact lengths, parameters are moved to the curve's nearest points and the equations solved again, alternately (P. J.
Schneider, *An algorithm for automatically fitting digitized curves*, Graphics Gems, 1990).
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import BoolArray, ComplexArray, FloatArray
from livecl.geometry.bezier import bernstein

#: Number of samples of a segment between its ends, and their places, ends included, as shares of its length.
SAMPLES = 12
SHARES = np.concatenate([[0.0], (np.arange(SAMPLES) + 0.5) / SAMPLES, [1.0]])
#: Weight of distances along the polyline: it decides where those across leave handles undetermined.
ALONG = 0.1
#: Largest distance, px, by which the end of a line moves if it is a corner.
MOST_MOVED = 0.25
#: Length, px, of the shortest line; length of a handle along a given tangent, as a share of the chord at least, and of
#: the polyline at most; weight that holds handles to a given tangent.
SHORTEST_LINE, SHORTEST, LONGEST, HOLD = 1.0, 0.01, 2.0, 1e6


@dataclasses.dataclass(frozen=True, kw_only=True)
class SegmentPrices:
    """Prices of a segment."""

    #: A straight segment, and a cubic.
    line: float
    curve: float
    straying: float = 1.0  # price of a distance of 1 px over a length of 1 px; grows with its square
    #: Largest distance of a line, and of a cubic, px.
    straight: float = np.inf
    tolerance: float = np.inf


@dataclasses.dataclass(frozen=True, eq=False)
class Tangents:
    """Unit tangents at the ends of segments, x + iy, in the direction of travel; and the ends that ignore them."""

    #: (Q,): at either end.
    first: ComplexArray
    last: ComplexArray
    free: BoolArray  # (Q, 2), whether the handle at either end may have any direction: at a corner


class Segments:
    """Lines and cubics between places of a polyline, and their costs at given prices.

    Parameters
    ----------
    points : (Q, SAMPLES + 2) complex
        The polyline x + iy from end to end of each, at SHARES of its length.
    lengths : (Q,) float64
        Length of the polyline, px.
    weights : (Q, SAMPLES) float64, optional
        Weight of each sample (default: 1).
    tangents : Tangents, optional
        By default, all ends are free.

    Attributes
    ----------
    handles : (Q, 2) complex
        Of the cubics.
    """

    def __init__(
        self,
        points: ComplexArray,
        lengths: FloatArray,
        weights: FloatArray | None = None,
        tangents: Tangents | None = None,
    ) -> None:
        self._lengths = lengths
        counted = np.ones((len(points), SAMPLES)) if weights is None else weights
        chord = points[:, -1] - points[:, 0]
        size = np.abs(chord)
        along = (points[:, 1:-1] - points[:, :1]) * (chord.conj() / np.maximum(size, 1e-9))[:, None]
        beyond = along.real - np.clip(along.real, 0, size[:, None])
        off = along.imag if tangents is None else _moved_ends(along.imag, counted, tangents.free)
        self._lined, self._short = _strayed(np.hypot(off, beyond), counted), size < SHORTEST_LINE
        self.handles, distances = fit_curves(points, counted, tangents)
        self._curved = _strayed(distances, counted)
        way = points[:, [2, -1]] - points[:, [0, -3]]
        turned = ((self.handles - points[:, [0, -1]]) * way.conj()).real * (1, -1) <= 0
        free = turned if tangents is None else turned & tangents.free
        self._turned = free.any(axis=1)

    def costs(self, prices: SegmentPrices) -> tuple[FloatArray, FloatArray]:
        """Return the cost of each as a line and as a cubic, (Q,) both; infinite if beyond the largest distance."""
        step = prices.straying * self._lengths / SAMPLES
        (lined, far), (curved, astray) = self._lined, self._curved
        lines = prices.line + np.where(far > prices.straight, np.inf, step * lined)
        lines[self._short] = np.inf
        curves = prices.curve + np.where(astray > prices.tolerance, np.inf, step * curved)
        curves[self._turned] = np.inf
        return lines, curves


def _strayed(distances: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the weighted sum of squared distances (Q, SAMPLES), and the largest weighted distance: (Q,) both."""
    weighted = weights * distances
    return np.asarray((weighted * distances).sum(axis=1)), np.asarray(weighted.max(axis=1, initial=0.0))


def _moved_ends(off: FloatArray, weights: FloatArray, free: BoolArray) -> FloatArray:
    """Return signed distances (Q, SAMPLES) of samples from lines, whose free ends (corners) are moved across to fit."""
    inner = SHARES[1:-1]
    basis = np.stack([1 - inner, inner]) * free[:, :, None]  # (Q, 2, SAMPLES)
    gram = (basis * weights[:, None]) @ basis.transpose(0, 2, 1) + 1e-6 * np.eye(2)
    moves = np.linalg.solve(gram, (basis * weights[:, None]) @ off[..., None])
    return np.asarray(off - (np.clip(moves, -MOST_MOVED, MOST_MOVED) * basis).sum(axis=1))


def fit_curves(
    points: ComplexArray, weights: FloatArray, tangents: Tangents | None = None, rounds: int = 1
) -> tuple[ComplexArray, FloatArray]:
    """Fit cubics to a polyline between its ends.

    Parameters
    ----------
    points : (Q, SAMPLES + 2) complex
        As for :class:`Segments`.
    weights : (Q, SAMPLES) float64
        Weight of each sample.
    tangents : Tangents, optional
        By default, all ends are free.
    rounds : int
        Number of solutions for the handles; the parameters are moved in between.

    Returns
    -------
    handles : (Q, 2) complex
    distances : (Q, SAMPLES) float64
        Distances of the samples from the curve, across the polyline, px.
    """
    way = points[:, 2:] - points[:, :-2]
    way = way / np.maximum(np.abs(way), 1e-9)
    ends, inner = points[:, [0, -1]], points[:, 1:-1]
    handles, distances = _solved(bernstein(SHARES[1:-1]), points, way, weights, tangents)
    t = np.broadcast_to(SHARES[1:-1], weights.shape)
    for _ in range(rounds - 1):
        t = _nearer(np.concatenate([ends[:, :1], handles, ends[:, 1:]], axis=1), inner, t)
        handles, distances = _solved(bernstein(t), points, way, weights, tangents)
    return handles, distances


def _solved(
    basis: FloatArray, points: ComplexArray, way: ComplexArray, weights: FloatArray, tangents: Tangents | None
) -> tuple[ComplexArray, FloatArray]:
    """Return handles and distances for one basis, (SAMPLES, 4), or one each, (Q, SAMPLES, 4)."""
    ends, inner = points[:, [0, -1]], basis[..., 1:3]
    rest = points[:, 1:-1] - _combined(basis[..., [0, 3]], ends)
    gram, right = _normal_equations(inner, rest - _combined(inner, ends), way, weights)
    diagonal = np.arange(4)
    ridge = 1e-9 * np.trace(gram, axis1=1, axis2=2)[:, None] + 1e-12
    if tangents is None:
        gram[:, diagonal, diagonal] += ridge
        steps = np.linalg.solve(gram, right[..., None])[..., 0]
        moves = steps[:, ::2] + 1j * steps[:, 1::2]
    else:  # along and across the tangents, not along x and y
        out = np.stack([tangents.first, -tangents.last], axis=1)
        turned = np.zeros((len(points), 4, 4))
        turned[:, [0, 2], [0, 2]] = turned[:, [1, 3], [1, 3]] = out.real
        turned[:, [0, 2], [1, 3]], turned[:, [1, 3], [0, 2]] = out.imag, -out.imag
        gram = turned @ gram @ turned.transpose(0, 2, 1)
        gram[:, diagonal, diagonal] += ridge  # here, as a tangent of a place without an extent is 0
        gram[:, [1, 3], [1, 3]] += np.where(tangents.free, 0.0, HOLD)
        steps = np.linalg.solve(gram, turned @ right[..., None])[..., 0]
        _clip(steps, points, tangents.free)
        moves = (steps[:, ::2] + 1j * steps[:, 1::2]) * out
    handles = ends + moves
    return handles, np.abs(((_combined(inner, handles) - rest) * way.conj()).imag)


def _combined(basis: FloatArray, two: ComplexArray) -> ComplexArray:
    """Return the sums of two points each, (Q, 2), by weights (SAMPLES, 2) or (Q, SAMPLES, 2): (Q, SAMPLES)."""
    if basis.ndim == 2:
        return np.asarray(two @ basis.T)
    return np.asarray((basis * two[:, None]).sum(axis=-1))


def _normal_equations(
    basis: FloatArray, rest: ComplexArray, way: ComplexArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the matrices (Q, 4, 4) and right sides (Q, 4) of handles' least squares, along x and y of either one."""
    nx, ny = -way.imag, way.real
    low, more = ALONG**2, 1 - ALONG**2
    metric = weights * np.stack([low + more * nx * nx, more * nx * ny, low + more * ny * ny])  # (3, Q, SAMPLES)
    first, second = basis[..., 0], basis[..., 1]
    products = np.stack([first**2, first * second, second**2], axis=-1)
    weighted = np.stack([metric[0] * rest.real + metric[1] * rest.imag, metric[1] * rest.real + metric[2] * rest.imag])
    if basis.ndim == 2:
        sums, sides = metric @ products, weighted @ basis
    else:
        sums, sides = (metric[:, :, None] @ products)[:, :, 0], (weighted[:, :, None] @ basis)[:, :, 0]
    gram = np.empty((len(way), 2, 2, 2, 2))  # handle, axis, handle, axis
    for (i, j), k in zip(((0, 0), (0, 1), (1, 1)), range(3), strict=True):
        for (x, y), m in zip(((0, 0), (0, 1), (1, 1)), range(3), strict=True):
            for a, b in {(i, j), (j, i)}:
                for c, d in {(x, y), (y, x)}:
                    gram[:, a, c, b, d] = sums[m, :, k]
    return gram.reshape(-1, 4, 4), sides.transpose(1, 2, 0).reshape(-1, 4)


def _clip(steps: NDArray[Any], points: ComplexArray, free: BoolArray) -> None:
    """Bound the lengths of handles along given tangents."""
    shortest = SHORTEST * np.abs(points[:, -1] - points[:, 0])
    longest = LONGEST * np.abs(np.diff(points, axis=1)).sum(axis=1)
    for along, side in ((0, 0), (2, 1)):
        steps[:, along] = np.where(free[:, side], steps[:, along], np.clip(steps[:, along], shortest, longest))
        steps[:, along + 1] = np.where(free[:, side], steps[:, along + 1], 0.0)


def _nearer(cubics: ComplexArray, samples: ComplexArray, t: FloatArray) -> FloatArray:
    """Return parameters moved by a Gauss-Newton step towards the curve's nearest points."""
    misses = (bernstein(t) * cubics[:, None]).sum(axis=-1) - samples
    u = 1 - t
    slopes = 3 * (np.stack([u * u, 2 * t * u, t * t], axis=-1) * np.diff(cubics, axis=1)[:, None]).sum(axis=-1)
    moved = t - (misses * slopes.conj()).real / np.maximum(np.abs(slopes) ** 2, 1e-12)
    return np.maximum.accumulate(np.clip(moved, 0, 1), axis=1)


def cheapest_way(
    lines: FloatArray, curves: FloatArray, joins: FloatArray | None = None
) -> tuple[list[int], list[bool], float]:
    """Return the places of the cheapest path from the first to the last, which segments are lines, and its price.

    Parameters
    ----------
    lines, curves : (n, n) float64
        Costs of a line and of a cubic from one place (row) to a later one.
    joins : (3, n) float64, optional
        Costs of a node between two cubics, between a line and a cubic, and between two lines (default: 0).
    """
    count = len(lines)
    joins = np.zeros((3, count)) if joins is None else joins.copy()
    joins[:, 0] = 0.0  # the beginning joins nothing
    best, before = np.full((2, count), np.inf), np.zeros((2, count), np.int64)
    best[0, 0] = 0.0
    nodes = joins[[[0, 1], [1, 2]]]  # by the kind of the segment after the node, and that before it
    tables = np.ascontiguousarray(np.stack([curves, lines]).transpose(2, 0, 1))[:, :, None]
    both = np.arange(2)
    for end in range(1, count):
        steps = (best[:, :end] + nodes[..., :end] + tables[end, ..., :end]).reshape(2, -1)
        before[:, end] = chosen = steps.argmin(axis=1)
        best[:, end] = steps[both, chosen]
    kind = int(best[1, -1] < best[0, -1])
    price, place = float(best[kind, -1]), count - 1
    places, straight = [place], []
    while place and np.isfinite(price):
        straight.append(bool(kind))
        kind, place = divmod(int(before[kind, place]), place)
        places.append(place)
    return places[::-1], straight[::-1], price
