# SPDX-License-Identifier: Apache-2.0
"""Candidates for new paths: regions with fitted outlines, ranked by the squared error that each path removes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, Window
from livecl.drawing.drawing import Drawing
from livecl.geometry.fitting import fit_outlines
from livecl.geometry.outlines import Outline, circle, random_outline, reversed_path
from livecl.image.errors import visible_error
from livecl.layering.componentwise.amodal import amodally_completed
from livecl.layering.componentwise.components import Place
from livecl.layering.componentwise.masks import border, filled_and_holes, holes, without_holes
from livecl.layering.componentwise.painting import Painting, Trial
from livecl.layering.context import Context
from livecl.layering.neighbors import SAME_COLOR
from livecl.layering.regions import Region, RegionFinder
from livecl.layering.stack import WHOLE, meet, window_of
from livecl.options import OPAQUE_FROM, Options

#: Smallest region, pixels, whose border is traced (about 4 px across); smaller ones become circles of equal area.
SMALL_REGION = 12
#: Price of a segment in squared error: half of a pixel that is wrong in one channel.
SEGMENT_ERROR = 0.5
#: Transmittance from which the ground counts as visible.
BARE = 0.9
#: Alpha below which a region counts as transparent (5 levels of 255); paint cannot make a picture more transparent.
CLEAR = 0.02


@dataclasses.dataclass(frozen=True, kw_only=True)
class Search:
    """Effort of the search for a new path, and the gain required of it.

    Effects of regions, depths and holes: docs/quality.md, "Choices of the default method", measured with these values.
    Where no source is named, no comparison of other values is recorded.
    """

    regions: int = 12  # regions whose own pixels are tried for each new path
    outlined: int = 3  # regions tried with an outline once one has lowered the error; all until then
    holes: int = 8  # largest holes tried for each region
    roughness: float = 1.05  # safety factor on the subsampled gain estimate of a region
    #: Share of `Options.prune` that a new layer must remove before training: training increases its gain, most where
    #: edges are soft. With 0.2 instead of 1, soft pictures on white end at .055 instead of .093 (mean error x 1000), 40
    #: faces at .470 instead of .475 (docs/notes/quality.md).
    worth_training: float = 0.2
    #: Share of the removed error that each segment beyond `Options.segments` must add; at most `SEGMENT_ERROR`.
    gain_per_segment: float = 0.001


SEARCH = Search()


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A candidate layer: its outline, its fill as straight RGBA (4,), and the trial at its best depth."""

    outline: Outline
    rgba: FloatArray
    trial: Trial

    @property
    def num_segments(self) -> int:
        """Number of segments of all subpaths."""
        return sum(map(len, self.outline))

    def beside(self, depth: int, window: Window) -> Candidate | None:
        """Return the candidate after another layer was inserted at `depth`; None if it overlaps the changed window."""
        if meet(self.trial.window, window):
            return None
        own = self.trial.depth
        return dataclasses.replace(self, trial=dataclasses.replace(self.trial, depth=own + (own >= depth)))


def paint_of(color: ArrayLike) -> FloatArray:
    """Return the fill, straight RGBA (4,), that shows a colour over transparency: RGB, or premultiplied RGBA, (C,)."""
    color = np.asarray(color, dtype=np.float64)
    alpha = color[3] if len(color) == 4 else 1.0
    opacity = 1.0 if alpha >= OPAQUE_FROM else max(alpha, CLEAR)
    return np.array([*np.clip(color[:3] / max(alpha, CLEAR), 0, 1), opacity])


def paint_over(ground: ArrayLike, color: ArrayLike) -> FloatArray:
    """Return the fill, straight RGBA (4,), that changes one premultiplied RGBA (4,) into another, clipped to [0, 1].

    Paint of colour c = (r, g, b, 1) and opacity o over G shows (1 - o) G + o c; so, from the alphas,
    o = (A - A_G) / (1 - A_G), and c follows.
    """
    ground, color = np.asarray(ground, dtype=np.float64), np.asarray(color, dtype=np.float64)
    opacity = np.clip((color[3] - ground[3]) / max(1 - ground[3], CLEAR), CLEAR, 1)
    return np.array([*np.clip((color - (1 - opacity) * ground)[:3] / opacity, 0, 1), opacity])


def initial_outline(place: Place, size: tuple[int, int], options: Options, rng: np.random.Generator) -> Outline:
    """Return the initial outline of a new path at a place, on a canvas of `size`."""
    if options.shape == "random":
        return [random_outline(place.center, options.segments, size, rng)]
    if options.shape == "outline" and place.mask is not None:
        return [fitted_paths(place.mask, options.segments)[-1]]
    return [circle(place.center, options.radius, options.segments)]


def region_candidates(context: Context, painting: Painting, count: int, rng: np.random.Generator) -> list[Candidate]:
    """Return the candidate paths that remove most error, found greedily, each inserted at its best depth.

    Fewer than `count` are returned if no other would be worth keeping (`Options.prune`); the first layer of a picture
    is never omitted.
    """
    judge = _Judge(context, painting, rng)
    found = []
    least = SEARCH.worth_training * context.options.prune * 3 * painting.target[..., 0].size
    for _ in range(count):
        best = judge.best(least)
        if best is None and len(painting.stack.order):
            break
        found.append(best or judge.circle())
        judge.accept(found[-1])
    return found


@dataclasses.dataclass
class _Guess:
    """Estimate for a region as a layer: mask (h, w) within a window, fill, estimated gain, and outline if fitted."""

    window: Window
    mask: BoolArray
    rgba: FloatArray
    gain: float
    candidate: Candidate | None = None


@dataclasses.dataclass(frozen=True)
class _Tried:
    """Cached trial of a region, valid until something changes within `window` or becomes hidden within `reach`."""

    guesses: list[_Guess]
    window: Window
    reach: Window


class _Judge:
    """Tries regions as layers of a painting.

    Trials are cached until a layer changes their window: with many small regions, most of them stay valid.
    """

    def __init__(self, context: Context, painting: Painting, rng: np.random.Generator) -> None:
        self._painting, self._stack = painting, painting.stack
        self._rasterizer, self._options = context.rasterizer, context.options
        self._rng = rng
        self._finder = RegionFinder(context.partitions, painting.stack.image.astype(np.float64))
        self._error = np.zeros(0)
        self._tried: dict[tuple[int, int], _Tried] = {}
        self._outlines: dict[Any, list[Outline]] = {}

    def best(self, least: float) -> Candidate | None:
        """Return the candidate that removes most squared error; None if none removes more than `least`."""
        self._error = self._painting.error.astype(np.float64)
        best: Candidate | None = None
        guesses = [guess for region in self._regions() for guess in self._as_it_is(region).guesses]
        for number, guess in enumerate(sorted(guesses, key=lambda guess: -guess.gain)):
            # No outline is better than the region itself; and one that helps is looked for among all of them.
            most = least if best is None else best.trial.gain
            if SEARCH.roughness * guess.gain <= most or (best is not None and number >= SEARCH.outlined):
                break
            interruption.check()
            candidate = guess.candidate or self._outlined(guess)
            if self._options.shape == "outline":  # others are drawn anew
                guess.candidate = candidate
            if candidate.trial.gain > most:
                best = candidate
        return best

    def circle(self) -> Candidate:
        """Return a circle at the pixel of largest error."""
        error = self._painting.error
        row, column = np.unravel_index(int(np.argmax(error)), error.shape)
        outline = [circle((column + 0.5, row + 0.5), self._options.radius, self._options.segments)]
        return self._candidates([outline], paint_of(self._painting.target[row, column]))[0]

    def accept(self, candidate: Candidate) -> None:
        """Insert a layer into the painting, and drop the cached trials that it invalidates."""
        hidden, depth = self._stack.hidden, candidate.trial.depth
        changed = self._painting.insert(candidate.trial)
        covered = window_of(self._stack.hidden != hidden)
        self._tried = {
            key: tried
            for key, tried in self._tried.items()
            if not meet(tried.window, changed) and not meet(tried.reach, covered)
        }
        for guess in (guess for tried in self._tried.values() for guess in tried.guesses):
            if guess.candidate is not None:
                guess.candidate = guess.candidate.beside(depth, changed)

    def _regions(self) -> Iterator[Region]:
        """Yield the regions to try: those with the largest error that are not transparent."""
        for region in self._finder.best(self._error, SEARCH.regions):
            interruption.check()
            if len(region.color) == 3 or region.color[3] >= CLEAR:
                yield region

    def _as_it_is(self, region: Region) -> _Tried:
        """Estimate the gain of a region's own pixels as a layer, with holes filled or kept and the best fill."""
        if region.key in self._tried:
            return self._tried[region.key]
        whole = region.mask
        window = reach = window_of(whole)
        pixels = whole[window]
        fills = [paint_of(region.color)]
        if fills[0][3] < 1:
            fills.append(paint_over(self._stack.image[window][pixels].mean(axis=0), region.color))
        filled, inner = filled_and_holes(pixels, SMALL_REGION)
        interruption.check()
        masks = [(window, filled)]
        if self._options.shape == "outline":
            opened = self._opened(window, filled, inner, region.color)
            if opened is not None:
                masks.append((window, opened))
        if self._options.holes and self._options.shape == "outline":
            interruption.check()
            completion = amodally_completed(whole, region.alike, self._stack.hidden)
            reach = completion.reach
            if completion.mask is not None:
                masks.append((completion.window, without_holes(completion.mask)))
        guesses = []
        for place, mask in masks:
            trials = [(self._try([mask], rgba, place, roughly=True)[0].gain, n) for n, rgba in enumerate(fills)]
            gain, number = max(trials)
            guesses.append(_Guess(place, mask, fills[number], gain))
        self._tried[region.key] = tried = _Tried(guesses, masks[-1][0], reach)
        return tried

    def _opened(self, window: Window, filled: BoolArray, inner: list[BoolArray], color: FloatArray) -> BoolArray | None:
        """Return a filled region without the holes that are better left unpainted; None if there are none.

        Without `Options.holes`, only holes that show the ground are left open, as in a ring.
        """
        target, error = self._painting.target[window], self._error[window]
        bare = self._stack.transmittances[0][window]
        opened = []
        for hole in inner[: SEARCH.holes]:
            interruption.check()
            painted = np.square(visible_error(target[hole] - color)).sum()
            shows_ground = bare[hole].min() > BARE and np.median(error[hole]) <= SAME_COLOR**2
            if error[hole].sum() < painted and (self._options.holes or shows_ground):
                opened.append(hole)
        return filled & ~np.logical_or.reduce(opened) if opened else None

    def _outlined(self, guess: _Guess) -> Candidate:
        """Fit an outline to a region, with more than `segments` segments where each removes enough error."""
        options, size = self._options, (self._stack.image.shape[0], self._stack.image.shape[1])
        if options.shape != "outline":
            place = _place(guess.window, guess.mask)
            return self._candidates([initial_outline(place, size, options, self._rng)], guess.rgba)[0]
        key = guess.window[0].start, guess.window[1].start, guess.mask.shape, guess.mask.tobytes()
        outlines = self._outlines.get(key) or fitted_outlines(guess.mask, options, guess.window)
        self._outlines[key] = outlines
        best, *others = self._candidates(outlines, guess.rgba)
        for candidate in others:
            share = min(SEARCH.gain_per_segment * best.trial.gain, SEGMENT_ERROR)
            if candidate.trial.gain > best.trial.gain + share * (candidate.num_segments - best.num_segments):
                best = candidate
        return best

    def _candidates(self, outlines: list[Outline], rgba: FloatArray) -> list[Candidate]:
        drawing = Drawing.from_outlines(outlines, (0, 0, 0, 1), self._rasterizer.size)
        trials = self._try(self._rasterizer.coverages(drawing), rgba)
        return [Candidate(outline, rgba, trial) for outline, trial in zip(outlines, trials, strict=True)]

    def _try(
        self, coverages: Iterable[NDArray[Any]], rgba: FloatArray, window: Window = WHOLE, roughly: bool = False
    ) -> list[Trial]:
        color = np.ones(self._painting.target.shape[2])
        color[:3] = rgba[:3]
        opacity = np.float32(rgba[3])
        return self._painting.try_layers([opacity * coverage for coverage in coverages], color, window, roughly)


def _place(window: Window, mask: BoolArray) -> Place:
    center = np.add(np.argwhere(mask), (window[0].start, window[1].start)).mean(axis=0)[::-1] + 0.5
    return Place(center, np.floor(center[::-1]).astype(np.int64))


def fitted_outlines(mask: BoolArray, options: Options, window: Window = WHOLE) -> list[Outline]:
    """Fit outlines of `segments` to `max_segments` segments to a region (h, w) in a window, holes included."""
    corner = (window[1].start or 0, window[0].start or 0)
    inner = [reversed_path(fitted_paths(hole, options.segments, corner)[-1]) for hole in holes(mask, SMALL_REGION)]
    outer = fitted_paths(mask, max(options.segments, options.max_segments), corner)
    return [[path, *inner] for path in outer[options.segments - 1 :]]


def fitted_paths(mask: BoolArray, most: int, corner: tuple[int, int] = (0, 0)) -> list[FloatArray]:
    """Fit paths of 1, 2, ... `most` segments to a region (h, w) with its corner at `corner` (x, y), holes filled."""
    area = int(mask.sum())
    if area < SMALL_REGION:
        center = (np.argwhere(mask) + corner[::-1]).mean(axis=0)[::-1] + 0.5
        return [circle(center, np.sqrt(area / np.pi), segments) for segments in range(1, most + 1)]
    return fit_outlines(border(mask) + corner, most)
