# SPDX-License-Identifier: Apache-2.0
"""Whole-shape scores: how well the things of a drawing overlap those of the drawing that the picture was made from.

A *thing* is a connected part of one layer drawn alone, what others hide of it included.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Coverage from which on a pixel belongs to a thing, pixels of the smallest thing, and the share of a thing that others
#: must cover for it to count as partly hidden.
INSIDE, SMALLEST, HIDDEN_SHARE = 0.5, 4, 0.01
#: Largest difference, of any channel, of the colours of two things that are matched.
COLOR_DIFFERENCE = 0.08


@dataclasses.dataclass(frozen=True)
class Things:
    """Connected parts of layers.

    Attributes
    ----------
    masks : (K, H, W) bool
        Pixels of each thing, hidden ones included.
    colors : (K, 3) float
        Straight RGB.
    layers : (K,) int
        Layer that each is a part of, 0 at the bottom.
    hidden : (K,) float
        Share of each thing's pixels that other layers cover.
    """

    masks: NDArray[np.bool_]
    colors: NDArray[np.float64]
    layers: NDArray[np.intp]
    hidden: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.masks)


def things_of(coverages: NDArray[Any], colors: NDArray[Any]) -> Things:
    """Return the things of layers, from coverages (N, H, W) and colours, (N, 3) or straight (N, 4)."""
    from skimage.measure import label

    inside = np.asarray(coverages) >= INSIDE
    above = np.zeros(inside.shape[1:], bool)
    masks, layers, hidden = [], [], []
    for layer in range(len(inside) - 1, -1, -1):
        labels = label(inside[layer], connectivity=2)
        sizes = np.bincount(labels.ravel())
        for k in range(1, len(sizes)):
            if sizes[k] >= SMALLEST:
                mask = labels == k
                masks.append(mask)
                layers.append(layer)
                hidden.append(np.count_nonzero(mask & above) / sizes[k])
        above |= inside[layer]
    order = np.arange(len(masks))[::-1]
    size = inside.shape[1:]
    return Things(
        np.array(masks).reshape(-1, *size)[order],
        np.asarray(colors, dtype=np.float64)[np.array(layers, int)[order], :3].reshape(-1, 3),
        np.array(layers, np.intp)[order],
        np.array(hidden, np.float64)[order],
    )


def overlaps(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Intersection over union of each of some masks (K, H, W) with each of others (L, H, W): (K, L)."""
    first = a.reshape(len(a), -1).astype(np.float32)
    second = b.reshape(len(b), -1).astype(np.float32)
    common = first @ second.T
    union = first.sum(1)[:, None] + second.sum(1)[None, :] - common
    return np.asarray(common / np.maximum(union, 1), dtype=np.float64)


def match_things(true: Things, ours: Things) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Match things one to one for the largest total overlap (Hungarian): overlap (K,), 0 and -1 where unmatched."""
    from scipy.optimize import linear_sum_assignment

    scores, partner = np.zeros(len(true)), np.full(len(true), -1, np.intp)
    if len(true) and len(ours):
        near = np.abs(true.colors[:, None] - ours.colors[None]).max(axis=2) <= COLOR_DIFFERENCE
        table = overlaps(true.masks, ours.masks) * near
        rows, columns = linear_sum_assignment(-table)
        good = table[rows, columns] > 0
        scores[rows[good]] = table[rows, columns][good]
        partner[rows[good]] = columns[good]
    return scores, partner
