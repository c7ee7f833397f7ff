# SPDX-License-Identifier: Apache-2.0
"""Layers from masks: one whole shape for each mask, in the depth order that the picture shows."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.arrays import FloatArray
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.geometry.corners import noise_of
from livecl.geometry.polylines import evenly, polygon_area
from livecl.geometry.tracing import traced_path

#: Coverage from which a pixel is inside a mask, and from which it is clear of the mask's anti-aliased edge.
INSIDE, CLEAR = 0.5, 0.95
#: Fewest pixels from which depth or colour is judged; area of the smallest part of a mask, px^2.
LEAST_PIXELS, LEAST_AREA = 3, 3.0
#: Bins per channel of the colour histograms; relative frequency that counts as absent.
BINS, RARE = 8, 1e-3
#: Share of grey pixels along a mask's edge below which the mask counts as binary, and the blur, px, that smooths its
#: pixel steps.
SOFT, EVENED = 0.3, 0.7


def masked_layers(
    image: NDArray[np.floating], masks: NDArray[np.floating], names: tuple[str, ...], background: FloatArray | None
) -> Drawing:
    """Return a drawing of one layer per mask, the lowest first, each in a group named after its mask.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array
        The picture, straight.
    masks : (K, H, W) array
        Coverage of each thing, hidden parts included where they are known.
    names : (K,) tuple of str
        Names of the masks.
    background : (3,) array or None
        Of the drawing.
    """
    order = depth_order(image, masks)
    outlines, colors, groups = [], [], []
    above = np.ones(masks.shape[1:])
    for k in order[::-1]:
        outline = mask_outline(masks[k])
        if outline:
            outlines.append(outline)
            colors.append((*_color(image, masks[k] * above, masks[k]), 1.0))
            groups.append((names[k],))
        above *= 1 - masks[k]
    size = (image.shape[0], image.shape[1])
    if not outlines:
        return empty_drawing(size, background)
    drawing = Drawing.from_outlines(outlines[::-1], np.clip(colors[::-1], 0, 1), size, background)
    return drawing.replace(groups=groups[::-1])


def depth_order(image: NDArray[np.floating], masks: NDArray[np.floating]) -> list[int]:
    """Return the masks in depth order, the lowest first; masks that do not overlap keep their order.

    Of two masks that overlap, the upper one is visible in the overlap: there the picture has the colours of the rest of
    that mask. A mask within another one lies above it. Masks are peeled off from the top: each time the one with least
    evidence of the others lying above it, counted in pixels not covered by masks already peeled; of equal ones the
    smallest in area.
    """
    bins = np.minimum(np.asarray(image[..., :3], dtype=np.float64) * BINS, BINS - 1).astype(np.intp) @ (
        BINS**2,
        BINS,
        1,
    )
    areas = masks.sum(axis=(1, 2))
    clear, touched = masks >= CLEAR, masks > 1 - CLEAR
    free = np.ones(masks.shape[1:], bool)
    left, order = list(range(len(masks))), []
    above = np.zeros((len(masks), len(masks)))  # how much each mask is above each other one
    changed = list(itertools.combinations(left, 2))
    while left:
        for a, b in changed:
            above[a, b] = _above(bins, (clear[a] & free, touched[a]), (clear[b] & free, touched[b]))
            above[b, a] = -above[a, b]
        covered = {k: float(above[left, k].max()) for k in left}
        least = max(min(covered.values()), 0.0)
        top = min((k for k in left if covered[k] <= least), key=lambda k: (areas[k], -k))
        order.append(top)
        left.remove(top)
        free &= ~touched[top]
        above[top], above[:, top] = 0.0, 0.0
        meets = {k for k in left if (clear[k] & touched[top]).any()}
        changed = [pair for pair in itertools.combinations(left, 2) if meets & set(pair)]
    return _in_given_order(order[::-1], masks)


def _above(
    bins: NDArray[np.intp],
    first: tuple[NDArray[np.bool_], NDArray[np.bool_]],
    second: tuple[NDArray[np.bool_], NDArray[np.bool_]],
) -> float:
    """Return the evidence that the first mask lies above the second, from the colours of their overlap.

    Mean log-likelihood ratio of the overlap's colours under the colour histograms of the rest of each mask, scaled to
    -1 to 1. `bins` (H, W) are indices of colours. Given for each mask are the pixels that are certainly its own, and
    all pixels that it touches.
    """
    both = first[0] & second[0]
    if np.count_nonzero(both) < LEAST_PIXELS:
        return 0.0
    rests = first[0] & ~second[1], second[0] & ~first[1]
    sizes = [np.count_nonzero(rest) for rest in rests]
    if max(sizes) < LEAST_PIXELS:
        return 0.0
    if min(sizes) < LEAST_PIXELS:  # one lies within the other
        return float(np.sign(sizes[1] - sizes[0]))
    shares = [np.bincount(bins[rest], minlength=BINS**3) / size + RARE for rest, size in zip(rests, sizes, strict=True)]
    return float(np.log(shares[0] / shares[1])[bins[both]].mean() / -np.log(RARE))


def _in_given_order(order: list[int], masks: NDArray[np.floating]) -> list[int]:
    """Return an order of masks, the lowest first, as near to ascending numbers as overlaps allow."""
    inside = (masks > 1 - CLEAR).reshape(len(masks), -1).astype(np.float32)
    overlap = inside @ inside.T > 0
    left, result = list(order), []
    while left:
        free = [k for n, k in enumerate(left) if not overlap[k, left[:n]].any()]
        result.append(min(free))
        left.remove(result[-1])
    return result


def mask_outline(mask: NDArray[np.floating]) -> list[FloatArray]:
    """Trace a mask (H, W) as closed cubic paths (s, 3, 2), px, the largest first; holes run the other way round."""
    from skimage.measure import find_contours

    padded = np.pad(np.asarray(mask, dtype=np.float64), 1)
    edge = ndimage.maximum_filter(padded, 3) - ndimage.minimum_filter(padded, 3) > 0.5
    if np.mean((padded[edge] > 0.02) & (padded[edge] < 0.98)) < SOFT:
        padded = ndimage.gaussian_filter(padded, EVENED)
    found = []
    for contour in find_contours(padded, 0.5):
        points = contour[:-1, ::-1] - 0.5  # pixel centres, and a pixel of padding
        area = polygon_area(points)
        if len(points) >= 4 and abs(area) >= LEAST_AREA:
            found.append((abs(area), evenly(points)))
    found.sort(key=lambda item: -item[0])
    noise = noise_of([points for _, points in found])
    return [traced_path(points, noise) for _, points in found]


def _color(image: NDArray[np.floating], seen: FloatArray, mask: NDArray[np.floating]) -> FloatArray:
    """Return the colour (3,) of a mask's visible part: the median away from edges if there is any, else the mean."""
    alpha = image[..., 3] if image.shape[2] == 4 else np.ones(image.shape[:2])
    pixels = np.asarray(image[..., :3], dtype=np.float64)
    inner = ndimage.minimum_filter(seen, 3) >= CLEAR
    for clear in (inner & (alpha > INSIDE), (seen >= CLEAR) & (alpha > INSIDE)):
        if (color := _median(pixels, clear)) is not None:
            return color
    weights = (seen if seen.sum() > 0.1 else mask) * alpha
    return np.asarray(np.average(pixels.reshape(-1, 3), axis=0, weights=weights.ravel() + 1e-12))


def _median(pixels: FloatArray, where: NDArray[np.bool_]) -> FloatArray | None:
    return np.asarray(np.median(pixels[where], axis=0)) if np.count_nonzero(where) >= LEAST_PIXELS else None
