# SPDX-License-Identifier: Apache-2.0
"""Reduce the number of pens: merge stroked layers of similar width and colour, and remove needless ones.

A change is made if the numbers saved are worth the error added, of which training leaves a part.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.assembly import outlines_of, with_outlines
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID
from livecl.drawing.strokes import Strokes
from livecl.geometry.bezier import evaluate
from livecl.layering.componentwise.candidates import SEGMENT_ERROR
from livecl.layering.context import Context
from livecl.layering.strokes.redrawing import LEFT

#: Largest ratio of widths, and difference of colours in RGBA, of pens that may be merged.
SAME_WIDTH, SAME_COLOR = 1.3, 0.15
#: Largest width, px, of lines whose width and shade are known as a product alone; least cosine between their colours,
#: seen from the ground.
THIN, SAME_WAY = 2.5, 0.95
#: Shades of thin lines that are tried, as shares of the contrast found.
SHADES = tuple(np.linspace(0.7, 1.5, 17).round(2).tolist())
#: Numbers of a pen: its width and colour. A segment has six.
PEN_NUMBERS = 4


def with_fewer_pens(context: Context, drawing: Drawing) -> tuple[Drawing, NDArray[np.intp]]:
    """Merge and remove stroked layers; return the drawing, and for each layer the index of its (first) source.

    Filled layers and gradients stay. The same object is returned if nothing is saved.
    """
    sources = np.arange(drawing.num_layers)
    changed = True
    while changed:
        changed = False
        for i, j in _alike(drawing):
            options = [_merged(drawing, i, j, place) for place in (i, j)]
            merged = min(options, key=context.visible_mse)
            if _pays(context, drawing, merged):
                drawing, sources, changed = merged, np.delete(sources, j if merged is options[0] else i), True
                break
    for layer in sorted(drawing.strokes.stroked_layers.tolist(), key=lambda layer: -layer):
        if drawing.num_layers > 1:
            kept = np.delete(np.arange(drawing.num_layers), layer)
            fewer = drawing.layer_subset(kept)
            if _pays(context, drawing, fewer):
                drawing, sources = fewer, sources[kept]
    return drawing, sources


def with_best_shades(context: Context, drawing: Drawing) -> Drawing:
    """Choose the shade of thin lines by the error, with the width that has the same ink per length.

    Training moves slowly along such changes, as the picture hardly does.
    """
    best, error = drawing, context.visible_mse(drawing)
    ground = drawing.background
    if ground is None:
        return drawing
    strokes = drawing.strokes
    for layer in strokes.stroked_layers[strokes.widths[strokes.stroked_layers] <= THIN].tolist():
        for share in SHADES:
            colors, widths = best.colors.copy(), best.strokes.widths.copy()
            colors[layer, :3] = np.clip(ground + share * (drawing.colors[layer, :3] - ground), 0, 1)
            widths[layer] = strokes.widths[layer] / share
            changed = drawing.replace(colors=colors, strokes=strokes.with_widths(widths))
            if (changed_error := context.visible_mse(changed)) < error:
                best, error = changed, changed_error
    return best


def _pays(context: Context, drawing: Drawing, fewer: Drawing) -> bool:
    """Whether the numbers saved are worth the error added."""
    interruption.check()
    rise = context.priced_error(fewer) - context.priced_error(drawing)
    pens = drawing.num_layers - fewer.num_layers
    saved = drawing.num_segments - fewer.num_segments + pens * PEN_NUMBERS / 6
    return LEFT * rise < saved * SEGMENT_ERROR


def _alike(drawing: Drawing) -> list[tuple[int, int]]:
    """Return pairs of stroked layers that may share a pen, the nearest widths first."""
    layers = np.intersect1d(drawing.strokes.stroked_layers, np.flatnonzero(drawing.fills.kinds == SOLID)).tolist()
    pairs = []
    for i, j in itertools.combinations(layers, 2):
        ratio = abs(float(np.log(drawing.strokes.widths[i] / drawing.strokes.widths[j])))
        same = ratio <= np.log(SAME_WIDTH) and np.abs(drawing.colors[i] - drawing.colors[j]).max() <= SAME_COLOR
        if same or _thin_alike(drawing, [i, j]):
            pairs.append((ratio, i, j))
    return [(i, j) for _, i, j in sorted(pairs)]


def _thin_alike(drawing: Drawing, layers: list[int]) -> bool:
    """Whether two layers of thin lines have about the same ink per length, and colours on one way from the ground.

    A line of a pixel that lies on the border of two pixels looks like a paler one of two pixels.
    """
    if drawing.background is None or drawing.strokes.widths[layers].max() > THIN:
        return False
    ways = drawing.colors[layers, 3:] * (drawing.colors[layers, :3] - drawing.background)
    lengths = np.maximum(np.linalg.norm(ways, axis=1), 1e-9)
    masses = drawing.strokes.widths[layers] * lengths
    return bool(masses.max() <= SAME_WIDTH * masses.min() and ways[0] @ ways[1] >= SAME_WAY * lengths.prod())


def _merged(drawing: Drawing, i: int, j: int, place: int) -> Drawing:
    """Merge the lines of layers i and j into one layer at the place of one of them.

    The pen has their mean width and colour, weighted by length, and the caps and joins of the longer; of thin lines of
    other widths, those of the layer at the place.
    """
    lengths = np.array([_length(drawing, layer) for layer in (i, j)])
    shares = lengths / max(lengths.sum(), 1e-9) if lengths.any() else np.array([0.5, 0.5])
    if drawing.strokes.widths[[i, j]].max() > SAME_WIDTH * drawing.strokes.widths[[i, j]].min():
        shares = np.array([place == i, place == j], dtype=np.float64)
    main = (i, j)[int(np.argmax(shares))]
    gone = j if place == i else i
    strokes = drawing.strokes
    widths, colors = strokes.widths.copy(), drawing.colors.copy()
    widths[place], colors[place] = shares @ widths[[i, j]], shares @ colors[[i, j]]
    caps, joins, limits = (values.copy() for values in (strokes.caps, strokes.joins, strokes.miter_limits))
    caps[place], joins[place], limits[place] = strokes.caps[main], strokes.joins[main], strokes.miter_limits[main]
    order = [layer for layer in range(drawing.num_layers) if layer != gone]
    parts = [[layer] if layer != place else [i, j] for layer in order]
    subpaths = [k for part in parts for layer in part for k in range(*drawing.layer_offsets[layer : layer + 2])]
    outlines = outlines_of(drawing)
    return with_outlines(
        drawing.layer_subset(order),
        [[rows for layer in part for rows in outlines[layer]] for part in parts],
        colors=colors[order],
        strokes=Strokes(
            widths=widths[order],
            caps=caps[order],
            joins=joins[order],
            miter_limits=limits[order],
            is_open=strokes.is_open[subpaths],
        ),
    )


def _length(drawing: Drawing, layer: int) -> float:
    """Return the length of a layer's lines, px, from eight chords per segment."""
    first = drawing.layer_offsets[layer]
    total = 0.0
    for number, rows in enumerate(drawing.subpaths(layer)):
        cubics = drawing.cubics[rows][: -1 if drawing.strokes.is_open[first + number] else None]
        total += float(np.linalg.norm(np.diff(evaluate(cubics, np.linspace(0, 1, 9)), axis=1), axis=2).sum())
    return total
