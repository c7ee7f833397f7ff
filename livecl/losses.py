# SPDX-License-Identifier: Apache-2.0
"""The Xing loss with its gradient.

The other half of the loss, the squared error under the distance weight (eq. 1-2), is computed on the device, where the
picture is: kernels/distance.cl (weight) and kernels/composite.cl (error and gradient).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

#: Handles shorter than this, px, have no direction: they cost nothing and get no gradient.
SHORTEST_HANDLE = 1e-3


def xing_loss(cubics: ArrayLike) -> tuple[float, FloatArray]:
    """Self-crossing loss of the paper's eq. (3)-(4), the mean over segments.

    With u and v the directions of AB and CD, D1 = [AB x BC > 0] and D2 = u x v, a segment costs
    D1 ReLU(-D2) + (1 - D1) ReLU(D2): the sine of the angle from AB to CD where it turns the other way than A, B, C do.

    Parameters
    ----------
    cubics : (M, 4, 2) array_like
        Control points A, B, C, D of the segments, px.

    Returns
    -------
    (float, (M, 4, 2) float64)
        The loss and its gradient per px.

    Notes
    -----
    D1 is a constant. From D2 = u x v and du = (I - u u^T) dAB / |AB|,

        dD2/dAB = ((v_y, -v_x) - D2 u) / |AB|        dD2/dCD = ((-u_y, u_x) - D2 v) / |CD|

    and A, B, C, D take these with the signs -, +, -, +.
    """
    cubics = np.asarray(cubics, dtype=np.float64)
    if not len(cubics):
        return 0.0, np.zeros_like(cubics)
    ab, bc, cd = cubics[:, 1] - cubics[:, 0], cubics[:, 2] - cubics[:, 1], cubics[:, 3] - cubics[:, 2]
    ab_length, cd_length = np.sqrt((ab * ab).sum(axis=1)), np.sqrt((cd * cd).sum(axis=1))
    counts = (ab_length >= SHORTEST_HANDLE) & (cd_length >= SHORTEST_HANDLE)
    ab_length, cd_length = np.where(counts, ab_length, 1.0), np.where(counts, cd_length, 1.0)
    u, v = ab / ab_length[:, None], cd / cd_length[:, None]
    d2 = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    turns_left = ab[:, 0] * bc[:, 1] - ab[:, 1] * bc[:, 0] > 0
    sign = np.where(turns_left, -1.0, 1.0)
    sign[(sign * d2 <= 0) | ~counts] = 0.0

    factor = (sign / len(cubics))[:, None]
    d_ab = factor * (np.stack([v[:, 1], -v[:, 0]], axis=1) - d2[:, None] * u) / ab_length[:, None]
    d_cd = factor * (np.stack([-u[:, 1], u[:, 0]], axis=1) - d2[:, None] * v) / cd_length[:, None]
    return float((sign * d2).sum() / len(cubics)), np.stack([-d_ab, d_ab, -d_cd, d_cd], axis=1)
