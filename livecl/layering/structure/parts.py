# SPDX-License-Identifier: Apache-2.0
"""Split a region into touching shapes of one colour, along an outline continued between two concave corners.

Where a shape lies across another of its own colour, no border is visible, but both outlines end in concave corners, and
the outline of the shape in front continues from one to the other (good continuation; the minima rule: Hoffman and
Richards, Cognition 18, 1984). The region is cut along that continuation if two shapes are the cheaper explanation.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Iterator

import numpy as np
from scipy.spatial import cKDTree

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.geometry.corners import find_corners, noise_of
from livecl.geometry.polylines import polygon_mask
from livecl.layering.outlines.completion import completed_contour
from livecl.layering.outlines.continuations import direction_at_end, smooth, straight_line
from livecl.layering.outlines.contours import COMPLETED, Contour, Outlines
from livecl.layering.outlines.prices import ASKED, PRICES, Prices, outline_price
from livecl.layering.outlines.primitives import fitted_primitive
from livecl.layering.segmentation.flat import FlatRegions
from livecl.layering.structure.views import ground_regions

#: Share of the picture up to which a region counts as a letter or a sign, which is not split; pixels of the smallest
#: part.
LETTER, LEAST_PART = 0.02, 20
#: Most concave corners of an outline that is split: more are a pattern, such as a lattice or a saw.
MOST_CONCAVE = 12
#: Least bend of a concave corner, radians, and the steps over which it is measured.
LEAST_BEND, BEND_REACH = 0.3, 6
#: Points used beside a corner, and fewest of them; largest root-mean-square and maximum distance, px, from a line
#: through them.
ARM, LEAST_ARM, ON_LINE, OFF_LINE = 16, 3, 0.1, 0.4
#: Least visible share of a circle or an ellipse along which an outline continues.
HALF = 0.5
#: Cosine of the largest angle between the end of an outline and the way to its continuation.
AHEAD = 0.75
#: Share of a continuation that must lie within regions other than the ground.
WITHIN = 0.97
#: Rounds in which parts are split again.
ROUNDS = 4


@dataclasses.dataclass(frozen=True, eq=False)
class _Cut:
    """A region split in two: the part behind, the curve along which the front part continues, and the saving."""

    behind: BoolArray
    curve: FloatArray
    saved: float


def with_parts(regions: FlatRegions, ground: FloatArray, prices: Prices = PRICES) -> Outlines:
    """Split regions of one colour into the parts that a person would see, over a ground of a colour (C,).

    Returns the outlines of all regions; each cut adds one.
    """
    outlines = Outlines(regions)
    behind = ground_regions(outlines, ground)
    outlines.ground = behind
    looked_at = set(range(outlines.count))
    for _ in range(ROUNDS):
        found = _cuts(sorted(looked_at - behind), outlines, prices)
        if not found:
            break
        looked_at = set()
        for k, cut in found.items():
            looked_at |= {k, len(regions.sizes)}
            regions = _divided(regions, k, cut)
        outlines = Outlines(regions, behind)
    return outlines


def with_more_parts(outlines: Outlines, number: int, prices: Prices = ASKED) -> Outlines:
    """Split regions into more parts, as requested, greedily by the saving, at most `number` times.

    Returns the same outlines if nothing can be split.
    """
    looked_at = [k for k in range(outlines.count) if k not in (outlines.ground or ())]
    found: dict[int, _Cut] = {}
    for _ in range(number):
        found |= _cuts(looked_at, outlines, prices)
        best = max(found, key=lambda k: found[k].saved, default=None)
        if best is None:
            break
        looked_at = [best, outlines.count]
        outlines = Outlines(_divided(outlines.regions, best, found.pop(best)), outlines.ground)
    return outlines


def _cuts(numbers: Iterable[int], outlines: Outlines, prices: Prices) -> dict[int, _Cut]:
    """Return the cuts that save anything, for the given regions."""
    inside = outlines.marks(k for k in range(outlines.count) if k not in (outlines.ground or ()))
    noise = noise_of([contour.points for k in range(outlines.count) for contour in outlines.of((k,))])
    found = {}
    for k in numbers:
        interruption.check()
        cut = _best_cut(k, outlines, inside, noise, prices)
        if cut is not None:
            found[k] = cut
    return found


def _best_cut(k: int, outlines: Outlines, inside: BoolArray, noise: float, prices: Prices) -> _Cut | None:
    """Return the cut of a region with the largest saving; None if no cut saves anything."""
    regions, (contour, *holes) = outlines.regions, outlines.of((k,))
    if regions.sizes[k] < LETTER * regions.labels.size or not all(inside[hole.across].any() for hole in holes):
        return None
    own = regions.labels == k
    whole = None
    best: _Cut | None = None
    for front, chain, curve, exact in _continuations(contour, noise):
        if outlines.share_in(curve, inside) < WITHIN:
            continue
        if whole is None:
            whole = outline_price(contour.points, prices)
        gain = prices.aligned * exact - prices.cut * len(curve) / np.sqrt(regions.sizes[k])
        saved = whole - outline_price(np.concatenate([front, curve]), prices) - prices.layer + gain
        if saved - (2 * np.pi - prices.primitive) <= prices.saving:
            continue
        across = np.concatenate([np.full(len(chain), COMPLETED), np.full(len(curve), k)])
        points = np.concatenate([chain, curve[::-1]])
        back = Contour(points, across, np.zeros(len(points), np.int64))
        price = completed_contour(back, outlines.marks((k,)), inside, outlines, prices)[1]
        both = price, whole - prices.layer + gain - saved
        saved -= price
        if saved <= max(prices.saving, best.saved if best else 0.0) or (max if exact else min)(both) > prices.simple:
            continue
        part = own & polygon_mask(points, own.shape)
        if LEAST_PART <= np.count_nonzero(part) <= np.count_nonzero(own) - LEAST_PART:
            best = _Cut(part, np.concatenate([chain[-1:], curve[::-1], chain[:1]]), saved)
    return best


def _continuations(contour: Contour, noise: float) -> Iterator[tuple[FloatArray, FloatArray, FloatArray, int]]:
    """Yield continuations of an outline from one concave corner to another.

    Each is the outline that continues, the chain that it leaves out, the connecting points, and how many of the two
    outlines, this one included, continue exactly.
    """
    outline = find_corners(contour.points, noise)
    points, corners, count = outline.points, outline.corners, len(outline.points)
    z = points[:, 0] + 1j * points[:, 1]
    arrive, depart = z[corners] - z[(corners - BEND_REACH) % count], z[(corners + BEND_REACH) % count] - z[corners]
    bends = np.angle(depart / np.where(arrive == 0, 1, arrive)) * np.sign(contour.area)
    concave = np.flatnonzero(bends < -LEAST_BEND).tolist()
    if len(concave) > MOST_CONCAVE:
        return
    found: dict[tuple[int, int], tuple[FloatArray, bool]] = {}
    for first, second in itertools.permutations(concave, 2):
        start, end = int(corners[first]), int(corners[second])
        before, after = corners[first - 1], corners[(second + 1) % len(corners)]
        lengths = int(start - before) % count - 1, int(after - end) % count - 1
        if min(lengths) >= LEAST_ARM:
            arm, other = (
                points[_after(start - lengths[0] - 1, lengths[0], count)],
                points[_after(end, lengths[1], count)],
            )
            going_on = _continuation(points[start], arm, points[end], other, before == end, noise)
            if going_on is not None:
                found[start, end] = going_on
    for (start, end), (curve, exact) in found.items():
        back = found.get((end, start))
        chain = _after(start - 1, (end - start) % count + 1, count)
        front = _after(end - 1, (start - end) % count + 1, count)
        yield points[front], points[chain], curve, exact + (exact and back is not None and back[1])


def _after(i: int, number: int, count: int) -> IntArray:
    """Return the indices of the `number` points after point i of a closed outline of `count` points."""
    return (i + 1 + np.arange(number)) % count


def _continuation(
    start: FloatArray, arm: FloatArray, end: FloatArray, other: FloatArray, one_side: bool, noise: float
) -> tuple[FloatArray, bool] | None:
    """Return the points by which an outline continues from one arm to another, if it does, and whether exactly.

    Exactly means along one straight line, or along a circle or an ellipse of which half is visible.
    """
    enter, leave = direction_at_end(arm[-ARM:]), direction_at_end(other[:ARM][::-1])
    if enter is None or leave is None:
        return None
    way = end - start
    length = float(np.hypot(*way))
    ahead = min(enter @ way, -leave @ way) >= AHEAD * length
    if ahead:
        both = np.concatenate([arm[-ARM:], other[:ARM]])
        centered = both - both.mean(axis=0)
        along = np.linalg.svd(centered, full_matrices=False)[2][0]
        away = np.abs(centered[:, 0] * along[1] - centered[:, 1] * along[0])
        if np.sqrt(np.mean(away**2)) < ON_LINE + 3 * noise and away.max() < OFF_LINE + 6 * noise:
            return straight_line(start, end), True
    seen = arm if one_side else np.concatenate([arm, other])
    whole = fitted_primitive(seen)
    if whole is not None and len(seen) >= HALF * len(whole):
        first, last = (int(np.hypot(*(whole - point).T).argmin()) for point in (start, end))
        step = whole[(first + 1) % len(whole)] - whole[first]
        if step @ enter < 0:
            whole, first, last = whole[::-1], len(whole) - 1 - first, len(whole) - 1 - last
        return whole[_after(first, (last - first) % len(whole) - 1, len(whole))], True
    return (smooth(start, enter, end, -leave), False) if ahead else None


def _divided(regions: FlatRegions, k: int, cut: _Cut) -> FlatRegions:
    """Return the regions with one split in two; the part behind becomes the last."""
    number, core = len(regions.sizes), int(max(regions.cores.max(), regions.other.max())) + 1
    labels, other, share = regions.labels.copy(), regions.other.copy(), regions.share.copy()
    old = int(regions.cores[k])
    labels[cut.behind] = number
    # Pixels on the cut are shared by both parts, as its distance from their middles tells.
    rows, columns = np.nonzero((regions.labels == k) & (share == 1))
    distance = cKDTree(_dense(cut.curve)).query(np.stack([columns, rows], axis=1) + 0.5, distance_upper_bound=0.5)[0]
    near = distance < 0.5
    rows, columns, distance = rows[near], columns[near], distance[near]
    share[rows, columns] = 0.5 + distance
    other[rows, columns] = np.where(cut.behind[rows, columns], old, core)
    # What mixes with the old core beside the part behind mixes with the new one.
    rows, columns = np.nonzero((regions.other == old) & (regions.labels != k))
    if len(rows):
        at = np.stack([rows, columns], axis=1)
        behind, front = (np.argwhere(labels == m) for m in (number, k))
        nearer = cKDTree(behind).query(at)[0] < cKDTree(front).query(at)[0]
        other[rows[nearer], columns[nearer]] = core
    return dataclasses.replace(
        regions,
        labels=labels,
        colors=np.concatenate([regions.colors, regions.colors[k : k + 1]]),
        sizes=np.bincount(labels.ravel(), minlength=number + 1),
        cores=np.append(regions.cores, core),
        other=other,
        share=share,
    )


def _dense(points: FloatArray) -> FloatArray:
    """Resample a polyline at steps of a fifth of a pixel."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0, lengths[-1], max(2, int(5 * lengths[-1])))
    return np.stack([np.interp(at, lengths, points[:, axis]) for axis in (0, 1)], axis=1)
