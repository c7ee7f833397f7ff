# SPDX-License-Identifier: Apache-2.0
"""The paper's component-wise path initialization, steps a-d: the largest components of the colour difference."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.options import Options


@dataclasses.dataclass(frozen=True)
class Place:
    """Start of a path: its centre (x, y) px, a pixel (row, column) there, and the component's mask, if any."""

    center: FloatArray
    pixel: IntArray
    mask: BoolArray | None = None


def component_places(target: NDArray[Any], image: NDArray[Any], count: int, options: Options) -> list[Place]:
    """Return the largest components of the error, then, when these run out, the pixels of largest error."""
    difference = np.abs(target - image).sum(axis=-1, dtype=np.float64)  # step a
    if options.variant == "released":
        difference = np.square(target - image).sum(axis=-1, dtype=np.float64)
    labels, bins = components(difference, options)
    places = [_component_place(labels == component) for component in _ranked(labels, bins, options)[:count]]
    taken = [place.pixel for place in places]
    for pixel in _largest_errors(difference, taken, count - len(places), 2 * options.radius):
        places.append(Place(pixel[::-1].astype(np.float64) + 0.5, pixel))
    return places


def components(difference: FloatArray, options: Options) -> tuple[IntArray, IntArray]:
    """Label the 4-connected components of quantized colour differences, and return the bins (steps b-c).

    Returns
    -------
    ((H, W) int, (H, W) int)
        Label of each pixel and its bin, both from 1 on; 0 where the difference is under the threshold.
    """
    wanted = difference >= options.color_threshold
    if not wanted.any():
        return np.zeros(difference.shape, np.int64), np.zeros(difference.shape, np.int64)
    # Bins of equal population: among the differences left, or (the released program) among all, the small ones being 0.
    shares = np.linspace(0, 1, options.bins + 1)
    if options.variant == "released":
        edges = _distinct(np.quantile(np.where(wanted, difference, 0.0), shares))[1:-1]
    else:
        edges = _distinct(np.quantile(difference[wanted], shares[1:-1]))
    bins = np.where(wanted, np.digitize(difference, edges) + 1, 0)
    return labels_of(bins), bins


def _distinct(rising: FloatArray) -> FloatArray:
    """Return the distinct ones of rising numbers: `np.unique` takes longer to load than this function to run."""
    return np.asarray(rising[np.append(True, rising[1:] > rising[:-1])[: len(rising)]])


def labels_of(bins: IntArray) -> IntArray:
    """Label the 4-connected components of equal bins (H, W) from 1 on, in the order of their first pixels; 0 stays 0.

    By runs of equal pixels within the rows: each run has the least number of those that touch it in the rows beside
    it, until none changes. (SciPy's and scikit-image's labelling are as quick, but take longer to load than a run.)
    """
    starts = np.ones(bins.shape, bool)
    starts[:, 1:] = bins[:, 1:] != bins[:, :-1]
    runs = np.cumsum(starts).reshape(bins.shape) - 1
    touching = bins[1:] == bins[:-1]
    above, below = runs[:-1][touching], runs[1:][touching]
    new = np.ones(len(above), bool)
    new[1:] = (above[1:] != above[:-1]) | (below[1:] != below[:-1])
    above, below = above[new], below[new]
    least = np.arange(runs[-1, -1] + 1)
    while len(above):
        np.minimum.at(least, np.maximum(above, below), np.minimum(above, below))
        while not np.array_equal(further := least[least], least):
            least = further
        above, below = least[above], least[below]
        apart = above != below
        above, below = above[apart], below[apart]
    filled = bins.ravel()[starts.ravel()] > 0
    numbers = np.cumsum(filled & (least == np.arange(len(least))))
    return np.asarray(np.where(filled, numbers[least], 0)[runs])


def _ranked(labels: IntArray, bins: IntArray, options: Options) -> list[int]:
    """Order components by decreasing size; `released`: each time the largest of the bin with most pixels left."""
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    by_size = [int(i) for i in np.argsort(-sizes, kind="stable") if sizes[i]]
    if options.variant == "paper":
        return by_size
    bin_of = np.zeros(len(sizes), np.int64)
    bin_of[labels.ravel()] = bins.ravel()
    left = np.bincount(bin_of, weights=sizes)
    ranked: list[int] = []
    queues = {b: [i for i in by_size if bin_of[i] == b] for b in np.unique(bin_of[by_size])}
    while queues:
        fullest = max(queues, key=lambda b: left[b])
        ranked.append(queues[fullest].pop(0))
        left[fullest] -= sizes[ranked[-1]]
        if not queues[fullest]:
            del queues[fullest]
    return ranked


def _component_place(mask: BoolArray) -> Place:
    """Return the centre of mass of a component, or its own pixel nearest to that (step d)."""
    members = np.argwhere(mask)
    mean = np.asarray(members.mean(axis=0), dtype=np.float64)
    pixel = np.floor(mean + 0.5).astype(np.int64)
    if mask[tuple(pixel)]:
        return Place(mean[::-1] + 0.5, pixel, mask)
    nearest = members[np.argmin(np.square(members - mean).sum(axis=1))]
    return Place(nearest[::-1] + 0.5, nearest, mask)


def _largest_errors(difference: FloatArray, taken: list[IntArray], count: int, apart: float) -> list[IntArray]:
    """Return the pixels of largest difference, at least `apart` px from each other while there is room."""
    rows, columns = np.indices(difference.shape)
    left = difference.copy()

    def leave_out(pixel: IntArray) -> None:
        left[np.hypot(rows - pixel[0], columns - pixel[1]) < apart] = -1.0

    for pixel in taken:
        leave_out(pixel)
    found: list[IntArray] = []
    for _ in range(count):
        if left.max() < 0:
            left[:] = difference
        found.append(np.array(np.unravel_index(np.argmax(left), left.shape)))
        leave_out(found[-1])
    return found
