# SPDX-License-Identifier: Apache-2.0
"""Pictures between pictures, through the latents of an autoencoder, and these pictures enlarged."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skimage.transform import resize

from livecl.vae import Vae
from livecl.vae_layers import sigmoid

FloatArray = NDArray[np.float64]

#: Logits are cut off here, each way, before they are enlarged: a pixel that is surely black, at -30, would otherwise
#: push the edge of a stroke beside it inwards. A grey level of 8 bits, 1 / 255, is a logit of -5.5.
LIMIT = 6.0


def interpolate_latents(model: Vae, a: ArrayLike, b: ArrayLike, count: int) -> FloatArray:
    """Return pictures on the way from one picture to another, through the latents.

    Parameters
    ----------
    model : Vae
        A trained model.
    a, b : (H, W) array_like
        First and last picture, in [0, 1].
    count : int
        How many, the model's pictures of `a` and `b` included.

    Returns
    -------
    (count, H, W) float64
        The decoded latents ``(1 - t) mean_a + t mean_b``, t from 0 to 1 in even steps.

    Notes
    -----
    Straight, as in the paper, not along a great circle: that keeps the length of *samples* of N(0, 1), which in many
    dimensions lie near a sphere. The means of the encoder do not, and with about ten latents nothing does; and four
    corners can be blended only on straight lines.
    """
    if count < 2:
        raise ValueError(f"count: got {count}, wanted at least 2")
    ends = model.encode(np.stack([np.asarray(a), np.asarray(b)]))[0]
    t = np.linspace(0, 1, count)[:, None]
    return model.decode((1 - t) * ends[0] + t * ends[1])


def latent_grid(model: Vae, corners: ArrayLike, rows: int, columns: int) -> FloatArray:
    """Return pictures between four, blended bilinearly through the latents.

    Parameters
    ----------
    model : Vae
        A trained model.
    corners : (4, H, W) array_like
        Pictures in the corners: top left, top right, bottom left, bottom right.
    rows, columns : int
        Pictures of the grid, the model's pictures of the corners included.

    Returns
    -------
    (rows, columns, H, W) float64
        The decoded latents.
    """
    for name, value in (("rows", rows), ("columns", columns)):
        if value < 2:
            raise ValueError(f"{name}: got {value}, wanted at least 2")
    means = model.encode(corners)[0]
    if len(means) != 4:
        raise ValueError(f"corners: {len(means)} pictures, wanted 4")
    down, across = np.linspace(0, 1, rows), np.linspace(0, 1, columns)
    vertical, horizontal = np.stack([1 - down, down]), np.stack([1 - across, across])
    latents = np.einsum("ir,jc,ijz->rcz", vertical, horizontal, means.reshape(2, 2, -1))
    return model.decode(latents.reshape(rows * columns, -1)).reshape(rows, columns, *model.size)


def enlarge(pictures: ArrayLike, size: int) -> FloatArray:
    """Return pictures at another size, with edges as sharp as there.

    A decoder's picture says how probable it is that a pixel is white, and the probability's logit is what the decoder
    gives. The logits are interpolated by cubic splines, and turned into probabilities after that: an edge, where they
    change sign, gets a place between the pixels of the small picture and a ramp steeper than theirs.

    Parameters
    ----------
    pictures : (B, H, W) array_like
        In [0, 1].
    size : int
        Height and width to enlarge to, px.

    Returns
    -------
    (B, size, size) float64
        In [0, 1].
    """
    given = np.asarray(pictures, np.float64)
    if given.ndim != 3:
        raise ValueError(f"pictures: shape {given.shape}, wanted (B, H, W)")
    if size < 1:
        raise ValueError(f"size: got {size}, wanted at least 1")
    low = sigmoid(np.array(-LIMIT))
    inside = np.clip(given, low, 1 - low)
    logits = np.log(inside) - np.log1p(-inside)
    # Splines overshoot: what is beyond the limit is as sure as the limit says.
    larger = [np.clip(resize(each, (size, size), order=3, mode="edge", clip=False), -LIMIT, LIMIT) for each in logits]
    shown: FloatArray = sigmoid(np.array(larger).reshape(-1, size, size))
    return np.clip((shown - low) / (1 - 2 * low), 0, 1)
