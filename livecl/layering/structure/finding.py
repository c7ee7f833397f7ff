# SPDX-License-Identifier: Apache-2.0
"""Structure of a picture, flat or of smoothly shaded regions: its layers, ranked, and whether they explain it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing.fills import SOLID, Fills
from livecl.layering.ramps import Shading
from livecl.layering.structure.contours import Outlines
from livecl.layering.structure.flat import SAME_COLOR, FlatRegions, flat_regions, flatness
from livecl.layering.structure.layers import Layer, find_layers
from livecl.layering.structure.mosaic import MOST_PARTS, Mosaic, mosaic_of
from livecl.layering.structure.noise import noise_level
from livecl.layering.structure.parts import with_parts
from livecl.layering.structure.smooth import SmoothRegions, smooth_regions, smoothness

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

#: Share of the pixels that regions of some size must explain for a picture to count as flat, and that size, px.
FLAT_SHARE, LARGE_REGION = 0.97, 16
#: Share of its pixels that flat cores must hold, or smooth ones: else it is not looked at any further. Pictures of
#: gradients have .64 and more in smooth ones, photographs .27 at most.
CORE_SHARE = 0.5
#: Largest share of neighbouring pixels that differ a little, as on slopes of shading.
MOST_SLOPES = 0.02
#: Most regions of a flat picture, for each of its 256 x 256 pixels.
MOST_REGIONS = 150
#: What a pixel's colour may miss and still count as explained: a constant, and for each unit of noise.
EXPLAINED, EXPLAINED_OF_NOISE = 12 / 255, 6.0
#: Share of the pixels within regions that the layers may show wrongly: a shape completed over what lies in front of it
#: hides that, and training does not bring much of it back. 26 of 30 icons have less than 0.01, the others 0.02 to 0.05,
#: which training mends; a logo of which a whole wave was hidden 0.22.
MAX_MISTAKEN = 0.1
#: Mean squared error that the layers may hold for which there are too few paths: as much as regions leave on faces at 8
#: paths, which paint several shapes with one path then.
MAX_LEFT_OUT = 5e-4
#: Share of neighbouring pixels that differ a little from which on shading is looked for: a flat picture has hardly any.
SOME_SLOPES = 0.004
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
        Layer that shows at each pixel, 1 for the lowest; 0 where the ground does.
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
        for number, mask in enumerate(masks, start=1):
            second[mask], top[mask] = top[mask], number
        lost = np.square(_painted(regions, layers, ground, top) - _painted(regions, layers, ground, second)).sum(
            axis=-1
        )
        gains = np.bincount(top.ravel(), lost.ravel(), len(layers) + 1)[1:].astype(np.float64)
        shown = np.bincount(top.ravel(), minlength=len(layers) + 1)[1:]
        order = np.argsort(-gains, kind="stable")
        ranked = order[(gains[order] >= LEAST_GAIN) | (shown[order] >= LEAST_PIXELS)]
        return cls(regions, layers, ground, masks, top, gains, ranked)

    def fills_of(self, layer: int) -> Fills:
        """Return the fill of a layer."""
        if isinstance(self.regions, SmoothRegions):
            return self.regions.paint(self.layers[layer].shown).fills
        return Fills.solid(1)

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
        regions = self.regions
        inner = ndimage.minimum_filter(regions.labels, 3) == ndimage.maximum_filter(regions.labels, 3)
        seen = _painted(regions, self.layers, self.ground, self.top)
        wanted = regions.image if isinstance(regions, SmoothRegions) else regions.colors[regions.labels]
        miss = np.abs(seen - wanted).max(axis=-1)
        return float(np.mean(miss[inner] > _explained(regions))) if inner.any() else 0.0

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
            if around is None or np.count_nonzero(self.masks[around] & own) < INSIDE * np.count_nonzero(own):
                continue
            below = [k for k in range(around) if (self.masks[k] & own).any()]
            if below:
                lower = below[-1]
                if np.count_nonzero(self.masks[lower] & own) < INSIDE * np.count_nonzero(own):
                    continue
                if self.regions.rise(self.layers[lower].shown, self.layers[layer].shown) > 0:
                    continue
            elif (
                np.abs(self.layers[layer].color - self.ground).max() > SAME_COLOR or self.fills_of(layer).any_gradients
            ):
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


def found_structure(
    target: NDArray[Any],
    background: NDArray[Any] | None,
    most: int,
    shading: Shading | None = None,
    check: Callable[[], None] = lambda: None,
) -> Structure | None:
    """Return the structure of a picture; None where none explains it in about as many layers as are wanted.

    Parameters
    ----------
    target : (H, W, C) array
        RGB, or premultiplied RGBA where there is no background.
    background : (3,) array or None
        Colour beneath all layers.
    most : int
        Layers wanted.
    shading : Shading, optional
        Gradients that layers may have; a picture without slopes is flat all the same.
    check : callable
        Called several times a second; what it raises ends the search.
    """
    return _explaining(*_frozen(target, background), most, shading, _Check(check))


def structure_of(
    target: NDArray[Any], background: NDArray[Any] | None, most: int, shading: Shading | None = None
) -> Structure:
    """Return the structure of a picture; that of its flat regions where none explains it. Arguments as above."""
    pixels = _frozen(target, background)
    check = _Check(lambda: None)
    return _explaining(*pixels, most, shading, check) or _flat(*pixels, check)


def _frozen(target: NDArray[Any], background: NDArray[Any] | None) -> tuple[bytes, tuple[int, ...], tuple[float, ...]]:
    ground = (0.0,) * target.shape[2] if background is None else tuple(float(v) for v in background)
    pixels = np.ascontiguousarray(target, dtype=np.float32)
    return pixels.tobytes(), pixels.shape, ground


@dataclasses.dataclass(frozen=True)
class _Check:
    """A callback that no result depends on: to a cache all are one."""

    call: Callable[[], None] = dataclasses.field(compare=False)


@functools.lru_cache(maxsize=2)
def _explaining(
    data: bytes, shape: tuple[int, ...], ground: tuple[float, ...], most: int, shading: Shading | None, check: _Check
) -> Structure | None:
    pixels = np.frombuffer(data, np.float32).reshape(shape)
    mosaic = mosaic_of(pixels)
    if mosaic is not None and mosaic.enlarged and mosaic.num_parts > MOST_PARTS:
        return _judged_mosaic(mosaic, np.array(ground), most)
    found = _explained_by_regions(data, shape, ground, most, shading, check)
    if found is None and mosaic is not None and (mosaic.enlarged or mosaic.repeats):
        return _judged_mosaic(mosaic, np.array(ground), most)
    return found


def _judged_mosaic(mosaic: Mosaic, ground: FloatArray, most: int) -> Structure | None:
    """Return the layers of pixel art, where as many as are wanted show the picture; else None."""
    found = mosaic.layers(ground, most)
    return None if found is None else _judged(Structure.of(found[0], found[1], ground, found[2]), most)


def _explained_by_regions(
    data: bytes, shape: tuple[int, ...], ground: tuple[float, ...], most: int, shading: Shading | None, check: _Check
) -> Structure | None:
    """Return the structure of flat or smoothly shaded regions that explains a picture, if one does."""
    pixels = np.frombuffer(data, np.float32).reshape(shape)
    if noise_level(pixels.astype(np.float64)):
        flat = _regions(data, shape)
        if flat.noise and _many_explained(flat):
            explaining = _judged(_flat(data, shape, ground, check), most)
            if explaining is not None:
                return explaining
    share, slopes, cores = flatness(pixels)
    if shading is not None and slopes > SOME_SLOPES and smoothness(pixels) >= CORE_SHARE:
        regions = smooth_regions(pixels, shading.price_in(pixels[..., 0].size), shading.kinds)
        if _many_explained(regions) and regions.shaded:
            found = _structure_of(regions, np.array(ground), check)
            if found.shaded and (explaining := _judged(found, most)) is not None:
                return explaining
    if share < CORE_SHARE or slopes > MOST_SLOPES or cores > _most_regions(shape):
        return None
    return _judged(_flat(data, shape, ground, check), most) if _many_explained(_regions(data, shape)) else None


@functools.lru_cache(maxsize=2)
def _flat(data: bytes, shape: tuple[int, ...], ground: tuple[float, ...], check: _Check) -> Structure:
    return _structure_of(_regions(data, shape), np.array(ground), check)


@functools.lru_cache(maxsize=2)
def _regions(data: bytes, shape: tuple[int, ...]) -> FlatRegions:
    return flat_regions(np.frombuffer(data, np.float32).reshape(shape))


def _most_regions(shape: tuple[int, ...]) -> float:
    return MOST_REGIONS * max(1.0, shape[0] * shape[1] / 65536)


def _explained(regions: FlatRegions) -> float:
    """Return what a pixel's colour may miss and still count as explained."""
    return EXPLAINED + EXPLAINED_OF_NOISE * regions.noise


def _many_explained(regions: FlatRegions) -> bool:
    """Whether not too many regions of some size explain nearly all pixels."""
    large = regions.sizes[regions.labels] >= LARGE_REGION
    explained = float(np.mean(large & (regions.miss <= _explained(regions))))
    return explained >= FLAT_SHARE and len(regions.sizes) <= _most_regions(regions.labels.shape)


def _judged(found: Structure, most: int) -> Structure | None:
    """Return a structure, united for a number of layers, where these show the picture; else None."""
    if not len(found.ranked) or found.mistaken > MAX_MISTAKEN:
        return None
    found = found.united(most)
    left_out = found.gains[found.ranked[most:]].sum()
    return found if left_out <= MAX_LEFT_OUT * found.top.size * len(found.ground) else None


def _structure_of(regions: FlatRegions, ground: FloatArray, check: _Check) -> Structure:
    from skimage.draw import polygon2mask

    smooth = isinstance(regions, SmoothRegions)
    outlines = Outlines(regions) if smooth else with_parts(regions, ground, check.call)
    layers, size, regions = find_layers(outlines, ground, check.call), regions.labels.shape, outlines.regions
    masks = np.zeros((len(layers), *size), bool)
    for mask, layer in zip(masks, layers, strict=True):
        for points in layer.outlines:
            mask ^= polygon2mask(size, points[:, ::-1] - 0.5)
    return Structure.of(regions, layers, ground, masks)


def _painted(regions: FlatRegions, layers: list[Layer], ground: FloatArray, numbers: IntArray) -> FloatArray:
    """Return the picture (H, W, C) of the layers that numbers (H, W) name, 1 for the lowest, 0 for the ground."""
    image = np.stack([ground, *(layer.color for layer in layers)])[numbers]
    if isinstance(regions, SmoothRegions):
        for number, layer in enumerate(layers, start=1):
            if regions.paint(layer.shown).kind != SOLID:
                mask = numbers == number
                image[mask] = regions.shown(layer.shown, mask)
    return np.asarray(image)
