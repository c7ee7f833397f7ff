# SPDX-License-Identifier: Apache-2.0
"""Working size: reduce large pictures for the run, as outlines have no resolution."""

from __future__ import annotations

import math
import reprlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Default side, px, of the square to whose area larger pictures are reduced.
DEFAULT_SIZE = 512
#: Least side, px, to which pictures may be reduced: about that of a letter; a smaller picture has fewer pixels than an
#: outline has numbers. A mistaken `--size 1` would reduce a picture to one pixel.
LEAST_SIZE = 16
#: Squared error above which a reduced image has lost visible detail. Photographs at a half to a quarter of
#: their size lose 0.001 to 0.0035, small print that is no longer readable 0.007 to 0.013.
DETAIL_IS_LOST = 5e-3


def working_size(size: tuple[int, int], side: int) -> tuple[int, int]:
    """Return the working size, (height, width) px, of a picture.

    Parameters
    ----------
    size : (int, int)
        Height and width of the picture, px.
    side : int
        Larger pictures are reduced to about the area of a square of this side, px. A limit on the area, not on the
        longer side, keeps long and narrow pictures. At least 16, or 0 for no limit.

    >>> working_size((1500, 2000), 512)
    (443, 591)
    >>> working_size((60, 1600), 512)
    (60, 1600)
    >>> working_size((240, 240), 512)
    (240, 240)
    """
    if isinstance(side, bool) or not isinstance(side, int) or (side and side < LEAST_SIZE):
        got = reprlib.repr(side)
        raise ValueError(
            f"size: got {got}, wanted a whole number of pixels, at least {LEAST_SIZE}, or 0 for all pixels"
        )
    height, width = size
    if not side or height * width <= side**2:
        return height, width
    scale = side / math.sqrt(height * width)
    return max(1, round(height * scale)), max(1, round(width * scale))


def working_size_of(image: NDArray[np.floating], side: int) -> tuple[int, int]:
    """Return the working size, (height, width) px, of a picture (H, W, C).

    Pixel art is reduced to a whole number of pixels per cell, other pictures to :func:`working_size`.
    """
    height, width = size = (image.shape[0], image.shape[1])
    smaller = working_size(size, side)
    if smaller == size:
        return size
    cell = cell_side(image)
    pixels = int(cell * math.sqrt(smaller[0] * smaller[1] / (height * width)))
    return (height // cell * pixels, width // cell * pixels) if pixels else smaller


def cell_side(image: NDArray[np.floating]) -> int:
    """Return the side, px, of the largest squares of one colour that make up a picture (H, W, C), as in pixel art."""
    side = math.gcd(image.shape[0], image.shape[1])
    for axis in (0, 1):
        if side > 1:
            changes = (np.diff(image, axis=axis) != 0).any(axis=(1 - axis, 2))
            side = math.gcd(side, *(np.flatnonzero(changes) + 1).tolist())
    return side


def reduced(image: ArrayLike, size: tuple[int, int]) -> NDArray[np.float32]:
    """Return an image reduced by area averaging, as coverage is averaged over pixels.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        Straight RGB or RGBA in [0, 1].
    size : (int, int)
        Height and width wanted, px, at most the picture's own.

    Returns
    -------
    (h, w, 3) or (h, w, 4) float32
        Straight; colours are averaged with alpha as weight.
    """
    pixels = np.asarray(image, dtype=np.float32)
    if pixels.shape[:2] == tuple(size):
        return pixels
    from skimage.transform import resize_local_mean

    if pixels.shape[2] == 3:
        means = resize_local_mean(pixels, size, channel_axis=-1)
    else:
        alpha = pixels[..., 3:]
        means = resize_local_mean(np.concatenate([alpha * pixels[..., :3], alpha], axis=2), size, channel_axis=-1)
        means[..., :3] /= np.maximum(means[..., 3:], np.finfo(np.float32).tiny)
    return np.clip(means, 0, 1).astype(np.float32)  # means may exceed 1 by rounding


def detail_lost(image: NDArray[np.float32], size: tuple[int, int]) -> float:
    """Return the mean squared error of a picture reduced to `size` and enlarged again (bilinear)."""
    if image.shape[:2] == tuple(size):
        return 0.0
    from skimage.transform import resize

    enlarged = resize(reduced(image, size), image.shape[:2], order=1)
    return float(np.mean(np.square(enlarged - image, dtype=np.float64)))
