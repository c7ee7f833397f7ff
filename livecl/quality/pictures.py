# SPDX-License-Identifier: Apache-2.0
"""Image similarity: mean squared error, peak signal-to-noise ratio, structural similarity."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numpy.typing import ArrayLike

from livecl.image.errors import mse, same_shape

__all__ = ["mse", "psnr", "ssim"]


def psnr(image: ArrayLike, target: ArrayLike) -> float:
    """Return the peak signal-to-noise ratio of two pictures (H, W, C) in [0, 1], dB; infinite if they are equal."""
    error = mse(image, target)
    return -10 * math.log10(error) if error > 0 else math.inf


def ssim(image: ArrayLike, target: ArrayLike) -> float:
    """Return the structural similarity of two pictures (scikit-image), the mean over pixels and channels.

    Parameters
    ----------
    image, target : (H, W, C) array_like
        In [0, 1]. The window is 7 px, or the largest odd number that fits into a smaller picture.

    Raises
    ------
    ValueError
        If the shapes differ, or a side is shorter than 3 px.
    """
    from skimage.metrics import structural_similarity

    image, target = same_shape(image, target)
    side = min(image.shape[:2])
    if side < 3:
        raise ValueError(f"image: shape {image.shape}, wanted sides of at least 3 px")
    window = min(7, side - 1 + side % 2)
    similarity: Callable[..., Any] = structural_similarity
    return float(similarity(image, target, win_size=window, data_range=1.0, channel_axis=2))
