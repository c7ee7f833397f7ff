# SPDX-License-Identifier: Apache-2.0
"""Masks of regions: their borders, holes, connected parts and convex hulls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import BoolArray


def border(mask: BoolArray) -> NDArray[np.float64]:
    """Trace the outer border of a region (H, W) as a closed polyline (P, 2), px; holes are ignored."""
    from skimage.measure import find_contours

    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = rows[0], columns[0]
    filled = without_holes(np.pad(mask[top : rows[-1] + 1, left : columns[-1] + 1], 1))
    contour = max(find_contours(filled.astype(np.float64), 0.5), key=len)[:-1]
    return np.asarray(contour[:, ::-1] + (left - 0.5, top - 0.5))  # of pixel centres; one pixel of padding


def without_holes(mask: BoolArray) -> BoolArray:
    """Fill the holes of a region (H, W): the pixels not 4-connected to the outside."""
    return np.asarray(_surroundings(mask) != 1)


def holes(mask: BoolArray, smallest: int) -> list[BoolArray]:
    """Return the holes of a region (H, W) of at least `smallest` pixels, the largest first."""
    return filled_and_holes(mask, smallest)[1]


def filled_and_holes(mask: BoolArray, smallest: int) -> tuple[BoolArray, list[BoolArray]]:
    """Return the results of :func:`without_holes` and :func:`holes` from one labelling."""
    labels = _surroundings(mask)
    areas = np.bincount(labels.ravel(), minlength=2)
    areas[:2] = 0  # the region itself, and what surrounds it
    return labels != 1, [labels == k for k in np.argsort(-areas, kind="stable") if areas[k] >= smallest]


def _surroundings(mask: BoolArray) -> NDArray[np.int32]:
    """Label the complement of a region (H, W), 4-connected: 1 outside, higher numbers in holes; 0 in the region."""
    from scipy.ndimage import label

    return np.asarray(label(~np.pad(mask, 1))[0][1:-1, 1:-1])  # the corner of the padding is labelled first


def connected_part(mask: BoolArray, pixel: tuple[int, ...]) -> BoolArray:
    """Return the part of a region (H, W) that is 4-connected to one of its pixels (row, column)."""
    from scipy.ndimage import label

    labels = label(mask)[0]
    return np.asarray(labels == labels[pixel])


def convex_hull(mask: BoolArray) -> BoolArray:
    """Return the pixels (H, W) whose centres lie in the convex hull of a region, or on its border.

    The hull of the midpoints of all pixel sides, as scikit-image's `convex_hull_image`, but row by row and in integers.
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
    """Return the first column of the hull in each row of `at`, given the first pixels of some.

    Coordinates are in half pixels, at the midpoints of upper, left and lower sides. Points on or inside the chord of
    their neighbours are removed until none is left.
    """
    height = 2 * int(rows[-1] - rows[0]) + 3
    nearest = np.full(height, np.iinfo(np.intp).max)
    y = 2 * (rows - rows[0]) + 1
    nearest[y] = 2 * first - 1
    for side in (y - 1, y + 1):  # of one kind, no two rows have the same
        nearest[side] = np.minimum(nearest[side], 2 * first)
    ys = np.flatnonzero(nearest < np.iinfo(np.intp).max)
    xs = nearest[ys]
    while len(ys) > 2:
        down, across = ys[1:] - ys[:-1], xs[1:] - xs[:-1]
        corner = across[:-1] * down[1:] < across[1:] * down[:-1]
        if corner.all():
            break
        kept = np.concatenate([[True], corner, [True]])
        ys, xs = ys[kept], xs[kept]
    wanted = 2 * (at - rows[0]) + 1
    side = np.searchsorted(ys, wanted, side="right") - 1
    rise = ys[side + 1] - ys[side]
    reached = xs[side] * rise + (wanted - ys[side]) * (xs[side + 1] - xs[side])
    return np.asarray(-(-reached // (2 * rise)))
