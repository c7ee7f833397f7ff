# SPDX-License-Identifier: Apache-2.0
"""Region growing: merge neighbouring regions while one mean colour for both adds less error than a price.

References
----------
G. Koepfler, C. Lopez, J.-M. Morel: *A Multiscale Algorithm for Image Segmentation by Variational Method*. SIAM Journal
on Numerical Analysis 31, 1994.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray, IntArray

#: Price of the first pass, squared error, and its factor from pass to pass: cheap merges come first, so that expensive
#: ones compare the colours of whole regions.
FIRST, STEP = 1e-3, 4.0


def grown(labels: IntArray, image: FloatArray, prices: Sequence[float]) -> Iterator[IntArray]:
    """Merge neighbouring regions while that adds less squared error than a price; yield the labels for each price.

    One colour for regions of n and m pixels, of mean colours c and d, adds n m / (n + m) |c - d|^2. In each round,
    regions merge with their cheapest neighbours, the smaller into the larger, unless these move themselves.

    Parameters
    ----------
    labels : (H, W) int
        Regions to begin with, numbered from 0 on.
    image : (H, W, C) float
        The picture.
    prices : sequence of float
        Squared errors, rising.
    """
    count = int(labels.max()) + 1
    area = np.bincount(labels.ravel(), minlength=count).astype(np.float64)
    sums = np.stack([np.bincount(labels.ravel(), channel.ravel(), count) for channel in np.moveaxis(image, -1, 0)], 1)
    pairs = np.concatenate(
        [
            np.stack([one[one != other], other[one != other]], axis=1)
            for one, other in ((labels[:, 1:], labels[:, :-1]), (labels[1:], labels[:-1]))
        ]
    )
    owner, most = np.arange(count), FIRST
    for price in prices:
        while True:
            most = min(most, price)
            while len(pairs):
                interruption.check()
                pairs = _distinct(pairs, count)
                interruption.check()
                moved = _moves(pairs, area, sums / area[:, None], most)
                interruption.check()
                gone = np.flatnonzero(moved != np.arange(count))
                if not len(gone):
                    break
                np.add.at(area, moved[gone], area[gone])
                np.add.at(sums, moved[gone], sums[gone])
                owner, pairs = moved[owner], moved[pairs]
                pairs = pairs[pairs[:, 0] != pairs[:, 1]]
            if most >= price:
                break
            most *= STEP
        interruption.check()
        yield np.unique(owner, return_inverse=True)[1][labels]


def _distinct(pairs: IntArray, count: int) -> IntArray:
    """Return each pair (P, 2) of numbers below `count` once, the smaller number first."""
    pairs = np.sort(pairs, axis=1)
    codes = np.unique(pairs[:, 0] * count + pairs[:, 1])
    return np.stack([codes // count, codes % count], axis=1)


def _moves(pairs: IntArray, area: FloatArray, means: FloatArray, most: float) -> IntArray:
    """Return the region into which each merges, itself if it stays: (N,)."""
    one, other = pairs.T
    cost = area[one] * area[other] / (area[one] + area[other]) * np.square(means[one] - means[other]).sum(axis=1)
    interruption.check()
    order = np.argsort(-cost, kind="stable")
    best = np.full(len(area), -1)
    best[pairs[order].ravel()] = np.repeat(order, 2)  # the last one written is the cheapest
    small, large = np.where(area[one] <= area[other], (one, other), (other, one))
    wanted = (best[small] == np.arange(len(cost))) & (cost < most)
    moves = np.zeros(len(area), bool)
    moves[small[wanted]] = True
    joined = wanted & (~moves[large] | (best[large] == np.arange(len(cost))))
    moved = np.arange(len(area))
    moved[small[joined]] = large[joined]
    return moved
