# SPDX-License-Identifier: Apache-2.0
"""Contribution of each layer to the picture: alphas, visible shares, and the error without the layer.

The share of layer i in a pixel's final colour is its alpha there (opacity * coverage) times the transmittance, the
product of (1 - alpha) of all layers above it. A pixel is visible in a layer if that share exceeds one half, so in at
most one.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl import interruption
from livecl.arrays import Float32Array, FloatArray, Window
from livecl.drawing.canvas import layer_boxes
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID
from livecl.image.errors import visible_error

if TYPE_CHECKING:
    from livecl.rendering.rasterizer import Rasterizer

#: Share of a pixel's final colour above which the pixel is visible in a layer.
VISIBLE_SHARE = 0.5


def layer_alphas(drawing: Drawing, rasterizer: Rasterizer | None = None) -> Float32Array:
    """Render opacity times coverage of each layer alone: (N, H, W)."""
    from livecl.rendering.rasterizer import Rasterizer

    if rasterizer is None:
        rasterizer = Rasterizer(drawing.size)
    return covered_alphas(drawing, rasterizer.coverages(drawing))


def covered_alphas(drawing: Drawing, coverages: Float32Array) -> Float32Array:
    """Return opacity times coverage of each layer alone, given the coverages: (N, H, W) both."""
    alphas = np.empty_like(coverages)
    for layer, window in enumerate(_windows(drawing)):
        interruption.check()
        np.multiply(coverages[layer], opacity_at_pixels(drawing, layer, window), out=alphas[layer])
    return alphas


def opacity_at_pixels(drawing: Drawing, layer: int, window: Window | None = None) -> Float32Array:
    """Return the opacity of a layer's paint: (), or (H, W) for a gradient of varying opacity.

    Values outside `window` may be 0.
    """
    fills = drawing.fills
    if fills.kinds[layer] != SOLID and (opacity := fills.opacity(layer)) is not None:
        return np.asarray(opacity, dtype=np.float32)
    return paint_at_pixels(drawing, layer, window)[..., 3].astype(np.float32)


def paint_at_pixels(drawing: Drawing, layer: int, window: Window | None = None) -> FloatArray:
    """Return the straight RGBA of a layer's paint: (4,), or (H, W, 4) for a gradient.

    Values outside `window` may be 0.
    """
    if drawing.fills.kinds[layer] == SOLID:
        return np.asarray(drawing.colors[layer])
    height, width = drawing.size
    if window is None:
        return drawing.fills.colors_at(layer, _centers(height, width).reshape(-1, 2)).reshape(height, width, 4)
    found = np.zeros((height, width, 4))
    centers = _centers(height, width)[window]
    found[window] = drawing.fills.colors_at(layer, centers.reshape(-1, 2)).reshape(*centers.shape[:2], 4)
    return found


@functools.lru_cache(maxsize=1)
def _centers(height: int, width: int) -> FloatArray:
    """Return the centres (x, y) of pixels: (H, W, 2)."""
    rows, columns = np.indices((height, width), dtype=np.float64) + 0.5
    return np.stack([columns, rows], axis=-1)


def composited_colors(drawing: Drawing, covered: bool = False) -> tuple[FloatArray, list[FloatArray]]:
    """Return the background (C,) and the colour of each layer as composited.

    A colour is (C,), or (H, W, C) for a gradient; with `covered`, only where the layer can cover pixels. Over a
    background C is 3. Without one it is 4, premultiplied RGBA: the background is transparent, and a paint has alpha 1,
    as its opacity is part of the layer's alpha.
    """
    windows = _windows(drawing) if covered and drawing.fills.any_gradients else [None] * drawing.num_layers
    paints = []
    for layer, window in enumerate(windows):
        interruption.check()
        paints.append(paint_at_pixels(drawing, layer, window))
    if drawing.background is not None:
        return drawing.background, [paint[..., :3] for paint in paints]
    return np.zeros(4), [np.concatenate([paint[..., :3], np.ones_like(paint[..., 3:])], axis=-1) for paint in paints]


def in_window(color: NDArray[Any], window: Window) -> NDArray[Any]:
    """Return a layer's colour within a window: (C,) unchanged, (H, W, C) cropped."""
    return color if color.ndim == 1 else color[window]


def visible_shares(alphas: Float32Array) -> Float32Array:
    """Return the share of each layer in the final colour, (N, H, W), from the layers' alphas, bottom first.

    ``share_i = alpha_i * prod_{j > i} (1 - alpha_j)``; the remainder to 1 is the background's.
    """
    shares = np.empty_like(alphas)
    transmittance = np.ones(alphas.shape[1:], np.float32)
    for layer in reversed(range(len(alphas))):
        interruption.check()
        shares[layer] = alphas[layer] * transmittance
        transmittance *= 1 - alphas[layer]
    return shares


def removal_changes(drawing: Drawing, alphas: Float32Array, target: ArrayLike, seen: bool = False) -> FloatArray:
    """Return the rise of the mean squared error when each layer is removed: (N,).

    Without layer i the picture changes by ``share_i * (C_i - c_i)``, where ``C_i`` is the picture of the background and
    all layers below it, and ``c_i`` its colour. With `seen`, the error is :func:`livecl.image.errors.visible_mse`.
    """
    target = checked_target(drawing, target)
    shares = visible_shares(alphas)
    windows = _windows(drawing)
    ground, colors = composited_colors(drawing, covered=True)
    below = np.broadcast_to(ground, target.shape).copy()
    changes_of_image = []
    for layer, window in enumerate(windows):
        interruption.check()
        missing = below[window] - in_window(colors[layer], window)
        changes_of_image.append((shares[layer][window][..., None] * missing).astype(np.float32))
        below[window] -= alphas[layer][window][..., None] * missing
    error, size = below - target, target.size
    if seen:
        changes_of_image = [visible_error(change) for change in changes_of_image]
        error, size = visible_error(error), 3 * target[..., 0].size
    return np.array(
        [
            float(np.sum(change * (2 * error[window] + change))) / size
            for window, change in zip(windows, changes_of_image, strict=True)
        ]
    )


def _windows(drawing: Drawing) -> list[Window]:
    """Return the rows and columns of the pixels that each layer can cover."""
    height, width = drawing.size
    low, high = np.split(layer_boxes(drawing), 2, axis=1)
    corners = np.clip(np.concatenate([np.floor(low), np.ceil(high)], axis=1), 0, (width, height, width, height))
    return [(slice(y0, y1), slice(x0, x1)) for x0, y0, x1, y1 in corners.astype(np.int64).tolist()]


def checked_target(drawing: Drawing, target: ArrayLike) -> FloatArray:
    """Return a target image after checking its size and channels against a drawing; ValueError for others."""
    array = np.asarray(target, dtype=np.float64)
    wanted = (*drawing.size, 4 if drawing.background is None else 3)
    if array.shape != wanted:
        raise ValueError(f"target: shape {array.shape}, wanted {wanted}")
    return array
