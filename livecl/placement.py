# SPDX-License-Identifier: Apache-2.0
"""Where the next paths start, what they look like, and in which colour.

`component` is the paper's component-wise path initialization, steps a-d; `region` takes the regions whose painting
would remove most error, judged by the coverage of the very path that would be added.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.components import Place, component_places
from livecl.drawing import Drawing
from livecl.options import Options
from livecl.outline import border, circle, fit_outline, random_outline
from livecl.regions import RegionFinder

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

#: Regions that are looked at closely for each new path.
CANDIDATES = 12
#: Pixels under which a region is too small for its border to tell more than a circle of its area.
SMALL_REGION = 12
#: Share of the removed error that each segment beyond `segments` must add.
GAIN_PER_SEGMENT = 0.001


def place_paths(
    target: NDArray[Any],
    image: NDArray[Any],
    count: int,
    options: Options,
    rng: np.random.Generator,
    coverage: Callable[[FloatArray], NDArray[Any]],
) -> Drawing:
    """Return `count` new layers for what the image still lacks of the target.

    Parameters
    ----------
    target, image : (H, W, 3) array
        What is wanted, and what is rendered so far.
    count : int
        Number of layers.
    options : Options
        Placement rule, shape and colours.
    rng : numpy.random.Generator
        Source of whatever is random.
    coverage : callable
        Gives the coverage (H, W) of one closed path (s, 3, 2).

    Returns
    -------
    Drawing
        Only the new layers, in paint order.
    """
    size = target.shape[:2]
    if options.placement == "region":
        return _region_paths(target.astype(np.float64), image.astype(np.float64), count, options, coverage)
    if options.placement == "random":
        centers = rng.uniform(size=(count, 2)) * (size[1], size[0])
        places = [Place(center, np.floor(center[::-1]).astype(np.int64)) for center in centers]
    else:
        places = component_places(target, image, count, options)
    shapes = [_shape(place, size, options, rng) for place in places]
    if options.new_color == "random":
        colors = rng.uniform(size=(count, 4))
    else:
        colors = np.ones((count, 4))
        colors[:, :3] = [target[tuple(place.pixel)][:3] for place in places]
    return _layers(shapes, colors, size)


def _layers(shapes: list[FloatArray], colors: FloatArray, size: tuple[int, int]) -> Drawing:
    subpath_offsets = np.cumsum([0, *map(len, shapes)])
    return Drawing(
        points=np.concatenate(shapes),
        colors=colors,
        size=size,
        subpath_offsets=subpath_offsets,
        layer_offsets=np.arange(len(shapes) + 1),
    )


def _shape(place: Place, size: tuple[int, int], options: Options, rng: np.random.Generator) -> FloatArray:
    if options.shape == "random":
        return random_outline(place.center, options.segments, size, rng)
    if options.shape == "outline" and place.mask is not None:
        return _region_outline(place.mask, options.segments)
    return circle(place.center, options.radius, options.segments)


def _region_outline(mask: BoolArray, segments: int) -> FloatArray:
    area = int(mask.sum())
    if area < SMALL_REGION:
        return circle(np.argwhere(mask).mean(axis=0)[::-1] + 0.5, np.sqrt(area / np.pi), segments)
    return fit_outline(border(mask), segments)


def _region_paths(
    target: FloatArray,
    image: FloatArray,
    count: int,
    options: Options,
    coverage: Callable[[FloatArray], NDArray[Any]],
) -> Drawing:
    """Paths that remove most error, one after the other, each on the picture that those before it leave."""
    finder = RegionFinder(target, image)
    strokes = []
    for _ in range(count):
        stroke = _best_stroke(finder, target, image, options, coverage)
        strokes.append(stroke)
        image = stroke.image
    colors = np.array([[*np.clip(stroke.color, 0, 1), 1] for stroke in strokes])
    return _layers([stroke.shape for stroke in strokes], colors, target.shape[:2])


@dataclasses.dataclass(frozen=True)
class _Stroke:
    """A path (s, 3, 2), its colour, the picture with it, and the squared error that it removes."""

    shape: FloatArray
    color: FloatArray
    image: FloatArray
    gain: float


def _best_stroke(
    finder: RegionFinder,
    target: FloatArray,
    image: FloatArray,
    options: Options,
    coverage: Callable[[FloatArray], NDArray[Any]],
) -> _Stroke:
    error = np.square(target - image).sum(axis=-1)

    def paint(shape: FloatArray, color: FloatArray) -> _Stroke:
        painted = image + coverage(shape)[..., None] * (color - image)
        return _Stroke(shape, color, painted, float((error - np.square(target - painted).sum(axis=-1)).sum()))

    best, best_mask = None, None
    for region in finder.best(error, CANDIDATES):
        if best is not None and region.gain <= best.gain:  # no path can do better than the region itself
            break
        stroke = paint(_new_shape(region.mask, options), region.color)
        if stroke.gain > (0.0 if best is None else best.gain):
            best, best_mask = stroke, region.mask
    if best is None or best_mask is None:
        row, column = np.unravel_index(int(np.argmax(error)), error.shape)
        return paint(circle((column + 0.5, row + 0.5), options.radius, options.segments), target[row, column])
    if options.shape == "outline":
        for segments in range(options.segments + 1, options.max_segments + 1):
            stroke = paint(_region_outline(best_mask, segments), best.color)
            needed = GAIN_PER_SEGMENT * best.gain * (segments - len(best.shape))
            if stroke.gain > best.gain + needed:
                best = stroke
    return best


def _new_shape(mask: BoolArray, options: Options) -> FloatArray:
    if options.shape == "outline":
        return _region_outline(mask, options.segments)
    return circle(np.argwhere(mask).mean(axis=0)[::-1] + 0.5, options.radius, options.segments)
