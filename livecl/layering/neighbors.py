# SPDX-License-Identifier: Apache-2.0
"""Flat regions of a picture, and pairs of neighbouring layers of one colour."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import Float32Array, Int32Array
from livecl.drawing.drawing import Drawing
from livecl.layering.contributions import VISIBLE_SHARE

#: Largest difference of neighbouring pixels, in any channel, within a flat region of a picture.
FLAT_DIFFERENCE = 0.05
#: Largest difference, in any channel and in opacity, of equal colours.
SAME_COLOR = 0.05
#: Largest distance, pixels along a row or column, between visible pixels of neighbouring layers: one mixed pixel may
#: lie between.
NEIGHBOR_DISTANCE = 2


def flat_labels(target: ArrayLike, difference: float = FLAT_DIFFERENCE) -> Int32Array:
    """Label the flat regions of a picture: (H, W), numbered from 0.

    Two of the four neighbours are in one region if they differ by at most `difference` in every channel; regions are
    the connected components. A slow gradient is therefore one region, and an anti-aliased edge falls into small ones.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    target = np.asarray(target, dtype=np.float64)
    index = np.arange(target.shape[0] * target.shape[1]).reshape(target.shape[:2])
    # Levels k/255 are stored rounded: half of the least difference between two of them is below any real one.
    limit = difference + 1e-6
    joined = [
        (first[near], second[near])
        for first, second, near in (
            (index[:, :-1], index[:, 1:], np.abs(np.diff(target, axis=1)).max(axis=2) <= limit),
            (index[:-1], index[1:], np.abs(np.diff(target, axis=0)).max(axis=2) <= limit),
        )
    ]
    first, second = (np.concatenate(ends) for ends in zip(*joined, strict=True))
    edges = coo_array((np.ones(len(first), bool), (first, second)), shape=(index.size, index.size))
    regions: Int32Array = connected_components(edges, directed=False)[1].reshape(index.shape)
    return regions


def mergeable_pairs(drawing: Drawing, shares: Float32Array) -> Int32Array:
    """Return the pairs of neighbouring layers of the same colour: (K, 2), the lower layer first.

    Colours are the same if RGB and opacity differ by at most 0.05 each. Layers are neighbours if visible pixels of the
    two are adjacent in a row or column, or one pixel apart: an edge between two layers may have a mixed pixel that is
    visible in neither.
    """
    owner = np.full(drawing.size, -1, np.int32)
    for layer, share in enumerate(shares):
        owner[share > VISIBLE_SHARE] = layer
    pairs = []
    for step in range(1, NEIGHBOR_DISTANCE + 1):
        for first, second in ((owner[:, :-step], owner[:, step:]), (owner[:-step], owner[step:])):
            differ = (first != second) & (first >= 0) & (second >= 0)
            pairs.append(np.stack([first[differ], second[differ]], axis=1))
    neighbors = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    difference = np.abs(drawing.colors[neighbors[:, 0]] - drawing.colors[neighbors[:, 1]])
    same: Int32Array = neighbors[difference.max(axis=1, initial=0.0) <= SAME_COLOR + 1e-9]
    return same
