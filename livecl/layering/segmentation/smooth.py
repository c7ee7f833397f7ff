# SPDX-License-Identifier: Apache-2.0
"""Regions of smoothly varying colour: a picture segmented where colour jumps, not where it drifts, with fitted fills.

Neighbouring pixels are connected where the second differences of colour are within rounding: they are 0 on a ramp, and
large on an anti-aliased edge. Where an edge fades out, two regions of different fills stay connected: a region that no
fill explains is split along the pixels missed by its best fill.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.drawing.colors import premultiplied_colors
from livecl.layering.drift import Changes
from livecl.layering.fills.ramps import COLOR_NUMBERS, Paint
from livecl.layering.segmentation.cores import (
    CUT_PIXELS,
    absorbed_cores,
    cut_cores,
    fitted_paint,
    pixel_centers,
    smooth_cores,
    straight,
)
from livecl.layering.segmentation.flat import MIXTURE_MISS, ROUNDS, FlatRegions, add_cores, regions_of
from livecl.layering.segmentation.labels import means_of
from livecl.layering.segmentation.mixtures import Mixture, explain

#: Mean squared error of a channel allowed to one fill for two regions, and that of an affine one above which no other
#: kind is tried.
ONE_FILL, ROUGHLY = (1.5 / 255) ** 2, (12 / 255) ** 2


@dataclasses.dataclass(frozen=True)
class SmoothRegions(FlatRegions):
    """Connected regions of one fill each; `colors` are the best single colours.

    Attributes
    ----------
    image : (H, W, C) float
        The picture: RGB, or premultiplied RGBA.
    price : float
        Price of a number that describes a fill, squared error.
    kinds : tuple of str
        Kinds of gradients allowed.
    inner : (H, W) bool
        Pixels wholly covered by their region.
    """

    image: FloatArray
    price: float
    kinds: tuple[str, ...]
    inner: BoolArray

    @functools.cached_property
    def _paints(self) -> dict[frozenset[int], Paint]:
        return {}

    @functools.cached_property
    def _changes(self) -> Changes:
        return Changes.of(self.image)

    @functools.cached_property
    def _boxes(self) -> list[tuple[slice, slice]]:
        return list(ndimage.find_objects(self.labels + 1))

    @property
    def numbers(self) -> int:
        """Count of the numbers that describe these regions as layers of four segments each, fills included."""
        fills = sum(self.paint(frozenset((k,))).numbers for k in range(len(self.sizes)))
        return super().numbers + fills - COLOR_NUMBERS * len(self.sizes)

    @property
    def shaded(self) -> bool:
        """Whether any region has a gradient; unions of flat regions have none."""
        return any(not self.paint(frozenset((k,))).solid for k in range(len(self.sizes)))

    def paint(self, ids: frozenset[int]) -> Paint:
        """Return the fill fitted to a set of regions together; that of several is searched for near those of each."""
        if ids not in self._paints:
            interruption.check()
            own = self.pixels_of(ids)
            kinds = self.kinds if self._changes.drift(own) else ()
            near = [self.paint(frozenset((k,))) for k in sorted(ids)] if len(ids) > 1 else []
            self._paints[ids] = fitted_paint(self.image, own, self.price, kinds, near)
        return self._paints[ids]

    def shown(self, ids: frozenset[int], mask: BoolArray) -> FloatArray:
        """Evaluate the fill of a set of regions at pixels (H, W), in the picture's channels: (n, C)."""
        return premultiplied_colors(self.paint(ids).at(pixel_centers(mask)))[:, : self.image.shape[2]]

    def pixels_of(self, ids: frozenset[int]) -> BoolArray:
        """Return the pixels (H, W) wholly covered by a set of regions; all of theirs if these are few."""
        found = np.zeros(self.labels.shape, bool)
        for k in ids:
            box = self._boxes[k]
            own = self.labels[box] == k
            alone = own & self.inner[box]
            found[box] |= alone if alone.sum() > 3 else own
        return found

    def error(self, ids: frozenset[int]) -> float:
        """Return the squared error plus price of the fill of a set of regions."""
        paint = self.paint(ids)
        return paint.error + self.price * paint.numbers

    @functools.cached_property
    def _moments(self) -> dict[frozenset[int], FloatArray]:
        return {}

    def _affine(self, ids: frozenset[int]) -> FloatArray:
        """Return the weighted sums of products of (1, x, y, straight RGBA) over the pixels of some regions: (7, 7)."""
        if ids not in self._moments:
            mask = self.pixels_of(ids)
            colors = straight(self.image[mask])
            terms = np.column_stack([np.ones(len(colors)), pixel_centers(mask), colors])
            self._moments[ids] = (terms * np.maximum(colors[:, 3:] ** 2, 1e-3)).T @ terms
        return self._moments[ids]

    def _missed(self, paint: Paint, mask: BoolArray) -> float:
        """Return the squared error of a fill at pixels (H, W)."""
        colors = straight(self.image[mask])
        weights = np.maximum(colors[:, 3] ** 2, 1e-3)
        return float(weights @ np.square(paint.at(pixel_centers(mask)) - colors).sum(axis=1))

    def alike(self, a: int, b: int) -> bool:
        """Whether two regions have the same fill: one fitted to both costs less than two, or hardly misses a pixel."""
        own = [frozenset((k,)) for k in (a, b)]
        if all(self.paint(k).solid for k in own):
            return super().alike(a, b)
        return self.rise(*own) <= 0

    def rise(self, one: frozenset[int], other: frozenset[int]) -> float:
        """Return the rise of error plus price if two sets of regions share one fill."""
        solid = [ids for ids in (one, other) if self.paint(ids).solid]
        if len(solid) == 2:  # no ramp leads from one flat colour to another
            return 0.0 if super().rise(one, other) == 0 else np.inf
        moments = self._affine(one), self._affine(other)
        count = float(moments[0][0, 0] + moments[1][0, 0])
        apart = self.error(one) + self.error(other) + 3 * ONE_FILL * count
        if solid and (mask := self.pixels_of(solid[0])).sum() >= CUT_PIXELS:  # nor from a gradient to a flat colour
            ramp = self.paint(other if solid[0] is one else one)
            return ramp.error + self.price * ramp.numbers + self._missed(ramp, mask) - apart
        # Affine ramps are quickly fitted. Where one for both is as good as two fills, no other is looked for; where it
        # is much worse than one for each, bent and round ones for both are no better.
        affine = _affine_error(moments[0] + moments[1])
        if affine <= apart:
            return affine - apart
        if affine - sum(map(_affine_error, moments)) > 3 * ROUGHLY * count:
            return np.inf
        return self.error(one | other) - apart


def smoothness(image: NDArray[np.floating]) -> float:
    """Return a quick measure: the share of the pixels of a picture (H, W, C) in smooth cores."""
    return float(np.mean(smooth_cores(np.asarray(image, dtype=np.float64)) > 0))


def unmixed(image: NDArray[np.floating], miss: float) -> float:
    """Return the share of the pixels of a picture (H, W, C) outside smooth cores that are no mixture of nearby colours.

    Their residual exceeds `miss`. Far quicker than splitting the cores, which hardly lowers the share.
    """
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    labels = smooth_cores(pixels)
    mixture = _mixed(pixels, labels)
    return float(np.count_nonzero(mixture.miss > miss) / labels.size)


def _mixed(image: FloatArray, labels: IntArray) -> Mixture:
    """Add flat cores for unexplained pixels between cores (H, W); return the mixtures of the other pixels."""
    for round_number in range(ROUNDS):
        interruption.check()
        mixture = explain(image, labels, None)
        if round_number == ROUNDS - 1 or not (mixture.miss > MIXTURE_MISS).any():
            break
        if not add_cores(image, labels, means_of(labels, image), mixture, MIXTURE_MISS)[1]:
            break
    return mixture


def smooth_regions(image: NDArray[np.floating], price: float, kinds: tuple[str, ...]) -> SmoothRegions:
    """Segment a picture (H, W, C) into regions of one fill each, with resolved borders."""
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    labels, overlaid = cut_cores(pixels, smooth_cores(pixels), price, kinds)
    _mixed(pixels, labels)
    labels, overlaid = absorbed_cores(pixels, labels, price, kinds, overlaid)
    mixture = explain(pixels, labels, None)
    interruption.check()
    inner = labels > 0
    flat = regions_of(pixels, labels, means_of(labels, pixels), mixture)
    found = SmoothRegions(**vars(flat), image=pixels, price=price, kinds=kinds, inner=inner)
    for k, core in enumerate(flat.cores.tolist()):
        if core in overlaid:
            found._paints[frozenset((k,))] = overlaid[core]
    miss = np.where(inner, 0.0, flat.miss)
    for k in range(len(flat.sizes)):
        interruption.check()
        own = found.pixels_of(frozenset((k,)))
        miss[own] = np.abs(found.shown(frozenset((k,)), own) - pixels[own]).max(axis=1)
    whole = dataclasses.replace(found, miss=miss)
    whole._paints.update(found._paints)
    return whole


def _affine_error(moments: FloatArray) -> float:
    """Return the squared error of the best affine ramp, from sums of products of (1, x, y, straight RGBA)."""
    matrix = moments[:3, :3] + 1e-6 * np.eye(3)
    return float(np.trace(moments[3:, 3:] - moments[3:, :3] @ np.linalg.solve(matrix, moments[:3, 3:])))
