# SPDX-License-Identifier: Apache-2.0
"""Where the next paths start and what they look like (the paper's component-wise path initialization, steps a-d)."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import Drawing
from livecl.options import Options

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclasses.dataclass(frozen=True)
class Places:
    """Where paths start: pixels (row, column), (K, 2) int, and centres (x, y), (K, 2) float, px."""

    pixels: IntArray
    centers: FloatArray


def place_paths(
    target: NDArray[Any], image: NDArray[Any], count: int, options: Options, rng: np.random.Generator
) -> Drawing:
    """Return `count` new layers for what the image still lacks of the target.

    Parameters
    ----------
    target, image : (H, W, 3) array
        What is wanted, and what is rendered so far.
    count : int
        Number of layers.
    options : Options
        Placement rule, shape and colours.
    rng : numpy.random.Generator
        Source of whatever is random.

    Returns
    -------
    Drawing
        Only the new layers, in paint order.
    """
    height, width = target.shape[:2]
    if options.placement == "random":
        centers = rng.uniform(size=(count, 2)) * (width, height)
        places = Places(np.floor(centers[:, ::-1]).astype(np.int64), centers)
    else:
        places = component_places(target, image, count, options)
    shapes = [
        circle(center, options.radius, options.segments)
        if options.shape == "circle"
        else random_outline(center, options.segments, (height, width), rng)
        for center in places.centers
    ]
    if options.new_color == "random":
        colors = rng.uniform(size=(count, 4))
    else:
        colors = np.ones((count, 4))
        colors[:, :3] = target[places.pixels[:, 0], places.pixels[:, 1], :3]
    return Drawing(points=np.concatenate(shapes), colors=colors, size=(height, width))


def component_places(target: NDArray[Any], image: NDArray[Any], count: int, options: Options) -> Places:
    """Return the centres of the largest components of the error; where they run out, the places of largest error."""
    difference = np.abs(target - image).sum(axis=-1, dtype=np.float64)  # step a
    if options.variant == "released":
        difference = np.square(target - image).sum(axis=-1, dtype=np.float64)
    labels, bins = components(difference, options)
    pixels, centers = _centers(labels, _ranked(labels, bins, options)[:count])
    if len(pixels) < count:
        more = _largest_errors(difference, pixels, count - len(pixels), 2 * options.radius)
        pixels, centers = np.concatenate([pixels, more]), np.concatenate([centers, more[:, ::-1] + 0.5])
    return Places(pixels, centers)


def components(difference: FloatArray, options: Options) -> tuple[IntArray, IntArray]:
    """Return the 4-connected components of pixels whose differences fall into one bin, and the bins (steps b-c).

    Returns
    -------
    ((H, W) int, (H, W) int)
        Label of each pixel and its bin, both from 1 on; 0 where the difference is under the threshold.
    """
    from skimage.measure import label

    wanted = difference >= options.color_threshold
    if not wanted.any():
        return np.zeros(difference.shape, np.int64), np.zeros(difference.shape, np.int64)
    # Bins of equal population: among the differences left, or (the released program) among all, the small ones being 0.
    population = np.where(wanted, difference, 0.0) if options.variant == "released" else difference[wanted]
    edges = np.unique(np.quantile(population, np.linspace(0, 1, options.bins + 1)))[1:-1]
    bins = np.where(wanted, np.digitize(difference, edges) + 1, 0)
    return label(bins, background=0, connectivity=1), bins


def _ranked(labels: IntArray, bins: IntArray, options: Options) -> list[int]:
    """Labels in the order in which they are taken: the largest first; `released`: of the bin that is fullest by then."""
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


def _centers(labels: IntArray, chosen: list[int]) -> tuple[IntArray, FloatArray]:
    """Centre of mass of each component, or the centre of its own pixel nearest to it where it lies outside (step d)."""
    pixels, centers = np.zeros((len(chosen), 2), np.int64), np.zeros((len(chosen), 2))
    for k, component in enumerate(chosen):
        members = np.argwhere(labels == component)
        mean = members.mean(axis=0)
        nearest = members[np.argmin(np.square(members - mean).sum(axis=1))]
        inside = labels[tuple(np.floor(mean + 0.5).astype(int))] == component
        pixels[k] = np.floor(mean + 0.5) if inside else nearest
        centers[k] = (mean if inside else nearest)[::-1] + 0.5
    return pixels, centers


def _largest_errors(difference: FloatArray, taken: IntArray, count: int, apart: float) -> IntArray:
    """Pixels of the largest difference, each at least `apart` px from the others while there is room."""
    rows, columns = np.indices(difference.shape)
    left = difference.copy()

    def leave_out(pixel: IntArray) -> None:
        left[np.hypot(rows - pixel[0], columns - pixel[1]) < apart] = -1.0

    for pixel in taken:
        leave_out(pixel)
    found = []
    for _ in range(count):
        if left.max() < 0:
            left = difference.copy()
        found.append(np.array(np.unravel_index(np.argmax(left), left.shape)))
        leave_out(found[-1])
    return np.array(found).reshape(-1, 2)


def circle(center: FloatArray, radius: float, segments: int) -> FloatArray:
    """Return a closed path whose 3s control points lie evenly on a circle: (s, 3, 2) px."""
    angles = 2 * np.pi * np.arange(3 * segments) / (3 * segments)
    return np.asarray(center + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)).reshape(segments, 3, 2)


def random_outline(center: FloatArray, segments: int, size: tuple[int, int], rng: np.random.Generator) -> FloatArray:
    """Return a random closed path (s, 3, 2) px: each control point within 2.5 % of the canvas of the one before.

    The outline of DiffVG's random paths (Li et al. 2020), as far as the paper's baseline and ablation go.
    """
    steps = rng.uniform(-0.5, 0.5, size=(3 * segments, 2)) * 0.05 * np.array([size[1], size[0]])
    steps[0] = 0
    return np.asarray(center + np.cumsum(steps, axis=0)).reshape(segments, 3, 2)
