# SPDX-License-Identifier: Apache-2.0
"""Convert long thin layers to strokes, a centre line and a width in place of an outline, where that saves numbers.

Each number saved may cost some error, as elsewhere (`SEGMENT_ERROR` for six).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.assembly import concatenate, empty_drawing
from livecl.drawing.borders import border_pairs
from livecl.drawing.drawing import Drawing
from livecl.layering.componentwise.candidates import SEGMENT_ERROR
from livecl.layering.context import Context
from livecl.layering.strokes.finding import best_pen
from livecl.layering.strokes.lines import find_lines
from livecl.layering.strokes.rules import RULES, StrokeRules

#: Share of the error added by a stroke that remains after training: its line is off by .3 px at first, then by .1.
LEFT = 0.1
#: Distance, px, of handles from the thirds of a straight segment.
STRAIGHT = 0.05
#: Numbers of a colour.
COLOR_NUMBERS = 3
#: Margin, px, around a layer that is included in the comparison.
MARGIN = 2


def thinned(context: Context, drawing: Drawing, free: NDArray[np.bool_], rules: StrokeRules = RULES) -> Drawing:
    """Convert thin layers of a drawing to strokes; return the same object if none changes.

    Only `free` (N,) layers without a gradient change.
    """
    found = drawing
    candidates = np.flatnonzero(free & (drawing.strokes.widths == 0))
    for layer in np.setdiff1d(candidates, drawing.fills.gradient_layers).tolist():
        interruption.check()
        stroke = _stroke_of(context, drawing.layer_subset([layer]), rules)
        if stroke is None:
            continue
        order = np.arange(drawing.num_layers)
        order[layer] = drawing.num_layers
        changed = concatenate(found, stroke).layer_subset(order)
        rise = context.priced_error(changed) - context.priced_error(found)
        if LEFT * rise < (_numbers(drawing, layer) - _numbers(stroke, 0)) * SEGMENT_ERROR / 6:
            found = changed
    return found


def worth(before: Drawing, after: Drawing) -> float:
    """Return the rise of the mean squared error that the numbers saved from one drawing to another are worth."""
    saved = numbers_of_all(before) - numbers_of_all(after)
    return saved * SEGMENT_ERROR / 6 / (3 * before.size[0] * before.size[1])


def numbers_of_all(drawing: Drawing) -> float:
    """Count the numbers that describe all layers, colours included; an outline with fill and stroke counts once."""
    total = float(COLOR_NUMBERS * drawing.num_layers)
    outlined = border_pairs(drawing)[:, 0].tolist()
    return total + sum(_numbers(drawing, layer) for layer in range(drawing.num_layers) if layer not in outlined)


def _stroke_of(context: Context, layer: Drawing, rules: StrokeRules) -> Drawing | None:
    """Return a drawing of one layer as a stroke; None if the layer is no line."""
    coverage = context.rasterizer.coverages(layer)[0].astype(np.float64)
    inside = coverage > 0.5
    if not inside.any():
        return None
    box = ndimage.find_objects(inside.astype(np.int64))[0]
    rows, columns = (slice(max(part.start - MARGIN, 0), part.stop + MARGIN) for part in box)
    radius = float(ndimage.distance_transform_edt(np.pad(inside[rows, columns], 1)).max())
    if inside.sum() < rules.slenderness * 2 * radius * max(2 * radius - 1, 1):  # half a pixel less on each side
        return None
    lines = [line for line in find_lines(coverage, rules) if not line.is_spot]
    if not lines or max(line.width for line in lines) > rules.same_width * min(line.width for line in lines):
        return None
    stroke = best_pen(context, lines, layer.colors[0], coverage, empty_drawing(layer.size, layer.background))
    return stroke.replace(stages=layer.stages, names=layer.names)


def _numbers(drawing: Drawing, layer: int) -> float:
    """Count the numbers of a layer: two for a straight segment, six for a curve, and one for a stroke's width."""
    total = 0.0
    for subpath in range(*drawing.layer_offsets[layer : layer + 2]):
        cubics = drawing.cubics[drawing.subpaths()[subpath]]
        if drawing.strokes.is_open[subpath]:
            cubics, total = cubics[:-1], total + 2
        thirds = cubics[:, :1] + (cubics[:, 3:] - cubics[:, :1]) * np.array([1, 2])[None, :, None] / 3
        straight = (np.abs(cubics[:, 1:3] - thirds).max(axis=(1, 2), initial=0) < STRAIGHT) | _flat(cubics)
        total += float(np.where(straight, 2, 6).sum())
    return total + (drawing.strokes.widths[layer] > 0)


def _flat(cubics: FloatArray) -> NDArray[Any]:
    """Whether the control points of each cubic (n, 4, 2) lie on the chord."""
    along = cubics[:, 3] - cubics[:, 0]
    lengths = np.maximum(np.hypot(*along.T), 1e-9)
    steps = cubics[:, 1:3] - cubics[:, :1]
    across = np.abs(along[:, None, 0] * steps[:, :, 1] - along[:, None, 1] * steps[:, :, 0])
    return np.asarray((across / lengths[:, None]).max(axis=1) < STRAIGHT)
