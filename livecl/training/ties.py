# SPDX-License-Identifier: Apache-2.0
"""Ties between control points: straight segments stay straight, and smooth joins smooth, while points are trained.

Ties are found in the drawing itself: handles at a third and two thirds of their segment, or collinear with those on the
other side of the anchor, to within rounding. Of a straight segment only the anchors are free: with h = (2 a + b) / 3
and k = (a + 2 b) / 3, the chain rule adds 2/3 dL/dh + 1/3 dL/dk to dL/da, and the reverse to dL/db. The handles of a
smooth join are projected, after each step, on the line through the anchor that is parallel to the line through both, or
on the straight side, if there is one.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import cross

#: Largest distance of a handle from its place on a straight segment, px, and tangent of the largest angle of a smooth
#: join: more than rounding loses.
EXACT = 1e-6


@dataclasses.dataclass(frozen=True, eq=False)
class Ties:
    """Straight segments and smooth joins of a drawing."""

    #: (M,): segments after and before each one on its closed outline.
    following: NDArray[np.intp]
    before: NDArray[np.intp]
    straight: NDArray[np.bool_]  # (M,), segments with handles at a third and two thirds
    smooth: NDArray[np.bool_]  # (M,), anchors with collinear handles, of which at least one segment is curved

    @classmethod
    def of(cls, drawing: Drawing) -> Ties:
        """Find the ties of a drawing."""
        points, following = drawing.points, drawing.next_segments.astype(np.intp)
        before = np.empty_like(following)
        before[following] = np.arange(len(following))
        start, end = points[:, 0], points[following, 0]
        third = (end - start) / 3
        out, back = points[:, 1] - start, start - points[before, 2]
        straight = np.abs(out - third).max(axis=1, initial=0) < EXACT
        straight &= np.abs(end - third - points[:, 2]).max(axis=1, initial=0) < EXACT
        along = (out * back).sum(axis=1)
        smooth = (np.abs(cross(out, back)) < EXACT * along) & ~(straight & straight[before])
        return cls(following, before, straight, smooth)

    def gather(self, d_points: FloatArray) -> None:
        """Move the gradients of handles of straight segments to their anchors, in place: (M, 3, 2)."""
        lines = self.straight
        first, second = d_points[lines, 1].copy(), d_points[lines, 2].copy()
        d_points[lines, 0] += (2 * first + second) / 3
        d_points[self.following[lines], 0] += (first + 2 * second) / 3
        d_points[lines, 1:] = 0

    def restore(self, points: FloatArray) -> None:
        """Put the handles of straight segments and smooth joins back, in place: (M, 3, 2) px."""
        lines = np.flatnonzero(self.straight)
        start, end = points[lines, 0], points[self.following[lines], 0]
        points[lines, 1], points[lines, 2] = start + (end - start) / 3, end - (end - start) / 3
        joins = np.flatnonzero(self.smooth)
        earlier = self.before[joins]
        anchor, out, back = points[joins, 0], points[joins, 1], points[earlier, 2]
        way = np.where(
            self.straight[joins][:, None],
            out - anchor,
            np.where(self.straight[earlier][:, None], anchor - back, out - back),
        )
        way = way / np.maximum(np.hypot(*way.T), 1e-12)[:, None]
        ahead, behind = ((out - anchor) * way).sum(axis=1), ((anchor - back) * way).sum(axis=1)
        whole = (ahead > 0) & (behind > 0)
        curved = whole & ~self.straight[joins]
        points[joins[curved], 1] = (anchor + ahead[:, None] * way)[curved]
        curved = whole & ~self.straight[earlier]
        points[earlier[curved], 2] = (anchor - behind[:, None] * way)[curved]
