# SPDX-License-Identifier: Apache-2.0
"""Disturb pictures as JPEG files and cameras do, which should add no layers."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Quality of JPEG, and standard deviation of the noise.
JPEG_QUALITY, NOISE = 50, 4 / 255
#: Disturbances by name.
DISTURBANCES = ("jpeg", "noise")


def disturbed(image: ArrayLike, kind: str, seed: int = 0) -> NDArray[np.float32]:
    """Return a disturbed picture, as read from an 8-bit file.

    Parameters
    ----------
    image : (H, W, 3) array_like
        The clean picture, in [0, 1].
    kind : "jpeg" or "noise"
        Compressed as JPEG of quality 50; or with independent Gaussian noise of a standard deviation of 4/255 in each
        pixel and channel.
    seed : int
        Seed of the noise.

    Raises
    ------
    ValueError
        If there is no such disturbance.
    """
    from PIL import Image

    pixels = np.asarray(image, dtype=np.float64)
    if kind == "noise":
        pixels = pixels + np.random.default_rng(seed).normal(0, NOISE, pixels.shape)
        return (np.rint(255 * np.clip(pixels, 0, 1)) / 255).astype(np.float32)
    if kind != "jpeg":
        raise ValueError(f"kind: got {kind!r}, wanted {' or '.join(map(repr, DISTURBANCES))}")
    file = io.BytesIO()
    Image.fromarray(np.rint(255 * pixels).astype(np.uint8)).save(file, "JPEG", quality=JPEG_QUALITY)
    with Image.open(file) as decoded:
        return (np.asarray(decoded.convert("RGB"), dtype=np.float64) / 255).astype(np.float32)
