# SPDX-License-Identifier: Apache-2.0
"""Fill: colours of gradients at pixel centres, by the definition of SVG's stops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import LINEAR, SOLID, Drawing

FloatArray = NDArray[np.float64]


def places(points: FloatArray, kind: int, size: tuple[int, int]) -> FloatArray:
    """Return t at all pixel centres, (H, W); infinity where the geometry is degenerate."""
    row, column = np.indices(size)
    centers = np.stack([column, row], axis=-1) + 0.5
    if kind == LINEAR:
        along = points[1] - points[0]
        length = float(np.hypot(*along))
        if not length:
            return np.full(size, np.inf)
        with np.errstate(over="ignore"):  # of points that all but coincide, infinite on either side
            return (centers - points[0]) @ (along / length) / length
    axes = (points[1:] - points[0]).T
    if not np.linalg.det(axes):
        return np.full(size, np.inf)
    return np.linalg.norm(np.linalg.solve(axes, (centers - points[0]).reshape(-1, 2).T), axis=0).reshape(size)


def stop_color(positions: FloatArray, colors: FloatArray, t: float) -> FloatArray:
    """Return the straight RGBA at t: (4,)."""
    if t < positions[0]:
        return colors[0]
    if t >= positions[-1]:
        return colors[-1]
    after = int(np.flatnonzero(positions > t)[0])
    share = (t - positions[after - 1]) / (positions[after] - positions[after - 1])
    return np.asarray((1 - share) * colors[after - 1] + share * colors[after])


def layer_paints(drawing: Drawing) -> FloatArray:
    """Return the straight RGBA of each layer at each pixel centre: (N, H, W, 4)."""
    fills, paints = drawing.fills, np.empty((drawing.num_layers, *drawing.size, 4))
    for layer, kind in enumerate(fills.kinds.tolist()):
        if kind == SOLID:
            paints[layer] = drawing.colors[layer]
            continue
        own = fills.stops(layer)
        t = places(fills.geometry[layer], kind, drawing.size)
        for pixel in np.ndindex(drawing.size):
            paints[layer][pixel] = stop_color(fills.stop_positions[own], fills.stop_colors[own], float(t[pixel]))
    return paints
