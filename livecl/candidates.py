# SPDX-License-Identifier: Apache-2.0
"""Candidates for new paths: regions with outlines fitted to them, judged by the error that the very path removes."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.components import Place
from livecl.drawing import Drawing
from livecl.options import Options
from livecl.outline import border, circle, fit_outline, holes, random_outline, reversed_path
from livecl.painting import Painting, Trial
from livecl.rasterizer import Rasterizer
from livecl.regions import Region, RegionFinder

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
#: Subpaths (s, 3, 2) of a layer, px.
Outline = list[FloatArray]

#: Regions that are looked at closely for each new path, and as long as none of them would lower the error.
CANDIDATES, MOST_CANDIDATES = 12, 48
#: Pixels under which a region is too small for its border to tell more than a circle of its area.
SMALL_REGION = 12
#: Share of the removed error that each segment beyond `segments` must add.
GAIN_PER_SEGMENT = 0.001
#: Alpha from which on paint starts opaque, and under which a region counts as clear: no paint makes a picture clearer.
OPAQUE_FROM, CLEAR = 0.9, 0.02
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
        return [_fitted(place.mask, options.segments)]
    return [circle(place.center, options.radius, options.segments)]


def region_candidates(
    painting: Painting, count: int, options: Options, rng: np.random.Generator, rasterizer: Rasterizer
) -> list[Candidate]:
    """Return the paths that remove most error, one after the other, each put into the painting where it does best."""
    finder = RegionFinder(painting.target.astype(np.float64), painting.image.astype(np.float64))
    judge = _Judge(painting, options, rng, rasterizer)
    found = []
    for _ in range(count):
        found.append(judge.best(finder))
        painting.insert(found[-1].trial)
    return found


class _Judge:
    """Tries regions as layers of a painting."""

    def __init__(self, painting: Painting, options: Options, rng: np.random.Generator, rasterizer: Rasterizer) -> None:
        self._painting = painting
        self._options = options
        self._rng = rng
        self._rasterizer = rasterizer

    def best(self, finder: RegionFinder) -> Candidate:
        """Return the best candidate; where no region lowers the error, a circle at its largest pixel."""
        best: Candidate | None = None
        best_region: Region | None = None
        error = self._painting.error.astype(np.float64)
        for number, region in enumerate(finder.best(error, MOST_CANDIDATES)):
            # No path can do better than the region itself.
            if best is not None and (region.gain <= best.trial.gain or number >= CANDIDATES):
                break
            if len(region.color) == 4 and region.color[3] < CLEAR:
                continue
            candidate = self._of_region(region)
            if candidate.trial.gain > (0.0 if best is None else best.trial.gain):
                best, best_region = candidate, region
        if best is None or best_region is None:
            row, column = np.unravel_index(int(np.argmax(error)), error.shape)
            outline = [circle((column + 0.5, row + 0.5), self._options.radius, self._options.segments)]
            return self._candidate(outline, paint_of(self._painting.target[row, column]))
        return self._finer(best, best_region) if self._options.shape == "outline" else best

    def _of_region(self, region: Region) -> Candidate:
        members = np.argwhere(region.mask)
        center = members.mean(axis=0)[::-1] + 0.5
        place = Place(center, np.floor(center[::-1]).astype(np.int64), region.mask)
        options, outline = self._options, initial_outline(place, region.mask.shape, self._options, self._rng)
        fills = [paint_of(region.color)]
        if fills[0][3] < 1:
            fills.append(paint_over(self._painting.image[region.mask].mean(axis=0), region.color))
        whole = max((self._candidate(outline, rgba) for rgba in fills), key=_gain)
        if not (options.holes and options.shape == "outline"):
            return whole
        opened = [hole for hole in holes(region.mask, SMALL_REGION)[:MOST_HOLES] if self._differs(hole, region.color)]
        if not opened:
            return whole
        outline = [*whole.outline, *(reversed_path(_fitted(hole, options.segments)) for hole in opened)]
        return max(whole, self._candidate(outline, whole.rgba), key=_gain)

    def _differs(self, hole: BoolArray, color: FloatArray) -> bool:
        """Whether the picture in a hole is better as it is than painted over."""
        painted = np.square(self._painting.target[hole] - color).sum()
        return bool(self._painting.error[hole].sum() < painted)

    def _finer(self, best: Candidate, region: Region) -> Candidate:
        """Take more segments for the outer border where each adds enough."""
        options, first = self._options, best
        for segments in range(options.segments + 1, options.max_segments + 1):
            outline = [_fitted(region.mask, segments), *first.outline[1:]]
            candidate = self._candidate(outline, best.rgba)
            needed = GAIN_PER_SEGMENT * best.trial.gain * (candidate.num_segments - best.num_segments)
            if candidate.trial.gain > best.trial.gain + needed:
                best = candidate
        return best

    def _candidate(self, outline: Outline, rgba: FloatArray) -> Candidate:
        color = np.ones(self._painting.target.shape[2])
        color[:3] = rgba[:3]
        return Candidate(outline, rgba, self._painting.try_layer(rgba[3] * self._coverage(outline), color))

    def _coverage(self, outline: Outline) -> NDArray[Any]:
        height, width = self._painting.target.shape[:2]
        white = Drawing(
            points=np.concatenate(outline),
            colors=[[1, 1, 1, 1]],
            size=(height, width),
            background=(0, 0, 0),
            subpath_offsets=np.cumsum([0, *map(len, outline)]),
            layer_offsets=[0, len(outline)],
        )
        return self._rasterizer.forward(white)[..., 0]


def _gain(candidate: Candidate) -> float:
    return candidate.trial.gain


def _fitted(mask: BoolArray, segments: int) -> FloatArray:
    """Return the path around a region (H, W); holes are filled."""
    area = int(mask.sum())
    if area < SMALL_REGION:
        return circle(np.argwhere(mask).mean(axis=0)[::-1] + 0.5, np.sqrt(area / np.pi), segments)
    return fit_outline(border(mask), segments)
