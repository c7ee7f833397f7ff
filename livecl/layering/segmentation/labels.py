# SPDX-License-Identifier: Apache-2.0
"""Labels of pixels: connected components of a relation between neighbours, and their mean colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray, IntArray

#: Structuring element of a pixel and its eight neighbours.
EIGHT_NEIGHBORS = np.ones((3, 3), bool)


def grid_components(right: NDArray[np.bool_], down: NDArray[np.bool_]) -> IntArray:
    """Label the components of pixels connected to right and lower neighbours, from 0 on in the order of their pixels.

    They are the components of a picture twice as wide and high, of the pixels and what connects them.
    """
    height, width = right.shape[0], down.shape[1]
    joined = np.zeros((2 * height - 1, 2 * width - 1), bool)
    joined[::2, ::2], joined[::2, 1::2], joined[1::2, ::2] = True, right, down
    return np.asarray(ndimage.label(joined)[0][::2, ::2], dtype=np.int64) - 1


def equal_components(labels: IntArray) -> IntArray:
    """Label the components of pixels connected to any of eight equal neighbours, from 0 on in the order of pixels."""
    from skimage.measure import label

    return np.asarray(label(labels, background=-1, connectivity=2), dtype=np.int64) - 1


def with_blocks(labels: IntArray) -> IntArray:
    """Renumber the labels (H, W) that hold a block of 2 x 2 pixels from 1 on; 0 elsewhere."""
    interruption.check()
    corner = labels[1:, 1:]
    block = (corner == labels[:-1, :-1]) & (corner == labels[1:, :-1]) & (corner == labels[:-1, 1:])
    has_block = np.zeros(labels.max() + 1, bool)
    has_block[corner[block]] = True
    return np.asarray(np.where(has_block, np.cumsum(has_block), 0)[labels])


def means_of(labels: IntArray, image: FloatArray) -> FloatArray:
    """Return the mean colour of each label: (K + 1, C)."""
    count = np.bincount(labels.ravel())
    sums = [np.bincount(labels.ravel(), weights=image[..., c].ravel()) for c in range(image.shape[2])]
    return np.asarray(np.stack(sums, axis=1) / np.maximum(count, 1)[:, None])
