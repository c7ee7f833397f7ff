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
from livecl.metrics import layer_alphas
from livecl.options import Options
from livecl.outline import border, circle, fit_outline, random_outline
from livecl.painting import Painting, Trial
from livecl.rasterizer import Rasterizer
from livecl.regions import RegionFinder

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

Coverage = Callable[[FloatArray], NDArray[Any]]

#: Regions that are looked at closely for each new path, and as long as none of them would lower the error.
CANDIDATES, MOST_CANDIDATES = 12, 48
#: Pixels under which a region is too small for its border to tell more than a circle of its area.
SMALL_REGION = 12
#: Share of the removed error that each segment beyond `segments` must add.
GAIN_PER_SEGMENT = 0.001


@dataclasses.dataclass(frozen=True)
class Placement:
    """New layers, and where they go.

    Attributes
    ----------
    drawing : Drawing
        Only the K new layers.
    order : (N + K,) int
        Paint order of all, bottom first: the N old layers by their numbers, the new ones from N on.
    """

    drawing: Drawing
    order: NDArray[np.intp]


def place_paths(
    target: NDArray[Any],
    drawing: Drawing,
    count: int,
    options: Options,
    rng: np.random.Generator,
    rasterizer: Rasterizer,
) -> Placement:
    """Return `count` new layers for what a drawing still lacks of the target.

    Parameters
    ----------
    target : (H, W, 3) array
        The picture wanted.
    drawing : Drawing
        What there is so far, with a background.
    count : int
        Number of layers.
    options : Options
        Placement rule, shape and colours.
    rng : numpy.random.Generator
        Source of whatever is random.
    rasterizer : Rasterizer
        One of the drawing's size.

    Returns
    -------
    Placement
        Regions may lie below layers that there are already; all else goes on top.
    """

    def coverage(shape: FloatArray) -> NDArray[Any]:
        white = Drawing(points=shape, colors=[[1, 1, 1, 1]], size=drawing.size, background=(0, 0, 0))
        return rasterizer.forward(white)[..., 0]

    image = rasterizer.forward(drawing)
    if options.placement == "region":
        assert drawing.background is not None
        alphas = layer_alphas(drawing, rasterizer)
        painting = Painting(target, image, drawing.background, alphas, drawing.colors[:, :3])

        def shape_of(mask: BoolArray) -> FloatArray:
            center = np.argwhere(mask).mean(axis=0)[::-1] + 0.5
            return _shape(Place(center, np.floor(center[::-1]).astype(np.int64), mask), drawing.size, options, rng)

        paths = _region_paths(painting, count, options, coverage, shape_of)
        colors = np.array([[*np.clip(color, 0, 1), 1] for _, color in paths])
        if options.new_color == "random":
            colors = rng.uniform(size=(count, 4))
        return Placement(_layers([shape for shape, _ in paths], colors, drawing.size), painting.order)
    new = _scattered_paths(target, image, count, options, rng)
    return Placement(new, np.arange(drawing.num_layers + new.num_layers))


def _scattered_paths(
    target: NDArray[Any], image: NDArray[Any], count: int, options: Options, rng: np.random.Generator
) -> Drawing:
    """Paths on the largest components, or anywhere."""
    size = target.shape[:2]
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
    painting: Painting, count: int, options: Options, coverage: Coverage, shape_of: Callable[[BoolArray], FloatArray]
) -> list[tuple[FloatArray, FloatArray]]:
    """Paths that remove most error, one after the other, each put into the painting where it does best."""
    finder = RegionFinder(painting.target.astype(np.float64), painting.image.astype(np.float64))
    shapes = []
    for _ in range(count):
        shape, trial = _best_path(finder, painting, options, coverage, shape_of)
        painting.insert(trial)
        shapes.append((shape, trial.color.astype(np.float64)))
    return shapes


def _best_path(
    finder: RegionFinder,
    painting: Painting,
    options: Options,
    coverage: Coverage,
    shape_of: Callable[[BoolArray], FloatArray],
) -> tuple[FloatArray, Trial]:
    best: tuple[FloatArray, Trial] | None = None
    best_mask = None
    error = painting.error.astype(np.float64)
    for number, region in enumerate(finder.best(error, MOST_CANDIDATES)):
        # No path can do better than the region itself.
        if best is not None and (region.gain <= best[1].gain or number >= CANDIDATES):
            break
        shape = shape_of(region.mask)
        trial = painting.try_layer(coverage(shape), region.color)
        if trial.gain > (0.0 if best is None else best[1].gain):
            best, best_mask = (shape, trial), region.mask
    if best is None or best_mask is None:
        row, column = np.unravel_index(int(np.argmax(error)), error.shape)
        shape = circle((column + 0.5, row + 0.5), options.radius, options.segments)
        return shape, painting.try_layer(coverage(shape), painting.target[row, column])
    if options.shape == "outline":
        for segments in range(options.segments + 1, options.max_segments + 1):
            shape = _region_outline(best_mask, segments)
            trial = painting.try_layer(coverage(shape), best[1].color)
            needed = GAIN_PER_SEGMENT * best[1].gain * (segments - len(best[0]))
            if trial.gain > best[1].gain + needed:
                best = shape, trial
    return best
