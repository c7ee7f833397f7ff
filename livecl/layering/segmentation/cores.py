# SPDX-License-Identifier: Apache-2.0
"""Cores of smoothly varying colour: found by second differences, split where no fill explains them, and absorbed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.drawing.colors import premultiplied_colors
from livecl.layering.drift import Changes
from livecl.layering.fills.overlays import fit_overlaid
from livecl.layering.fills.ramps import COLOR_NUMBERS, LAYER_NUMBERS, Paint, fit_paint
from livecl.layering.segmentation.labels import grid_components, with_blocks
from livecl.layering.segmentation.small import SAME_STEP

#: Largest error of a fill at a pixel that it explains, and share of unexplained pixels above which a region is split.
MISSED, MISSED_SHARE = 3.5 / 255, 0.03
#: Least share of a region that one fill must explain to be split off, and pixels of the smallest part.
CUT_SHARE, CUT_PIXELS = 0.2, 24
#: Rounds of reweighting unexplained pixels; most splits of one region.
TRIMS, CUTS = 4, 6
#: Pixels of the smallest core in which overlaid fills are sought: fewer hardly tell them from one fill.
OVERLAID_PIXELS = 400
#: Place values of the channels of a colour in levels, of which 256 and a few beyond occur.
_PLACES = np.int64(1024) ** np.arange(3, -1, -1)
#: Largest distance, px, between neighbouring cores across pixels of no core.
BESIDE = 2.0


def straight(pixels: FloatArray) -> FloatArray:
    """Convert RGB or premultiplied RGBA (n, C) to straight RGBA (n, 4)."""
    if pixels.shape[1] == 3:
        return np.column_stack([pixels, np.ones(len(pixels))])
    alpha = pixels[:, 3:]
    return np.concatenate([np.clip(pixels[:, :3] / np.maximum(alpha, 1e-3), 0, 1), alpha], axis=1)


def fitted_paint(
    image: FloatArray, mask: BoolArray, price: float, kinds: tuple[str, ...], near: Sequence[Paint] = ()
) -> Paint:
    """Fit a fill to the pixels (H, W) of a picture, near others as in :func:`fit_paint`."""
    colors = straight(image[mask])
    if len(colors) < CUT_PIXELS:
        kinds = ()
    return fit_paint(pixel_centers(mask), colors, np.maximum(colors[:, 3] ** 2, 1e-3), price, kinds, near)


def pixel_centers(mask: BoolArray) -> FloatArray:
    """Return the centres (n, 2) of pixels (H, W)."""
    rows, columns = np.nonzero(mask)
    return np.asarray(np.column_stack([columns, rows]) + 0.5, dtype=np.float64)


def smooth_cores(image: FloatArray) -> IntArray:
    """Label the smooth components of a picture from 1 on; 0 elsewhere.

    Neighbouring pixels are connected within 2 x 2 blocks of nearly one colour, which thin parts have too, and where
    both are smooth in all directions.
    """
    smooth = Changes.of(image).smooth
    corners = np.stack([image[:-1, :-1], image[1:, :-1], image[:-1, 1:], image[1:, 1:]])
    block = (corners.max(axis=0) - corners.min(axis=0)).max(axis=-1) <= SAME_STEP
    interruption.check()
    right, down = smooth[:, :-1] & smooth[:, 1:], smooth[:-1] & smooth[1:]
    right[:-1] |= block
    right[1:] |= block
    down[:, :-1] |= block
    down[:, 1:] |= block
    interruption.check()
    return with_blocks(grid_components(right, down))


def cut_cores(
    image: FloatArray, labels: IntArray, price: float, kinds: tuple[str, ...]
) -> tuple[IntArray, dict[int, Paint]]:
    """Split the cores that no fill explains; return the labels, and the fills of cores explained by overlaid fills.

    The cheapest of one fill, overlaid fills, and parts with a fill each is chosen.
    """
    labels = labels.copy()
    overlaid: dict[int, Paint] = {}
    count = int(labels.max())
    for k, box in enumerate(ndimage.find_objects(labels), start=1):
        interruption.check()
        mask = labels[box] == k
        parts = _cut(image[box], mask, price, kinds)
        if parts is None:
            continue
        paint = _overlaid(image[box], mask, parts, price, kinds)
        if paint is not None:
            overlaid[k] = paint.shifted(np.array([box[1].start, box[0].start], dtype=np.float64))
            continue
        labels[box][mask] = np.where(parts > 1, parts - 1 + count, np.where(parts == 1, k, 0))[mask]
        count += int(parts.max()) - 1
    # Parts of a core that hung together by pixels that were cut are regions of their own.
    parts = grid_components(labels[:, 1:] == labels[:, :-1], labels[1:] == labels[:-1])
    _, numbers = np.unique(parts[labels > 0], return_inverse=True)
    found = np.zeros_like(labels)
    found[labels > 0] = numbers + 1
    return found, {int(found[labels == k][0]): paint for k, paint in overlaid.items()}


def _cut(image: FloatArray, mask: BoolArray, price: float, kinds: tuple[str, ...]) -> IntArray | None:
    """Return the parts of a core that are explained by one fill each, from 1 on; None if one explains all.

    Pixels that no fill explains are 0.
    """
    labels = mask.astype(np.int64)
    left, count = [(1, CUTS)], 1
    while left:
        interruption.check()
        k, cuts = left.pop()
        own = labels == k
        if not cuts or own.sum() < 2 * CUT_PIXELS:
            continue
        kept = _explained(image, own, price, kinds)
        if kept is None:
            continue
        parts, found = ndimage.label(own & ~kept)
        sizes = np.bincount(parts.ravel())
        labels[(sizes < CUT_PIXELS)[parts] & (parts > 0)] = 0
        for part in range(1, found + 1):
            if sizes[part] >= CUT_PIXELS:
                count += 1
                labels[parts == part] = count
                left.append((count, cuts - 1))
    return None if count == 1 and np.array_equal(labels > 0, mask) else labels


def _overlaid(
    image: FloatArray, mask: BoolArray, parts: IntArray, price: float, kinds: tuple[str, ...]
) -> Paint | None:
    """Fit overlaid fills to a core; None unless they cost less than one fill for all and one for each part."""
    colors = straight(image[mask])
    if len(colors) < OVERLAID_PIXELS or colors[:, 3].min() < 1:
        return None
    most = min(_cost_of(image, mask, some, price, kinds) for some in (mask.astype(np.int64), parts))
    return fit_overlaid(pixel_centers(mask), colors, price, kinds, most)


def _cost_of(image: FloatArray, mask: BoolArray, parts: IntArray, price: float, kinds: tuple[str, ...]) -> float:
    """Return the squared error plus price of a core in parts of one fill each, small ones absorbed."""
    parts = absorbed_cores(image, parts, price, kinds)[0]
    nearest = ndimage.distance_transform_edt(parts == 0, return_distances=False, return_indices=True)
    whole, total = np.where(mask, parts[tuple(nearest)], 0), 0.0
    for k in range(1, int(parts.max()) + 1):
        paint, own = fitted_paint(image, parts == k, price, kinds), whole == k
        total += float(np.square(paint.at(pixel_centers(own)) - straight(image[own])).sum())
        total += price * (paint.numbers + LAYER_NUMBERS - COLOR_NUMBERS)
    return total


def _explained(image: FloatArray, mask: BoolArray, price: float, kinds: tuple[str, ...]) -> BoolArray | None:
    """Return the pixels of a core explained by the fill that explains most; None if it explains all or too few."""
    colors, points = straight(image[mask]), pixel_centers(mask)
    seen, alphas = premultiplied_colors(colors), np.maximum(colors[:, 3] ** 2, 1e-3)
    weights = alphas
    for _ in range(TRIMS):
        interruption.check()
        paint = fit_paint(points, colors, weights, price, kinds)
        miss = np.abs(premultiplied_colors(paint.at(points)) - seen).max(axis=1)
        if np.mean(miss > MISSED) <= MISSED_SHARE:
            break
        weights = alphas / (1 + np.square(miss / MISSED))
    interruption.check()
    plain = np.abs(seen - _mode(seen)).max(axis=1)
    interruption.check()
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


def absorbed_cores(
    image: FloatArray,
    labels: IntArray,
    price: float,
    kinds: tuple[str, ...],
    known: Mapping[int, Paint] = MappingProxyType({}),
) -> tuple[IntArray, dict[int, Paint]]:
    """Merge cores into the neighbour whose fill shows them at less error than a layer of their own would cost.

    The smallest first: slivers along fading edges, where the part cut from a region hardly differs in colour. Returns
    the labels, and the `known` fills by new label.
    """
    labels, count = labels.copy(), int(labels.max())
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    near = _neighbors(labels)
    boxes = ndimage.find_objects(labels)
    paints: dict[int, Paint] = dict(known)

    def paint_of(k: int) -> Paint:
        if k not in paints:
            interruption.check()
            paints[k] = fitted_paint(image, labels == k, price, kinds)
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
    return np.concatenate([[0], kept])[labels], {int(kept[k - 1]): known[k] for k in known if sizes[k]}


def _neighbors(labels: IntArray) -> dict[int, set[int]]:
    """Return the cores within a few pixels of each core, with no other core between."""
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
    """Return the most frequent of some colours (n, C), rounded to 8 bits."""
    levels = np.round(colors * 255).astype(np.int64)
    # One number for each colour, in the order of its channels: sorting rows takes ten times as long.
    _, first, counts = np.unique(levels @ _PLACES[-levels.shape[1] :], return_index=True, return_counts=True)
    return np.asarray(levels[first[np.argmax(counts)]] / 255)
