# SPDX-License-Identifier: Apache-2.0
"""How far a single-precision result may lie from the exact one: number of operations x unit roundoff x scale.

All are bounds of the worst case, in which every rounding errs the same way; real errors lie some ten times below.
They hold for generic drawings, where no pixel that an edge crosses has |A| within rounding of 0 or 1: there the
derivative itself jumps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing import Drawing
from reference.coverage import lines_of
from reference.flatten import flatten

#: Relative error of one rounding in float32.
UNIT = 2.0**-24

#: Roundings in a vertex: 4 control points converted, 4 weights, 4 products, 3 sums, of parts that add up to the scale.
VERTEX_OPERATIONS = 8
#: Further roundings, each of the scale, in where a line meets a pixel border: difference, quotient, product, sum.
CROSSING_OPERATIONS = 4


def coverage_tolerance(drawing: Drawing, pieces: ArrayLike) -> NDArray[np.float64]:
    """Return the largest error of each layer's coverage: (N,).

    A line whose ends and crossings are off by e moves at most 2 e of area into or out of a pixel (the pixel is 1 wide
    and 1 high). All K lines of the row deposit, and their at most K + W deposits, of at most K in all, are summed.
    """
    tolerances = []
    for outlines in flatten(drawing, pieces):
        lines = _lines_per_row(outlines, drawing.size[0])
        position = (VERTEX_OPERATIONS + CROSSING_OPERATIONS) * _scale(drawing)
        tolerances.append(UNIT * lines * (2 * position + lines + drawing.size[1]))
    return np.array(tolerances)


def image_tolerance(drawing: Drawing, pieces: ArrayLike) -> float:
    """Return the largest error of the image: the layers' coverage errors, and 6 roundings of `over` a layer."""
    return float(np.sum(coverage_tolerance(drawing, pieces)) + UNIT * (6 * drawing.num_layers + 2))


def points_tolerance(drawing: Drawing, pieces: ArrayLike, d_image: NDArray[np.float64]) -> float:
    """Return the largest error of an entry of d_points.

    A line's ends receive n times the sum over its C crossed pixels of g times an integral over the line's share in the
    pixel, |n| being its length. The share's ends are off by a crossing's error, g by what the image is off, relatively.
    A control point receives from the lines of its own segment and of the one before, with weights of at most 1.
    """
    largest_g = d_image.shape[2] * float(np.max(np.abs(d_image)))
    position = (VERTEX_OPERATIONS + CROSSING_OPERATIONS) * _scale(drawing)
    d_error = 2 * image_tolerance(drawing, pieces)
    starts, ends = zip(*(lines_of(outlines) for outlines in flatten(drawing, pieces)), strict=True)
    start, end = np.concatenate(starts), np.concatenate(ends)
    crossed = 1 + np.sum(np.abs(np.floor(end) - np.floor(start)), axis=1)
    error = largest_g * (2 * crossed * UNIT * position + np.hypot(*(end - start).T) * (d_error + UNIT * crossed))
    return 2 * float(np.max(np.add.reduceat(error, np.cumsum(pieces) - pieces)))


def colors_tolerance(drawing: Drawing, pieces: ArrayLike, d_image: NDArray[np.float64]) -> float:
    """Return the largest error of an entry of d_colors or d_background.

    A sum over P pixels of products, each off relatively by what the image is off, and P roundings of partial sums.
    """
    total = float(np.sum(np.abs(d_image)))
    num_pixels = drawing.size[0] * drawing.size[1]
    return total * (2 * image_tolerance(drawing, pieces) + UNIT * num_pixels)


def _scale(drawing: Drawing) -> float:
    return float(max(np.max(np.abs(drawing.points), initial=1.0), *drawing.size))


def _lines_per_row(outlines: list[NDArray[np.float64]], height: int) -> int:
    start, end = lines_of(outlines)
    top, bottom = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    row = np.arange(height)[:, None]
    return int(np.max(np.sum((top <= row + 1) & (bottom >= row), axis=1)))
