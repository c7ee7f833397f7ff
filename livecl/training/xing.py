# SPDX-License-Identifier: Apache-2.0
"""The Xing loss with its gradient.

The pixel loss, the squared error under the distance weight (eq. 1-2), is computed on the device: kernels/distance.cl
(weight) and kernels/composite.cl (error and gradient).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray

#: Handles shorter than this, px, have no direction: no loss and no gradient.
MIN_HANDLE = 1e-3


def xing_loss(cubics: ArrayLike) -> tuple[float, FloatArray]:
    """Self-crossing loss of the paper's eq. (3)-(4), the mean over segments of control points A, B, C, D: (M, 4, 2) px.

    With u and v the directions of AB and CD, D1 = [AB x BC > 0] and D2 = u x v, a segment costs
    D1 ReLU(-D2) + (1 - D1) ReLU(D2): the sine of the angle from AB to CD where it turns the other way than A, B, C do.

    Returns
    -------
    (float, (M, 4, 2) float64)
        The loss and its gradient per px.

    Notes
    -----
    D1 is a constant. With points as complex numbers x + iy, a x b is the imaginary part of conj(a) b. From D2 = u x v
    and du = (I - u u^T) dAB / |AB|,

        dD2/dAB = (-i v - D2 u) / |AB|        dD2/dCD = (i u - D2 v) / |CD|

    and A, B, C, D take these with the signs -, +, -, +.
    """
    points = np.ascontiguousarray(cubics, dtype=np.float64).view(np.complex128)[..., 0]  # (M, 4)
    d_points = np.zeros_like(points)
    ab, bc, cd = (points[:, 1:] - points[:, :-1]).T
    turn, across = (ab.conj() * bc).imag, (ab.conj() * cd).imag
    rows = np.flatnonzero(np.where(turn > 0, -across, across) > 0)
    if not len(rows):
        return 0.0, d_points.view(np.float64).reshape(-1, 4, 2)
    ab, cd, sign = ab[rows], cd[rows], np.where(turn[rows] > 0, -1.0, 1.0)
    ab_length, cd_length = np.abs(ab), np.abs(cd)
    factor = np.where(np.minimum(ab_length, cd_length) >= MIN_HANDLE, sign / len(points), 0.0)
    u, v = ab / ab_length, cd / cd_length
    d2 = (u.conj() * v).imag
    d_ab = factor / ab_length * (-1j * v - d2 * u)
    d_cd = factor / cd_length * (1j * u - d2 * v)
    d_points[rows] = np.array([-d_ab, d_ab, -d_cd, d_cd]).T
    return float((factor * d2).sum()), d_points.view(np.float64).reshape(-1, 4, 2)
