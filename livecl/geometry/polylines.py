# SPDX-License-Identifier: Apache-2.0
"""Polylines: lengths along them, areas within, points at equal steps of length, directions."""

from __future__ import annotations

import numpy as np

from livecl.arrays import BoolArray, FloatArray
from livecl.geometry import cyclic


def lengths_along(points: FloatArray) -> FloatArray:
    """Return the length, px, of a polyline (n, 2) up to each of its points, from 0 on: (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def points_at(places: FloatArray, points: FloatArray, lengths: FloatArray) -> FloatArray:
    """Return the points (k, 2) at places (k,), px, along a polyline (n, 2) of known :func:`lengths_along`."""
    return np.stack([np.interp(places, lengths, points[:, axis]) for axis in (0, 1)], axis=1)


def evenly(outline: FloatArray, count: int | None = None) -> FloatArray:
    """Return `count` points at equal steps along a closed polyline (n, 2); by default at about 1 px, at least 8."""
    closed = np.concatenate([outline, outline[:1]])
    lengths = lengths_along(closed)
    count = max(8, round(lengths[-1])) if count is None else count
    return points_at(np.linspace(0, lengths[-1], count, endpoint=False), closed, lengths)


def unit(vectors: FloatArray) -> FloatArray:
    """Normalize vectors (..., 2); zero vectors stay zero."""
    lengths = np.hypot(vectors[..., 0], vectors[..., 1])[..., None]
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1))


def polygon_area(points: FloatArray) -> float:
    """Return the signed area of a closed polyline (n, 2), px^2: positive if clockwise on the screen."""
    x, y = points.T
    return 0.5 * float(x[:-1] @ y[1:] - y[:-1] @ x[1:] + x[-1] * y[0] - y[-1] * x[0])


def polygon_mask(points: FloatArray, size: tuple[int, int]) -> BoolArray:
    """Return the pixels (H, W) whose centres lie in a closed polyline (n, 2), px, by the even-odd rule.

    Each edge flips all pixels to the right of where it crosses the middle of a row. The lower end of an edge does not
    belong to it, so that a vertex on such a line counts once for an outline that goes on, and twice or not at all for
    one that turns back. A centre on an edge is inside if the area lies to its right.
    """
    height, width = size
    ends = cyclic.following(points)
    first, last = (
        np.clip(np.ceil(bound(points[:, 1], ends[:, 1]) - 0.5), 0, height).astype(np.int64)
        for bound in (np.minimum, np.maximum)
    )
    counts = last - first
    edges = np.repeat(np.arange(len(points)), counts)
    rows = np.arange(len(edges)) - np.repeat(np.cumsum(counts) - counts, counts) + first[edges]
    way = ends[edges] - points[edges]
    x = points[edges, 0] + (rows + 0.5 - points[edges, 1]) * (way[:, 0] / way[:, 1])
    columns = np.clip(np.ceil(x - 0.5), 0, width).astype(np.int64)
    flips = np.bincount(rows * (width + 1) + columns, minlength=height * (width + 1)).reshape(height, width + 1)
    return np.asarray(np.cumsum(flips, axis=1)[:, :-1] % 2 == 1)
