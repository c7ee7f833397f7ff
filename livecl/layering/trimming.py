# SPDX-License-Identifier: Apache-2.0
"""Trimming of a drawing: outlines that hang far over the page are cut to a small bleed."""

from __future__ import annotations

import numpy as np

from livecl.drawing.drawing import Drawing
from livecl.geometry.trimming import trimmed_outline

#: Longer side of the page by the width of the bleed; and widths of it beyond which an outline is cut.
SIDE_BY_BLEED, FAR = 60, 2


def trimmed(drawing: Drawing) -> Drawing:
    """Return the drawing with the filled outlines that reach far beyond the page cut to a bleed: the picture stays.

    Drawings with strokes stay as they are.
    """
    size = np.array(drawing.size[::-1], dtype=np.float64)
    bleed = max(1.0, round(size.max() / SIDE_BY_BLEED))
    beyond = np.maximum(-drawing.points, drawing.points - size).max(axis=(1, 2)) > FAR * bleed  # (M,)
    if not beyond.any() or drawing.strokes.any:
        return drawing
    paths, counts = [], []
    for layer in range(drawing.num_layers):
        rows = drawing.subpaths(layer)
        own = [drawing.points[row] for row in rows]
        cut = [
            trimmed_outline(points, -np.full(2, bleed), size + bleed) if beyond[row].any() else points
            for points, row in zip(own, rows, strict=True)
        ]
        own = [points for points in cut if points is not None] or own
        paths += own
        counts.append(len(own))
    return drawing.replace(
        points=np.concatenate(paths),
        subpath_offsets=np.cumsum([0, *map(len, paths)]),
        layer_offsets=np.cumsum([0, *counts]),
    )
