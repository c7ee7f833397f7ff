# SPDX-License-Identifier: Apache-2.0
"""Layers of a picture, ranked by the error that each removes; united, or made holes, where there are too many."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing.fills import Fills
from livecl.layering.structure.cores import pixel_centers
from livecl.layering.structure.flat import SAME_COLOR, FlatRegions
from livecl.layering.structure.layers import Layer
from livecl.layering.structure.smooth import SmoothRegions

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

#: What a pixel's colour may miss and still count as explained: a constant, and for each unit of noise.
EXPLAINED, EXPLAINED_OF_NOISE = 12 / 255, 6.0
#: Squared error that a layer must remove, in channels of a pixel that are wholly wrong; or pixels that must show it.
LEAST_GAIN, LEAST_PIXELS = 3.0, 64
#: Share of a layer that must lie within another one to become a hole of it.
INSIDE = 0.98
#: Layers beyond the number wanted, as a share of it and more, that are looked at for uniting.
UNITED_SHARE, UNITED_MORE = 2, 12


@dataclasses.dataclass(frozen=True, eq=False)
class Structure:
    """Layers of a picture.

    Attributes
    ----------
    regions : FlatRegions
        What they show.
    layers : list of Layer
        The lowest first.
    ground : (C,) float
        What shows where there are none.
    masks : (N, H, W) bool
        Pixels within each layer's outlines.
    top : (H, W) int
        Layer that shows at each pixel, 1 for the lowest; 0 where the ground does. Of fills over each other, the lowest.
    gains : (N,) float
        Squared error that each removes.
    ranked : (K,) int
        Layers worth having, those that remove most first.
    """

    regions: FlatRegions
    layers: list[Layer]
    ground: FloatArray
    masks: BoolArray
    top: IntArray
    gains: FloatArray
    ranked: NDArray[np.intp]

    @classmethod
    def of(cls, regions: FlatRegions, layers: list[Layer], ground: FloatArray, masks: BoolArray) -> Structure:
        """Rank layers by the error that each removes."""
        size = regions.labels.shape
        top, second = np.zeros((2, *size), np.int64)
        for number, (mask, layer) in enumerate(zip(masks, layers, strict=True), start=1):
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
        return cls(regions, layers, ground, masks, top, gains, ranked)

    def fills_of(self, layer: int) -> Fills:
        """Return the fill of a layer."""
        if isinstance(self.regions, SmoothRegions):
            paint, over = self.regions.paint(self.layers[layer].shown), self.layers[layer].over
            return paint.over[over - 1].fills if over else paint.fills
        return Fills.solid(1)

    def shows(self, layers: IntArray) -> BoolArray:
        """Return the pixels (H, W) at which any of some layers (K,) show."""
        lowest = [int(k) - self.layers[k].over for k in layers]
        return np.isin(self.top, np.array(lowest, np.int64) + 1)

    def _overlaid(self, layer: int) -> bool:
        """Whether a layer is one of several fills over each other."""
        return bool(self.layers[layer].over or (layer + 1 < len(self.layers) and self.layers[layer + 1].over))

    @property
    def shaded(self) -> bool:
        """Whether any layer worth having has a gradient."""
        return any(self.fills_of(k).any_gradients for k in self.ranked)

    @property
    def exact(self) -> bool:
        """Whether the outlines are those of pixel art, which stay as they are."""
        return any(layer.exact for layer in self.layers)

    @property
    def mistaken(self) -> float:
        """Share of the pixels within regions at which the layers, painted over each other, show something else."""
        wrong, inner = self._wrong
        return float(wrong.sum() / max(inner, 1))

    def mistaken_by(self, least: float) -> list[Layer]:
        """Return the layers that show something else at more than a share of the pixels within regions each."""
        wrong, inner = self._wrong
        counts = np.bincount(self.top[wrong], minlength=len(self.layers) + 1)[1:]
        return [self.layers[k] for k in np.flatnonzero(counts > least * inner)]

    @functools.cached_property
    def _wrong(self) -> tuple[BoolArray, int]:
        """Pixels within regions at which the layers show something else, (H, W), and how many are within regions."""
        regions = self.regions
        inner = ndimage.minimum_filter(regions.labels, 3) == ndimage.maximum_filter(regions.labels, 3)
        seen = painted(regions, self.layers, self.ground, self.top)
        wanted = regions.image if isinstance(regions, SmoothRegions) else regions.colors[regions.labels]
        miss = np.abs(seen - wanted).max(axis=-1)
        return inner & (miss > explained_miss(regions)), int(inner.sum())

    def united(self, most: int) -> Structure:
        """Unite layers of one fill, where at most `most` are wanted and less is lost by it than by leaving one out.

        One path has several parts then, as the artist's own would have.
        """
        regions, found = self.regions, self
        rises: dict[frozenset[frozenset[int]], float] = {}
        while len(found.ranked) > most:
            if isinstance(regions, SmoothRegions) and (opened := found._with_a_hole()) is not None:
                found = opened
                continue
            best: tuple[float, float, int, int, int] | None = None
            looked_at = np.sort(found.ranked[: UNITED_SHARE * most + UNITED_MORE]).tolist()
            looked_at = [k for k in looked_at if not found._overlaid(k)]
            for i, lower in enumerate(looked_at):
                for upper in looked_at[i + 1 :]:
                    pair = found.layers[lower].shown, found.layers[upper].shown
                    if (key := frozenset(pair)) not in rises:
                        rises[key] = regions.rise(*pair)
                    lost = rises[key], float(found.gains[lower] + found.gains[upper])
                    if not np.isfinite(lost[0]) or (best is not None and lost >= best[:2]):
                        continue
                    place = found._place_of_both(lower, upper)
                    if place is not None:
                        best = *lost, lower, upper, place
            if best is not None and best[0] <= found.gains[found.ranked[-1]]:
                found = found._with_both(*best[2:])
            elif (opened := found._with_a_hole()) is not None:
                found = opened
            else:
                break
        return found

    def _with_a_hole(self) -> Structure | None:
        """Cut a layer out of the one that it lies on, as a hole, where the same shows below; the smallest first."""
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
            return Structure.of(self.regions, layers, self.ground, np.delete(masks, layer, axis=0))
        return None

    def _place_of_both(self, lower: int, upper: int) -> int | None:
        """Return which of two layers' places both may have; None where what lies between overlaps either."""
        between = self.masks[lower + 1 : upper].any(axis=0)
        for place, moved in ((lower, upper), (upper, lower)):
            if not (between & self.masks[moved]).any():
                return place
        return None

    def _with_both(self, lower: int, upper: int, place: int) -> Structure:
        layers, masks = list(self.layers), self.masks.copy()
        one, other = layers[lower], layers[upper]
        larger = one if self.masks[lower].sum() >= self.masks[upper].sum() else other
        outlines = [*one.outlines, *other.outlines]
        layers[place] = Layer(outlines, larger.color, one.shown | other.shown, exact=one.exact)
        masks[place] = masks[lower] | masks[upper]
        gone = lower + upper - place
        del layers[gone]
        return Structure.of(self.regions, layers, self.ground, np.delete(masks, gone, axis=0))


def explained_miss(regions: FlatRegions) -> float:
    """Return what a pixel's colour may miss and still count as explained."""
    return EXPLAINED + EXPLAINED_OF_NOISE * regions.noise


def _gain_over(regions: SmoothRegions, layer: Layer, shown: BoolArray) -> float:
    """Return the squared error that a fill removes over others on the same outline, at pixels (H, W)."""
    paint, points = regions.paint(layer.shown), pixel_centers(shown)
    below, whole = (dataclasses.replace(paint, over=paint.over[:count]) for count in (layer.over - 1, layer.over))
    return float(np.square(whole.at(points) - below.at(points)).sum())


def painted(regions: FlatRegions, layers: list[Layer], ground: FloatArray, numbers: IntArray) -> FloatArray:
    """Return the picture (H, W, C) of the layers that numbers (H, W) name, 1 for the lowest, 0 for the ground."""
    image = np.stack([ground, *(layer.color for layer in layers)])[numbers]
    if isinstance(regions, SmoothRegions):
        for number, layer in enumerate(layers, start=1):
            if not layer.over and not regions.paint(layer.shown).solid:
                mask = numbers == number
                image[mask] = regions.shown(layer.shown, mask)
    return np.asarray(image)
