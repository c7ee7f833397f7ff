# SPDX-License-Identifier: Apache-2.0
"""Fill: colours of gradients at pixel centres, pixel by pixel, by the definition of SVG's stops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import LINEAR, SOLID, Drawing

FloatArray = NDArray[np.float64]


def place(points: FloatArray, kind: int, pixel: FloatArray) -> float:
    """Return t at a pixel centre (2,); infinity where the geometry is degenerate."""
    if kind == LINEAR:
        along = points[1] - points[0]
        square = float(along @ along)
        return float((pixel - points[0]) @ along) / square if square > 0 else np.inf
    axes = (points[1:] - points[0]).T
    if not np.linalg.det(axes):
        return np.inf
    return float(np.linalg.norm(np.linalg.solve(axes, pixel - points[0])))


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
    height, width = drawing.size
    paints = np.empty((drawing.num_layers, height, width, 4))
    for layer, kind in enumerate(drawing.fills.kinds.tolist()):
        if kind == SOLID:
            paints[layer] = drawing.colors[layer]
            continue
        own = drawing.fills.stops(layer)
        for row, column in np.ndindex(height, width):
            t = place(drawing.fills.geometry[layer], kind, np.array((column + 0.5, row + 0.5)))
            paints[layer, row, column] = stop_color(
                drawing.fills.stop_positions[own], drawing.fills.stop_colors[own], t
            )
    return paints


def fill_render(coverage: FloatArray, drawing: Drawing) -> FloatArray:
    """Return the image (H, W, 3), or premultiplied (H, W, 4), of coverages (N, H, W) and the drawing's fills."""
    channels = 3 if drawing.background is not None else 4
    image = np.zeros((*drawing.size, channels)) + (0 if drawing.background is None else drawing.background)
    for share, paint in zip(coverage, layer_paints(drawing), strict=True):
        color = np.concatenate([paint[..., :3], np.ones((*drawing.size, channels - 3))], axis=-1)
        image = image + (paint[..., 3] * share)[..., None] * (color - image)
    return image
