# SPDX-License-Identifier: Apache-2.0
"""Outlines of flat regions at sub-pixel accuracy, with the neighbouring region at each point, and T-junctions.

Where three regions meet, the outline that runs straight through belongs to one of them, and the other two end at it:
the stem of a T. The region with the straight outline lies in front (Kellman and Shipley 1991; Law and Kang,
2409.06648).
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Iterable
from collections.abc import Set as AbstractSet

import numpy as np
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.geometry import cyclic
from livecl.geometry.polylines import polygon_area
from livecl.layering.outlines.edges import edge_polylines
from livecl.layering.segmentation.flat import SAME_COLOR, SAME_OF_NOISE, FlatRegions
from livecl.layering.segmentation.labels import EIGHT_NEIGHBORS

#: Values of `across` that are no region: beyond the page, a completed part, or the region itself.
PAGE, COMPLETED, _SELF = -1, -2, -3
#: Whose outline runs straight through a T-junction: undecided, the region's own, that of the neighbour before, or that
#: of the neighbour after.
UNCLEAR, OWN, BEFORE, AFTER = range(4)
#: Reach, px, within which directions at a junction are measured; pixels nearer than `LEFT_OUT` are excluded.
REACH, LEFT_OUT = 11, 1.2
#: Largest bend, radians, of an outline that runs straight through a junction, and its least advantage over the next.
STRAIGHT, CLEARER = 0.6, 0.25
#: Area, px^2, of the smallest outline of a region beside its largest: regions have more pixels (flat.SMALLEST), so less
#: is a mixed pixel attributed to the wrong region.
LEAST_AREA = 2.0
#: Sample size, pixels, of the test whether an outline keeps its regions, and the least share of them that it must keep.
SAMPLED, KEPT = 400, 0.98
_STEPS_OUT = (1.0, 1.5, 0.6, 2.2, 3.0)


@dataclasses.dataclass(frozen=True, eq=False)
class Contour:
    """A closed outline, sampled at steps of about 1 px."""

    points: FloatArray  # (n, 2), (x, y) px
    across: IntArray  # (n,), region on the other side, PAGE or COMPLETED
    straight: IntArray  # (n,), UNCLEAR, OWN, BEFORE or AFTER at points where `across` changes

    def __len__(self) -> int:
        return len(self.points)

    @functools.cached_property
    def area(self) -> float:
        """Signed area, px^2."""
        return polygon_area(self.points)

    def is_hole_of(self, outer: Contour) -> bool:
        """Whether it has the opposite orientation."""
        return self.area * outer.area < 0

    def runs(self, below: BoolArray) -> list[tuple[int, int]] | None:
        """Return (first point, length) of each run of points facing the regions in `below`: whole runs, then parts.

        A run that several regions share is also split where one gives way to the next. None if the whole contour is one
        run.
        """
        marked, count = below[self.across], len(self)
        if marked.all():
            return None
        if not marked.any():
            return []
        start = int(np.flatnonzero(~marked)[0])
        edges = np.diff(np.concatenate([[0], np.roll(marked, -start).astype(np.int8), [0]]))
        whole = [
            (int(first + start) % count, int(end - first))
            for first, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True)
        ]
        parts = []
        for first, length in whole:
            changes = np.flatnonzero(np.diff(self.across[(first + np.arange(length)) % count])) + 1
            if len(changes):
                cuts = [0, *changes.tolist(), length]
                parts += [((first + a) % count, b - a) for a, b in itertools.pairwise(cuts)]
        return whole + parts


class Outlines:
    """Outlines of the regions of a picture, and of unions of them; `ground`: the regions of the ground, if known."""

    def __init__(self, regions: FlatRegions, ground: AbstractSet[int] | None = None) -> None:
        self.regions, self.ground = regions, ground
        self.count = len(regions.sizes)
        self._boxes = ndimage.find_objects(regions.labels + 1)
        self._padded = np.pad(regions.labels, 3, constant_values=PAGE)
        wider = np.pad(self._padded, 1, constant_values=PAGE)
        self._around = np.lib.stride_tricks.sliding_window_view(wider, (3, 3))  # of each padded pixel
        self._known: dict[frozenset[int], list[Contour]] = {}
        single = [self._traced((k,)) for k in range(self.count)]
        for k in range(self.count):
            self._known[frozenset((k,))] = [self._with_junctions(contour, single) for contour in single[k]]

    def of(self, ids: Iterable[int]) -> list[Contour]:
        """Trace the outlines of a union of regions, the largest first."""
        key = frozenset(int(k) for k in ids)
        if key not in self._known:
            self._known[key] = self._traced(sorted(key))
        return self._known[key]

    def outer(self, k: int) -> Contour:
        """Return the outer outline of a region."""
        return self.of((k,))[0]

    def marks(self, ids: Iterable[int]) -> BoolArray:
        """Return a boolean mask of some regions: (K + 3,), with entries for pixels of no region."""
        marks = np.zeros(self.count + 3, bool)
        marks[list(ids)] = True
        return marks

    def covers(self, ids: Iterable[int]) -> BoolArray:
        """Return a boolean mask of those of some regions that are opaque, hiding the layers below: (K + 3,)."""
        colors = self.regions.colors
        if colors.shape[1] < 4:
            return self.marks(ids)
        opaque = colors[:, 3] >= 1 - SAME_COLOR - SAME_OF_NOISE * self.regions.noise
        return self.marks(k for k in ids if opaque[k])

    def room(self, ids: Iterable[int], below: BoolArray) -> BoolArray:
        """Return the regions in which a shape of some regions may lie when it continues behind others: (K + 3,)."""
        marks = below.copy()
        marks[list(ids)] = True
        return marks

    def share_in(self, points: FloatArray, room: BoolArray) -> float:
        """Return the share of points that lie in the regions of a room, or a pixel beside them."""
        if not len(points):
            return 1.0
        rows, columns = self._index(points)
        return float(room[self._around[rows, columns]].any(axis=(1, 2)).mean())

    def keeps(self, ids: Iterable[int], before: Contour, after: Contour) -> bool:
        """Whether a changed outline still encloses the pixels of some regions, by a sample of about `SAMPLED`."""
        from skimage.measure import points_in_poly

        if after is before:
            return True
        rows, columns = np.nonzero(np.isin(self.regions.labels, list(ids)))
        step = 1 + len(rows) // SAMPLED
        points = np.stack([columns, rows], axis=1)[::step] + 0.5
        points = points[points_in_poly(points, before.points)]
        return bool(np.mean(points_in_poly(points, after.points)) >= KEPT) if len(points) else True

    def neighbors(self, k: int) -> dict[int, int]:
        """Return the regions adjacent to the outlines of one, with the number of points that face each."""
        across, counts = np.unique(np.concatenate([c.across for c in self.of((k,))]), return_counts=True)
        return {int(o): int(n) for o, n in zip(across, counts, strict=True) if o >= 0}

    def _index(self, points: FloatArray) -> tuple[IntArray, IntArray]:
        height, width = self.regions.labels.shape
        at = np.floor(points).astype(np.int64)
        return np.clip(at[:, 1], -3, height + 2) + 3, np.clip(at[:, 0], -3, width + 2) + 3

    def _traced(self, ids: Iterable[int]) -> list[Contour]:
        ids, regions = list(ids), self.regions
        interruption.check()
        height, width = regions.labels.shape
        top = max(min(self._boxes[k][0].start for k in ids) - 2, 0)
        left = max(min(self._boxes[k][1].start for k in ids) - 2, 0)
        bottom = min(max(self._boxes[k][0].stop for k in ids) + 2, height)
        right = min(max(self._boxes[k][1].stop for k in ids) + 2, width)
        window = slice(top, bottom), slice(left, right)
        inside_of = self.marks(ids)
        inside = inside_of[regions.labels[window]]
        cores = np.zeros(regions.other.max() + int(regions.cores.max()) + 2, bool)
        cores[regions.cores[ids]] = True
        # The rest of a pixel may belong to the union as well, if it is one of its cores that lies beside.
        rest = cores[regions.other[window]] & ndimage.binary_dilation(inside, EIGHT_NEIGHBORS)
        share = regions.share[window]
        cover = np.where(inside, np.where(rest, 1.0, share), np.where(rest, 1 - share, 0.0))
        soft = np.where(inside, np.maximum(cover, 0.5001), np.minimum(cover, 0.4999))
        origin = np.array((left, top), dtype=np.float64)
        found = [self._labelled(origin + points, inside_of) for points in edge_polylines(soft, cover)]
        found.sort(key=lambda contour: -abs(contour.area))
        return found[:1] + [contour for contour in found[1:] if abs(contour.area) >= LEAST_AREA]

    def _labelled(self, points: FloatArray, inside_of: BoolArray) -> Contour:
        """Orient an outline, and label its points with the region on the other side."""
        along = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
        along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
        out = np.stack([along[:, 1], -along[:, 0]], axis=1)
        inner = [inside_of[self._padded[self._index(points + side * 0.9 * out)]].mean() for side in (1, -1)]
        if inner[0] > inner[1]:
            points, out = points[::-1].copy(), -out[::-1]
        across = np.full(len(points), _SELF)
        for distance in _STEPS_OUT:
            seen = self._padded[self._index(points + distance * out)]
            new = (across == _SELF) & ~inside_of[seen]
            across[new] = seen[new]
        return Contour(points, _cleaned(across), np.zeros(len(points), np.int64))

    def _with_junctions(self, contour: Contour, single: list[list[Contour]]) -> Contour:
        straight, count = np.zeros(len(contour), np.int64), len(contour)
        reach = min(REACH, count // 3)
        for i in np.flatnonzero(contour.across != cyclic.preceding(contour.across)):
            before, after = int(contour.across[i - 1]), int(contour.across[i])
            junction = (contour.points[i - 1] + contour.points[i]) / 2
            backward, forward = (i - 1 - np.arange(reach)) % count, (i + np.arange(reach)) % count
            arms = (
                _direction(junction, contour.points[backward[contour.across[backward] == before]]),
                _direction(junction, contour.points[forward[contour.across[forward] == after]]),
                _direction(junction, _border_near(junction, before, after, single)),
            )
            if any(arm is None for arm in arms):
                continue
            a, b, c = arms
            bends = np.pi - np.array([_angle(a, b), _angle(a, c), _angle(b, c)])
            order = np.argsort(bends, kind="stable")
            if bends[order[0]] < STRAIGHT and bends[order[1]] - bends[order[0]] > CLEARER:
                straight[i] = order[0] + 1
        return dataclasses.replace(contour, straight=straight)


def _border_near(junction: FloatArray, a: int, b: int, single: list[list[Contour]]) -> FloatArray:
    """Return the points near a junction on the border of two regions."""
    for region, across in ((a, b), (b, a)):
        if region < 0:
            continue
        for contour in single[region]:
            distance = np.hypot(*(contour.points - junction).T)
            near = (contour.across == across) & (distance < REACH) & (distance > 0.7)
            if near.sum() >= 3:
                return contour.points[near]
    return np.zeros((0, 2))


def _direction(junction: FloatArray, points: FloatArray) -> FloatArray | None:
    """Return the unit vector from a junction to the points around it, if there is one."""
    if not len(points):
        return None
    away = np.hypot(*(points - junction).T) > LEFT_OUT
    mean = (points[away] if away.sum() >= 2 else points).mean(axis=0) - junction
    length = float(np.hypot(*mean))
    return mean / length if length > 0.3 else None


def _angle(a: FloatArray | None, b: FloatArray | None) -> float:
    assert a is not None and b is not None
    return float(np.arccos(np.clip(a @ b, -1, 1)))


def _cleaned(across: IntArray) -> IntArray:
    """Assign points without a neighbour, and runs of one or two points within another's run, to the preceding run."""
    across = across.copy()
    unknown = across == _SELF
    if unknown.all():
        return np.full(len(across), PAGE)
    if unknown.any():
        known = np.flatnonzero(~unknown)
        across = across[known[np.searchsorted(known, np.arange(len(across)), side="right") - 1]]
    for width in (1, 2):
        before = cyclic.preceding(across)
        lone = (before == np.roll(across, -width)) & (across != before)
        across[lone] = before[lone]
    return across
