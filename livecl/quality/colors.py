# SPDX-License-Identifier: Apache-2.0
"""Colour scores: CIEDE2000 difference of two pictures, and layers in colours that the picture does not have."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID
from livecl.image.errors import same_shape

#: Largest CIEDE2000 difference that most people do not notice (M. Mahy, L. Van Eycken, A. Oosterlinck: *Evaluation of
#: uniform color spaces*, Color Research and Application 19, 1994, found 2.3 in CIELAB), and the pixels that a colour
#: needs to be one of the picture's.
NOTICED, MIN_PIXELS = 2.3, 20
#: Least opacity of a layer that counts as opaque.
OPAQUE = 0.999


def color_difference(image: ArrayLike, target: ArrayLike) -> float:
    """Return the mean CIEDE2000 difference over the pixels of two sRGB pictures (H, W, 3) in [0, 1].

    References
    ----------
    G. Sharma, W. Wu, E. N. Dalal: *The CIEDE2000 color-difference formula*. Color Research and Application 30, 2005.
    """
    from skimage.color import deltaE_ciede2000, rgb2lab

    first, second = same_shape(image, target)
    differs = np.any(first != second, axis=2)
    if not differs.any():
        return 0.0
    return float(np.sum(deltaE_ciede2000(rgb2lab(first[differs]), rgb2lab(second[differs]))) / differs.size)


def main_colors(image: ArrayLike, least: int = MIN_PIXELS) -> NDArray[np.float64]:
    """Return the colours (K, 3) that at least `least` pixels of a picture (H, W, 3) in [0, 1] have, in 8 bits."""
    pixels = np.rint(255 * np.asarray(image, dtype=np.float64)[..., :3]).astype(np.uint8).reshape(-1, 3)
    colors, counts = np.unique(pixels, axis=0, return_counts=True)
    return np.asarray(colors[counts >= least] / 255)


def colors_in_picture(drawing: Drawing, image: ArrayLike) -> tuple[int, int]:
    """Count the layers whose colour is one of the picture's.

    Parameters
    ----------
    drawing : Drawing
        Any drawing; translucent layers and those with a gradient are ignored.
    image : (H, W, 3) array_like
        The picture, in [0, 1].

    Returns
    -------
    found, opaque : int
        Opaque solid layers within 2.3 CIEDE2000 of a colour of at least 20 pixels; opaque solid layers in all.
    """
    from skimage.color import deltaE_ciede2000, rgb2lab

    solid = drawing.colors[(drawing.fills.kinds == SOLID) & (drawing.colors[:, 3] >= OPAQUE), :3]
    there = main_colors(image)
    if not len(solid) or not len(there):
        return 0, len(solid)
    nearest = deltaE_ciede2000(rgb2lab(solid)[:, None], rgb2lab(there)[None]).min(axis=1)
    return int(np.count_nonzero(nearest <= NOTICED)), len(solid)
