# SPDX-License-Identifier: Apache-2.0
"""Fit the simplest path to an outline: lines and cubics between anchors, by one price for error and segments.

Between two corners, the path of least price over candidate places gives the anchors (livecl/geometry/least_path.py).
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import BoolArray, FloatArray
from livecl.geometry import cyclic
from livecl.geometry.corners import CorneredOutline
from livecl.geometry.least_path import SHARES, SegmentPrices, Segments, cheapest_way

#: Candidate nodes: largest spacing along the outline, px, and turning, radians; least spacing, px; maximum number
#: between two corners.
PLACE_LENGTH, PLACE_TURN, LEAST_SPACING, MOST_PLACES = 12.0, 0.2, 2.0, 56


@dataclasses.dataclass(frozen=True, eq=False)
class Draft:
    """A path along an outline before its joins are made smooth."""

    places: FloatArray  # (S,), length along the outline, px, at which each segment begins
    cubics: FloatArray  # (S, 4, 2), control points
    straight: BoolArray  # (S,), segments that are lines
    corners: BoolArray  # (S,), whether the outline has a corner where each segment begins
    price: float  # total of squared distances and prices


class MeasuredOutline:
    """A closed outline by its length: points, and candidate places of anchors."""

    def __init__(self, outline: CorneredOutline) -> None:
        self.outline = outline
        z = outline.points[:, 0] + 1j * outline.points[:, 1]
        closed = np.concatenate([z, z[:1]])
        self.lengths = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(closed)))])
        self.total = float(self.lengths[-1])
        self._s = np.concatenate([self.lengths[:-1], self.lengths + self.total])
        self._z = np.concatenate([z, closed])
        wide = np.roll(z, -2) - np.roll(z, 2)
        turns = np.abs(np.angle(cyclic.following(wide) / np.where(wide == 0, 1, wide)))
        turns[outline.corners] = 0
        self._effort = np.concatenate([[0.0], np.cumsum(turns)]) / PLACE_TURN + self.lengths / PLACE_LENGTH

    def at(self, s: FloatArray) -> NDArray[np.complex128]:
        """Return the points at lengths from 0 to twice the total."""
        return np.asarray(np.interp(s, self._s, self._z.real) + 1j * np.interp(s, self._s, self._z.imag))

    def places(self, start: float, end: float) -> FloatArray:
        """Return candidate places from one length to another, both of them included."""
        grid = np.concatenate([self.lengths[:-1], self.lengths + self.total])
        effort = np.concatenate([self._effort[:-1], self._effort + self._effort[-1]])
        first, last = np.interp([start, end], grid, effort)
        most = min(MOST_PLACES, int((end - start) / LEAST_SPACING))
        count = max(1, min(most, round(last - first)))
        found = np.interp(np.linspace(first, last, count + 1), effort, grid)
        found[0], found[-1] = start, end
        return np.asarray(found)


def simplest_path(measured: MeasuredOutline, prices: SegmentPrices) -> Draft:
    """Return the path of the smallest price along an outline; its corners are anchors."""
    corners = measured.lengths[measured.outline.corners]
    if not len(corners):
        return _loop(measured, prices)
    ends = np.array([*corners, corners[0] + measured.total])
    whole = _Fits(measured, ends[:-1], ends[1:], prices)
    # A segment that costs no more than two lines without error is cheapest.
    open_ = whole.least > 2 * prices.line
    spans = [measured.places(ends[k], ends[k + 1]) if open_[k] else ends[k : k + 2] for k in range(len(corners))]
    pairs = [np.stack(np.triu_indices(len(span), 1)) for span in spans]
    starts = np.concatenate([span[pair[0]] for span, pair in zip(spans, pairs, strict=True)])
    fits = _Fits(
        measured, starts, np.concatenate([span[pair[1]] for span, pair in zip(spans, pairs, strict=True)]), prices
    )
    chosen, corner = [], []
    first, price = 0, 0.0
    for span, pair in zip(spans, pairs, strict=True):
        numbers = np.full((len(span), len(span)), -1)
        numbers[tuple(pair)] = first + np.arange(pair.shape[1])
        first += pair.shape[1]
        table = np.where(numbers >= 0, fits.least[numbers], np.inf)
        way, _, cost = cheapest_way(table, table)
        segments = [int(numbers[a, b]) for a, b in itertools.pairwise(way)]
        chosen += segments
        corner += [True, *[False] * (len(segments) - 1)]
        price += cost
    return fits.draft(chosen, corner, price)


def _loop(measured: MeasuredOutline, prices: SegmentPrices) -> Draft:
    """Return the simplest path of an outline without corners: from its sharpest bend, then from an anchor of that."""
    places = measured.places(0.0, measured.total)[:-1]
    while len(places) < 4:
        places = np.linspace(0, measured.total, 5)[:-1]
    count = len(places)
    starts, lengths = (grid.ravel() for grid in np.meshgrid(np.arange(count), np.arange(1, count), indexing="ij"))
    ends = starts + lengths
    fits = _Fits(measured, places[starts], places[ends % count] + measured.total * (ends >= count), prices)
    table = fits.least.reshape(count, count - 1)
    best: tuple[float, list[int]] | None = None
    first = int(np.argmax(table[:, max(1, count // 8) - 1]) + count // 16) % count
    for _ in range(2):
        a, b = np.triu_indices(count + 1, 1)
        inner = b - a < count
        a, b = a[inner], b[inner]
        costs = np.full((count + 1, count + 1), np.inf)
        costs[a, b] = table[(first + a) % count, b - a - 1]
        way, _, price = cheapest_way(costs, costs)
        numbers = [((first + i) % count) * (count - 1) + j - i - 1 for i, j in itertools.pairwise(way)]
        if best is None or price < best[0]:
            best = price, numbers
        first = int((first + way[len(way) // 2]) % count)
    assert best is not None
    return fits.draft(best[1], [False] * len(best[1]), best[0])


def without_anchors(measured: MeasuredOutline, draft: Draft, prices: SegmentPrices) -> list[tuple[float, float, Draft]]:
    """Return for each anchor that is no corner its place, the path without it and the rise in price, least first."""
    count = len(draft.places)
    if count < 3:
        return []
    numbers = np.flatnonzero(~draft.corners)
    before, after = (numbers - 1) % count, (numbers + 1) % count
    starts = draft.places[before]
    ends = starts + (draft.places[after] - starts) % measured.total
    fits = _Fits(measured, starts, ends, prices)
    own_ends = draft.places + (cyclic.following(draft.places) - draft.places) % measured.total
    own = _Fits(measured, draft.places, own_ends, prices).least
    rises = fits.least - own[before] - own[numbers]
    found = []
    for i in np.argsort(rises, kind="stable"):
        if not np.isfinite(rises[i]):
            break
        one = fits.draft([int(i)], [False], 0.0)
        cubics, straight = draft.cubics.copy(), draft.straight.copy()
        cubics[before[i], 1:3], cubics[before[i], 3] = one.cubics[0, 1:3], draft.cubics[numbers[i], 3]
        straight[before[i]] = one.straight[0]
        kept = np.arange(count) != numbers[i]
        less = Draft(draft.places[kept], cubics[kept], straight[kept], draft.corners[kept], draft.price + rises[i])
        found.append((float(draft.places[numbers[i]]), float(rises[i]), less))
    return found


class _Fits(Segments):
    """Lines and cubics between places of an outline (Q,), and the cost of the cheaper of both."""

    def __init__(self, measured: MeasuredOutline, starts: FloatArray, ends: FloatArray, prices: SegmentPrices) -> None:
        points = measured.at(starts[:, None] + (ends - starts)[:, None] * SHARES)
        super().__init__(points, ends - starts)
        self.starts, self._total = starts, measured.total
        self._ends = points[:, [0, -1]]
        lines, curves = self.costs(prices)
        self._straight = lines <= curves
        self.least = np.minimum(lines, curves)

    def draft(self, chosen: list[int], corners: list[bool], price: float) -> Draft:
        """Return the path of some of them."""
        ends, straight = self._ends[chosen], self._straight[chosen]
        handles = np.where(straight[:, None], (ends @ np.array([[2, 1], [1, 2]])) / 3, self.handles[chosen])
        z = np.stack([ends[:, 0], handles[:, 0], handles[:, 1], ends[:, 1]], axis=1)
        cubics = np.stack([z.real, z.imag], axis=-1)
        return Draft(self.starts[chosen] % self._total, cubics, straight, np.array(corners), price)
