# SPDX-License-Identifier: Apache-2.0
"""Flat regions of a picture, with mixed pixels of anti-aliased borders attributed to the two sides.

Components of nearly equal pixels that contain a 2 x 2 block are cores. Any other pixel is explained as a mixture of two
nearby cores; unexplained pixels (thin lines, small parts) become cores themselves.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.layering.fills.ramps import LAYER_NUMBERS
from livecl.layering.segmentation.labels import (
    EIGHT_NEIGHBORS,
    equal_components,
    grid_components,
    means_of,
    with_blocks,
)
from livecl.layering.segmentation.mixtures import Mixture, explain, with_seams
from livecl.layering.segmentation.noise import noise_level, noisy_cores
from livecl.layering.segmentation.small import ALIKE_OF_NOISE, SAME_STEP, without_small

#: Largest step between neighbouring pixels of one core in a clean picture, and largest residual of a mixture.
CLEAN_STEP, MIXTURE_MISS = 0.6 / 255, 10 / 255
#: Additional residual allowed to a mixture, per unit of noise.
MISS_OF_NOISE = 6.0
#: Largest difference, in any channel, of two regions of one colour: a constant, and per unit of noise.
SAME_COLOR, SAME_OF_NOISE = 1.5 / 255, 1.0
#: Largest step that counts as a slope: shading, and its bands when rounded to 8 bits.
SLOPE_STEP = 6 / 255
#: Largest step between two cores of a clean picture that counts as shading: its bands, rounded to 8 bits, are one level
#: apart. More is the border between two near colours. Of 36 gradients the share of bands is the same as with 6 levels.
BAND_STEP = 1.5 / 255
#: Share of equal neighbouring pixels from which a picture counts as clean.
CLEAN_SHARE = 0.6
#: Most rounds in which unexplained pixels become cores.
ROUNDS = 6
#: Residual from which a single pixel becomes a core; pixels of the smallest region, in a clean and in a noisy picture.
SINGLE_MISS, SMALLEST, SMALLEST_NOISY = 0.15, 5, 12


@dataclasses.dataclass(frozen=True)
class FlatRegions:
    """Connected regions of one colour each.

    Attributes
    ----------
    labels : (H, W) int
        Region of each pixel, 0 to K - 1: the one that covers most of it.
    colors : (K, C) float
        Colour of each region.
    sizes : (K,) int
        Number of pixels of each region.
    cores : (K,) int
        Core of each region.
    other : (H, W) int
        Core that covers the rest of each pixel.
    share : (H, W) float
        Share of each pixel covered by its region, from 0.5 to 1.
    miss : (H, W) float
        Largest residual of each pixel's colour, over the channels.
    noise : float
        Root-mean-square noise of the picture, 0 for a clean one.
    """

    labels: IntArray
    colors: FloatArray
    sizes: IntArray
    cores: IntArray
    other: IntArray
    share: FloatArray
    miss: FloatArray
    noise: float = dataclasses.field(default=0.0, kw_only=True)

    @property
    def numbers(self) -> int:
        """Count of the numbers that describe these regions as layers of four segments each."""
        return LAYER_NUMBERS * len(self.sizes)

    def cost(self, price: float) -> float:
        """Return the squared residual of each pixel's worst channel, summed, plus the price of the numbers."""
        return float(np.square(self.miss).sum()) + price * self.numbers

    def near(self, color: FloatArray) -> NDArray[np.bool_]:
        """Whether each region has a colour (C,), up to noise: (K,)."""
        return np.asarray(np.abs(self.colors - color).max(axis=1) <= SAME_COLOR + SAME_OF_NOISE * self.noise)

    def alike(self, a: int, b: int) -> bool:
        """Whether two regions have the same fill."""
        if a not in self._alike:
            self._alike[a] = self.near(self.colors[a])
        return bool(self._alike[a][b])

    @functools.cached_property
    def _alike(self) -> dict[int, NDArray[np.bool_]]:
        """Cache of the results of :meth:`near` for the colours of regions."""
        return {}

    @functools.cached_property
    def border_noise(self) -> float:
        """Standard deviation of the borders, px: the noise over the median contrast across borders."""
        steps = [
            (self.colors[a] - self.colors[b])[a != b]
            for a, b in ((self.labels[1:], self.labels[:-1]), (self.labels[:, 1:], self.labels[:, :-1]))
        ]
        contrasts = np.abs(np.concatenate(steps)).max(axis=-1)
        return (
            float(self.noise / max(float(np.median(contrasts)), self.noise)) if self.noise and len(contrasts) else 0.0
        )

    def rise(self, one: frozenset[int], other: frozenset[int]) -> float:
        """Return the rise of the squared error if two sets of regions share one colour.

        0 if all are alike.
        """
        if all(self.alike(a, b) for a in one for b in other):
            return 0.0
        return self.one_color(one | other)[1] - self.one_color(one)[1] - self.one_color(other)[1]

    def one_color(self, ids: frozenset[int]) -> tuple[FloatArray, float]:
        """Return the region colour (C,) that represents a set of regions with least squared error, and that error."""
        own = sorted(ids)
        away = np.square(self.colors[own][:, None] - self.colors[own][None]).sum(axis=-1)
        errors = away @ self.sizes[own]
        best = int(errors.argmin())
        return self.colors[own[best]], float(errors[best])


class Flatness(NamedTuple):
    """Quick measures of a picture: shares of its pixels, of its steps between neighbouring pixels, and a number."""

    cored: float  #: pixels in flat cores
    slopes: float  #: small steps: shading, or a border between near colours
    bands: float  #: small steps from one core to another: shading; a border between flat regions has mixed pixels
    cores: int  #: number of flat cores


def flatness(image: NDArray[np.floating]) -> Flatness:
    """Return quick measures of a picture (H, W, C)."""
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    step = _step(pixels)
    labels = _cores(pixels, step)
    interruption.check()
    steps, both = [], []
    for axis in (0, 1):
        steps.append(np.abs(np.diff(pixels, axis=axis)).max(axis=-1).ravel())
        both.append((np.minimum(*_beside(labels, axis)) > 0).ravel())
    interruption.check()
    size = np.concatenate(steps)
    between = np.concatenate(both)
    slope = (size > CLEAN_STEP) & (size <= SLOPE_STEP)
    if step == CLEAN_STEP:
        slope &= ~between | (size <= BAND_STEP)
    share = float(1 / max(len(size), 1))
    slopes, bands = (share * int(np.count_nonzero(these)) for these in (slope, slope & between))
    return Flatness(float(np.mean(labels > 0)), slopes, bands, int(labels.max()))


def _beside(values: IntArray, axis: int) -> tuple[IntArray, IntArray]:
    """Return the values (H, W) of the first and the second of each two neighbours along an axis."""
    return (values[:-1], values[1:]) if axis == 0 else (values[:, :-1], values[:, 1:])


def _step(pixels: FloatArray) -> float:
    """Return the largest step between neighbouring pixels of one core."""
    steps = np.concatenate([np.abs(np.diff(pixels, axis=axis)).max(axis=-1).ravel() for axis in (0, 1)])
    return CLEAN_STEP if len(steps) and np.mean(steps <= CLEAN_STEP) >= CLEAN_SHARE else SAME_STEP


def noisy_regions(image: NDArray[np.floating], miss: float = MIXTURE_MISS) -> FlatRegions | None:
    """Segment a noisy picture into flat regions; None if it has no noise, or is not flat beneath the noise."""
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    noise = noise_level(pixels)
    cores = noisy_cores(pixels, noise) if noise else None
    if cores is None:
        return None
    labels, colors, noise = cores
    return _resolved(pixels, labels, colors, miss + MISS_OF_NOISE * noise, noise)


def clean_regions(image: NDArray[np.floating], miss: float = MIXTURE_MISS) -> FlatRegions:
    """Segment a picture assumed to have no noise into flat regions."""
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    labels = _cores(pixels, _step(pixels))
    interruption.check()
    return _resolved(pixels, labels, means_of(labels, pixels), miss, 0.0)


def _resolved(pixels: FloatArray, labels: IntArray, colors: FloatArray, miss: float, noise: float) -> FlatRegions:
    """Grow cores, labels (H, W) and colours (K + 1, C), into regions, adding cores for unexplained pixels."""
    sure = len(colors)
    for round_number in range(ROUNDS):
        interruption.check()
        mixture = explain(pixels, labels, colors)
        if not noise:
            mixture = with_seams(pixels, np.where(labels < sure, labels, 0), colors[:sure], mixture, miss)
        if round_number == ROUNDS - 1 or not (mixture.miss > miss).any():
            break
        colors, added = add_cores(pixels, labels, colors, mixture, miss, noise)
        if not added:
            break
    return regions_of(pixels, labels, colors, mixture, np.arange(len(colors)) < sure, miss, noise)


def _cores(image: FloatArray, step: float) -> IntArray:
    """Label the flat components that contain a 2 x 2 block from 1 on; 0 elsewhere."""
    right, down = (np.abs(np.diff(image, axis=axis)).max(axis=-1) <= step for axis in (1, 0))
    return with_blocks(grid_components(right, down))


def add_cores(
    image: FloatArray, labels: IntArray, colors: FloatArray, mixture: Mixture, miss: float, noise: float = 0.0
) -> tuple[FloatArray, int]:
    """Make a core of the worst pixel of each unexplained patch and similar pixels around it; changes `labels`."""
    missed = np.zeros(labels.shape)
    missed[mixture.rows, mixture.columns] = np.minimum(mixture.miss, 9)
    interruption.check()
    patches, count = ndimage.label(missed > miss, EIGHT_NEIGHBORS)
    boxes = ndimage.find_objects(patches)
    new_colors: list[FloatArray] = []
    for patch, worst in enumerate(ndimage.maximum_position(missed, patches, np.arange(1, count + 1)), start=1):
        interruption.check()
        box = boxes[patch - 1]
        inside = patches[box] == patch
        if inside.sum() < (SMALLEST_NOISY if noise else 2) and (noise or missed[worst] < SINGLE_MISS):
            continue
        alike = inside & (np.abs(image[box] - image[worst]).max(axis=-1) <= 4 * SAME_STEP + ALIKE_OF_NOISE * noise)
        parts, _ = ndimage.label(alike, EIGHT_NEIGHBORS)
        alike = parts == parts[worst[0] - box[0].start, worst[1] - box[1].start]
        labels[box][alike] = len(colors) + len(new_colors)
        new_colors.append(image[box][alike].mean(axis=0))
    return np.concatenate([colors, np.reshape(new_colors, (-1, colors.shape[1]))]), len(new_colors)


def regions_of(
    image: FloatArray,
    labels: IntArray,
    colors: FloatArray,
    mixture: Mixture,
    sure: NDArray[np.bool_] | None = None,
    miss_of_blends: float = 0.0,
    noise: float = 0.0,
) -> FlatRegions:
    """Assign mixed pixels to the core that covers most of them, and number the connected regions.

    Cores that are not `sure` may be blends of their neighbours; None means that all are.
    """
    size = image.shape[:2]
    miss = np.where(labels > 0, np.abs(image - colors[labels]).max(axis=-1), 0.0)
    labels, other, share = labels.copy(), labels.copy(), np.ones(size)
    known = mixture.first > 0
    at = mixture.rows[known], mixture.columns[known]
    first = mixture.share[known] >= 0.5
    labels[at] = np.where(first, mixture.first[known], mixture.second[known])
    other[at] = np.where(first, mixture.second[known], mixture.first[known])
    share[at] = np.maximum(mixture.share[known], 1 - mixture.share[known])
    miss[at] = mixture.miss[known]
    if (labels == 0).any():
        nearest = ndimage.distance_transform_edt(labels == 0, return_distances=False, return_indices=True)
        miss[labels == 0] = 1.0
        labels = labels[tuple(nearest)]
        other = np.where(other == 0, labels, other)
    interruption.check()
    parts = equal_components(labels)
    interruption.check()
    cores = np.zeros(parts.max() + 1, np.int64)
    cores[parts.ravel()] = labels.ravel()
    certain = np.ones(len(cores), bool) if sure is None else sure[cores]
    smallest = SMALLEST_NOISY if noise else SMALLEST
    parts = without_small(parts, colors[cores], smallest, miss_of_blends, certain, noise)
    interruption.check()
    kept, parts = np.unique(parts, return_inverse=True)
    parts = parts.reshape(size)
    found = colors[cores[kept]], np.bincount(parts.ravel()), cores[kept]
    return FlatRegions(parts, *found, other, share, miss, noise=noise)
