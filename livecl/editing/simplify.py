# SPDX-License-Identifier: Apache-2.0
"""Make outlines editable, the last step of a run: describe each with few nodes or as a shape, where that pays.

A description costs its numbers, as SVG writes them, plus the squared error that it adds to the picture. The cheapest is
chosen: the present outline, one with few nodes, or a circle, an ellipse or a rectangle.
"""

from __future__ import annotations

import functools
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.assembly import outlines_of, with_outlines
from livecl.drawing.borders import border_pairs
from livecl.drawing.drawing import Drawing
from livecl.editing.constraints import SHORT, Joins
from livecl.editing.outline import Fit, editable_outlines
from livecl.editing.polish import polished
from livecl.editing.shapes import fitted_shapes
from livecl.editing.tidying import tidied
from livecl.editing.trace import SampledOutline, sampled
from livecl.geometry import cyclic
from livecl.geometry.bezier import signed_area
from livecl.geometry.outlines import Outline
from livecl.geometry.untangle import find_crossings, parted
from livecl.image.errors import visible_error
from livecl.layering.componentwise.candidates import SEGMENT_ERROR
from livecl.layering.context import Context
from livecl.layering.contributions import composited_colors, in_window, layer_alphas, opacity_at_pixels
from livecl.layering.stack import over, window_of
from livecl.svg.outline_data import MAX_PRECISION, format_outline, rounded_points
from livecl.svg.path_data import NUMBER
from livecl.svg.primitives import Primitive, primitive_of

#: Least squared error that a number is worth (a segment has six); share of the error added by a description that
#: remains after training.
NUMBER_ERROR, LEFT = SEGMENT_ERROR / 36, 0.15
#: Range of alpha of a layer's edge pixels; median over mean of a squared normal variable.
EDGE, MEDIAN_SQUARE = (0.02, 0.98), 0.455
#: Fits tried, from coarse to fine.
FITS = (Fit(), Fit(tolerance=0.2, straight=0.15, straying=12.0))
#: Weight of samples hidden by layers above; largest transmittance of a hidden sample.
HIDDEN_WEIGHT, HIDDEN = 0.25, 0.6
#: Most subpaths of a layer that are described individually; more are all described in one way.
MOST_APART = 24
#: Sine of its turn from which on a corner costs no more than others.
FLAT = 0.5
#: Decimals at which numbers are counted.
PRECISION = 3

_NUMBER = re.compile(NUMBER)


def editable(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> Drawing:
    """Make the outlines of the layers that are `free`, (N,), editable where that pays.

    Parameters
    ----------
    context : Context
        Rasterizer, target and options (`Options.simplify`, `Options.primitives`).
    drawing : Drawing
        Any drawing; strokes, and shapes that have one, stay as they are.
    free : (N,) bool
        Layers that may change.
    """
    options = context.options
    if not (options.simplify or options.primitives) or not drawing.num_layers:
        return drawing
    movable = free & (drawing.strokes.widths == 0)
    movable[border_pairs(drawing)] = False
    paints = _Paints(drawing)
    drawing = _without_crossings(context, drawing, movable, paints)
    editor = _Editor(context, drawing, LEFT, paints)
    outlines: list[Outline] = []
    for layer, outline in enumerate(outlines_of(drawing)):
        interruption.check()
        if movable[layer]:
            outline = editor.best(layer, outline)
        outlines.append(outline)
        editor.advance(layer)
    edited = with_outlines(drawing, outlines)
    edited = polished(context, edited, movable)
    edited = _without_crossings(context, _verified(context, drawing, edited, paints), movable, paints)
    pairs = zip(outlines_of(drawing), outlines_of(edited), editor.number_errors, strict=True)
    saved = sum((price_of(before) - price_of(after)) * error for before, after, error in pairs)
    rise = (context.visible_mse(edited) - context.visible_mse(drawing)) * 3 * drawing.size[0] * drawing.size[1]
    return edited if rise <= max(saved, 0) else drawing


def _without_crossings(context: Context, drawing: Drawing, free: NDArray[np.bool_], paints: _Paints) -> Drawing:
    """Return a drawing whose outlines of the layers that are `free`, (N,), fall into parts where they cross themselves.

    The parts show the same; those that cost more than they show are left out, as loops within the others are.
    """
    outlines = outlines_of(drawing)
    subpaths = [_closed(subpath) for outline in outlines for subpath in outline]
    crossings = find_crossings(subpaths) if context.options.untangle else []
    numbers = np.repeat(np.arange(len(outlines)), np.diff(drawing.layer_offsets))
    tangled = {int(number) for number, crossing in zip(numbers, crossings, strict=False) if crossing is not None}
    tangled &= set(np.flatnonzero(free).tolist())
    if not tangled:
        return drawing
    editor = _Editor(context, drawing, 1.0, paints)
    for layer, outline in enumerate(outlines):
        if layer in tangled:
            found = [part[:, :3] for subpath in outline for part in parted(_closed(subpath))]
            for part in sorted(found, key=lambda part: abs(signed_area(_closed(part)))):
                interruption.check()
                fewer = [other for other in found if other is not part]
                found = editor.cheapest(layer, [found, fewer] if fewer else [found])
            outlines[layer] = found
        editor.advance(layer)
    return with_outlines(drawing, outlines)


def _closed(subpath: FloatArray) -> FloatArray:
    """Return the cubics (m, 4, 2) of a closed subpath (m, 3, 2)."""
    return np.concatenate([subpath, cyclic.following(subpath[:, :1])], axis=1)


def _verified(context: Context, drawing: Drawing, edited: Drawing, paints: _Paints) -> Drawing:
    """Return an edited drawing after training, its layers as they were, or these tidied, where they cost more."""
    editor = _Editor(context, edited, 1.0, paints)
    outlines = []
    for layer, pair in enumerate(zip(outlines_of(edited), outlines_of(drawing), strict=True)):
        interruption.check()
        tidy = [_tidied(subpath.tobytes(), FITS[-1]) for subpath in pair[1]] if context.options.simplify else pair[1]
        outlines.append(pair[1] if _same(*pair) else editor.cheapest(layer, [*pair, tidy]))
        editor.advance(layer)
    return with_outlines(edited, outlines)


def _same(a: Outline, b: Outline) -> bool:
    return all(np.array_equal(one, other) for one, other in zip(a, b, strict=True))


class _Paints:
    """Colours and opacities of a drawing's layers at its pixels, independent of their outlines."""

    def __init__(self, drawing: Drawing) -> None:
        self.ground, self.colors = composited_colors(drawing)
        self.opacities = []
        for layer in range(drawing.num_layers):
            interruption.check()
            self.opacities.append(opacity_at_pixels(drawing, layer))


class _Editor:
    """Weighs descriptions of a drawing's layers, bottom first, by the picture that all layers make.

    Of the error that a description adds, a share `left` counts. A number must save twice the variance of what the
    layer's edges miss: so much it saves by following noise, such as the steps of edges that were never smooth.
    `number_errors` has that for each layer, as squared error.

    References
    ----------
    C. L. Mallows: *Some Comments on Cp*. Technometrics 15, 1973.
    """

    def __init__(self, context: Context, drawing: Drawing, left: float, paints: _Paints) -> None:
        self._context, self._drawing, self._left = context, drawing, left
        self._alphas = layer_alphas(drawing, context.rasterizer)
        self._paints, ground, self._colors = paints, paints.ground, paints.colors
        self._below: NDArray[Any] = np.broadcast_to(ground, context.target.shape).astype(np.float32)
        self._above = np.ones_like(self._alphas)  # transmittance of the layers above each
        for layer in range(len(self._alphas) - 2, -1, -1):
            interruption.check()
            self._above[layer] = self._above[layer + 1] * (1 - self._alphas[layer + 1])
        interruption.check()
        self._rest = context.rasterizer.forward(drawing) - context.target
        missed = np.square(visible_error(self._rest), dtype=np.float64).sum(axis=-1)
        self.number_errors = []
        for alphas in self._alphas:
            interruption.check()
            edge = (alphas > EDGE[0]) & (alphas < EDGE[1])
            noise = np.median(missed[edge]) / MEDIAN_SQUARE if edge.any() else 0.0
            self.number_errors.append(max(NUMBER_ERROR, 2 * float(noise)))

    def advance(self, layer: int) -> None:
        """Continue with the layer above."""
        self._below = over(self._below, self._alphas[layer], self._colors[layer].astype(np.float32))

    def best(self, layer: int, outline: Outline) -> Outline:
        """Return the outline of least price for a layer, and composite it."""
        every = list(range(len(outline)))
        for members in [every] if len(outline) > MOST_APART else [[k] for k in every]:
            outline = self.cheapest(layer, [outline, *self._descriptions(layer, outline, members)])
        return outline

    def cheapest(self, layer: int, found: list[Outline]) -> Outline:
        """Return the cheapest of several outlines for a layer, the first being its present one."""
        if len(found) == 1:
            return found[0]
        drawing, present = self._drawing, self._alphas[layer]
        tried = Drawing.from_outlines(found[1:], drawing.colors[layer], drawing.size, drawing.background)
        interruption.check()
        others = self._context.rasterizer.coverages(tried)
        window = window_of(np.maximum.reduce([others.max(axis=0), present]))
        opacity = self._paints.opacities[layer]
        others = others[:, window[0], window[1]] * (in_window(opacity, window) if opacity.ndim else opacity)
        alphas = np.concatenate([present[window][None], others])
        tint = self._above[layer][window][..., None] * (in_window(self._colors[layer], window) - self._below[window])
        prices = []
        for description, alpha in zip(found, alphas, strict=True):
            interruption.check()
            change = (alpha - alphas[0])[..., None] * tint
            error = float(np.square(visible_error(self._rest[window] + change), dtype=np.float64).sum())
            prices.append(self._left * error / self.number_errors[layer] + price_of(description))
        chosen = int(np.argmin(prices))
        self._rest[window] += (alphas[chosen] - alphas[0])[..., None] * tint
        present[window] = alphas[chosen]
        return found[chosen]

    def _descriptions(self, layer: int, outline: Outline, members: list[int]) -> list[Outline]:
        """Return other descriptions of an outline, of which some subpaths are tidied, traced anew, or a shape."""
        options = self._context.options
        traces = [self._trace(layer, outline[k]) for k in members]
        found: list[Outline] = []

        def add(subpaths: list[FloatArray | None]) -> None:
            changed = list(outline)
            for k, subpath in zip(members, subpaths, strict=True):
                changed[k] = changed[k] if subpath is None else subpath
            if not any(_same(changed, known) for known in (outline, *found)):
                found.append(changed)

        if options.simplify:
            described = [[None] * len(FITS) if traced is None else editable_outlines(traced, FITS) for traced in traces]
            for fit, subpaths in zip(FITS, zip(*described, strict=True), strict=True):
                add([_tidied(outline[k].tobytes(), fit) for k in members])
                add(list(subpaths))
        if options.primitives and len(outline) == 1 and traces[0] is not None:
            found += [[shape.points] for shape in fitted_shapes(traces[0])]
        return found

    def _trace(self, layer: int, subpath: FloatArray) -> SampledOutline | None:
        """Return the trace of a subpath, with less weight on its hidden parts."""
        traced = sampled(_closed(subpath))
        if traced is not None:
            height, width = self._drawing.size
            columns, rows = np.floor(traced.points).astype(np.int64).T
            inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
            through = self._above[layer][np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
            traced.weights[~inside | (through < HIDDEN)] = HIDDEN_WEIGHT
        return traced


def price_of(outline: Outline) -> float:
    """Return the description length of an outline in numbers: those that SVG writes, more where joins bend curves."""
    shape = _shape_of(outline)
    return float(_numbers_of_shape(shape)) if shape else sum(_price_of(subpath.tobytes()) for subpath in outline)


@functools.lru_cache(maxsize=1024)
def _price_of(data: bytes) -> float:
    """Return what a subpath costs, given as the bytes of its points (m, 3, 2): the same one is often weighed again."""
    subpath, fit = np.frombuffer(data).reshape(-1, 3, 2), FITS[0]
    joins = Joins(subpath, cyclic.following(np.arange(len(subpath))), np.ones(len(subpath), bool))
    lines = joins.lines.astype(int) + cyclic.preceding(joins.lines)
    known = np.abs(joins.directions(subpath)).min(axis=1) < SHORT
    price = _numbers_of(subpath) + fit.corner * np.count_nonzero(~joins.smooth & (lines < 2))
    price += fit.flat * float(np.maximum(1 - joins.turns / FLAT, 0)[~joins.smooth].sum())
    price -= fit.smooth * np.count_nonzero(joins.smooth)
    return float(price - fit.smooth * np.count_nonzero(joins.smooth & known & (lines == 0)))


@functools.lru_cache(maxsize=1024)
def _tidied(data: bytes, fit: Fit) -> FloatArray:
    """Return a subpath, given as the bytes of its points (m, 3, 2), tidied: it is asked for again at the end."""
    tidy = tidied(np.frombuffer(data).reshape(-1, 3, 2), fit.tolerance)
    tidy.setflags(write=False)
    return tidy


def numbers_of(outline: Outline) -> int:
    """Count the numbers that SVG writes for an outline."""
    shape = _shape_of(outline)
    return _numbers_of_shape(shape) if shape else sum(map(_numbers_of, outline))


def _numbers_of_shape(shape: Primitive) -> int:
    return sum(len(_NUMBER.findall(value)) for value in shape.attributes.values())


def _numbers_of(subpath: FloatArray) -> int:
    following = cyclic.following(np.arange(len(subpath)))
    held = rounded_points(subpath, following, np.ones(len(subpath), bool), PRECISION)
    return len(_NUMBER.findall(format_outline(held, PRECISION)))


def _shape_of(outline: Outline) -> Primitive | None:
    return primitive_of(outline[0], MAX_PRECISION) if len(outline) == 1 else None
