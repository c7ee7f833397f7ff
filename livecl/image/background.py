# SPDX-License-Identifier: Apache-2.0
"""Backgrounds: choose a background for an image, and composite the image over it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray
from livecl.drawing.colors import parse_color
from livecl.image.reading import over_background, premultiplied

#: Backgrounds by name: chosen by the picture, none, the colour of its border, trained from white.
PICTURE, NONE, AUTO, TRAIN = "picture", "none", "auto", "train"
WHITE = (1.0, 1.0, 1.0)
#: Levels of each channel for the histogram of the border's colours.
LEVELS = 32
#: Least share of the border in one colour, within `SAME_COLOR` in each channel, for a picture to have a ground.
GROUND_SHARE, SAME_COLOR = 0.75, 8 / 255
#: Least value of all channels of a ground that counts as white.
WHITE_FROM = 253 / 255

Rgb = tuple[float, float, float]


def check_background(text: str) -> None:
    """Raise ValueError unless `text` is one of the words above or an opaque CSS colour."""
    if text not in (PICTURE, NONE, AUTO, TRAIN):
        try:
            parse_color(text)
        except ValueError as error:
            reason = str(error).removeprefix("color: ")
            raise ValueError(f"background: {reason}, or one of {PICTURE}, {NONE}, {AUTO}, {TRAIN}") from None


def background_for(text: str, image: NDArray[np.float32], start: ArrayLike | None = None) -> Rgb | None:
    """Return the background that a run begins with.

    Parameters
    ----------
    text : str
        A colour; "none"; "auto", the most frequent colour of the picture's border; "train", white at first; "picture":
        none if the picture has alpha; as "auto" if most of the border has that colour, or as the corners if all four
        have another; else white.
    image : (H, W, 3) or (H, W, 4) float32
        The picture, straight.
    start : (3,) array_like or None
        Background of the drawing from which the run starts; "picture" and "train" keep it.

    Returns
    -------
    (float, float, float) or None
        Opaque RGB in [0, 1]; None for a transparent canvas.
    """
    if text == NONE:
        return None
    if text == AUTO:
        return border_color(image)
    if text in (PICTURE, TRAIN):
        if start is not None:
            red, green, blue = map(float, np.asarray(start))
            return red, green, blue
        if text == TRAIN:
            return WHITE
        return None if image.shape[2] == 4 else ground_color(image)
    red, green, blue = map(float, parse_color(text))
    return red, green, blue


def ground_color(image: NDArray[np.float32]) -> Rgb:
    """Return the colour of an opaque picture's ground: that of most of its border, or white if it has several.

    So a light shape on a coloured ground is a shape, and not a hole in that ground over a white page. Four corners of
    another colour are the ground of a plate with round corners: one shape, not four.
    """
    color = border_color(image)
    share = float(np.mean(np.abs(_border(image) - color).max(axis=1) <= SAME_COLOR))
    if share < GROUND_SHARE:
        return WHITE
    corners = over_background(image, WHITE)[[0, 0, -1, -1], [0, -1, 0, -1]].astype(np.float64)
    if np.ptp(corners, axis=0).max() <= SAME_COLOR and np.abs(corners - color).max(axis=1).min() > SAME_COLOR:
        red, green, blue = corners.mean(axis=0).tolist()
        color = red, green, blue
    return color if min(color) < WHITE_FROM else WHITE


def border_color(image: NDArray[np.float32]) -> Rgb:
    """Return the most frequent colour of a picture's outermost pixels, over white: the mean of the fullest bin."""
    border = _border(image)
    bins = np.minimum(np.floor(border * LEVELS), LEVELS - 1).astype(np.int64) @ (LEVELS**2, LEVELS, 1)
    fullest = np.argmax(np.bincount(bins))
    red, green, blue = border[bins == fullest].mean(axis=0).tolist()
    return red, green, blue


def _border(image: NDArray[np.float32]) -> FloatArray:
    """Return the outermost pixels of a picture over white: (n, 3)."""
    flat = over_background(image, WHITE)
    return np.concatenate([flat[0], flat[-1], flat[1:-1, 0], flat[1:-1, -1]]).astype(np.float64)


def target_over(image: NDArray[np.float32], background: ArrayLike | None) -> NDArray[np.float32]:
    """Return the target: the image with which a drawing's render is compared.

    With a background, it is RGB, (H, W, 3). Without one, it is premultiplied RGBA, (H, W, 4), so that the colour of
    transparent pixels does not count, and over any background b the difference is (C - C*) - (A - A*) b
    (:mod:`livecl.image.errors`).
    """
    return premultiplied(image) if background is None else over_background(image, background)
