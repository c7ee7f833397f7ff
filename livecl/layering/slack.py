# SPDX-License-Identifier: Apache-2.0
"""Slack of edges: how far the edges of a picture may lie off, measured on the picture itself.

Renderers that sample a pixel N x N times set an edge off by up to half a step, 1 / (2 N) px: along the grid all of it
alike, elsewhere in a pattern of steps. A free outline follows this, so that it needs more numbers than the line
drawn, and shows nothing that anybody sees. From the pattern the offset is known: of circles and rectangles sampled
N x N times, the half step is 4 times the jitter of the outline for N = 2, 7 times for 4, 11 times for 8, and resvg's,
of .125 px, is 4 times the jitter of its pictures. Exact coverages and cairo's have a jitter below .01 px.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from livecl.arrays import FloatArray
from livecl.geometry.corners import jitter_of

#: Offset of edges as a multiple of their jitter, and the largest offset, px, that is believed.
OFFSET, MOST = 4.0, 0.25


def edge_offset(outlines: Sequence[FloatArray]) -> float:
    """Return the distance, px, that edges may lie off, from the outlines traced on them, closed polylines (n, 2)."""
    return min(OFFSET * jitter_of(outlines), MOST)


def edge_slack(target: FloatArray, offset: float) -> FloatArray:
    """Return the errors (H, W, C) that a picture's edges are uncertain by: their offset, px, times their contrast.

    An edge set off by d px changes a pixel by d times the difference of its two sides; d sqrt(2) at most, on a slant.
    """
    if not offset:
        return np.zeros_like(target)
    contrast = ndimage.maximum_filter(target, (3, 3, 1)) - ndimage.minimum_filter(target, (3, 3, 1))
    return np.asarray(offset * contrast)
