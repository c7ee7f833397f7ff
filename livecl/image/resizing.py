# SPDX-License-Identifier: Apache-2.0
"""Working on a smaller picture: pictures reduced before, drawings enlarged to the picture's own coordinates after.

A path's outline has no resolution, so a large picture is learned at fewer pixels, in a fraction of the time, and the
drawing is scaled back.
"""

from __future__ import annotations

import reprlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import MAX_COORDINATE, Drawing

#: Longer side, px, that larger pictures are reduced to where nothing else is asked for.
DEFAULT_SIZE = 512


def working_size(size: tuple[int, int], longest: int) -> tuple[int, int]:
    """Return the height and width, px, that a picture is worked on at.

    Parameters
    ----------
    size : (int, int)
        Height and width of the picture, px.
    longest : int
        Longer side that a larger picture is reduced to, px; smaller ones stay as they are. 0 for no limit.

    >>> working_size((1500, 2000), 512)
    (384, 512)
    >>> working_size((240, 240), 512)
    (240, 240)
    """
    if isinstance(longest, bool) or not isinstance(longest, int) or longest < 0:
        raise ValueError(f"size: got {reprlib.repr(longest)}, wanted a whole number of pixels, or 0 for all pixels")
    height, width = size
    if not longest or max(size) <= longest:
        return height, width
    scale = longest / max(size)
    return max(1, round(height * scale)), max(1, round(width * scale))


def reduced(image: ArrayLike, size: tuple[int, int]) -> NDArray[np.float32]:
    """Return a picture of fewer pixels, each the mean over its area: what a drawing's coverage is compared with.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        Straight RGB or RGBA in [0, 1].
    size : (int, int)
        Height and width wanted, px, at most the picture's own.

    Returns
    -------
    (h, w, 3) or (h, w, 4) float32
        Straight; colours are averaged by what their alpha shows of them.
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
    return np.clip(means, 0, 1).astype(np.float32)  # means of many float32 numbers may exceed 1 by rounding


def scaled(drawing: Drawing, size: tuple[int, int]) -> Drawing:
    """Return a drawing stretched to a canvas of another size.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    size : (int, int)
        Height and width of the canvas wanted, px.
    """
    if drawing.size == tuple(size):
        return drawing
    factors = np.array([size[1] / drawing.size[1], size[0] / drawing.size[0]])
    points = np.clip(drawing.points * factors, -MAX_COORDINATE, MAX_COORDINATE)
    return drawing.replace(points=points, size=size)
