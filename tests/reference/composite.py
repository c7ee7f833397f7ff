# SPDX-License-Identifier: Apache-2.0
"""Composite: layers over one another in paint order, and back.

With a_i = opacity_i coverage_i and C_0 the background (nothing: zeros, with an alpha channel),

    C_{i+1} = C_i + a_i (c_i - C_i),      c_i = (r, g, b), or (r, g, b, 1) where there is no background.

Colours are those of layers, (N, 4), or, of gradient fills, of each pixel too, (N, H, W, 4); straight RGBA.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def composite_forward(
    coverage: FloatArray, colors: FloatArray, background: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Return the image C_N (H, W, K), and what each layer covers, C_0 ... C_{N-1}: (N, H, W, K); K is 3 or 4.

    `coverage` is (N, H, W); `background` (3,), or None for a premultiplied RGBA image.
    """
    paint = _paint(colors, background)
    below = np.zeros((*coverage.shape, paint.shape[-1]))
    image = np.zeros((*coverage.shape[1:], paint.shape[-1])) + (0.0 if background is None else background)
    for i in range(len(colors)):
        below[i] = image
        image = image + (colors[i, ..., 3] * coverage[i])[..., None] * (paint[i] - image)
    return image, below


def composite_backward(
    d_image: FloatArray, coverage: FloatArray, colors: FloatArray, background: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return d_coverage (N, H, W), d_colors (N, 4), summed over the pixels, and d_background (K,)."""
    d_coverage, d_paints, d_background = paint_backward(d_image, coverage, colors, background)
    return d_coverage, np.sum(d_paints, axis=(1, 2)), d_background


def paint_backward(
    d_image: FloatArray, coverage: FloatArray, colors: FloatArray, background: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return d_coverage (N, H, W), the gradient by the colour of each pixel (N, H, W, 4), and d_background (K,).

    With G_N = d_image, from the top layer down:
        d_c_i = a_i G_{i+1}     d_a_i = G_{i+1} . (c_i - C_i)     G_i = (1 - a_i) G_{i+1}     d_background = G_0,
    the background's summed over pixels.
    """
    paint = _paint(colors, background)
    _, below = composite_forward(coverage, colors, background)
    d_coverage, d_paints = np.zeros_like(coverage), np.zeros((*coverage.shape, 4))
    g = d_image
    for i in reversed(range(len(colors))):
        alpha = (colors[i, ..., 3] * coverage[i])[..., None]
        d_alpha = np.sum(g * (paint[i] - below[i]), axis=-1)
        d_paints[i, ..., :3] = (alpha * g)[..., :3]
        d_paints[i, ..., 3] = coverage[i] * d_alpha
        d_coverage[i] = colors[i, ..., 3] * d_alpha
        g = (1 - alpha) * g
    return d_coverage, d_paints, np.sum(g, axis=(0, 1))


def squared_error(image: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the squared error of each pixel, (H, W), and its gradient by the image, (H, W, K).

    Of RGB it is |e|^2. Of premultiplied RGBA, with e = (f, e_a), the mean over a black background, where f shows, and a
    white one, where f - e_a (1, 1, 1) does: 1/2 |f|^2 + 1/2 |f - e_a (1, 1, 1)|^2.
    """
    error = image - target
    if error.shape[-1] == 3:
        return np.sum(error**2, axis=-1), 2 * error
    black, white = error[..., :3], error[..., :3] - error[..., 3:]
    d_error = np.concatenate([black + white, -np.sum(white, axis=-1, keepdims=True)], axis=-1)
    return np.sum(black**2 + white**2, axis=-1) / 2, d_error


def _paint(colors: FloatArray, background: FloatArray | None) -> FloatArray:
    rgb = colors[..., :3]
    return rgb if background is not None else np.concatenate([rgb, np.ones_like(rgb[..., :1])], axis=-1)
