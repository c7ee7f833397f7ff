# SPDX-License-Identifier: Apache-2.0
"""Small regions explained by their neighbours: specks, blends of two colours, noise and ringing."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.layering.segmentation.labels import EIGHT_NEIGHBORS

#: Largest difference within one colour, and per unit of noise.
SAME_STEP, ALIKE_OF_NOISE = 2.5 / 255, 3.0
#: Largest region, as a multiple of the smallest one kept, that may be a blend of two neighbours.
BLENDED = 5
#: Contrast of a small or thin region up to which it counts as compression ringing, as a share of the contrast of the
#: edge along it; share of a region's pixels in 3 x 3 blocks below which it is thin.
RINGING, THIN_SHARE = 0.3, 0.5


def without_small(
    parts: IntArray, colors: FloatArray, smallest: int, miss: float, sure: NDArray[np.bool_], noise: float
) -> IntArray:
    """Merge regions that are too small, or that their neighbours explain, into the neighbour of nearest colour.

    Regions that are `sure` have a colour of their own.
    """
    sizes = np.bincount(parts.ravel())
    boxes = ndimage.find_objects(parts + 1)
    for part in np.argsort(sizes, kind="stable"):
        interruption.check()
        if sizes[part] >= smallest and not noise and (sure[part] or sizes[part] >= BLENDED * smallest):
            continue
        box = tuple(slice(max(s.start - 1, 0), s.stop + 1) for s in boxes[part])
        inside = parts[box] == part
        around = np.unique(parts[box][ndimage.binary_dilation(inside, EIGHT_NEIGHBORS) & ~inside])
        if not len(around) or not inside.any():
            continue
        contrast = np.abs(colors[around] - colors[part]).max(axis=1)
        if sizes[part] >= smallest:
            explained = noise > 0 and contrast.min() <= SAME_STEP + ALIKE_OF_NOISE * noise
            if not explained and not sure[part]:
                little = sizes[part] < BLENDED * smallest
                explained = little and _is_blend(colors[part], colors[around], miss)
                explained |= noise > 0 and (little or _is_thin(inside)) and _is_ringing(contrast.min(), colors[around])
            if not explained:
                continue
        target = around[np.argmin(contrast)]
        parts[box][inside] = target
        sizes[target] += sizes[part]
        boxes[target] = tuple(
            slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(boxes[target], boxes[part], strict=True)
        )
    return parts


def _is_thin(inside: NDArray[np.bool_]) -> bool:
    """Whether few of a region's pixels lie in 3 x 3 blocks of it."""
    return bool(ndimage.binary_opening(inside, EIGHT_NEIGHBORS).sum() < THIN_SHARE * inside.sum())


def _is_ringing(contrast: float, others: FloatArray) -> bool:
    """Whether a contrast is small compared with that of the edge between other colours (K, C)."""
    return bool(contrast < RINGING * np.abs(others[:, None] - others[None]).max())


def _is_blend(color: FloatArray, others: FloatArray, miss: float) -> bool:
    """Whether a colour lies between two others, within a tolerance."""
    for a, b in itertools.combinations(others, 2):
        share = float((color - b) @ (a - b) / max(float((a - b) @ (a - b)), 1e-12))
        if 0 <= share <= 1 and np.abs(color - b - share * (a - b)).max() <= miss:
            return True
    return False
