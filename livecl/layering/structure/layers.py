# SPDX-License-Identifier: Apache-2.0
"""From the regions of a flat picture to its layers, bottom first: whole shapes, occluded parts included."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from typing import Literal

import numpy as np

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray
from livecl.layering.outlines.completion import completed_contour, cut_in_two, filled_out, joined_contours, trapped
from livecl.layering.outlines.contours import Contour, Outlines
from livecl.layering.outlines.prices import PRICES, Prices, outline_price
from livecl.layering.structure.depth import evidence
from livecl.layering.structure.ordering import paint_order
from livecl.layering.structure.twins import Pairs, few_alike, same_color
from livecl.layering.structure.views import ground_regions, screens, worth_it


@dataclasses.dataclass(frozen=True, eq=False)
class Layer:
    """A shape of one fill.

    Attributes
    ----------
    outlines : list of (n, 2) float
        Closed polylines, px, the outer one first; holes have the opposite orientation.
    color : (C,) float
        As in the picture: the colour of most of its pixels.
    shown : frozenset of int
        Regions in which the layer is visible.
    exact : bool
        Whether the points of the outlines are corners of straight sides, not samples of curves.
    over : int
        0, or the index of its fill among overlaid fills on one outline: it follows the layers below it.
    """

    outlines: list[FloatArray]
    color: FloatArray
    shown: frozenset[int] = frozenset()
    exact: bool = dataclasses.field(default=False, kw_only=True)
    over: int = dataclasses.field(default=0, kw_only=True)


@dataclasses.dataclass(frozen=True)
class Assumptions:
    """What an explanation assumes beyond what is cheapest shape by shape.

    Attributes
    ----------
    views : "cheaper", "all" or "none"
        Which of the holes that may show what lies behind do so.
    apart : frozenset of int
        Regions joined with no others.
    """

    views: Literal["cheaper", "all", "none"] = "cheaper"
    apart: frozenset[int] = frozenset()


#: Nothing beyond what is cheapest.
PLAIN = Assumptions()


@dataclasses.dataclass(eq=False)
class _Shape:
    """A layer in the making: its visible regions, the regions enclosed by its outline, and its contours."""

    shown: set[int]
    around: set[int]
    contours: list[Contour]

    def sort(self) -> None:
        self.contours.sort(key=lambda contour: -abs(contour.area))

    def outer(self) -> list[tuple[int, Contour]]:
        """Contours that are no holes, with their indices."""
        return [(i, c) for i, c in enumerate(self.contours) if not c.is_hole_of(self.contours[0])]


@dataclasses.dataclass(frozen=True, eq=False)
class _Join:
    """A join of two shapes: the saving, the indices of the two contours, and the joined contour."""

    saved: float
    shapes: tuple[int, int]
    contours: tuple[int, int]
    whole: Contour
    pair: tuple[Contour, ...] = ()


def find_layers(
    outlines: Outlines, ground: FloatArray, prices: Prices = PRICES, assumed: Assumptions = PLAIN
) -> list[Layer]:
    """Find the layers of a flat picture over a ground of a colour (C,), the lowest first."""
    regions = outlines.regions
    behind = ground_regions(outlines, ground)
    seen_through = screens(outlines, behind)
    nodes = [k for k in range(outlines.count) if k not in behind]
    front, markings = evidence(outlines, nodes, prices)
    if assumed.views != "all":
        cheaper = assumed.views == "cheaper"
        seen_through = [screen for screen in seen_through if cheaper and worth_it(screen, outlines, front, prices)]
    for screen in seen_through:
        for k in screen.behind:
            front.pop((k, screen.front), None)
            front[screen.front, k] = 2 * np.pi
    order = paint_order(front, nodes, regions.sizes, [screen.behind for screen in seen_through])
    scene = _Scene(outlines, front, order, prices)
    for k in order:
        interruption.check()
        groups = [group for (region, _), group in markings.items() if region == k]
        above = [group for group in groups if all(scene.depth[o] > scene.depth[k] for o in group)]
        scene.add(k, set().union(*above))
    for screen in seen_through:
        scene.unite(screen.front, screen.behind)
    scene.join_all(assumed.apart)
    return [Layer(shape, regions.colors[k], frozenset(scene.shapes[k].shown)) for k, shape in scene.whole()]


class _Scene:
    """Shapes, by the region that stands for each, and their known depths."""

    def __init__(self, outlines: Outlines, front: Pairs, order: list[int], prices: Prices) -> None:
        self.outlines, self.prices = outlines, prices
        self.depth = {k: i for i, k in enumerate(order)}
        self.shapes: dict[int, _Shape] = {}
        self._front = front
        self._known: dict[int, set[int]] = {k: set() for k in order}
        self._sure: dict[int, set[int]] = {k: set() for k in order}
        for (a, b), weight in front.items():
            self._known[a].add(b)
            self._known[b].add(a)
            if weight > prices.sure:
                self._sure[b].add(a)

    def add(self, k: int, markings: Iterable[int]) -> None:
        """Add a shape visible in one region; its outline includes the markings on the region."""
        around = {k, *markings}
        self.shapes[k] = _Shape({k}, around, list(self.outlines.of(around)))

    def unite(self, front: int, behind: Iterable[int]) -> None:
        """Unite the regions seen through another one into one shape, continued behind that one if this is simpler."""
        parts_of = set(behind)
        keys = sorted((k for k, shape in self.shapes.items() if shape.shown & parts_of), key=lambda k: self.depth[k])
        if not keys or front not in self.depth:
            return
        around = set().union(*(self.shapes[k].around for k in keys))
        shown = set().union(*(self.shapes[k].shown for k in keys))
        parts, whole = self.outlines.of(around), self.outlines.of(around | {front})
        sizes, prices = self.outlines.regions.sizes, self.prices
        apart = sum(outline_price(part.points, prices) for part in parts)
        apart += prices.layer * (sum(not part.is_hole_of(parts[0]) for part in parts) - 1)
        hidden = prices.hidden * sizes[front] / sizes[list(around)].sum()
        for k in keys:
            del self.shapes[k]
        if outline_price(whole[0].points, prices) + hidden < apart:
            parts, around = whole, around | {front}
        self.shapes[keys[0]] = _Shape(shown, around, list(parts))

    def _above(self, *keys: int) -> set[int]:
        """Regions of the shapes above the lowest of the given ones."""
        depth = min(self.depth[k] for k in keys)
        others = (k for k in self.shapes if self.depth[k] > depth and k not in keys)
        return {o for k in others for o in self.shapes[k].shown}

    def covers(self, *keys: int) -> tuple[BoolArray, BoolArray]:
        """Return the regions behind which some shapes may continue, and the room for doing so."""
        above = self._above(*keys)
        own = set().union(*(self.shapes[k].shown for k in keys))
        sure = set().union(*(self._sure[k] for k in own))
        known = set().union(*(self._known[k] for k in own))
        below = self.outlines.covers(o for o in above if o in sure or o not in known)
        around = set().union(*(self.shapes[k].around for k in keys))
        return below, self.outlines.room(around, self.outlines.covers(above))

    def _against(self, shown: set[int], depth: int) -> float:
        """Return the evidence against some regions lying at a depth."""
        at = {o: self.depth[k] for k, shape in self.shapes.items() for o in shape.shown - shown}
        total = 0.0
        for (a, b), weight in self._front.items():
            if (a in shown and b in at and at[b] > depth) or (b in shown and a in at and at[a] < depth):
                total += weight
        return total

    def _joint_depth(self, a: int, b: int) -> tuple[float, int]:
        """Return the evidence against two shapes being one, beyond that against each as it is, and its best depth.

        The joined shape must lie above the shapes whose outlines include a part of it.
        """
        shown = self.shapes[a].shown | self.shapes[b].shown
        around = [self.depth[k] for k, shape in self.shapes.items() if k not in (a, b) and shape.around & shown]
        depths = [self.depth[k] for k in (a, b) if self.depth[k] > max(around, default=-1)]
        if not depths:
            return np.inf, self.depth[a]
        apart = sum(self._against(self.shapes[k].shown, self.depth[k]) for k in (a, b))
        against, best = min((self._against(shown, depth), depth) for depth in depths)
        return max(0.0, against - apart), best

    def join_all(self, apart: AbstractSet[int]) -> None:
        """Join shapes of one colour greedily, the pair of largest saving first; then each with itself.

        Shapes with regions in `apart` are not joined. A shape that could be joined with either of two others, but not
        with both, at about equal savings is joined with neither.
        """
        few = few_alike(self.outlines, sorted(k for k, shape in self.shapes.items() if not shape.shown & apart))
        tried: dict[tuple[Contour, ...], _Join | None] = {}
        unclear: set[tuple[Contour, ...]] = set()
        while True:
            keys = sorted(self.shapes.keys() & set(few), key=lambda k: self.depth[k])
            joins: list[_Join] = []
            for a, b in itertools.combinations(keys, 2):
                if not same_color(self.outlines, a, b):
                    continue
                interruption.check()
                pair = (*self.shapes[a].contours, *self.shapes[b].contours)
                if pair not in tried:
                    tried[pair] = self._best_join(a, b)
                found = tried[pair]
                if found is not None:
                    joins.append(dataclasses.replace(found, pair=pair))
            best = max((join for join in joins if join.pair not in unclear), key=lambda join: join.saved, default=None)
            if best is None:
                break
            rivals = [join for join in joins if self._excludes(best, join)]
            if rivals:
                unclear.update(join.pair for join in (best, *rivals))
            else:
                self._join(best)
        for k, shape in self.shapes.items():
            if not shape.shown & apart:
                self._cut(k, shape)

    def _best_join(self, a: int, b: int) -> _Join | None:
        """Return the best join of two shapes; None if none saves anything."""
        below, room = self.covers(a, b)
        ends = [[(i, c) for i, c in self.shapes[k].outer() if below[c.across].any()] for k in (a, b)]
        if not (ends[0] and ends[1]):
            return None
        best: _Join | None = None
        least = self.prices.saving + self._joint_depth(a, b)[0]
        for i, first in ends[0]:
            for j, second in ends[1]:
                found = joined_contours(first, second, below, room, self.outlines, self.prices)
                if found is None:
                    continue
                apart = sum(completed_contour(c, below, room, self.outlines, self.prices)[1] for c in (first, second))
                saved = apart + self.prices.layer - found[1]
                if saved > least and (best is None or saved > best.saved):
                    best = _Join(saved, (a, b), (i, j), found[0])
        return best

    def _excludes(self, join: _Join, other: _Join) -> bool:
        """Whether a join precludes another one of about the same saving that shares a shape with it."""
        common = set(join.shapes) & set(other.shapes)
        if len(common) != 1 or abs(join.saved - other.saved) > self.prices.saving:
            return False
        shapes, depth = dict(self.shapes), dict(self.depth)
        self._join(join)
        (third,) = set(other.shapes) - common
        left = self._best_join(*sorted((join.shapes[0], third), key=lambda k: self.depth[k]))
        self.shapes, self.depth = shapes, depth
        return left is None

    def _join(self, join: _Join) -> None:
        (a, b), (i, j) = join.shapes, join.contours
        self.depth[a] = self._joint_depth(a, b)[1]
        first, second = self.shapes[a], self.shapes.pop(b)
        contours = [
            join.whole,
            *first.contours[:i],
            *first.contours[i + 1 :],
            *second.contours[:j],
            *second.contours[j + 1 :],
        ]
        self.shapes[a] = _Shape(first.shown | second.shown, first.around | second.around, contours)
        self.shapes[a].sort()

    def _cut(self, k: int, shape: _Shape) -> None:
        below, room = self.covers(k)
        again = True
        while again:
            again = False
            for i, contour in shape.outer():
                two = cut_in_two(contour, below, room, self.outlines, self.prices)
                if two is not None:
                    shape.contours[i : i + 1] = two
                    shape.sort()
                    again = True
                    break

    def whole(self) -> list[tuple[int, list[FloatArray]]]:
        """Return the shapes, bottom first, with completed outlines; holes in which other shapes lie are filled."""
        found = []
        for k in sorted(self.shapes, key=lambda k: self.depth[k]):
            below, room = self.covers(k)
            contours = self.shapes[k].contours
            polylines = []
            for contour in contours:
                if below[contour.across].all() and contour.is_hole_of(contours[0]):
                    continue
                whole = filled_out(contour, below, room, self.outlines, self.prices)
                if not self.outlines.keeps(self.shapes[k].shown, contour, whole):
                    whole = contour
                polylines.append(trapped(whole, below, room, self.outlines))
            found.append((k, polylines))
        return found
