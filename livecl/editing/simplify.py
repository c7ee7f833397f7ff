# SPDX-License-Identifier: Apache-2.0
"""Last step of a run: each layer's outline is described as an editor would have it, where that pays.

A description is paid for by its numbers, as SVG writes them, and by the squared error that it adds to the picture. The
cheapest is taken: the outline as it is, one with few nodes, or a circle, an ellipse or a rectangle.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.editing.outline import Fit, editable_outline
from livecl.editing.polish import polished
from livecl.editing.shapes import fitted_shapes
from livecl.editing.trace import Trace, trace
from livecl.geometry.outlines import Outline
from livecl.image.errors import visible_error
from livecl.layering.candidates import SEGMENT_ERROR
from livecl.layering.context import Context
from livecl.layering.contributions import composited_colors, in_window, layer_alphas, opacity_at_pixels
from livecl.layering.stack import over, window_of
from livecl.svg.outline_data import format_outline, rounded_points
from livecl.svg.path_data import NUMBER
from livecl.svg.primitives import primitive_of

FloatArray = NDArray[np.float64]

#: Squared error that a number is worth, as a segment has six; and share of the error that a description adds which
#: training leaves of it.
NUMBER_ERROR, LEFT = SEGMENT_ERROR / 6, 0.6
#: Fits that are tried, from coarse to fine.
FITS = (Fit(), Fit(tolerance=0.2, straight=0.15, straying=12.0))
#: Weight of samples that layers above hide, and transmittance up to which they do.
HIDDEN_WEIGHT, HIDDEN = 0.25, 0.6
#: Decimals that numbers are counted with.
PRECISION = 3

_NUMBER = re.compile(NUMBER)


def editable(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> Drawing:
    """Return a drawing with the layers that are `free`, (N,), described as editors would have them, where that pays.

    Parameters
    ----------
    context : Context
        Rasterizer, target and options (`Options.simplify`, `Options.primitives`).
    drawing : Drawing
        Any drawing; strokes stay as they are.
    free : (N,) bool
        Layers that may change.
    """
    options = context.options
    if not (options.simplify or options.primitives) or not drawing.num_layers:
        return drawing
    editor = _Editor(context, drawing)
    outlines: list[Outline] = []
    for layer, outline in enumerate(_outlines(drawing)):
        context.check()
        if free[layer] and drawing.strokes.widths[layer] == 0:
            outline = editor.best(layer, outline)
        outlines.append(outline)
        editor.advance(layer)
    subpaths = [subpath for outline in outlines for subpath in outline]
    edited = drawing.replace(points=np.concatenate(subpaths), subpath_offsets=np.cumsum([0, *map(len, subpaths)]))
    edited = polished(context, edited, free & (drawing.strokes.widths == 0))
    saved = sum(map(numbers_of, _outlines(drawing))) - sum(map(numbers_of, _outlines(edited)))
    rise = (context.visible_mse(edited) - context.visible_mse(drawing)) * 3 * drawing.size[0] * drawing.size[1]
    return edited if rise <= max(saved, 0) * NUMBER_ERROR else drawing


def _outlines(drawing: Drawing) -> list[Outline]:
    return [[drawing.points[rows] for rows in drawing.subpaths(layer)] for layer in range(drawing.num_layers)]


class _Editor:
    """Weighs descriptions of a drawing's layers, bottom first, by the picture that all layers make."""

    def __init__(self, context: Context, drawing: Drawing) -> None:
        self._context, self._drawing = context, drawing
        self._alphas = layer_alphas(drawing, context.rasterizer)
        ground, self._colors = composited_colors(drawing)
        self._below: NDArray[Any] = np.broadcast_to(ground, context.target.shape).astype(np.float32)
        self._above = np.ones_like(self._alphas)  # transmittance of the layers above each
        for layer in range(len(self._alphas) - 2, -1, -1):
            self._above[layer] = self._above[layer + 1] * (1 - self._alphas[layer + 1])
        self._rest = context.rasterizer.forward(drawing) - context.target

    def advance(self, layer: int) -> None:
        """Go on to the layer above."""
        self._below = over(self._below, self._alphas[layer], self._colors[layer].astype(np.float32))

    def best(self, layer: int, outline: Outline) -> Outline:
        """Return the outline of least price for a layer, and take it into the picture."""
        found = [outline, *self._descriptions(layer, outline)]
        if len(found) == 1:
            return outline
        drawing = self._drawing
        alphas = self._context.rasterizer.coverages(
            Drawing.from_outlines(found, drawing.colors[layer], drawing.size, drawing.background)
        )
        alphas *= opacity_at_pixels(drawing, layer)
        window = window_of(np.maximum(alphas.max(axis=0), self._alphas[layer]))
        tint = self._above[layer][window][..., None] * (in_window(self._colors[layer], window) - self._below[window])
        prices = []
        for description, alpha in zip(found, alphas, strict=True):
            change = (alpha[window] - self._alphas[layer][window])[..., None] * tint
            error = float(np.square(visible_error(self._rest[window] + change), dtype=np.float64).sum())
            prices.append(LEFT * error / NUMBER_ERROR + numbers_of(description))
        chosen = int(np.argmin(prices))
        self._rest[window] += (alphas[chosen][window] - self._alphas[layer][window])[..., None] * tint
        self._alphas[layer] = alphas[chosen]
        return found[chosen]

    def _descriptions(self, layer: int, outline: Outline) -> list[Outline]:
        """Return descriptions of an outline with fewer numbers."""
        options, traces = self._context.options, [self._trace(layer, subpath) for subpath in outline]
        found: list[Outline] = []
        if options.simplify:
            for fit in FITS:
                edited = [
                    (None if traced is None else editable_outline(traced, fit), subpath)
                    for traced, subpath in zip(traces, outline, strict=True)
                ]
                found.append([subpath if path is None else path for path, subpath in edited])
        if options.primitives and len(outline) == 1 and traces[0] is not None:
            found += [[shape.points] for shape in fitted_shapes(traces[0])]
        return found

    def _trace(self, layer: int, subpath: FloatArray) -> Trace | None:
        """Return the trace of a subpath, its hidden parts weighing less."""
        ends = np.roll(subpath[:, :1], -1, axis=0)
        traced = trace(np.concatenate([subpath, ends], axis=1))
        if traced is not None:
            height, width = self._drawing.size
            columns, rows = np.floor(traced.points).astype(np.int64).T
            inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
            through = self._above[layer][np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
            traced.weights[~inside | (through < HIDDEN)] = HIDDEN_WEIGHT
        return traced


def numbers_of(outline: Outline) -> int:
    """Return how many numbers SVG writes for an outline."""
    if len(outline) == 1:
        shape = primitive_of(outline[0], PRECISION)
        if shape is not None:
            return sum(len(_NUMBER.findall(value)) for value in shape.attributes.values())
    count = 0
    for subpath in outline:
        following = np.roll(np.arange(len(subpath)), -1)
        held = rounded_points(subpath, following, np.ones(len(subpath), bool), PRECISION)
        count += len(_NUMBER.findall(format_outline(held, PRECISION)))
    return count
