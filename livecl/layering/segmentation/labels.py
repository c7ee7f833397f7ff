# SPDX-License-Identifier: Apache-2.0
"""Labels of pixels: connected components of a relation between neighbours, and their mean colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from livecl import interruption
from livecl.arrays import FloatArray, IntArray

#: Structuring element of a pixel and its eight neighbours.
EIGHT_NEIGHBORS = np.ones((3, 3), bool)


def grid_components(right: NDArray[np.bool_], down: NDArray[np.bool_], *slanted: NDArray[np.bool_]) -> IntArray:
    """Label the components of pixels connected to right, lower and, optionally, diagonal neighbours."""
    height, width = right.shape[0], down.shape[1]
    n = np.arange(height * width).reshape(height, width)
    starts, ends = [n[:, :-1][right], n[:-1][down]], [n[:, 1:][right], n[1:][down]]
    if slanted:
        starts += [n[:-1, :-1][slanted[0]], n[:-1, 1:][slanted[1]]]
        ends += [n[1:, 1:][slanted[0]], n[1:, :-1][slanted[1]]]
    a, b = np.concatenate(starts), np.concatenate(ends)
    graph = sparse.coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(n.size, n.size))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64).reshape(height, width)


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
