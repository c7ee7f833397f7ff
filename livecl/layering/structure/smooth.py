# SPDX-License-Identifier: Apache-2.0
"""Regions of smoothly changing colour: a picture cut where colour jumps, not where it drifts, and the fill of each.

Neighbouring pixels belong together where the second differences of colour are as small as rounding makes them: they
are 0 on a ramp, and large on an antialiased edge. Where an edge fades out, two regions of different fills hang
together: a region that no fill explains is cut along the pixels which its best fill misses.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing.fills import SOLID
from livecl.layering.drift import Changes
from livecl.layering.ramps import COLOR_NUMBERS, LAYER_NUMBERS, Paint, fit_paint
from livecl.layering.structure.flat import (
    MIXTURE_MISS,
    ROUNDS,
    FlatRegions,
    add_cores,
    explain,
    grid_components,
    means_of,
    regions_of,
)
from livecl.layering.structure.small import SAME_STEP

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

#: What a pixel's colour may miss its region's fill by, and share of the pixels that may miss it: else it is cut.
MISSED, MISSED_SHARE = 3.5 / 255, 0.03
#: Least share of a region that one fill must explain to be cut from the rest, and pixels of the smallest part cut.
CUT_SHARE, CUT_PIXELS = 0.2, 24
#: Rounds in which pixels that a fill misses come to count less, and cuts of one region, at most.
TRIMS, CUTS = 4, 6
#: Distance, px, up to which a core is another's neighbour across pixels without one.
BESIDE = 2.0
#: Mean squared error of a channel that may come of one fill for two regions, and that of a linear one beyond which no
#: other is looked for.
ONE_FILL, ROUGHLY = (1.5 / 255) ** 2, (12 / 255) ** 2


@dataclasses.dataclass(frozen=True)
class SmoothRegions(FlatRegions):
    """Connected regions of one fill each; `colors` are those of the best single colours.

    Attributes
    ----------
    image : (H, W, C) float
        The picture: RGB, or premultiplied RGBA.
    price : float
        Of a number that describes a fill, squared error.
    kinds : tuple of str
        Fills that regions may have.
    inner : (H, W) bool
        Pixels that are their region's alone.
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
    def shaded(self) -> bool:
        """Whether any region has a gradient; flat ones have none together either."""
        return any(self.paint(frozenset((k,))).kind != SOLID for k in range(len(self.sizes)))

    def paint(self, ids: frozenset[int]) -> Paint:
        """Return the fill that some regions have together."""
        if ids not in self._paints:
            own = self.pixels_of(ids)
            kinds = self.kinds if self._changes.drift(own) else ()
            self._paints[ids] = fitted(self.image, own, self.price, kinds)
        return self._paints[ids]

    def shown(self, ids: frozenset[int], mask: BoolArray) -> FloatArray:
        """Return what the fill of some regions shows at pixels (H, W), as pixels of the picture: (n, C)."""
        return premultiplied(self.paint(ids).at(_centers(mask)))[:, : self.image.shape[2]]

    def pixels_of(self, ids: frozenset[int]) -> BoolArray:
        """Return the pixels (H, W) that are some regions' alone; all of theirs where these are few."""
        found = np.zeros(self.labels.shape, bool)
        for k in ids:
            box = self._boxes[k]
            own = self.labels[box] == k
            alone = own & self.inner[box]
            found[box] |= alone if alone.sum() > 3 else own
        return found

    def error(self, ids: frozenset[int]) -> float:
        """Return the squared error that the fill of some regions leaves, and its price."""
        paint = self.paint(ids)
        return paint.error + self.price * paint.numbers

    @functools.cached_property
    def _moments(self) -> dict[frozenset[int], FloatArray]:
        return {}

    def _affine(self, ids: frozenset[int]) -> FloatArray:
        """Return the weighted sums of the products of (1, x, y, straight RGBA) over some regions' pixels: (7, 7)."""
        if ids not in self._moments:
            mask = self.pixels_of(ids)
            colors = straight(self.image[mask])
            terms = np.column_stack([np.ones(len(colors)), _centers(mask), colors])
            self._moments[ids] = (terms * np.maximum(colors[:, 3:] ** 2, 1e-3)).T @ terms
        return self._moments[ids]

    def _missed(self, paint: Paint, mask: BoolArray) -> float:
        """Return the squared error of a fill at pixels (H, W)."""
        colors = straight(self.image[mask])
        weights = np.maximum(colors[:, 3] ** 2, 1e-3)
        return float(weights @ np.square(paint.at(_centers(mask)) - colors).sum(axis=1))

    def alike(self, a: int, b: int) -> bool:
        """Whether two regions have one fill: a fill fitted to both costs less than two, or hardly misses any pixel."""
        own = [frozenset((k,)) for k in (a, b)]
        if all(self.paint(k).kind == SOLID for k in own):
            return super().alike(a, b)
        return self.rise(*own) <= 0

    def rise(self, one: frozenset[int], other: frozenset[int]) -> float:
        """Return by how much error and price of one fill for some regions and others exceed those of two fills."""
        solid = [ids for ids in (one, other) if self.paint(ids).kind == SOLID]
        if len(solid) == 2:  # no ramp leads from one flat colour to another
            return super().rise(one, other)
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
    """Return the share of the pixels of a picture (H, W, C) in smooth cores: quickly."""
    return float(np.mean(_cores(np.asarray(image, dtype=np.float64)) > 0))


def smooth_regions(image: NDArray[np.floating], price: float, kinds: tuple[str, ...]) -> SmoothRegions:
    """Cut a picture (H, W, C) into regions of one fill each with resolved borders."""
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    labels = _cut(pixels, _cores(pixels), price, kinds)
    for round_number in range(ROUNDS):
        mixture = explain(pixels, labels, None)
        if round_number == ROUNDS - 1 or not (mixture.miss > MIXTURE_MISS).any():
            break
        if not add_cores(pixels, labels, means_of(labels, pixels), mixture, MIXTURE_MISS)[1]:
            break
    labels = _absorbed(pixels, labels, price, kinds)
    mixture = explain(pixels, labels, None)
    inner = labels > 0
    flat = regions_of(pixels, labels, means_of(labels, pixels), mixture)
    found = SmoothRegions(**vars(flat), image=pixels, price=price, kinds=kinds, inner=inner)
    miss = np.where(inner, 0.0, flat.miss)
    for k in range(len(flat.sizes)):
        own = found.pixels_of(frozenset((k,)))
        miss[own] = np.abs(found.shown(frozenset((k,)), own) - pixels[own]).max(axis=1)
    whole = dataclasses.replace(found, miss=miss)
    whole._paints.update(found._paints)
    return whole


def straight(pixels: FloatArray) -> FloatArray:
    """Return straight RGBA (n, 4) of RGB or premultiplied RGBA (n, C)."""
    if pixels.shape[1] == 3:
        return np.column_stack([pixels, np.ones(len(pixels))])
    alpha = pixels[:, 3:]
    return np.concatenate([np.clip(pixels[:, :3] / np.maximum(alpha, 1e-3), 0, 1), alpha], axis=1)


def _affine_error(moments: FloatArray) -> float:
    """Return the squared error of the best affine ramp, from sums of products of (1, x, y, straight RGBA)."""
    matrix = moments[:3, :3] + 1e-6 * np.eye(3)
    return float(np.trace(moments[3:, 3:] - moments[3:, :3] @ np.linalg.solve(matrix, moments[:3, 3:])))


def premultiplied(rgba: FloatArray) -> FloatArray:
    """Return premultiplied RGBA (n, 4) of straight one."""
    return np.concatenate([rgba[:, :3] * rgba[:, 3:], rgba[:, 3:]], axis=1)


def fitted(image: FloatArray, mask: BoolArray, price: float, kinds: tuple[str, ...]) -> Paint:
    """Fit a fill to the pixels (H, W) of a picture."""
    colors = straight(image[mask])
    if len(colors) < CUT_PIXELS:
        kinds = ()
    return fit_paint(_centers(mask), colors, np.maximum(colors[:, 3] ** 2, 1e-3), price, kinds)


def _centers(mask: BoolArray) -> FloatArray:
    """Return the centres (n, 2) of pixels (H, W)."""
    rows, columns = np.nonzero(mask)
    return np.asarray(np.column_stack([columns, rows]) + 0.5, dtype=np.float64)


def _cores(image: FloatArray) -> IntArray:
    """Label the smooth components from 1 on; 0 elsewhere.

    Pixels hang together within blocks of 2 x 2 of nearly one colour, which thin parts have too, and where both are
    smooth in all directions.
    """
    smooth = Changes.of(image).smooth
    corners = np.stack([image[:-1, :-1], image[1:, :-1], image[:-1, 1:], image[1:, 1:]])
    block = (corners.max(axis=0) - corners.min(axis=0)).max(axis=-1) <= SAME_STEP
    right, down = smooth[:, :-1] & smooth[:, 1:], smooth[:-1] & smooth[1:]
    right[:-1] |= block
    right[1:] |= block
    down[:, :-1] |= block
    down[:, 1:] |= block
    labels = grid_components(right, down)
    corner = labels[1:, 1:]
    square = (corner == labels[:-1, :-1]) & (corner == labels[1:, :-1]) & (corner == labels[:-1, 1:])
    kept = np.zeros(labels.max() + 1, bool)
    kept[corner[square]] = True
    return np.where(kept, np.cumsum(kept), 0)[labels]


def _cut(image: FloatArray, labels: IntArray, price: float, kinds: tuple[str, ...]) -> IntArray:
    """Cut the cores that no fill explains."""
    labels = labels.copy()
    boxes = ndimage.find_objects(labels)
    left = [(k, box, CUTS) for k, box in enumerate(boxes, start=1)]
    count = len(boxes)
    while left:
        k, box, cuts = left.pop()
        mask = labels[box] == k
        if not cuts or mask.sum() < 2 * CUT_PIXELS:
            continue
        kept = _explained(image[box], mask, price, kinds)
        if kept is None:
            continue
        parts, found = ndimage.label(mask & ~kept)
        sizes = np.bincount(parts.ravel())
        small = (sizes < CUT_PIXELS)[parts] & (parts > 0)
        labels[box][small] = 0
        for part in range(1, found + 1):
            if sizes[part] >= CUT_PIXELS:
                count += 1
                labels[box][parts == part] = count
                left.append((count, box, cuts - 1))
    # Parts of a core that hung together by pixels that were cut are regions of their own.
    parts = grid_components(labels[:, 1:] == labels[:, :-1], labels[1:] == labels[:-1])
    _, numbers = np.unique(parts[labels > 0], return_inverse=True)
    labels[labels > 0] = numbers + 1
    return labels


def _explained(image: FloatArray, mask: BoolArray, price: float, kinds: tuple[str, ...]) -> BoolArray | None:
    """Return which pixels of a core the fill explains that explains most; None where it explains all or too few."""
    colors, points = straight(image[mask]), _centers(mask)
    seen, alphas = premultiplied(colors), np.maximum(colors[:, 3] ** 2, 1e-3)
    weights = alphas
    for _ in range(TRIMS):
        paint = fit_paint(points, colors, weights, price, kinds)
        miss = np.abs(premultiplied(paint.at(points)) - seen).max(axis=1)
        if np.mean(miss > MISSED) <= MISSED_SHARE:
            break
        weights = alphas / (1 + np.square(miss / MISSED))
    plain = np.abs(seen - _mode(seen)).max(axis=1)
    if np.mean(plain <= MISSED) > np.mean(miss <= MISSED):
        miss = plain
    good = np.zeros(mask.shape, bool)
    good[mask] = miss <= MISSED
    share = np.count_nonzero(good) / len(points)
    if share > 1 - MISSED_SHARE or share < CUT_SHARE:
        return None
    # Single pixels that are missed are noise, and single ones that are met are chance.
    good = ndimage.binary_opening(ndimage.binary_closing(good, iterations=1) & mask, iterations=1)
    return good if 0 < np.count_nonzero(good) < len(points) else None


def _absorbed(image: FloatArray, labels: IntArray, price: float, kinds: tuple[str, ...]) -> IntArray:
    """Give cores to the neighbour whose fill shows them at less error than a layer of their own would cost.

    The smallest first: slivers along edges that fade out, where the part cut from a region is hardly of another colour.
    """
    labels, count = labels.copy(), int(labels.max())
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    near = _neighbors(labels)
    boxes = ndimage.find_objects(labels)
    paints: dict[int, Paint] = {}

    def paint_of(k: int) -> Paint:
        if k not in paints:
            paints[k] = fitted(image, labels == k, price, kinds)
        return paints[k]

    for k in np.argsort(sizes[1:], kind="stable") + 1:
        if not near[k] or not sizes[k]:
            continue
        mask = labels[boxes[k - 1]] == k
        corner = boxes[k - 1][1].start, boxes[k - 1][0].start
        colors, points = straight(image[boxes[k - 1]][mask]), _centers(mask) + corner
        weights = np.maximum(colors[:, 3] ** 2, 1e-3)
        own = paint_of(k)
        errors = {n: float(weights @ np.square(paint_of(n).at(points) - colors).sum(axis=1)) for n in sorted(near[k])}
        best = min(errors, key=lambda n: errors[n])
        if errors[best] < own.error + price * (own.numbers + LAYER_NUMBERS - COLOR_NUMBERS):
            labels[boxes[k - 1]][mask] = best
            sizes[best], sizes[k] = sizes[best] + sizes[k], 0
            one, other = boxes[best - 1], boxes[k - 1]
            boxes[best - 1] = tuple(
                slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(one, other, strict=True)
            )
            for n in near.pop(k):
                near[n].discard(k)
                if n != best:
                    near[n].add(best)
                    near[best].add(n)
            near[k] = set()
    kept = np.cumsum(np.bincount(labels.ravel(), minlength=count + 1)[1:] > 0)
    return np.concatenate([[0], kept])[labels]


def _neighbors(labels: IntArray) -> dict[int, set[int]]:
    """Return the cores that are at most a few pixels without a core away from each."""
    distance, nearest = ndimage.distance_transform_edt(labels == 0, return_indices=True)
    grown = np.where(distance <= BESIDE, labels[tuple(nearest)], 0)
    near: dict[int, set[int]] = {k: set() for k in range(1, int(labels.max()) + 1)}
    for a, b in ((grown[:, 1:], grown[:, :-1]), (grown[1:], grown[:-1])):
        meet = (a != b) & (a > 0) & (b > 0)
        for one, other in np.unique(np.column_stack([a[meet], b[meet]]), axis=0).tolist():
            near[one].add(other)
            near[other].add(one)
    return near


def _mode(colors: FloatArray) -> FloatArray:
    """Return the commonest of some colours (n, C), to a level."""
    levels, counts = np.unique(np.round(colors * 255), axis=0, return_counts=True)
    return np.asarray(levels[np.argmax(counts)] / 255)
