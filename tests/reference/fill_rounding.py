# SPDX-License-Identifier: Apache-2.0
"""How far gradients of stops and geometry in single precision may lie from the exact ones (kernels/fill.h).

They are sums over P pixels of d = dL/dc of a pixel times shares, steps and offsets. In each term,

    d       is off by what the image is off, times |d_image|, as d_colors are (rounding.py)
    s       is off as places.py derives
    d_t = d . (c' - c) / w, times 1 - s or s, or the direction (u, v) / t, or x or y: 8 roundings, of 4 products and
            3 sums and the quotient, and 2 of what follows
    (u, v) / t  is off by what t is off, over t

and each of the P roundings of the sum is of a partial sum, no larger than the root of P such terms. Errors of s and t
are shared by the pixels of a row or a column, errors of outlines by 3 neighbours. Where rounding may bring t to the
other side of a stop, the whole of the pixel's d_t is in doubt.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from livecl.drawing.drawing import Drawing
from livecl.rendering.fills import D_GEOMETRY, FillGradients, fill_gradients, record_reals
from reference import images
from reference.composite import paint_backward
from reference.fill import layer_paints
from reference.places import DEVIATIONS, ROUNDING, Between, FloatArray, Places, gradient_places
from reference.rounding import image_variance

#: Roundings of a term of d_t, and of what it is multiplied by.

TERM_ROUNDINGS = 10


@dataclasses.dataclass
class _Sum:
    """Error of a sum over pixels: a variance, and a bound where a branch is in doubt."""

    variance: FloatArray
    doubt: FloatArray


def fills_tolerance(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> FillGradients:
    """Return the error allowed for each entry of the fills' gradient."""
    rounding, doubt = fills_tolerances(drawing, pieces, d_image)
    return FillGradients(
        rounding.geometry + doubt.geometry,
        rounding.stop_positions + doubt.stop_positions,
        rounding.stop_colors + doubt.stop_colors,
    )


def fills_tolerances(
    drawing: Drawing, pieces: ArrayLike, d_image: FloatArray, moved: float = 0.0
) -> tuple[FillGradients, FillGradients]:
    """Return the rounding error of each entry of the fills' gradient, and its doubt at stops.

    With `moved`, px, pixels are in doubt too that such a move takes past a stop.
    """
    return _tolerances(drawing, *_errors(drawing, pieces, d_image), gradient_places(drawing, moved))


def _errors(drawing: Drawing, pieces: ArrayLike, d_image: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return dL/dc of each pixel, (N, H, W, 4), and the variance of its components, (H, W)."""
    shares, paints = images.layer_coverages(drawing, pieces), layer_paints(drawing)
    size = np.sum(d_image**2, axis=2) * d_image.shape[2]
    variance = size * image_variance(drawing, pieces, 3, max(drawing.size))
    return paint_backward(d_image, shares, paints, drawing.background)[1], variance


def _tolerances(
    drawing: Drawing, d_paints: FloatArray, variance: FloatArray, layers: dict[int, Places]
) -> tuple[FillGradients, FillGradients]:
    fills, shared = drawing.fills, max(drawing.size)
    stops = _Sum(np.zeros(len(fills.stop_positions)), np.zeros(len(fills.stop_positions)))
    colors = _Sum(np.zeros((len(fills.stop_positions), 4)), np.zeros((len(fills.stop_positions), 4)))
    records = np.zeros((2, drawing.num_layers, D_GEOMETRY))
    for layer, places in layers.items():
        d = d_paints[layer]
        size = np.sum(d**2, axis=2)
        colors.variance[fills.stops(layer)] += np.sum(variance + d[..., 0].size * ROUNDING * size)
        slopes = _Sum(np.zeros(drawing.size), np.zeros(drawing.size))
        for part in places.between:
            ends = [part.stop, part.stop + 1]
            colors.variance[ends] += np.sum(size * shared * part.variance * part.inside)
            if not part.width:
                colors.doubt[ends] += np.sum(np.abs(d) * part.doubtful[..., None], axis=(0, 1))
                continue
            own = _slope(part, d, variance)
            sides = own.variance + shared * part.variance * (d @ part.step / part.width) ** 2 * part.inside
            stops.variance[ends] += np.sum(sides)
            stops.doubt[ends] += np.sum(own.doubt)
            slopes.variance += own.variance
            slopes.doubt += own.doubt
            if places.radial:
                turned = places.variance / np.maximum(places.t, 1e-300) ** 2
                slopes.variance += shared * turned * (d @ part.step / part.width) ** 2 * part.inside
        records[:, layer] = _record(places, slopes)
    rounding, doubt = _geometry(drawing, records[0]), _geometry(drawing, records[1])
    return (
        FillGradients(rounding, DEVIATIONS * np.sqrt(stops.variance), DEVIATIONS * np.sqrt(colors.variance)),
        FillGradients(doubt, stops.doubt, colors.doubt),
    )


def _slope(part: Between, d: FloatArray, variance: FloatArray) -> _Sum:
    """Return what d . (c' - c) / w of each pixel may be off by, but for its factors: (H, W)."""
    slope = d @ part.step / part.width
    roundings = (TERM_ROUNDINGS + slope.size) * ROUNDING * slope**2
    own = np.sum(part.step**2) / part.width**2 * variance + roundings
    return _Sum(np.where(part.inside, own, 0), np.where(part.doubtful, np.abs(slope), 0))


def _record(places: Places, slopes: _Sum) -> FloatArray:
    """Return the rounding error of a layer's sums of d_u, d_v and d_A, and its doubt: (2, 6)."""
    one, x, y = np.ones_like(places.x), np.abs(places.x), np.abs(places.y)
    factors = [one, one, x, y, x, y] if places.radial else [one, 0 * x, x, y, 0 * x, 0 * x]
    rounding = [DEVIATIONS * np.sqrt(np.sum(slopes.variance * m**2)) for m in factors]
    return np.array([rounding, [np.sum(slopes.doubt * m) for m in factors]])


def _geometry(drawing: Drawing, records: FloatArray) -> FloatArray:
    """Return the error allowed for points, (N, 3, 2): they are linear in the sums."""
    tolerance = np.zeros_like(drawing.fills.geometry)
    for entry in range(D_GEOMETRY):
        sums = np.zeros((drawing.num_layers, record_reals(drawing.fills)))
        sums[:, entry] = records[:, entry]
        tolerance += np.abs(fill_gradients(drawing.fills, sums).geometry)
    return tolerance
