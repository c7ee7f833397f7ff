# SPDX-License-Identifier: Apache-2.0
"""Rank the layers of a picture by the error that each removes; unite or cut out layers if there are too many."""

from __future__ import annotations

import dataclasses
import functools
import itertools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.drawing.fills import Fills
from livecl.geometry.polylines import polygon_area, polygon_mask
from livecl.layering.outlines.contours import Outlines
from livecl.layering.segmentation.cores import pixel_centers
from livecl.layering.segmentation.flat import SAME_COLOR, FlatRegions
from livecl.layering.segmentation.smooth import SmoothRegions
from livecl.layering.structure.layers import Layer

#: Largest residual of an explained pixel: a constant, and per unit of noise.
EXPLAINED, EXPLAINED_OF_NOISE = 12 / 255, 6.0
#: Least squared error that a layer must remove, in wholly wrong channels of a pixel; or least number of visible pixels.
#: `prune` is 0.98 on a canvas of 256 px.
LEAST_GAIN, LEAST_PIXELS = 1.0, 64
#: Share of a layer that must lie within another one for it to become a hole there.
INSIDE = 0.98
#: Layers considered for uniting: a multiple of the number wanted, plus a constant.
UNITED_SHARE, UNITED_MORE = 2, 40
#: Price, squared error per px, of a border at which a shape ends that continued behind another: .0009 on a face of 18
#: shapes at 8 paths, and whole shapes as without such unions. The thirtieth that such a seam adds, the mean of (a (1 -
#: a))^2 over coverages a, gives .0003, and on icons .0006 less overlap.
SEAM = 0.3
#: Largest error of sharing one colour or one place, as a share of the error of omitting the last layer: colours almost
#: as different from each other as from the layers below are not equal.
NEAR = 0.5


@dataclasses.dataclass(frozen=True, eq=False)
class _Union:
    """A union of two layers: squared error lost, and their gains; their places, that of the union, lower outlines."""

    lost: tuple[float, float]
    lower: int
    upper: int
    place: int
    outlines: list[FloatArray]


@dataclasses.dataclass(frozen=True, eq=False)
class Structure:
    """Ranked layers of a picture.

    Attributes
    ----------
    regions : FlatRegions
        Regions of the picture.
    layers : list of Layer
        The lowest first.
    ground : (C,) float
        Colour where there are no layers.
    masks : (N, H, W) bool
        Pixels within each layer's outlines.
    top : (H, W) int
        Top layer at each pixel, 1 for the lowest; 0 for the ground. Of overlaid fills, the lowest.
    gains : (N,) float
        Squared error that each layer removes.
    ranked : (K,) int
        Layers worth placing, those that remove most first.
    outlines : Outlines, optional
        Outlines of the regions, if occluded layers may be cut to their visible part.
    left_out : (H, W) bool, optional
        Pixels at which omitted layers were visible.
    """

    regions: FlatRegions
    layers: list[Layer]
    ground: FloatArray
    masks: BoolArray
    top: IntArray
    gains: FloatArray
    ranked: NDArray[np.intp]
    outlines: Outlines | None = None
    left_out: BoolArray | None = None

    @classmethod
    def of(
        cls,
        regions: FlatRegions,
        layers: list[Layer],
        ground: FloatArray,
        masks: BoolArray,
        outlines: Outlines | None = None,
        left_out: BoolArray | None = None,
    ) -> Structure:
        """Rank layers by the error that each removes."""
        size = regions.labels.shape
        top, second = np.zeros((2, *size), np.int64)
        for number, (mask, layer) in enumerate(zip(masks, layers, strict=True), start=1):
            interruption.check()
            if not layer.over:
                second[mask], top[mask] = top[mask], number
        lost = np.square(painted(regions, layers, ground, top) - painted(regions, layers, ground, second)).sum(axis=-1)
        gains = np.bincount(top.ravel(), lost.ravel(), len(layers) + 1)[1:].astype(np.float64)
        for number, layer in enumerate(layers):
            if layer.over and isinstance(regions, SmoothRegions):  # never before the layers below it
                gains[number] = min(_gain_over(regions, layer, top == number - layer.over + 1), gains[number - 1])
        shown = np.bincount(top.ravel(), minlength=len(layers) + 1)[1:]
        order = np.argsort(-gains, kind="stable")
        ranked = order[(gains[order] >= LEAST_GAIN) | (shown[order] >= LEAST_PIXELS)]
        return cls(regions, layers, ground, masks, top, gains, ranked, outlines, left_out)

    @property
    def _kept(self) -> tuple[Outlines | None, BoolArray | None]:
        """Fields that stay when layers are united."""
        return self.outlines, self.left_out

    def fills_of(self, layer: int) -> Fills:
        """Return the fill of a layer."""
        if isinstance(self.regions, SmoothRegions):
            paint, over = self.regions.paint(self.layers[layer].shown), self.layers[layer].over
            return paint.over[over - 1].fills if over else paint.fills
        return Fills.solid(1)

    def shows(self, layers: IntArray) -> BoolArray:
        """Return the pixels (H, W) at which any of some layers (K,) is visible."""
        lowest = [int(k) - self.layers[k].over for k in layers]
        return np.isin(self.top, np.array(lowest, np.int64) + 1)

    def _overlaid(self, layer: int) -> bool:
        """Whether a layer is one of several overlaid fills."""
        return bool(self.layers[layer].over or (layer + 1 < len(self.layers) and self.layers[layer + 1].over))

    @property
    def shaded(self) -> bool:
        """Whether any layer worth placing has a gradient."""
        return any(self.fills_of(k).any_gradients for k in self.ranked)

    @property
    def exact(self) -> bool:
        """Whether the outlines are exact, as of pixel art."""
        return any(layer.exact for layer in self.layers)

    @property
    def mistaken(self) -> float:
        """Share of the pixels within regions that the composited layers show wrongly."""
        return float(self._wrong.sum() / max(np.count_nonzero(self._missed[1]), 1))

    @property
    def error(self) -> float:
        """Mean squared error of the composited layers at pixels within regions."""
        missed, inner = self._missed
        return float(np.square(missed[inner]).sum() / missed.size)

    def mistaken_by(self, least: float) -> list[Layer]:
        """Return the layers that are each wrong at more than a share of the pixels within regions."""
        counts = np.bincount(self.top[self._wrong], minlength=len(self.layers) + 1)[1:]
        return [self.layers[k] for k in np.flatnonzero(counts > least * np.count_nonzero(self._missed[1]))]

    @functools.cached_property
    def _wrong(self) -> BoolArray:
        """Pixels within regions that the layers show wrongly, (H, W)."""
        missed, inner = self._missed
        return np.asarray(inner & (np.abs(missed).max(axis=-1) > explained_miss(self.regions)))

    @functools.cached_property
    def _missed(self) -> tuple[FloatArray, BoolArray]:
        """Residual of the layers, (H, W, C), and the pixels within regions, (H, W)."""
        regions = self.regions
        inner = ndimage.minimum_filter(regions.labels, 3) == ndimage.maximum_filter(regions.labels, 3)
        seen = painted(regions, self.layers, self.ground, self.top)
        wanted = regions.image if isinstance(regions, SmoothRegions) else regions.colors[regions.labels]
        return np.asarray(seen - wanted), inner

    def united(self, most: int) -> Structure:
        """Unite or omit layers, whichever loses least, until there are at most `most`.

        A path may then have several parts, as an artist's may; if their fills differ, that of one part is used for
        both. A layer below what lies between the two moves up, cut to its visible part if needed.
        """
        found, rises = self, dict[frozenset[frozenset[int]], float]()
        while len(found.ranked) > most:
            if isinstance(self.regions, SmoothRegions) and (opened := found._with_a_hole()) is not None:
                found = opened
                continue
            union = found._best_union(most, rises)
            if (union is None or union.lost[0] > 0) and (opened := found._with_a_hole()) is not None:
                found = opened
            elif union is not None and union.lost[0] <= found.gains[found.ranked[-1]]:
                found = found._with(union)
            else:
                found = found._without(int(found.ranked[-1]))
        return found

    def _best_union(self, most: int, rises: dict[frozenset[frozenset[int]], float]) -> _Union | None:
        """Return the union of two layers that loses least; `rises` caches the error lost by sharing fills."""
        looked_at = np.sort(self.ranked[: UNITED_SHARE * most + UNITED_MORE]).tolist()
        looked_at = [k for k in looked_at if not self._overlaid(k)]
        pairs = []
        for lower, upper in itertools.combinations(looked_at, 2):
            fills = self.layers[lower].shown, self.layers[upper].shown
            if (key := frozenset(fills)) not in rises:
                rises[key] = self.regions.rise(*fills)
            if rises[key] <= NEAR * self.gains[self.ranked[-1]]:
                pairs.append((rises[key], float(self.gains[lower] + self.gains[upper]), lower, upper))
        best: _Union | None = None
        for rise, gain, lower, upper in sorted(pairs):
            if best is not None and (rise, gain) >= best.lost:
                break
            place, moved = self._place_of_both(lower, upper)
            if moved == 0:
                return _Union((rise, gain), lower, upper, place, self.layers[lower].outlines)
            ways = [] if best is None else [best]
            if rise + moved <= NEAR * self.gains[self.ranked[-1]]:
                ways.append(_Union((rise + moved, gain), lower, upper, place, self.layers[lower].outlines))
            if (seen := self._seen_outlines(lower)) is not None:
                ways.append(_Union((rise + SEAM * seen[1], gain), lower, upper, upper, seen[0]))
            best = min(ways, key=lambda union: union.lost, default=None)
        return best

    def _without(self, layer: int) -> Structure:
        """Omit a layer, together with its overlays."""
        after = next((k for k in range(layer + 1, len(self.layers)) if not self.layers[k].over), len(self.layers))
        kept = [*range(layer), *range(after, len(self.layers))]
        layers, shown = [self.layers[k] for k in kept], self.shows(np.array([layer]))
        left_out = shown if self.left_out is None else self.left_out | shown
        return Structure.of(self.regions, layers, self.ground, self.masks[kept], self.outlines, left_out)

    def _with_a_hole(self) -> Structure | None:
        """Cut a layer out of the one around it, as a hole, if the same colour shows through; the smallest first."""
        for layer in self.ranked[::-1].tolist():
            own = self.masks[layer]
            around = max((k for k in range(layer) if (self.masks[k] & own).any()), default=None)
            if around is None or self._overlaid(layer) or self._overlaid(around):
                continue
            if np.count_nonzero(self.masks[around] & own) < INSIDE * np.count_nonzero(own):
                continue
            below = [k for k in range(around) if (self.masks[k] & own).any()]
            if below:
                lower = below[-1]
                if self._overlaid(lower) or np.count_nonzero(self.masks[lower] & own) < INSIDE * np.count_nonzero(own):
                    continue
                if self.regions.rise(self.layers[lower].shown, self.layers[layer].shown) > 0:
                    continue
            elif self.top.all() or np.abs(self.layers[layer].color - self.ground).max() > SAME_COLOR:
                continue  # where no ground shows, none shows through a hole
            elif self.fills_of(layer).any_gradients:
                continue
            layers, masks = list(self.layers), self.masks.copy()
            holes = [points[::-1] for points in layers[layer].outlines]
            layers[around] = dataclasses.replace(layers[around], outlines=[*layers[around].outlines, *holes])
            masks[around] &= ~own
            if below:
                both = layers[lower].shown | layers[layer].shown
                layers[lower] = dataclasses.replace(layers[lower], shown=both)
            del layers[layer]
            return Structure.of(self.regions, layers, self.ground, np.delete(masks, layer, axis=0), *self._kept)
        return None

    def _place_of_both(self, lower: int, upper: int) -> tuple[int, float]:
        """Return the better of two layers' places for their union, and the squared error of the visible change."""
        between = (self.top > lower + 1) & (self.top < upper + 1)
        risen = self.masks[lower] & between
        sunk = (self.top == upper + 1) & self.masks[lower + 1 : upper].any(axis=0)
        lost = float(self._differences[self.top[risen] - 1, lower].sum())
        if lost == 0:
            return upper, lost
        shown = upper - 1 - np.argmax(self.masks[lower + 1 : upper, sunk][::-1], axis=0)
        below = float(self._differences[shown, upper].sum())
        return (lower, below) if below < lost else (upper, lost)

    @functools.cached_property
    def _differences(self) -> FloatArray:
        """Squared differences of the layers' colours, (N, N)."""
        colors = np.array([layer.color for layer in self.layers])
        return np.asarray(np.square(colors[:, None] - colors[None]).sum(axis=-1))

    def _seen_outlines(self, layer: int) -> tuple[list[FloatArray], int] | None:
        """Return the outlines of a layer's visible part, and the length of their borders with other shapes, px."""
        shown = self.layers[layer].shown
        if self.outlines is None or not shown:
            return None
        contours = self.outlines.of(shown)
        borders = sum(int(np.count_nonzero(contour.across >= 0)) for contour in contours)
        return [contour.points for contour in contours], borders

    def _with(self, union: _Union) -> Structure:
        """Unite two layers."""
        lower, upper = union.lower, union.upper
        layers, masks = list(self.layers), self.masks.copy()
        one, other = dataclasses.replace(layers[lower], outlines=union.outlines), layers[upper]
        shown = one.shown | other.shown
        color = self.regions.one_color(shown)[0]
        layers[union.place] = Layer([*one.outlines, *other.outlines], color, shown, exact=one.exact)
        masks[union.place] = mask_of(one, masks.shape[1:]) | masks[upper]
        gone = lower + upper - union.place
        del layers[gone]
        return Structure.of(self.regions, layers, self.ground, np.delete(masks, gone, axis=0), *self._kept)


def mask_of(layer: Layer, size: tuple[int, int]) -> BoolArray:
    """Rasterize a layer's outlines to pixels (H, W)."""
    winding = np.zeros(size, np.int64)
    for points in layer.outlines:
        interruption.check()
        winding[polygon_mask(points, size)] += int(np.sign(polygon_area(points)))
    return np.asarray(winding != 0)


def explained_miss(regions: FlatRegions) -> float:
    """Return the largest residual of an explained pixel."""
    return EXPLAINED + EXPLAINED_OF_NOISE * regions.noise


def _gain_over(regions: SmoothRegions, layer: Layer, shown: BoolArray) -> float:
    """Return the squared error that an overlay removes, at pixels (H, W)."""
    paint, points = regions.paint(layer.shown), pixel_centers(shown)
    below, whole = (dataclasses.replace(paint, over=paint.over[:count]) for count in (layer.over - 1, layer.over))
    return float(np.square(whole.at(points) - below.at(points)).sum())


def painted(regions: FlatRegions, layers: list[Layer], ground: FloatArray, numbers: IntArray) -> FloatArray:
    """Return the picture (H, W, C) of the layers with the given indices (H, W), 1 for the lowest, 0 for the ground."""
    image = np.stack([ground, *(layer.color for layer in layers)])[numbers]
    if isinstance(regions, SmoothRegions):
        for number, layer in enumerate(layers, start=1):
            if not layer.over and not regions.paint(layer.shown).solid:
                interruption.check()
                mask = numbers == number
                image[mask] = regions.shown(layer.shown, mask)
    return np.asarray(image)
