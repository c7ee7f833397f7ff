# SPDX-License-Identifier: Apache-2.0
"""Candidates for new paths: regions with outlines fitted to them, judged by the error that the very path removes."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.geometry.fitting import fit_outlines
from livecl.geometry.outlines import border, circle, holes, random_outline, reversed_path, without_holes
from livecl.image.alpha import error_seen
from livecl.layering.amodal import completed
from livecl.layering.components import Place
from livecl.layering.painting import Painting, Trial
from livecl.layering.regions import Region, RegionFinder
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
#: Subpaths (s, 3, 2) of a layer, px.
Outline = list[FloatArray]

#: Regions that are tried as they are for each new path; and how many are tried with an outline once one of them has
#: lowered the error: until then all are.
CANDIDATES, CLOSE_CANDIDATES = 12, 3
#: Pixels under which a region is too small for its border to tell more than a circle of its area.
SMALL_REGION = 12
#: What the gain of a region tried roughly may be too small by.
ROUGHNESS = 1.05
#: Share of what a layer must remove to be kept that a new one must remove where it is placed: training makes more of
#: it, most where edges are soft.
WORTH_TRAINING = 0.2
#: What each segment beyond `segments` must add: a share of the error removed or, if that is less, a squared error: half
#: of a pixel that is wrong in one channel.
GAIN_PER_SEGMENT, SEGMENT_ERROR = 0.001, 0.5
#: Alpha from which on paint starts opaque, and under which a region counts as clear: no paint makes a picture clearer.
OPAQUE_FROM, CLEAR = 0.9, 0.02
#: Regions whose outlines are remembered.
REMEMBERED = 256
#: Holes of a region that are looked at.
MOST_HOLES = 8


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A new layer: its outline, its fill as straight RGBA (4,), and what it does at its best depth."""

    outline: Outline
    rgba: FloatArray
    trial: Trial

    @property
    def num_segments(self) -> int:
        """Segments of all subpaths."""
        return sum(map(len, self.outline))


def paint_of(color: ArrayLike) -> FloatArray:
    """Return the fill, straight RGBA (4,), that shows a colour over nothing: RGB, or premultiplied RGBA, (C,)."""
    color = np.asarray(color, dtype=np.float64)
    alpha = color[3] if len(color) == 4 else 1.0
    opacity = 1.0 if alpha >= OPAQUE_FROM else max(alpha, CLEAR)
    return np.array([*np.clip(color[:3] / max(alpha, CLEAR), 0, 1), opacity])


def paint_over(ground: ArrayLike, color: ArrayLike) -> FloatArray:
    """Return the fill, straight RGBA (4,), that turns one premultiplied RGBA (4,) into another where paint can do so.

    Paint of colour c = (r, g, b, 1) and opacity o over G shows (1 - o) G + o c; so, from the alphas,
    o = (A - A_G) / (1 - A_G), and c follows.
    """
    ground, color = np.asarray(ground, dtype=np.float64), np.asarray(color, dtype=np.float64)
    opacity = np.clip((color[3] - ground[3]) / max(1 - ground[3], CLEAR), CLEAR, 1)
    return np.array([*np.clip((color - (1 - opacity) * ground)[:3] / opacity, 0, 1), opacity])


def initial_outline(place: Place, size: tuple[int, int], options: Options, rng: np.random.Generator) -> Outline:
    """Return what a new path at a place looks like, on a canvas of `size`."""
    if options.shape == "random":
        return [random_outline(place.center, options.segments, size, rng)]
    if options.shape == "outline" and place.mask is not None:
        return [fitted(place.mask, options.segments)[-1]]
    return [circle(place.center, options.radius, options.segments)]


def region_candidates(
    painting: Painting,
    count: int,
    options: Options,
    rng: np.random.Generator,
    rasterizer: Rasterizer,
    check: Callable[[], None] = lambda: None,
) -> list[Candidate]:
    """Return the paths that remove most error, one after the other, each put into the painting where it does best.

    They are fewer than `count` where none is left that would come to be worth keeping (`Options.prune`); the first
    layer of a picture is never left out. `check` is called before each region that is tried; what it raises ends the
    search.
    """
    finder = RegionFinder(painting.target.astype(np.float64), painting.image.astype(np.float64), check)
    judge = _Judge(painting, options, rng, rasterizer, check)
    found = []
    least = WORTH_TRAINING * options.prune * 3 * painting.target[..., 0].size
    for _ in range(count):
        best = judge.best(finder, least)
        if best is None and len(painting.order):
            break
        found.append(best or judge.circle())
        painting.insert(found[-1].trial)
    return found


class _Judge:
    """Tries regions as layers of a painting."""

    def __init__(
        self,
        painting: Painting,
        options: Options,
        rng: np.random.Generator,
        rasterizer: Rasterizer,
        check: Callable[[], None],
    ) -> None:
        self._painting = painting
        self._check = check
        self._options = options
        self._rng = rng
        self._rasterizer = rasterizer
        self._error = np.zeros(0)

    def best(self, finder: RegionFinder, least: float) -> Candidate | None:
        """Return the candidate that removes most squared error; None where none removes more than `least`."""
        error = self._error = self._painting.error.astype(np.float64)
        best: Candidate | None = None
        tried = [trial for region in self._regions(finder, error) for trial in self._as_they_are(region)]
        for number, (gain, mask, rgba) in enumerate(sorted(tried, key=lambda item: -item[0])):
            # No outline is better than the region itself; and one that helps is looked for among all of them.
            most = least if best is None else best.trial.gain
            if ROUGHNESS * gain <= most or (best is not None and number >= CLOSE_CANDIDATES):
                break
            self._check()
            candidate = self._outlined(mask, rgba)
            if candidate.trial.gain > most:
                best = candidate
        return best

    def circle(self) -> Candidate:
        """Return a circle where the largest error is."""
        error = self._painting.error
        row, column = np.unravel_index(int(np.argmax(error)), error.shape)
        outline = [circle((column + 0.5, row + 0.5), self._options.radius, self._options.segments)]
        return self._candidates([outline], paint_of(self._painting.target[row, column]))[0]

    def _regions(self, finder: RegionFinder, error: FloatArray) -> Iterator[Region]:
        """Yield the regions to look at: those that hold most error, and are not clear."""
        for region in finder.best(error, CANDIDATES):
            self._check()
            if len(region.color) == 3 or region.color[3] >= CLEAR:
                yield region

    def _as_they_are(self, region: Region) -> Iterator[tuple[float, BoolArray, FloatArray]]:
        """Yield what a region's own pixels would remove as a layer, without holes and with them, and in which fill."""
        fills = [paint_of(region.color)]
        if fills[0][3] < 1:
            fills.append(paint_over(self._painting.image[region.mask].mean(axis=0), region.color))
        masks = [without_holes(region.mask)]
        if self._options.holes and self._options.shape == "outline":
            opened = self._opened(region, masks[0])
            if opened is not None:
                masks.append(opened)
            joined = completed(region.mask, region.alike, self._painting.hidden)
            if joined is not None:
                masks.append(without_holes(joined))
        for mask in masks:
            trials = [(self._try([mask], rgba, roughly=True)[0].gain, number) for number, rgba in enumerate(fills)]
            gain, number = max(trials)
            yield gain, mask, fills[number]

    def _opened(self, region: Region, filled: BoolArray) -> BoolArray | None:
        """Return the region with those holes in which the picture is better as it is; None if there are none."""
        opened = [hole for hole in holes(region.mask, SMALL_REGION)[:MOST_HOLES] if self._differs(hole, region.color)]
        return filled & ~np.logical_or.reduce(opened) if opened else None

    def _differs(self, hole: BoolArray, color: FloatArray) -> bool:
        """Whether the picture in a hole is better as it is than painted over."""
        painted = np.square(error_seen(self._painting.target[hole] - color)).sum()
        return bool(self._error[hole].sum() < painted)

    def _outlined(self, mask: BoolArray, rgba: FloatArray) -> Candidate:
        """Return a layer with an outline around a region, of more segments than `segments` where each adds enough."""
        options = self._options
        if options.shape != "outline":
            return self._candidates([initial_outline(_place(mask), mask.shape, options, self._rng)], rgba)[0]
        best, *others = self._candidates(fitted_outlines(mask, options), rgba)
        for candidate in others:
            share = min(GAIN_PER_SEGMENT * best.trial.gain, SEGMENT_ERROR)
            if candidate.trial.gain > best.trial.gain + share * (candidate.num_segments - best.num_segments):
                best = candidate
        return best

    def _candidates(self, outlines: list[Outline], rgba: FloatArray) -> list[Candidate]:
        trials = self._try(self._rasterizer.coverages(layers_of(outlines, self._painting.target.shape[:2])), rgba)
        return [Candidate(outline, rgba, trial) for outline, trial in zip(outlines, trials, strict=True)]

    def _try(self, coverages: Iterable[NDArray[Any]], rgba: FloatArray, roughly: bool = False) -> list[Trial]:
        color = np.ones(self._painting.target.shape[2])
        color[:3] = rgba[:3]
        opacity = np.float32(rgba[3])
        return self._painting.try_layers([opacity * coverage for coverage in coverages], color, roughly)


def layers_of(outlines: list[Outline], size: tuple[int, ...], rgba: ArrayLike = (0, 0, 0, 1)) -> Drawing:
    """Return outlines as layers, on a canvas of `size`, in one fill or one for each: straight RGBA, (4,) or (N, 4)."""
    subpaths = [subpath for outline in outlines for subpath in outline]
    return Drawing(
        points=np.concatenate([np.zeros((0, 3, 2)), *subpaths]),
        colors=np.broadcast_to(rgba, (len(outlines), 4)),
        size=(size[0], size[1]),
        subpath_offsets=np.cumsum([0, *map(len, subpaths)]),
        layer_offsets=np.cumsum([0, *map(len, outlines)]),
    )


def _place(mask: BoolArray) -> Place:
    center = np.argwhere(mask).mean(axis=0)[::-1] + 0.5
    return Place(center, np.floor(center[::-1]).astype(np.int64), mask)


def fitted_outlines(mask: BoolArray, options: Options) -> list[Outline]:
    """Return outlines around a region (H, W) and its holes, of `segments` to `max_segments` segments for the border."""
    inner = [reversed_path(fitted(hole, options.segments)[-1]) for hole in holes(mask, SMALL_REGION)]
    outer = fitted(mask, max(options.segments, options.max_segments))
    return [[path, *inner] for path in outer[options.segments - 1 :]]


def fitted(mask: BoolArray, most: int) -> Sequence[FloatArray]:
    """Return paths of 1, 2, ... `most` segments around a region (H, W); holes are filled.

    The last ones are remembered, as the regions of a picture are looked at again for each new path.
    """
    return _fitted(np.packbits(mask).tobytes(), mask.shape, most)


@functools.lru_cache(maxsize=REMEMBERED)
def _fitted(packed: bytes, shape: tuple[int, ...], most: int) -> tuple[FloatArray, ...]:
    mask = np.unpackbits(np.frombuffer(packed, np.uint8), count=math.prod(shape)).reshape(shape).astype(bool)
    area = int(mask.sum())
    if area < SMALL_REGION:
        center = np.argwhere(mask).mean(axis=0)[::-1] + 0.5
        paths = [circle(center, np.sqrt(area / np.pi), segments) for segments in range(1, most + 1)]
    else:
        paths = fit_outlines(border(mask), most)
    for path in paths:
        path.flags.writeable = False  # they are shared
    return tuple(paths)
