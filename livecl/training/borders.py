# SPDX-License-Identifier: Apache-2.0
"""Ties between a fill and the stroke around it: both follow one outline while it is trained.

An outline p that two layers share has the gradient dL/dp = d_p(fill) + d_p(stroke), by the chain rule. The fill's
points take it, and the stroke's follow them.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.drawing.borders import border_pairs, paired_rows
from livecl.drawing.drawing import Drawing


@dataclasses.dataclass(frozen=True, eq=False)
class Borders:
    """Segments of fills, and the same segments of the strokes around them, (R,) each."""

    fills: NDArray[np.int64]
    strokes: NDArray[np.int64]

    @classmethod
    def of(cls, drawing: Drawing, locked: NDArray[np.bool_]) -> Borders:
        """Find the pairs of a drawing, without those of which one layer alone is locked, (N,) bool."""
        if not drawing.strokes.any:
            return _NONE
        pairs = border_pairs(drawing)
        return cls(*paired_rows(drawing, pairs[locked[pairs[:, 0]] == locked[pairs[:, 1]]]))

    def gather(self, d_points: FloatArray) -> None:
        """Move the gradients of strokes to the fills that they surround, in place: (M, 3, 2)."""
        if len(self.fills):
            d_points[self.fills] += d_points[self.strokes]
            d_points[self.strokes] = 0

    def restore(self, points: FloatArray) -> None:
        """Copy the points of fills to the strokes around them, in place: (M, 3, 2) px."""
        if len(self.fills):
            points[self.strokes] = points[self.fills]


_NONE = Borders(np.zeros(0, np.int64), np.zeros(0, np.int64))
