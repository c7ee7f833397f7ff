# SPDX-License-Identifier: Apache-2.0
"""Coverage: share of each pixel inside a layer's flattened outline, min(|A|, 1).

A is the integral of the winding number over the pixel, which by Green's theorem is a sum over the outline's lines: in
the pixel of column j and row i,

    A = sum over lines of the integral over y in [i, i + 1] of clip(x(y) - j, 0, 1) dy.

Each line is cut at the row borders and its part in a row is compared with every pixel of that row; nothing is carried
from one pixel to the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def coverage(outlines: Sequence[FloatArray], size: tuple[int, int]) -> FloatArray:
    """Return min(|A|, 1): (H, W). `outlines` are the closed polylines (V, 2) of one layer, px."""
    return np.minimum(np.abs(winding_area(outlines, size)), 1.0)


def winding_area(outlines: Sequence[FloatArray], size: tuple[int, int]) -> FloatArray:
    """Return A, positive where the outline turns from the x axis towards the y axis: (H, W), px^2."""
    height, width = size
    area = np.zeros(size)
    start, end = lines_of(outlines)
    sloped = start[:, 1] != end[:, 1]
    start, end = start[sloped], end[sloped]
    top = np.clip(np.floor(np.minimum(start[:, 1], end[:, 1])), 0, height).astype(int)
    bottom = np.clip(np.ceil(np.maximum(start[:, 1], end[:, 1])), 0, height).astype(int)
    num_rows = np.maximum(bottom - top, 0)
    line = np.repeat(np.arange(len(start)), num_rows)
    row = np.arange(len(line)) - np.repeat(np.cumsum(num_rows) - num_rows, num_rows) + top[line]
    start, end = start[line], end[line]

    # The part of the line in the row, from (x_0, y_0) to (x_1, y_1).
    y_0 = np.clip(start[:, 1], row, row + 1)
    y_1 = np.clip(end[:, 1], row, row + 1)
    x_0, x_1 = _abscissa(start, end, y_0), _abscissa(start, end, y_1)

    # Mean over the part of clip(u, 0, 1), where u = x - j runs evenly from low to high: the share between 0 and 1
    # counts with its middle, the share beyond 1 counts with 1.
    column = np.arange(width)
    low, high = np.minimum(x_0, x_1)[:, None] - column, np.maximum(x_0, x_1)[:, None] - column
    low_clipped, high_clipped = np.clip(low, 0, 1), np.clip(high, 0, 1)
    run = np.where(high > low, high - low, 1.0)
    between = (high_clipped - low_clipped) / run
    beyond = (np.maximum(high, 1) - np.maximum(low, 1)) / run
    mean = np.where(high > low, between * (low_clipped + high_clipped) / 2 + beyond, low_clipped)
    np.add.at(area, row, (y_1 - y_0)[:, None] * mean)
    return area


def supersampled(outlines: Sequence[FloatArray], size: tuple[int, int], factor: int = 10) -> FloatArray:
    """Return the share of a pixel's factor x factor samples whose winding number is not 0: (H, W)."""
    height, width = size
    x = (np.arange(width * factor) + 0.5) / factor
    y = (np.arange(height * factor) + 0.5) / factor
    winding = np.zeros((len(y), len(x)), dtype=int)
    for start, end in zip(*lines_of(outlines), strict=True):
        # A ray to the right crosses the line: once down counts +1, once up counts -1.
        crosses = (start[1] <= y) != (end[1] <= y)
        if np.any(crosses):
            sign = 1 if end[1] > start[1] else -1
            crossing = start[0] + (y[crosses] - start[1]) * (end[0] - start[0]) / (end[1] - start[1])
            winding[crosses] += sign * (x[None, :] < crossing[:, None])
    return (winding != 0).reshape(height, factor, width, factor).mean(axis=(1, 3))


def enclosed_area(outlines: Sequence[FloatArray]) -> float:
    """Return the signed area within the closed polylines (shoelace formula), px^2."""
    start, end = lines_of(outlines)
    return float(np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]) / 2)


def lines_of(outlines: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return where the lines of closed polylines start and end: (E, 2) each, px."""
    return np.concatenate(outlines), np.concatenate([np.roll(vertices, -1, axis=0) for vertices in outlines])


def _abscissa(start: FloatArray, end: FloatArray, y: FloatArray) -> FloatArray:
    share = (y - start[:, 1]) / (end[:, 1] - start[:, 1])
    return np.where(share == 1, end[:, 0], start[:, 0] + share * (end[:, 0] - start[:, 0]))
