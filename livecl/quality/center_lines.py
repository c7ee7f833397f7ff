# SPDX-License-Identifier: Apache-2.0
"""Centre line scores: distance of a drawing's strokes from those of the true drawing."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import cKDTree

from livecl.arrays import FloatArray
from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import evaluate

#: Samples per px of the sides of a segment's control polygon.
DENSITY = 2


@dataclasses.dataclass(frozen=True, kw_only=True)
class LineScores:
    """Agreement of a drawing's strokes with true ones.

    Attributes
    ----------
    line_distance : float or None
        Mean distance of the centre lines in both directions, px; None if one of the drawings has no strokes.
    line_width_off : float or None
        Mean relative error of the width, at the true centre lines.
    line_nodes : float
        Ratio of the numbers of segments of all layers, fills included.
    """

    line_distance: float | None
    line_width_off: float | None
    line_nodes: float


def score_lines(true: Drawing, found: Drawing) -> LineScores:
    """Score a drawing's strokes by the true ones; both drawings have one size."""
    theirs, their_widths = _samples(true)
    ours, our_widths = _samples(found)
    nodes = found.num_segments / max(true.num_segments, 1)
    if not len(ours) or not len(theirs):
        return LineScores(line_distance=None, line_width_off=None, line_nodes=nodes)
    near, index = cKDTree(ours).query(theirs)
    back, _ = cKDTree(theirs).query(ours)
    off = np.abs(our_widths[index] / their_widths - 1)
    return LineScores(
        line_distance=float((near.mean() + back.mean()) / 2), line_width_off=float(off.mean()), line_nodes=nodes
    )


def _samples(drawing: Drawing) -> tuple[FloatArray, FloatArray]:
    """Return points (P, 2) along the centre lines of all strokes, and the width at each, (P,)."""
    points, widths = [np.zeros((0, 2))], [np.zeros(0)]
    for layer in drawing.strokes.stroked_layers.tolist():
        first = drawing.layer_offsets[layer]
        for number, rows in enumerate(drawing.subpaths(layer)):
            cubics = drawing.cubics[rows][: -1 if drawing.strokes.is_open[first + number] else None]
            for cubic in cubics:
                count = 2 + int(DENSITY * np.abs(np.diff(cubic, axis=0)).sum())
                points.append(evaluate(cubic, np.linspace(0, 1, count)))
                widths.append(np.full(count, drawing.strokes.widths[layer]))
    return np.concatenate(points), np.concatenate(widths)
