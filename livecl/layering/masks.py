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
