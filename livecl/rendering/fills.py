# SPDX-License-Identifier: Apache-2.0
"""Gradient fills on the device: pack their parameters for kernels/fill.h, and finish the gradient from its sums."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.drawing.fills import LINEAR, RADIAL, Fills
from livecl.geometry.bezier import cross

#: Sizes in reals as in kernels/fill.h: geometry and stop of a record; a layer and a stop in `params`.
D_GEOMETRY, D_STOP = 6, 5
FILL_REALS = 12
#: Area of an ellipse over its axes' squared lengths below which it is degenerate; width of stops below which they are a
#: step.
_FLAT = 1e-12
#: Length, px, below which a linear gradient is a step, and an ellipse a point: quotients by smaller numbers overflow.
_SHORT = 1e-9


@dataclasses.dataclass(frozen=True)
class FillGradients:
    """Gradient of a scalar loss with respect to a drawing's fills; zero for solid layers.

    Attributes
    ----------
    geometry : (N, 3, 2) float64
        Loss per pixel of displacement.
    stop_positions : (S,) float64
        Loss per unit of offset.
    stop_colors : (S, 4) float64
        Loss per unit of straight RGBA.
    """

    geometry: FloatArray
    stop_positions: FloatArray
    stop_colors: FloatArray


def record_reals(fills: Fills) -> int:
    """Return the size of a record in reals: that of the layer with most stops."""
    return D_GEOMETRY + D_STOP * int(np.diff(fills.stop_offsets).max())


@functools.lru_cache(maxsize=1)
def place_maps(fills: Fills) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return A of each layer, (N, 2, 2), and whether it exists; (u, v) = A (p - origin).

    The last result is cached: a step of training needs it before the kernels and after.
    """
    maps = np.zeros((len(fills), 2, 2))
    first, second = fills.geometry[:, 1] - fills.geometry[:, 0], fills.geometry[:, 2] - fills.geometry[:, 0]  # e1, e2
    length = np.hypot(*first.T)
    linear = (fills.kinds == LINEAR) & (length > 0)
    maps[linear, 0] = first[linear] / length[linear, None] / np.maximum(length[linear, None], _SHORT)
    determinant = cross(first, second)
    size = (first * first + second * second).sum(axis=1)
    radial = (fills.kinds == RADIAL) & (np.abs(determinant) > _FLAT * size) & (size > _SHORT**2)
    (a, c), (b, d), whole = first[radial].T, second[radial].T, determinant[radial]
    maps[radial] = np.array([[d, -b], [-c, a]]).transpose(2, 0, 1) / whole[:, None, None]
    return maps, linear | radial


def pack_fills(fills: Fills) -> FloatArray:
    """Pack all fills in the layout of kernels/fill.h."""
    num, offsets = len(fills), fills.stop_offsets
    maps, regular = place_maps(fills)
    table = np.zeros((num, FILL_REALS))
    table[:, 0] = fills.kinds
    table[:, 1] = 4 + FILL_REALS * num + 6 * offsets[:-1]
    table[:, 2] = np.diff(offsets)
    table[:, 3] = np.where(regular, 0.0, 2.0)
    table[:, 4:6] = fills.geometry[:, 0]
    table[:, 6:10] = maps.reshape(-1, 4)
    stops = np.zeros((len(fills.stop_positions), 6))
    stops[:, 0] = fills.stop_positions
    widths = np.zeros(len(stops))
    widths[:-1] = fills.stop_positions[1:] - fills.stop_positions[:-1]
    widths[fills.end_stops[1]] = 0
    stops[:, 1] = np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > _FLAT)
    stops[:, 2:] = fills.stop_colors
    return np.concatenate([[record_reals(fills), 0, 0, 0], table.ravel(), stops.ravel()])


def fill_gradients(fills: Fills, sums: FloatArray) -> FillGradients:
    """Return the gradient with respect to points and stops from the sums of the records, (N, reals).

    With d_u, d_v summed into d (2,), and d_A (2, 2), both from kernels/fill.h, and q = p - origin:

        radial  A = E^-1, so dA = -A dE A:   d_E = -A^T d_A A^T,   d_e1, d_e2 its columns
                d_c = -A^T d - d_e1 - d_e2,  as E's columns are e1 - c, e2 - c
        linear  row = a / |a|^2, a = p1 - p0:   d_a = (d_row - 2 (d_row . a) row) / |a|^2,  as row . a = 1
                d_p1 = d_a,   d_p0 = -d_a - row d_u
    """
    maps, regular = place_maps(fills)
    d_place, d_maps = sums[:, :2], sums[:, 2:D_GEOMETRY].reshape(-1, 2, 2)
    geometry = np.zeros_like(fills.geometry)
    transposed = np.swapaxes(maps, 1, 2)
    d_origin = -(maps * d_place[:, :, None]).sum(axis=1)

    radial = (fills.kinds == RADIAL) & regular
    d_axes = -(transposed @ d_maps @ transposed)
    geometry[radial, 1:] = np.swapaxes(d_axes, 1, 2)[radial]
    geometry[radial, 0] = d_origin[radial] - geometry[radial, 1:].sum(axis=1)

    linear = (fills.kinds == LINEAR) & regular
    if linear.any():
        along = fills.geometry[linear, 1] - fills.geometry[linear, 0]
        square = (along**2).sum(axis=1, keepdims=True)
        square[square <= _SHORT**2] = np.inf
        d_row, row = d_maps[linear, 0], maps[linear, 0]
        geometry[linear, 1] = (d_row - 2 * (d_row * along).sum(axis=1, keepdims=True) * row) / square
        geometry[linear, 0] = np.where(np.isfinite(square), d_origin[linear], 0) - geometry[linear, 1]

    records = sums[:, D_GEOMETRY:].reshape(len(fills), -1, D_STOP)
    stops = records[fills.stop_layers, fills.stop_ranks]
    return FillGradients(geometry, stops[:, 0], stops[:, 1:])
