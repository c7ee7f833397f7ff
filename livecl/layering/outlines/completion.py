# SPDX-License-Identifier: Apache-2.0
"""Amodal completion: continue the outline of an occluded shape behind its occluder, and join visible parts.

A gap in an outline is closed by a straight line, by a smooth curve in the directions of its two ends (good
continuation), or by the corner in which their tangents meet, whichever makes the cheapest shape; the curve must run
behind the layers in front. Two parts are joined where both outlines continue into each other ("relatable" ends: Kellman
and Shipley 1991).
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.geometry import cyclic
from livecl.geometry.crossings import polygon_crossing_area
from livecl.geometry.polylines import polygon_area
from livecl.layering.outlines.continuations import Gap, bridges, curves, direction_at_end, tangent
from livecl.layering.outlines.contours import AFTER, BEFORE, COMPLETED, Contour, Outlines
from livecl.layering.outlines.prices import Prices, hidden_price, outline_price, sliver_price
from livecl.layering.outlines.primitives import FARTHEST, fitted_primitive

#: Points of the shortest gap; points to which the direction of an end is fitted.
SHORTEST_GAP, FITTED = 3, 12
#: Points on each side of a gap's end from which the turning of the outline there is measured.
REACH = 16
#: Share of a closing curve that must lie behind its occluder.
COVERED = 0.97
#: Longest gaps bridged by a join, as a share of both outlines, and by splitting an outline in two, as a share of it.
LONGEST_GAP, LONGEST_CUT = 0.6, 0.5
#: Largest area, px^2, in which a completed outline may cross itself: crossing curves make two lobes, of which the path
#: would keep the larger.
MOST_CROSSED = 1.0
#: Width of the trap, px: how far a shape extends behind one in front that it ends at.
TRAP = 1.25


def completed_contour(
    contour: Contour, below: BoolArray, room: BoolArray, outlines: Outlines, prices: Prices
) -> tuple[Contour, float]:
    """Complete a contour, outer outline or hole, where that is cheaper; return it and its price.

    Its gaps are closed one by one, or it becomes a circle or an ellipse. It may continue behind the regions `below` (K
    + 3,); hidden curves may run in those with `room` (K + 3,), see :meth:`Outlines.room`.
    """
    closed, price = _gaps_closed(contour, below, room, outlines, prices)
    hidden = below[contour.across]
    if hidden.any() and not hidden.all():
        seen = ~(hidden | np.roll(hidden, 2) | np.roll(hidden, -2))
        whole = _around(contour, fitted_primitive(contour.points[seen]), below, room, outlines)
        if whole is not None:
            cost = _whole_price(whole, contour, prices) - prices.primitive
            if cost < price - (prices.saving if closed is contour else 0.0):
                return whole, cost
    return closed, price


def filled_out(contour: Contour, below: BoolArray, room: BoolArray, outlines: Outlines, prices: Prices) -> Contour:
    """Return a completed contour, or the convex hull of its visible part where no single gap closes.

    The hull closes several gaps at once, such as those that a lattice leaves. It is no evidence of depth order, as any
    region has one. Arguments as of :func:`completed_contour`.
    """
    whole, price = completed_contour(contour, below, room, outlines, prices)
    hidden = below[contour.across]
    if whole is contour and hidden.any() and not hidden.all():
        hull = _around(contour, _hull(contour.points[~hidden]), below, room, outlines)
        if (
            hull is not None
            and _whole_price(hull, contour, prices) < price - prices.saving
            and outlines.share_in(_points_between(contour, hull), room) >= COVERED
        ):
            return hull
    return whole


def _points_between(inner: Contour, outer: Contour) -> FloatArray:
    """Return the centres (n, 2) of pixels inside one contour and outside another."""
    from skimage.measure import points_in_poly

    low, high = np.floor(outer.points.min(axis=0)), np.ceil(outer.points.max(axis=0))
    columns, rows = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
    points = np.column_stack([columns.ravel(), rows.ravel()])
    points = points[points_in_poly(points, outer.points)]
    return np.asarray(points[~points_in_poly(points, inner.points)])


def _whole_price(whole: Contour, seen: Contour, prices: Prices) -> float:
    """Return the price of the whole outline of a contour, its hidden area included."""
    return outline_price(whole.points, prices) + hidden_price(whole.area, seen.area, prices)


def _around(
    contour: Contour, points: FloatArray | None, below: BoolArray, room: BoolArray, outlines: Outlines
) -> Contour | None:
    """Return a closed polyline (n, 2), if any, as the whole outline of a contour: hidden where it was not visible."""
    if points is None:
        return None
    hidden = below[contour.across]
    if polygon_area(points) * contour.area < 0:
        points = points[::-1].copy()
    distance, nearest = cKDTree(contour.points[~hidden]).query(points)
    made_up = distance > FARTHEST
    if outlines.share_in(points[made_up], room) < COVERED:
        return None
    across = np.where(made_up, COMPLETED, contour.across[~hidden][nearest])
    return Contour(points, across, np.zeros(len(points), np.int64))


def _hull(points: FloatArray) -> FloatArray | None:
    """Return the convex hull of points (n, 2) as a closed polyline at steps of about 1 px; None for a line."""
    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:
        return None
    sides = cyclic.following(corners) - corners
    counts = np.maximum(1, np.round(np.hypot(*sides.T)).astype(np.int64))
    at = np.concatenate([np.arange(count) / count for count in counts])
    return np.asarray(np.repeat(corners, counts, axis=0) + at[:, None] * np.repeat(sides, counts, axis=0))


def _gaps_closed(
    contour: Contour, below: BoolArray, room: BoolArray, outlines: Outlines, prices: Prices
) -> tuple[Contour, float]:
    """Close each gap of a contour by the cheapest curve, where that saves; return the contour and its price.

    Accidents (coincidences of viewpoint) rank the curves among each other. They are no reason to leave a gap open: an
    outline that ends exactly along the one in front is an accident, too.
    """
    price, done = outline_price(contour.points, prices), 0
    area = abs(contour.area)
    while True:
        runs = [run for run in contour.runs(below) or [] if run[1] >= SHORTEST_GAP]
        if len(runs) <= done:
            return contour, price
        start, length = runs[done]
        best = None
        if len(contour) - length >= 3 and not _silhouette(contour, start, length):
            kept = _others(contour, start, length)
            for curve in curves(_gap(contour, start, length)):
                if outlines.share_in(curve, room) < COVERED:
                    continue
                closed = _spliced((contour, kept, curve))
                grown = max(0.0, abs(closed.area) - area)
                cost = outline_price(closed.points, prices) + prices.hidden * grown / area
                cost += sliver_price(grown / area, prices)
                accidents = prices.accident * _accidents(contour, start, length, curve)
                if (best is None or cost + accidents < best[0] - prices.better) and _simple(closed):
                    best = cost + accidents, cost, closed
        if best is not None and best[1] < price - prices.saving:
            _, price, contour = best
            done = 0
        else:
            done += 1


def joined_contours(
    first: Contour, second: Contour, below: BoolArray, room: BoolArray, outlines: Outlines, prices: Prices
) -> tuple[Contour, float] | None:
    """Join two contours behind their occluder; return the result and its price, or None if unrelatable."""
    best: tuple[Contour, float] | None = None
    seen = abs(first.area) + abs(second.area)
    runs = [[run for run in contour.runs(below) or [] if run[1] >= SHORTEST_GAP] for contour in (first, second)]
    for (start, length), (start2, length2) in itertools.product(*runs):
        left = len(first) - length, len(second) - length2
        if min(left) < 4:
            continue
        gap, gap2 = _gap(first, start, length), _gap(second, start2, length2)
        for bridge, back in bridges(gap, gap2, LONGEST_GAP * sum(left)):
            if min(outlines.share_in(bridge, room), outlines.share_in(back, room)) < COVERED:
                continue
            whole = _spliced(
                (first, _others(first, start, length), bridge), (second, _others(second, start2, length2), back)
            )
            cost = outline_price(whole.points, prices)
            cost += prices.hidden * max(0.0, abs(whole.area) - seen) / seen
            if (best is None or cost < best[1] - prices.better) and _simple(whole):
                best = whole, cost
    return best


def cut_in_two(
    contour: Contour, below: BoolArray, room: BoolArray, outlines: Outlines, prices: Prices
) -> list[Contour] | None:
    """Split a contour in two by joining its own ends behind an occluder: a C closes to a ring."""
    best: tuple[list[Contour], float] | None = None
    runs = [run for run in contour.runs(below) or [] if run[1] >= SHORTEST_GAP]
    count = len(contour)
    for (start, length), (start2, length2) in itertools.combinations(runs, 2):
        inner = (start + length + np.arange((start2 - start - length) % count)) % count
        outer = (start2 + length2 + np.arange((start - start2 - length2) % count)) % count
        if min(len(inner), len(outer)) < 4:
            continue
        gap, gap2 = _gap(contour, start, length), _gap(contour, start2, length2)
        for bridge, back in bridges(gap, gap2, LONGEST_CUT * count):
            if min(outlines.share_in(bridge, room), outlines.share_in(back, room)) < COVERED:
                continue
            two = [_spliced((contour, inner, back)), _spliced((contour, outer, bridge))]
            cost = sum(outline_price(part.points, prices) for part in two)
            if (best is None or cost < best[1] - prices.better) and all(map(_simple, two)):
                best = two, cost
    if best is None or best[1] > completed_contour(contour, below, room, outlines, prices)[1] + prices.ring:
        return None
    return best[0]


def trapped(contour: Contour, below: BoolArray, room: BoolArray, outlines: Outlines) -> FloatArray:
    """Extend a contour slightly behind the shapes in front where it ends at them (printers' trapping).

    No ground shines through between the two, and no pixel constrains the hidden outline.
    """
    points = contour.points
    along = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
    along = along / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    ends = below[contour.across] & (contour.across != COMPLETED)
    distance = np.where(ends, TRAP, 0.0)
    distance = np.minimum(distance, np.minimum(cyclic.preceding(distance), cyclic.following(distance)))
    moved = points + distance[:, None] * np.stack([along[:, 1], -along[:, 0]], axis=1)
    inside = np.array([outlines.share_in(point[None], room) > 0 for point in moved[ends]], dtype=bool)
    kept = np.ones(len(points), bool)
    kept[ends] = inside
    return np.where(kept[:, None], moved, points)


def _others(contour: Contour, start: int, length: int) -> IntArray:
    """Return the indices of the points outside a run, in order from its end."""
    return (start + length + np.arange(len(contour) - length)) % len(contour)


def _spliced(*pieces: tuple[Contour, IntArray, FloatArray]) -> Contour:
    """Return one contour made of pieces of others, each followed by a closing curve."""
    points, across, straight = [], [], []
    for contour, kept, curve in pieces:
        points += [contour.points[kept], curve]
        across += [contour.across[kept], np.full(len(curve), COMPLETED)]
        straight += [contour.straight[kept], np.zeros(len(curve), np.int64)]
    return Contour(np.concatenate(points), np.concatenate(across), np.concatenate(straight))


def _simple(contour: Contour) -> bool:
    """Whether an outline does not cross itself."""
    interruption.check()
    return polygon_crossing_area(contour.points) <= MOST_CROSSED


def _silhouette(contour: Contour, start: int, length: int) -> bool:
    """Whether at an end of a gap the outline continues straight as that of the occluder: a common silhouette."""
    count = len(contour)
    ends = ((start, BEFORE), ((start + length) % count, AFTER))
    return any(contour.straight[(i + d) % count] == kind for i, kind in ends for d in (-1, 0, 1))


def _gap(contour: Contour, start: int, length: int) -> Gap:
    """Return the ends of a run and the directions of the outline there."""
    points, count = contour.points, len(contour)
    reach = min(FITTED, count - length)
    steps = np.arange(1 if reach > 5 else 0, reach)
    before, after = points[(start - 1 - steps) % count][::-1], points[(start + length + steps) % count][::-1]
    enter, leave = direction_at_end(before), direction_at_end(after)
    return points[(start - 1) % count], enter, points[(start + length) % count], None if leave is None else -leave


def _accidents(contour: Contour, start: int, length: int, curve: FloatArray) -> float:
    """Return the total angle, radians, by which an outline turns, or begins to turn, at the ends of a closing curve.

    A corner exactly where a shape disappears behind another, or a change from straight to curved there, is a
    coincidence: the principle of the generic view. Half the curve (n, 2) is compared with the extrapolation of each
    end, within `REACH` px.
    """
    points, count = contour.points, len(contour)
    reach = min(REACH, count - length)
    steps = np.arange(1 if reach > 5 else 0, reach)
    total = 0.0
    for indices, made in (((start - 1 - steps) % count, curve), ((start + length + steps) % count, curve[::-1])):
        seen = points[indices]
        hidden = np.concatenate([seen[:1], made[:REACH]])
        out, back = tangent(seen[::-1]), tangent(hidden[::-1])
        if out is None or back is None:
            continue
        total += float(np.arccos(np.clip(-(out[0] @ back[0]), -1, 1))) + abs(out[1] + back[1]) * len(curve) / 2
    return total
