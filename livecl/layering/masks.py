# SPDX-License-Identifier: Apache-2.0
"""Regions as masks of pixels: their borders, their holes, the part that hangs together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]


def border(mask: BoolArray) -> NDArray[np.float64]:
    """Return the outer border of a region (H, W) as a closed polyline (P, 2), px; holes are filled."""
    from skimage.measure import find_contours

    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = rows[0], columns[0]
    filled = without_holes(np.pad(mask[top : rows[-1] + 1, left : columns[-1] + 1], 1))
    contour = max(find_contours(filled.astype(np.float64), 0.5), key=len)[:-1]
    return np.asarray(contour[:, ::-1] + (left - 0.5, top - 0.5))  # of pixel centres; one pixel of padding


def without_holes(mask: BoolArray) -> BoolArray:
    """Return a region (H, W) with its holes filled: pixels not connected, by their sides, to the outside."""
    from skimage.measure import label

    outside = label(~np.pad(mask, 1), connectivity=1)[1:-1, 1:-1] == 1  # the corner of the padding is labelled first
    return ~outside


def holes(mask: BoolArray, smallest: int) -> list[BoolArray]:
    """Return the holes of a region (H, W) of at least `smallest` pixels, the largest first."""
    from skimage.measure import label

    labels = label(~np.pad(mask, 1), connectivity=1)[1:-1, 1:-1]
    areas = np.bincount(labels.ravel(), minlength=2)
    areas[:2] = 0  # the region itself, and what surrounds it
    return [labels == k for k in np.argsort(-areas, kind="stable") if areas[k] >= smallest]


def connected(mask: BoolArray, pixel: tuple[int, ...]) -> BoolArray:
    """Return the part of a region (H, W) that is connected, by sides of pixels, to one of its pixels (row, column)."""
    from skimage.measure import label

    labels = label(mask, connectivity=1)
    return np.asarray(labels == labels[pixel])


def convex_hull(mask: BoolArray) -> BoolArray:
    """Return the pixels (H, W) whose centres lie in the convex hull of a region, or on its border.

    The hull of the middles of all sides of the region's pixels, as scikit-image's `convex_hull_image` has it, but row
    by row and in whole numbers.
    """
    rows = np.flatnonzero(mask.any(axis=1))
    filled = np.zeros_like(mask)
    if not len(rows):
        return filled
    width = mask.shape[1]
    first = mask[rows].argmax(axis=1)
    last = width - 1 - mask[rows, ::-1].argmax(axis=1)
    at = np.arange(rows[0], rows[-1] + 1)
    starts = _convex_side(rows, first, at)
    ends = width - 1 - _convex_side(rows, width - 1 - last, at)
    columns = np.arange(width)
    filled[at] = (columns >= starts[:, None]) & (columns <= ends[:, None])
    return filled


def _convex_side(rows: NDArray[np.intp], first: NDArray[np.intp], at: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the first column of the hull in each row of `at`, given the first pixels of some: monotone chain."""
    nearest: dict[int, int] = {}  # in half pixels: the middles of upper, left and lower sides
    for row, column in zip((2 * rows).tolist(), (2 * first).tolist(), strict=True):
        for y, x in ((row - 1, column), (row, column - 1), (row + 1, column)):
            nearest[y] = min(x, nearest.get(y, x))
    chain: list[tuple[int, int]] = []
    for y, x in sorted(nearest.items()):
        while len(chain) > 1:
            (y0, x0), (y1, x1) = chain[-2:]
            if (x1 - x0) * (y - y0) < (x - x0) * (y1 - y0):
                break
            chain.pop()
        chain.append((y, x))
    ys, xs = np.array(chain).T
    side = np.searchsorted(ys, 2 * at, side="right") - 1
    rise = ys[side + 1] - ys[side]
    reached = xs[side] * rise + (2 * at - ys[side]) * (xs[side + 1] - xs[side])
    return np.asarray(-(-reached // (2 * rise)))
