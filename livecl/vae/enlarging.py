# SPDX-License-Identifier: Apache-2.0
"""Enlarge the autoencoder's pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from skimage.transform import resize

from livecl.arrays import FloatArray
from livecl.vae.parts import sigmoid

#: Logits are clipped to this magnitude before they are enlarged: a certainly black pixel, at -30, would otherwise push
#: the edge of a stroke beside it inwards. A grey level of 8 bits, 1 / 255, is a logit of -5.5.
LIMIT = 6.0


def enlarge(pictures: ArrayLike, size: int) -> FloatArray:
    """Resize pictures, with edges that are sharp at the new size.

    A decoder's output are logits of the probability that a pixel is white. These are interpolated by cubic splines and
    then turned into probabilities: an edge, where they change sign, is located between the pixels of the small picture,
    with a steeper ramp.

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
    # Splines overshoot: logits beyond the limit are clipped to it.
    larger = [np.clip(resize(each, (size, size), order=3, mode="edge", clip=False), -LIMIT, LIMIT) for each in logits]
    shown: FloatArray = sigmoid(np.array(larger).reshape(-1, size, size))
    return np.clip((shown - low) / (1 - 2 * low), 0, 1)
