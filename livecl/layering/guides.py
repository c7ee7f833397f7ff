# SPDX-License-Identifier: Apache-2.0
"""Layers of masks: a whole shape for each, in the order of depth that the picture shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.geometry.corners import noise_of
from livecl.geometry.polylines import evenly, polygon_area
from livecl.geometry.tracing import traced_path

FloatArray = NDArray[np.float64]

#: Coverage from which on a pixel is inside a mask, and clear of its antialiased edge.
INSIDE, CLEAR = 0.5, 0.95
#: Pixels that decide on depth or colour, at least; and area of the smallest part of a mask, px^2.
LEAST_PIXELS, LEAST_AREA = 3, 3.0
#: Difference of colour that counts as another colour, and of the means of such differences that decides nothing.
DIFFERENT, EQUAL = 0.1, 0.01
#: Share of grey pixels at a mask's edge under which it is steps of pixels, and the blur that evens them, px.
SOFT, EVENED = 0.3, 0.7


def masked_layers(
    image: NDArray[np.floating], masks: NDArray[np.floating], names: tuple[str, ...], background: FloatArray | None
) -> Drawing:
    """Return a drawing of one layer a mask, the lowest first, each in a group of its mask's name.

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
    """Return the masks, the lowest first, peeled off from the top; those that do not overlap stay in their order.

    A thing that nothing covers shows one colour all over its mask. So again and again the mask is taken off whose
    pixels, but for those under masks taken off before, differ least from their median; of about equal ones the smallest
    in area. A mask of which nothing is left lies below all.
    """
    pixels = np.asarray(image[..., :3], dtype=np.float64)
    areas = masks.sum(axis=(1, 2))
    free = np.ones(masks.shape[1:], bool)
    left, order = list(range(len(masks))), []
    spreads: dict[int, float] = {}
    while left:
        for k in left:
            if k not in spreads:
                spreads[k] = _spread(pixels, masks[k], free)
        least = min(spreads.values())
        top = min((k for k in left if spreads[k] <= least + EQUAL), key=lambda k: (areas[k], -k))
        order.append(top)
        left.remove(top)
        del spreads[top]
        free &= masks[top] <= 1 - CLEAR
        for k in left:  # those that it covered in part
            if ((masks[k] >= INSIDE) & (masks[top] > 1 - CLEAR)).any():
                spreads.pop(k, None)
    return _in_given_order(order[::-1], masks)


def _in_given_order(order: list[int], masks: NDArray[np.floating]) -> list[int]:
    """Return an order of masks, the lowest first, as near to rising numbers as it may be where masks overlap."""
    inside = (masks > 1 - CLEAR).reshape(len(masks), -1).astype(np.float32)
    overlap = inside @ inside.T > 0
    left, result = list(order), []
    while left:
        free = [k for n, k in enumerate(left) if not overlap[k, left[:n]].any()]
        result.append(min(free))
        left.remove(result[-1])
    return result


def _spread(pixels: FloatArray, mask: NDArray[np.floating], free: NDArray[np.bool_]) -> float:
    """Return how much the free pixels of a mask differ from their median, on the average: 0 to 1; 2 without any."""
    for own in ((mask >= CLEAR) & free, (mask >= INSIDE) & free):
        if (color := _median(pixels, own)) is not None:
            return float(np.minimum(np.abs(pixels[own] - color).max(axis=1) / DIFFERENT, 1).mean())
    return 2.0


def mask_outline(mask: NDArray[np.floating]) -> list[FloatArray]:
    """Return the outlines of a mask (H, W) as closed cubic paths (s, 3, 2), px, the largest first; holes run back."""
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
    """Return the colour (3,) of a mask's visible part: the median where it is clear of edges, else the mean."""
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
