# SPDX-License-Identifier: Apache-2.0
"""Errors of images: the mean squared error, and the visible error of transparent images over a background.

The error of a transparent image is visible over a background. Let e be an error of premultiplied RGBA. Over a
background b the picture is p + (1 - a) b in each of R, G and B, so the visible error is e_i - e_a b. Over black and
white backgrounds, the mean of its square is

    1/2 e_i^2 + 1/2 (e_i - e_a)^2 = (e_i - e_a / 2)^2 + e_a^2 / 4;

summed over R, G and B it is |E|^2 with E_i = e_i - e_a / 2 and E_a = sqrt(3) / 2 e_a. A run minimizes it
(kernels/composite.cl) and decides by it; errors in alpha weigh more than in |e|^2, as they are visible in three
channels.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

ALPHA_SEEN = math.sqrt(3) / 2


def mse(image: ArrayLike, target: ArrayLike) -> float:
    """Return the mean over pixels and channels of the squared difference of two pictures (H, W, C) in [0, 1]."""
    first, second = same_shape(image, target)
    return float(np.mean(np.square(first - second)))


def same_shape(image: ArrayLike, target: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two pictures as arrays; ValueError unless both are (H, W, C)."""
    first, second = np.asarray(image, dtype=np.float64), np.asarray(target, dtype=np.float64)
    if first.shape != second.shape or first.ndim != 3:
        raise ValueError(f"image: shape {first.shape}, wanted the target's, {second.shape}, (H, W, C)")
    return first, second


def visible_error(error: NDArray[Any]) -> NDArray[Any]:
    """Return numbers (..., C) whose squares sum to the visible squared error of an error (..., C) of RGB or RGBA.

    For RGB it is the error itself.
    """
    if error.shape[-1] == 3:
        return error
    alpha = error[..., 3:]
    return np.concatenate([error[..., :3] - alpha / 2, ALPHA_SEEN * alpha], axis=-1).astype(error.dtype)


def unpremultiplied(image: NDArray[Any]) -> NDArray[Any]:
    """Return premultiplied RGBA (H, W, 4) as straight RGBA in [0, 1]; clear pixels are black."""
    alpha = image[..., 3:]
    color = np.divide(image[..., :3], alpha, out=np.zeros_like(image[..., :3]), where=alpha > 0)
    return np.concatenate([np.clip(color, 0, 1), alpha], axis=-1)


def visible_mse(image: NDArray[Any], target: NDArray[Any]) -> float:
    """Return the mean over pixels, RGB, and black and white backgrounds of the squared difference of two pictures.

    Pictures are (H, W, 3), or (H, W, 4) premultiplied. For RGB this is the mean squared error.
    """
    error = visible_error(np.asarray(image, dtype=np.float64) - np.asarray(target, dtype=np.float64))
    return float(np.mean(np.square(error)) * (error.shape[-1] / 3))
