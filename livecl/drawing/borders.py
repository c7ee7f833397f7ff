# SPDX-License-Identifier: Apache-2.0
"""Borders: a fill and a stroke on one outline, two layers that an SVG holds as one element.

Pairs are found in the drawing itself: two consecutive layers with the same closed outlines, one filled and one stroked.
The stroke lies above the fill or below it (`paint-order` of SVG).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from livecl.arrays import IntArray
from livecl.drawing.fills import SOLID

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing


#: Smallest opacity above 0 in 8 bits.
LEAST_OPACITY = 0.5 / 255


def border_pairs(drawing: Drawing) -> IntArray:
    """Return the filled and the stroked layer of each pair of one outline: (K, 2), the lowest pair first.

    They share stage, name and groups. A transparent stroke is not paired: the reader ignores it in an element with a
    fill.
    """
    pairs: list[tuple[int, int]] = []
    free = 0
    for layer in drawing.strokes.stroked_layers.tolist():
        for fill in (layer - 1, layer + 1):
            if free <= min(fill, layer) and fill < drawing.num_layers and _is_pair(drawing, fill, layer):
                pairs.append((fill, layer))
                free = max(fill, layer) + 1
                break
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def paired_rows(drawing: Drawing, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Return the segments of the fills and of the strokes of pairs, (R,) each, in the same order."""
    offsets = drawing.segment_offsets.astype(np.int64)
    fills, strokes = ([np.arange(*offsets[layer : layer + 2]) for layer in layers] for layers in pairs.T)
    return tuple(np.concatenate(rows) if rows else np.zeros(0, np.int64) for rows in (fills, strokes))  # type: ignore[return-value]


def _is_pair(drawing: Drawing, fill: int, stroke: int) -> bool:
    """Whether a filled and a stroked layer form a pair."""
    first, end = drawing.layer_offsets[[stroke, stroke + 1]]
    own, others = (drawing.subpaths(layer) for layer in (fill, stroke))
    return (
        not drawing.strokes.widths[fill]
        and (drawing.fills.kinds[stroke] != SOLID or drawing.colors[stroke, 3] >= LEAST_OPACITY)
        and not drawing.strokes.is_open[first:end].any()
        and [rows.stop - rows.start for rows in own] == [rows.stop - rows.start for rows in others]
        and drawing.stages[fill] == drawing.stages[stroke]
        and drawing.names[fill] == drawing.names[stroke]
        and drawing.groups[fill] == drawing.groups[stroke]
        and all(np.array_equal(drawing.points[a], drawing.points[b]) for a, b in zip(own, others, strict=True))
    )
