# SPDX-License-Identifier: Apache-2.0
"""Regions that a new path could paint in one colour, ranked by the squared error that this would remove.

The paper ranks components of the colour difference by area. Here regions come from the target as well, at several
scales, and are ranked by the squared error that painting them in their mean colour would remove.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray
from livecl.image.errors import visible_error
from livecl.layering.growing import grown
from livecl.layering.neighbors import SAME_COLOR


@dataclasses.dataclass(frozen=True, kw_only=True)
class Partitions:
    """Partitions of a picture into candidate regions.

    Regions grown by the price of a layer lower the error of ten photographs of 112 to 128 px, 32 paths, by 12 % in the
    geometric mean, with an eighth more segments, and that of seven faces at 8 paths by 12 %; prices four times as high
    gain less. Ranking regions by the error in them halves the error of faces (docs/quality.md, "Choices of the default
    method"), measured with these values; no comparison of other values is recorded.
    """

    #: Blur of the target, px, and quantization levels of each channel: from flat regions to blobs of photographs.
    target_levels: tuple[tuple[float, int], ...] = ((0.0, 4), (0.0, 8), (1.0, 8), (2.0, 6), (4.0, 6))
    #: Quantization levels of the channels for region growing, and the prices of growing, in prices of a layer.
    fine_levels: int = 16
    prices: tuple[float, ...] = (1.0, 8.0, 64.0)
    #: Quantization levels per unit of the difference from the target, in each channel, over a background and without
    #: one. Without a background, paint can add alpha but not remove it: most candidates are useless, and small
    #: differences are tried too.
    difference_levels: tuple[int, ...] = (4, 8)
    transparent_levels: tuple[int, ...] = (4, 8, 16, 32)
    alike: int = 20  # regions count as duplicates if gain and area differ by less than about 1 / `alike`
    min_pixels: int = 3  # fewest pixels of a region


PARTITIONS = Partitions()


@dataclasses.dataclass(frozen=True)
class _Segmentation:
    """A partition of the picture: labels, and for each region its area, mean colour and residual squared error."""

    labels: NDArray[Any]
    area: FloatArray
    mean: FloatArray
    within: FloatArray


@dataclasses.dataclass(frozen=True)
class Region:
    """A candidate region: its mean colour (C,), and the squared error that painting it would remove.

    `key` identifies it within a finder, independently of the error.
    """

    key: tuple[int, int]
    color: FloatArray
    gain: float
    _segmentation: _Segmentation = dataclasses.field(repr=False)

    @property
    def mask(self) -> BoolArray:
        """Pixels of the region: (H, W)."""
        return np.asarray(self._segmentation.labels == self.key[1])

    @property
    def alike(self) -> BoolArray:
        """Pixels of all regions of the same partition with about the same colour: (H, W)."""
        alike = np.abs(self._segmentation.mean - self.color).max(axis=1) <= SAME_COLOR
        return np.asarray(alike[self._segmentation.labels])


class TargetPartitions:
    """Partitions of a target (H, W, C), RGB or premultiplied RGBA, at several scales.

    They do not depend on the picture compared with the target.
    """

    def __init__(self, target: NDArray[Any], price: float = 0.0) -> None:
        from scipy.ndimage import gaussian_filter

        self.target: FloatArray = target.astype(np.float64)
        self._channels = [np.ascontiguousarray(channel).ravel() for channel in np.moveaxis(self.target, -1, 0)]
        self._squares = np.square(visible_error(self.target)).sum(axis=-1).ravel()
        self.segmentations = []
        for blur, levels in PARTITIONS.target_levels:
            smooth = gaussian_filter(self.target, (blur, blur, 0)) if blur else self.target
            self.segmentations.append(self.measure(np.minimum(np.floor(smooth * levels), levels - 1)))
        if price:
            fine = _level_components(
                np.minimum(np.floor(self.target * PARTITIONS.fine_levels), PARTITIONS.fine_levels - 1)
            )
            prices = [times * price for times in PARTITIONS.prices]
            for labels in grown(fine.astype(np.int64) - 1, visible_error(self.target), prices):
                self.segmentations.append(self._measured(labels))

    def measure(self, levels: FloatArray) -> _Segmentation:
        """Partition the picture into connected regions of equal levels (H, W, C)."""
        interruption.check()
        return self._measured(_level_components(levels))

    def _measured(self, labels: NDArray[Any]) -> _Segmentation:
        interruption.check()
        flat, count = labels.ravel(), int(labels.max()) + 1
        area = np.bincount(flat, minlength=count).astype(np.float64)
        sums = np.stack([np.bincount(flat, channel, count) for channel in self._channels], axis=1)
        squares = np.bincount(flat, self._squares, count)
        mean = sums / np.maximum(area, 1)[:, None]
        within = squares - (visible_error(sums) * visible_error(mean)).sum(axis=1)
        return _Segmentation(labels, area, mean, within)


class RegionFinder:
    """Finder of the regions of one target, as the picture (H, W, C) approaches it."""

    def __init__(self, partitions: TargetPartitions, image: NDArray[Any]) -> None:
        difference = partitions.target - image
        opaque = difference.shape[2] == 3
        self._segmentations = [
            *partitions.segmentations,
            *(
                partitions.measure(np.round(difference * levels))
                for levels in (PARTITIONS.difference_levels if opaque else PARTITIONS.transparent_levels)
            ),
        ]

    def best(self, error: FloatArray, count: int) -> Iterator[Region]:
        """Yield up to `count` regions that would remove most of the squared error (H, W), the best first.

        Near-duplicates at several scales are returned once.
        """
        found: list[tuple[float, int, int]] = []
        seen: set[tuple[int, int]] = set()
        for number, segmentation in enumerate(self._segmentations):
            interruption.check()
            gain = np.bincount(segmentation.labels.ravel(), error.ravel(), len(segmentation.area)) - segmentation.within
            gain[segmentation.area < PARTITIONS.min_pixels] = 0.0
            found += [(-gain[k], number, int(k)) for k in np.argsort(-gain, kind="stable")[:count] if gain[k] > 0]
        for negative_gain, number, k in sorted(found):
            segmentation = self._segmentations[number]
            gain_and_area = PARTITIONS.alike * np.log([-negative_gain, segmentation.area[k]])
            size = int(gain_and_area[0]), int(gain_and_area[1])
            if size in seen or len(seen) >= count:
                continue
            seen.add(size)
            yield Region((number, k), segmentation.mean[k], -negative_gain, segmentation)


def _level_components(levels: FloatArray) -> NDArray[Any]:
    """Label the 4-connected regions of equal levels (H, W, C), from 1 on."""
    from skimage.measure import label

    whole = (levels - levels.min()).astype(np.int64)
    codes = whole @ (whole.max() + 1) ** np.arange(whole.shape[2])[::-1]
    return np.asarray(label(codes + 1, background=0, connectivity=1))
