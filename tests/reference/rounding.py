# SPDX-License-Identifier: Apache-2.0
"""How far a single-precision result may lie from the exact one: root of the number of roundings x eps x scale.

Roundings are independent and of either sign: n of them add up to the root of n, not to n as in the worst case, which
would allow ten thousand times the largest error and hide real mistakes. A rounding to nearest of a number x is spread
evenly over +-UNIT |x|, so its standard deviation is UNIT |x| / sqrt(3). What is allowed is `DEVIATIONS` of these.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

import reference
from livecl.drawing.drawing import Drawing
from reference.composite import composite_backward
from reference.coverage import lines_of, winding_area
from reference.flatten import flatten

FloatArray = NDArray[np.float64]

#: Relative error of one rounding in float32.
UNIT = 2.0**-24

#: Standard deviations allowed. One in 2 million lies beyond 5, and some 100 000 numbers are compared.
DEVIATIONS = 5

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


def image_tolerance(drawing: Drawing, pieces: ArrayLike) -> float:
    """Return the error allowed for the image."""
    return DEVIATIONS * _image_deviation(drawing, pieces)


def colors_tolerance(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> float:
    """Return the error allowed for an entry of d_colors and d_background.

    It is a sum over P pixels of d_image times numbers up to 1 that are off by what the image is off. Neighbouring
    pixels share a vertex's error, some 3 of them, which adds a root of 3. Each of the sum's P roundings is of a partial
    sum, which is no larger than the root of P such products where signs are mixed.
    """
    size = float(np.linalg.norm(d_image)) * np.sqrt(d_image.shape[2])
    num_pixels = drawing.size[0] * drawing.size[1]
    return DEVIATIONS * size * float(np.sqrt(3 * _image_deviation(drawing, pieces) ** 2 + num_pixels * UNIT**2 / 3))


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
    g = opacity G . (c - C) is off by what the image is off. A control point receives from its own segment's lines and
    from those of the one before.
    """
    pieces = np.asarray(pieces)
    d_coverage = _d_coverage(drawing, pieces, d_image)
    g_deviation = drawing.colors[:, 3] * np.sqrt(np.max(np.sum(d_image**2, axis=2))) * _image_deviation(drawing, pieces)
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
        share += drawing.colors[layer, 3] * np.where(area <= band[layer], area, 0.0)
    return share[..., None]


def _d_coverage(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> FloatArray:
    shares = reference.layer_coverages(drawing, pieces)
    return np.abs(composite_backward(d_image, shares, drawing.colors, drawing.background)[0])


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


def _image_deviation(drawing: Drawing, pieces: ArrayLike) -> float:
    layers = drawing.colors[:, 3] * _coverage_deviation(drawing, pieces)
    return float(np.sqrt(np.sum(layers**2) + OVER_ROUNDINGS * (drawing.num_layers + 1) * UNIT**2 / 3))


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
