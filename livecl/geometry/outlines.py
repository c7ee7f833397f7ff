# SPDX-License-Identifier: Apache-2.0
"""Outlines for new layers: a circle, a random outline, and the borders and holes of regions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def circle(center: ArrayLike, radius: float, segments: int) -> FloatArray:
    """Return a closed path whose 3s control points lie evenly on a circle: (s, 3, 2) px."""
    angles = 2 * np.pi * np.arange(3 * segments) / (3 * segments)
    points = np.asarray(center) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points.reshape(segments, 3, 2)


def random_outline(center: ArrayLike, segments: int, size: tuple[int, int], rng: np.random.Generator) -> FloatArray:
    """Return a random closed path (s, 3, 2) px: each control point within 2.5 % of the canvas of the one before.

    The outline of DiffVG's random paths (Li et al. 2020), as far as the paper's baseline and ablation go.
    """
    steps = rng.uniform(-0.5, 0.5, size=(3 * segments, 2)) * 0.05 * np.array([size[1], size[0]])
    steps[0] = 0
    return (np.asarray(center) + np.cumsum(steps, axis=0)).reshape(segments, 3, 2)


def reversed_path(path: FloatArray) -> FloatArray:
    """Return a closed path (s, 3, 2) run through the other way round, from the same anchor on."""
    return np.roll(path.reshape(-1, 2)[::-1], 1, axis=0).reshape(path.shape)


def border(mask: NDArray[np.bool_]) -> FloatArray:
    """Return the outer border of a region (H, W) as a closed polyline (P, 2), px; holes are filled."""
    from skimage.measure import find_contours

    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = rows[0], columns[0]
    filled = without_holes(np.pad(mask[top : rows[-1] + 1, left : columns[-1] + 1], 1))
    contour = max(find_contours(filled.astype(np.float64), 0.5), key=len)[:-1]
    return np.asarray(contour[:, ::-1] + (left - 0.5, top - 0.5))  # of pixel centres; one pixel of padding


def without_holes(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a region (H, W) with its holes filled: what is not connected, by sides of pixels, to the outside."""
    from skimage.measure import label

    outside = label(~np.pad(mask, 1), connectivity=1)[1:-1, 1:-1] == 1  # the corner of the padding is labelled first
    return ~outside


def holes(mask: NDArray[np.bool_], smallest: int) -> list[NDArray[np.bool_]]:
    """Return the holes of a region (H, W) of at least `smallest` pixels, the largest first."""
    from skimage.measure import label

    labels = label(~np.pad(mask, 1), connectivity=1)[1:-1, 1:-1]
    areas = np.bincount(labels.ravel(), minlength=2)
    areas[:2] = 0  # the region itself, and what surrounds it
    return [labels == k for k in np.argsort(-areas, kind="stable") if areas[k] >= smallest]
