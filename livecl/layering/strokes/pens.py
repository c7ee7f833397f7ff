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
        if ratio <= np.log(SAME_WIDTH) and np.abs(drawing.colors[i] - drawing.colors[j]).max() <= SAME_COLOR:
            pairs.append((ratio, i, j))
    return [(i, j) for _, i, j in sorted(pairs)]


def _merged(drawing: Drawing, i: int, j: int, place: int) -> Drawing:
    """Merge the lines of layers i and j into one layer at the place of one of them.

    The pen has their mean width and colour, weighted by length, and the caps and joins of the longer.
    """
    lengths = np.array([_length(drawing, layer) for layer in (i, j)])
    shares = lengths / max(lengths.sum(), 1e-9) if lengths.any() else np.array([0.5, 0.5])
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
