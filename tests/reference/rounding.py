# SPDX-License-Identifier: Apache-2.0
"""How far a single-precision result may lie from the exact one: root of the number of roundings x eps x scale.

Roundings are independent and of either sign: n of them add up to the root of n, not to n as in the worst case, which
would allow ten thousand times the largest error and hide real mistakes. A rounding to nearest of a number x is spread
evenly over +-UNIT |x|, so its standard deviation is UNIT |x| / sqrt(3). What is allowed is `DEVIATIONS` of these.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from reference import images
from reference.composite import composite_backward
from reference.coverage import lines_of, winding_area
from reference.fill import layer_paints
from reference.flatten import flatten
from reference.places import DEVIATIONS, ROUNDING, UNIT, gradient_places

FloatArray = NDArray[np.float64]

#: Roundings of a position, each of the coordinates' size: 3 sums in a vertex; 4 conversions, 4 weights and 4 products,
#: whose squares add up to no more than one such rounding for each kind; 4 for where a line meets a pixel border.
POSITION_ROUNDINGS = 3 + 3 + 4

#: SNAP of kernels/common.h: single precision takes |A| for 0 below it, and for not yet saturated up to 1 + SNAP.
SNAP = 128 * 2 * UNIT

#: Roundings of `over` a layer, each of up to 1: opacity, coverage's product with it, difference, product, sum.
OVER_ROUNDINGS = 5


def coverage_tolerance(drawing: Drawing, pieces: ArrayLike) -> FloatArray:
    """Return the error allowed for each layer's coverage: (N,)."""
    return DEVIATIONS * _coverage_deviation(drawing, pieces)


def image_tolerance(drawing: Drawing, pieces: ArrayLike) -> FloatArray:
    """Return the error allowed for each pixel of the image: (H, W, 1)."""
    tolerance = DEVIATIONS * np.sqrt(image_variance(drawing, pieces))
    for places in gradient_places(drawing).values():
        tolerance += places.doubtful_steps
    return tolerance[..., None]


def image_variance(drawing: Drawing, pieces: ArrayLike, outlines: float = 1, places: float = 1) -> FloatArray:
    """Return the variance of the image, (H, W): of outlines, of the places of gradients (both by a factor), of `over`.

    A colour's error counts by the layer's alpha, one of its opacity by the coverage, times up to 1.
    """
    layers = _opacities(drawing) * _coverage_deviation(drawing, pieces)
    rounding = OVER_ROUNDINGS * (drawing.num_layers + 1) * ROUNDING
    variance = np.full(drawing.size, outlines * float(np.sum(layers**2)) + rounding)
    if drawing.fills.any_gradients:
        shares = images.layer_coverages(drawing, pieces)
        for layer, own in gradient_places(drawing).items():
            variance += places * 2 * shares[layer] ** 2 * own.color_variance
    return variance


def colors_tolerance(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> float:
    """Return the error allowed for an entry of d_colors and d_background.

    It is a sum over P pixels of d_image times numbers up to 1 that are off by what the image is off. Neighbouring
    pixels share a vertex's error, some 3 of them, which adds a root of 3; those of a row or a column share an error of
    a gradient's place. Each of the sum's P roundings is of a partial sum, which is no larger than the root of P such
    products where signs are mixed.
    """
    size = np.sum(d_image**2, axis=2) * d_image.shape[2]
    num_pixels = drawing.size[0] * drawing.size[1]
    variance = image_variance(drawing, pieces, 3, max(drawing.size)) + num_pixels * ROUNDING
    steps = sum((places.doubtful_steps for places in gradient_places(drawing).values()), np.zeros(drawing.size))
    return float(DEVIATIONS * np.sqrt(np.sum(size * variance)) + np.sum(np.sqrt(size) * steps))


def points_tolerance(
    drawing: Drawing, pieces: ArrayLike, d_image: FloatArray, *, on_borders: bool = False
) -> FloatArray:
    """Return the error allowed for the entries of each segment's d_points: (M, 1, 1).

    The bound of rounding, and the doubtful part at kinks. Not so `on_borders`: outlines on pixel borders have
    whole numbers for coordinates, which both precisions hold.
    """
    tolerance = points_rounding(drawing, pieces, d_image)
    if not on_borders:
        tolerance += share_of_kinks(drawing, pieces, d_image, SNAP + coverage_tolerance(drawing, pieces))
    return tolerance[drawing.segment_layers][:, None, None]


def points_rounding(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> FloatArray:
    """Return what rounding may move the entries of each layer's d_points by: (N,).

    A line's ends receive n times the sum over its C crossed pixels of g times an integral over the line's share in the
    pixel, |n| being its length. In each pixel both ends of the share are off by a position's error, times g; and
    g = opacity G . (c - C) is off by what the image is off, or the opacity itself, of a gradient. A control point
    receives from its own segment's lines and from those of the one before.
    """
    pieces = np.asarray(pieces)
    d_coverage = _d_coverage(drawing, pieces, d_image)
    variance = _opacities(drawing) ** 2 * np.max(image_variance(drawing, pieces, 1, max(drawing.size)))
    for layer, places in gradient_places(drawing).items():
        variance[layer] += max(drawing.size) * d_image.shape[2] * np.max(places.color_variance)
    g_deviation = np.sqrt(np.max(np.sum(d_image**2, axis=2)) * variance)
    tolerances = []
    for layer, outlines in enumerate(flatten(drawing, pieces)):
        start, end = lines_of(outlines)
        # Bound to the canvas and one pixel around it, a line crosses all pixels that count.
        bound = np.array(drawing.size[::-1]) + 1.0
        crossed = 1 + np.sum(np.abs(np.clip(end, -1, bound) - np.clip(start, -1, bound)), axis=1)
        g = float(np.max(d_coverage[layer]))
        variance = crossed * (2 * (_position_deviation(drawing) * g) ** 2 + g_deviation[layer] ** 2)
        own = pieces[drawing.segment_layers == layer]
        tolerances.append(DEVIATIONS * np.sqrt(2 * np.max(np.add.reduceat(variance, np.cumsum(own) - own))))
    return np.array(tolerances)


def share_of_kinks(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray, band: FloatArray) -> FloatArray:
    """Return what the entries of each layer's d_points owe to pixels whose |A| is within `band` (N,) of 0 or 1: (N,).

    An error of A within the band takes such a pixel for an empty or saturated one, or the other way round: then the
    whole of its share is in question, which is g times the length of outline in the pixel.
    """
    d_coverage = _d_coverage(drawing, pieces, d_image)
    shares = []
    for layer, outlines in enumerate(flatten(drawing, pieces)):
        area = np.abs(winding_area(outlines, drawing.size))
        doubtful = np.argwhere(np.minimum(area, np.abs(area - 1)) <= band[layer])
        shares.append(float(np.sum(d_coverage[layer][tuple(doubtful.T)] * _lengths(outlines, doubtful))))
    return np.array(shares)


def share_of_snapped(drawing: Drawing, pieces: ArrayLike) -> FloatArray:
    """Return what the image may lack where single precision takes a small |A| for 0: (H, W, 1)."""
    band = SNAP + coverage_tolerance(drawing, pieces)
    share = np.zeros(drawing.size)
    for layer, outlines in enumerate(flatten(drawing, pieces)):
        area = np.abs(winding_area(outlines, drawing.size))
        share += _opacities(drawing)[layer] * np.where(area <= band[layer], area, 0.0)
    return share[..., None]


def _d_coverage(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> FloatArray:
    shares = images.layer_coverages(drawing, pieces)
    colors = layer_paints(drawing) if drawing.fills.any_gradients else drawing.colors
    return np.abs(composite_backward(d_image, shares, colors, drawing.background)[0])


def _opacities(drawing: Drawing) -> FloatArray:
    """Return the opacity of each layer, of gradients that of the most opaque stop: (N,)."""
    opacities, fills = drawing.colors[:, 3].copy(), drawing.fills
    for layer in fills.gradient_layers:
        opacities[layer] = np.max(fills.stop_colors[fills.stops(int(layer)), 3])
    return opacities


def _coverage_deviation(drawing: Drawing, pieces: ArrayLike) -> FloatArray:
    """A line whose two ends in a pixel are off by e moves 2 e of area (pixels are 1 wide and high).

    L lines touch a pixel at most. Of the K lines in its row to the left, a vertex's error cancels between its two
    lines, and one rounding each is left of the up to K + W partial sums, of up to the largest winding, here K / 2.
    """
    deviations = []
    for outlines in flatten(drawing, pieces):
        start, end = lines_of(outlines)
        low, high = np.minimum(start, end), np.maximum(start, end)
        row, column = np.arange(drawing.size[0])[:, None], np.arange(drawing.size[1])[:, None]
        in_row = (low[:, 1] <= row + 1) & (high[:, 1] >= row)
        in_column = (low[:, 0] <= column + 1) & (high[:, 0] >= column)
        per_pixel = np.max(in_row.astype(int) @ in_column.astype(int).T)
        per_row = np.max(np.sum(in_row, axis=1))
        sums = (per_row + drawing.size[1]) * (UNIT * max(1, per_row / 2)) ** 2 / 3
        deviations.append(np.sqrt(per_pixel * (2 * _position_deviation(drawing)) ** 2 + sums))
    return np.array(deviations)


def _position_deviation(drawing: Drawing) -> float:
    scale = np.sqrt(np.mean(drawing.points**2)) if drawing.num_segments else 0.0
    return float(np.sqrt(POSITION_ROUNDINGS / 3) * UNIT * max(1.0, scale))


def _lengths(outlines: list[FloatArray], pixels: NDArray[np.intp]) -> FloatArray:
    """Length of outline in each of the pixels (row, column) (P, 2), by clipping every line to them: (P,), px."""
    start, end = lines_of(outlines)
    along = end - start
    enter, leave = np.zeros((len(pixels), len(start))), np.ones((len(pixels), len(start)))
    for axis in (0, 1):
        border = pixels[:, 1 - axis, None] + np.array([0, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            meets = (border[:, None, :] - start[:, axis, None]) / along[:, axis, None]
        # A line along a border has 0 / 0 there and is taken to lie inside.
        enter = np.fmax(enter, np.min(meets, axis=2))
        leave = np.fmin(leave, np.max(meets, axis=2))
    return np.sum(np.maximum(leave - enter, 0) * np.hypot(*along.T), axis=1)
