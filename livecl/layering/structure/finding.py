# SPDX-License-Identifier: Apache-2.0
"""Find the structure of a flat or smoothly shaded picture: its layers, ranked, if these explain it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.layering.fills.ramps import Shading
from livecl.layering.outlines.contours import Outlines
from livecl.layering.outlines.prices import PRICES
from livecl.layering.segmentation.flat import FlatRegions, clean_regions, flatness, noisy_regions
from livecl.layering.segmentation.paper import lit_regions
from livecl.layering.segmentation.smooth import SmoothRegions, smooth_regions, smoothness, unmixed
from livecl.layering.structure.layers import PLAIN, Assumptions, Layer, find_layers
from livecl.layering.structure.mosaic import MOST_PARTS, Mosaic, mosaic_of
from livecl.layering.structure.parts import with_more_parts, with_parts
from livecl.layering.structure.ranking import EXPLAINED, Structure, explained_miss, mask_of
from livecl.layering.structure.views import ground_regions, screens

#: Least share of the pixels that large regions must explain for a picture to count as flat, and pixels of a large
#: region.
FLAT_SHARE, LARGE_REGION = 0.97, 16
#: Least share of the pixels in flat or smooth cores; otherwise the picture is not segmented. Gradients have at least
#: .64 in smooth cores, photographs at most .27.
CORE_SHARE = 0.5
#: The same for a picture that noise explains but that may be clean: gradients have at least .93, icons saved as JPEG at
#: most .92. This affects the time only, as the cheaper explanation is chosen.
CLEAN_SHARE = 0.9
#: Largest share of pixels outside smooth cores that mix no nearby colours, for the cores to be split: twice the share
#: that regions may leave unexplained. In 19 pictures of gradients and clip art it was at most .037, in 6 photographs,
#: which take minutes to split, at least .17. This affects the time only.
UNMIXED_SHARE = 2 * (1 - FLAT_SHARE)
#: Largest share of neighbouring pixels in a flat picture that differ slightly though both lie in flat cores, as bands
#: of shading do: at most .0001 in 340 flat drawings, more than .002 in 27 of 36 gradients, of which the others are
#: steeper.
MOST_BANDS = 0.002
#: Most regions of a flat picture per 256 x 256 pixels.
MOST_REGIONS = 150
#: Largest share of the pixels within regions that the layers may show wrongly: a shape completed over one in front of
#: it hides that one, which training hardly recovers. 26 of 30 icons have less than 0.01, the others 0.02 to 0.05, which
#: training corrects; a logo in which a whole wave was hidden has 0.22.
MAX_MISTAKEN = 0.1
#: Mean squared error up to which the first explanation is accepted; otherwise the one of least error. Pixels decide
#: first.
SHOWN = 2e-4
#: Share of the pixels within regions that a layer may show wrongly; above it, the layer is joined with no other shape:
#: the bridge between two shapes hides what lies between.
LAYER_MISTAKEN = 0.002
#: Share of slightly differing neighbouring pixels from which shading is sought: flat pictures have hardly any.
SOME_SLOPES = 0.004
#: Largest requested number of layers, as a multiple of those found, that is a request: more is a limit.
MOST_ASKED = 2


def found_structure(
    target: NDArray[Any],
    background: NDArray[Any] | None,
    most: int,
    shading: Shading | None = None,
    asked: int = 0,
) -> Structure | None:
    """Return the structure of a picture in at most `most` layers; None if no structure explains it.

    The target (H, W, C) is RGB, or premultiplied RGBA without a background (3,). Layers may have the gradients of
    `shading`; a picture without slopes is treated as flat. If a flat picture shows fewer layers than `asked`, but at
    least half of them, its shapes are cut at concave corners until there are as many, or none can be cut; with 0, the
    picture decides.
    """
    return _explaining(*_frozen(target, background), (most, asked), shading)


def structure_of(
    target: NDArray[Any], background: NDArray[Any] | None, most: int, shading: Shading | None = None, asked: int = 0
) -> Structure:
    """Return the structure of a picture, or of its flat regions if none explains it. Arguments as above."""
    pixels = _frozen(target, background)
    found = _explaining(*pixels, (most, asked), shading)
    return found or _of_outlines(_parts(*pixels), np.array(pixels[2]))


def _frozen(target: NDArray[Any], background: NDArray[Any] | None) -> tuple[bytes, tuple[int, ...], tuple[float, ...]]:
    ground = (0.0,) * target.shape[2] if background is None else tuple(float(v) for v in background)
    pixels = np.ascontiguousarray(target, dtype=np.float32)
    return pixels.tobytes(), pixels.shape, ground


@functools.lru_cache(maxsize=2)
def _explaining(
    data: bytes,
    shape: tuple[int, ...],
    ground: tuple[float, ...],
    numbers: tuple[int, int],
    shading: Shading | None,
) -> Structure | None:
    pixels = np.frombuffer(data, np.float32).reshape(shape)
    mosaic = mosaic_of(pixels)
    if mosaic is not None and mosaic.enlarged and mosaic.num_parts > MOST_PARTS:
        return _judged_mosaic(mosaic, np.array(ground), numbers[0])
    found = _explained_by_regions(data, shape, ground, numbers, shading)
    if found is None and mosaic is not None and (mosaic.enlarged or mosaic.repeats):
        return _judged_mosaic(mosaic, np.array(ground), numbers[0])
    return found


def _judged_mosaic(mosaic: Mosaic, ground: FloatArray, most: int) -> Structure | None:
    """Return the structure of pixel art, if at most `most` layers show the picture; else None."""
    found = mosaic.layers(ground, most)
    return None if found is None else _judged(Structure.of(found[0], found[1], ground, found[2]), most)


def _explained_by_regions(
    data: bytes,
    shape: tuple[int, ...],
    ground: tuple[float, ...],
    numbers: tuple[int, int],
    shading: Shading | None,
) -> Structure | None:
    """Return the structure of flat or smoothly shaded regions that explains a picture, if one does."""
    pixels = np.frombuffer(data, np.float32).reshape(shape)
    noisy, price = _noisy(data, shape), 0.0
    if noisy is not None and not _many_explained(noisy):
        noisy = None
    kinds: list[FlatRegions] = [] if noisy is None else [noisy]
    interruption.check()
    flat = flatness(pixels)
    interruption.check()
    if shading is not None and flat.slopes > SOME_SLOPES:
        price = shading.price_in(pixels[..., 0].size)
        lit = lit_regions(pixels, price, shading.kinds) if noisy is None else None
        kinds += _shaded(lit)
        if smoothness(pixels) >= (CLEAN_SHARE if kinds else CORE_SHARE) and unmixed(pixels, EXPLAINED) <= UNMIXED_SHARE:
            kinds += _shaded(smooth_regions(pixels, price, shading.kinds))
    # What was taken for noise may be slopes: the cheaper explanation comes first.
    for regions in sorted(kinds, key=lambda regions: regions.cost(price)):
        if isinstance(regions, SmoothRegions):
            found = _explained(Outlines(regions), np.array(ground), numbers[0])
            explaining = found if found is not None and found.shaded else None
        else:
            explaining = _judged_flat(data, shape, ground, numbers)
        if explaining is not None:
            return explaining
    if flat.cored < CORE_SHARE or flat.bands > MOST_BANDS or flat.cores > _most_regions(shape):
        return None
    return _judged_flat(data, shape, ground, numbers) if _many_explained(_regions(data, shape)) else None


def _shaded(regions: SmoothRegions | None) -> list[SmoothRegions]:
    """Return the regions, if they explain a picture and any has a gradient; else none."""
    return [regions] if regions is not None and _many_explained(regions) and regions.shaded else []


def _judged_flat(
    data: bytes, shape: tuple[int, ...], ground: tuple[float, ...], numbers: tuple[int, int]
) -> Structure | None:
    """Return the structure of a flat picture, if it shows it, for most layers and layers asked for."""
    most, asked = numbers
    outlines, over = _parts(data, shape, ground), np.array(ground)
    found = _explained(outlines, over, most)
    if found is None or not len(found.ranked) < asked <= MOST_ASKED * len(found.ranked):
        return found
    return _with_more_layers(found, outlines, over, most, asked)


def _with_more_layers(found: Structure, outlines: Outlines, ground: FloatArray, most: int, asked: int) -> Structure:
    """Return a structure of up to as many layers as asked for, by other assumptions, one after another.

    Nothing is seen through holes; regions are cut into more parts; nothing is joined.
    """
    assumed = PLAIN
    if screens(outlines, ground_regions(outlines, ground)):
        on_top = Assumptions(views="none")
        more = _explained(outlines, ground, most, on_top)
        if _is_better(more, found, asked):
            found, assumed = more, on_top
    cut = with_more_parts(outlines, asked - len(found.ranked))
    if cut is not outlines:
        more = _explained(cut, ground, cut.count, assumed)
        if _is_better(more, found, asked):
            found, outlines = more, cut
    joined = frozenset(k for layer in found.layers if len(layer.shown) > 1 for k in layer.shown)
    if joined and len(found.ranked) < asked:
        more = _explained(outlines, ground, most, dataclasses.replace(assumed, apart=joined))
        if _is_better(more, found, asked):
            return more
    return found


def _is_better(more: Structure | None, found: Structure, asked: int) -> TypeGuard[Structure]:
    """Whether a structure has more layers than another one, as asked for, and shows the picture as well.

    More than asked for would share a path again, and not those that are one.
    """
    if more is None or more.error > max(found.error, SHOWN):
        return False
    return len(found.ranked) < len(more.ranked) <= asked


def _explained(outlines: Outlines, ground: FloatArray, most: int, assumed: Assumptions = PLAIN) -> Structure | None:
    """Return the first explanation that shows a picture well in at most `most` layers, or that of least error."""
    best: Structure | None = None
    for explanation in _explanations(outlines, ground, assumed):
        found = _judged(explanation, most)
        if found is not None and (best is None or found.error < best.error):
            best = found
        if best is not None and best.error <= SHOWN:
            break
    return best


def _explanations(outlines: Outlines, ground: FloatArray, assumed: Assumptions) -> Iterator[Structure]:
    """Yield explanations under one list of assumptions: those given, all views through holes, fewer and fewer joins.

    Layers that hide visible regions are joined with no others, as long as that lowers the error.
    """
    untried = [(assumed, np.inf)]
    if assumed.views == "cheaper" and screens(outlines, ground_regions(outlines, ground)):
        untried.append((dataclasses.replace(assumed, views="all"), np.inf))
    while untried:
        assumed, before = untried.pop(0)
        found = _of_outlines(outlines, ground, assumed)
        yield found
        hiding = found.mistaken_by(LAYER_MISTAKEN) if found.error < before else []
        if hiding:
            apart = assumed.apart.union(*(layer.shown for layer in hiding))
            untried.append((dataclasses.replace(assumed, apart=apart), found.error))


@functools.lru_cache(maxsize=2)
def _parts(data: bytes, shape: tuple[int, ...], ground: tuple[float, ...]) -> Outlines:
    return with_parts(_regions(data, shape), np.array(ground))


@functools.lru_cache(maxsize=2)
def _regions(data: bytes, shape: tuple[int, ...]) -> FlatRegions:
    noisy = _noisy(data, shape)
    return clean_regions(np.frombuffer(data, np.float32).reshape(shape)) if noisy is None else noisy


@functools.lru_cache(maxsize=2)
def _noisy(data: bytes, shape: tuple[int, ...]) -> FlatRegions | None:
    return noisy_regions(np.frombuffer(data, np.float32).reshape(shape))


def _most_regions(shape: tuple[int, ...]) -> float:
    return MOST_REGIONS * max(1.0, shape[0] * shape[1] / 65536)


def _many_explained(regions: FlatRegions) -> bool:
    """Whether a moderate number of regions, large ones, explains nearly all pixels."""
    large = regions.sizes[regions.labels] >= LARGE_REGION
    explained = float(np.mean(large & (regions.miss <= explained_miss(regions))))
    return explained >= FLAT_SHARE and len(regions.sizes) <= _most_regions(regions.labels.shape)


def _judged(found: Structure, most: int) -> Structure | None:
    """Return a structure, united to at most `most` layers, if all its layers together show the picture; else None."""
    return found.united(most) if len(found.ranked) and found.mistaken <= MAX_MISTAKEN else None


def _of_outlines(outlines: Outlines, ground: FloatArray, assumed: Assumptions = PLAIN) -> Structure:
    regions = outlines.regions
    layers, size = find_layers(outlines, ground, PRICES, assumed), regions.labels.shape
    if isinstance(regions, SmoothRegions):
        layers = [one for layer in layers for one in (layer, *_over(layer, regions))]
    masks = np.array([mask_of(layer, size) for layer in layers], bool).reshape(-1, *size)
    return Structure.of(regions, layers, ground, masks, outlines)


def _over(layer: Layer, regions: SmoothRegions) -> list[Layer]:
    """Return the overlays of a layer's fill as layers, on the same outline."""
    fills = regions.paint(layer.shown).over
    return [
        dataclasses.replace(layer, color=paint.stops[0, : len(layer.color)], over=place)
        for place, paint in enumerate(fills, start=1)
    ]
