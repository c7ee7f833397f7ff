# SPDX-License-Identifier: Apache-2.0
"""Trim outlines that extend far beyond the page to a small bleed."""

from __future__ import annotations

import numpy as np

from livecl.drawing.assembly import outlines_of, with_outlines
from livecl.drawing.drawing import Drawing
from livecl.geometry.trimming import trimmed_outline

#: Ratio of the page's longer side to the bleed's width; multiple of the bleed beyond which an outline is cut.
SIDE_BY_BLEED, FAR = 60, 2


def trimmed(drawing: Drawing) -> Drawing:
    """Cut filled outlines that extend far beyond the page to a bleed, without changing the picture.

    Drawings with strokes are returned unchanged.
    """
    size = np.array(drawing.size[::-1], dtype=np.float64)
    bleed = max(1.0, round(size.max() / SIDE_BY_BLEED))
    beyond = np.maximum(-drawing.points, drawing.points - size).max(axis=(1, 2)) > FAR * bleed  # (M,)
    if not beyond.any() or drawing.strokes.any:
        return drawing
    outlines = outlines_of(drawing)
    for layer, own in enumerate(outlines):
        cut = [
            trimmed_outline(points, -np.full(2, bleed), size + bleed) if beyond[row].any() else points
            for points, row in zip(own, drawing.subpaths(layer), strict=True)
        ]
        outlines[layer] = [points for points in cut if points is not None] or own
    return with_outlines(drawing, outlines)
