# SPDX-License-Identifier: Apache-2.0
"""Cores of smoothly changing colour: found by second differences, cut where no fill explains them, and absorbed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.layering.drift import Changes
from livecl.layering.ramps import COLOR_NUMBERS, LAYER_NUMBERS, Paint, fit_paint
from livecl.layering.structure.flat import grid_components
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


def straight(pixels: FloatArray) -> FloatArray:
    """Return straight RGBA (n, 4) of RGB or premultiplied RGBA (n, C)."""
    if pixels.shape[1] == 3:
        return np.column_stack([pixels, np.ones(len(pixels))])
    alpha = pixels[:, 3:]
    return np.concatenate([np.clip(pixels[:, :3] / np.maximum(alpha, 1e-3), 0, 1), alpha], axis=1)


def premultiplied(rgba: FloatArray) -> FloatArray:
    """Return premultiplied RGBA (n, 4) of straight one."""
    return np.concatenate([rgba[:, :3] * rgba[:, 3:], rgba[:, 3:]], axis=1)


def fitted(image: FloatArray, mask: BoolArray, price: float, kinds: tuple[str, ...]) -> Paint:
    """Fit a fill to the pixels (H, W) of a picture."""
    colors = straight(image[mask])
    if len(colors) < CUT_PIXELS:
        kinds = ()
    return fit_paint(pixel_centers(mask), colors, np.maximum(colors[:, 3] ** 2, 1e-3), price, kinds)


def pixel_centers(mask: BoolArray) -> FloatArray:
    """Return the centres (n, 2) of pixels (H, W)."""
    rows, columns = np.nonzero(mask)
    return np.asarray(np.column_stack([columns, rows]) + 0.5, dtype=np.float64)


def smooth_cores(image: FloatArray) -> IntArray:
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


def cut_cores(image: FloatArray, labels: IntArray, price: float, kinds: tuple[str, ...]) -> IntArray:
    """Cut the cores that no fill explains."""
    labels = labels.copy()
    boxes = ndimage.find_objects(labels)
    left = [(k, box, CUTS) for k, box in enumerate(boxes, start=1)]
    count = len(boxes)
    while left:
        interruption.check()
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
    colors, points = straight(image[mask]), pixel_centers(mask)
    seen, alphas = premultiplied(colors), np.maximum(colors[:, 3] ** 2, 1e-3)
    weights = alphas
    for _ in range(TRIMS):
        interruption.check()
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


def absorbed_cores(image: FloatArray, labels: IntArray, price: float, kinds: tuple[str, ...]) -> IntArray:
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
            interruption.check()
            paints[k] = fitted(image, labels == k, price, kinds)
        return paints[k]

    for k in np.argsort(sizes[1:], kind="stable") + 1:
        interruption.check()
        if not near[k] or not sizes[k]:
            continue
        mask = labels[boxes[k - 1]] == k
        corner = boxes[k - 1][1].start, boxes[k - 1][0].start
        colors, points = straight(image[boxes[k - 1]][mask]), pixel_centers(mask) + corner
        weights = np.maximum(colors[:, 3] ** 2, 1e-3)
        own = paint_of(k)
        errors = {}
        for n in sorted(near[k]):
            interruption.check()
            errors[n] = float(weights @ np.square(paint_of(n).at(points) - colors).sum(axis=1))
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
