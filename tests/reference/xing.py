# SPDX-License-Identifier: Apache-2.0
"""Xing loss, eq. (3) and (4), of one segment at a time; its derivative is left to differences."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

#: AB or CD shorter than this has no direction: no loss, no gradient; px.
SHORTEST = 1e-3


def xing_loss(cubics: NDArray[np.float64]) -> float:
    """Return the mean over segments (M, 4, 2) of D1 ReLU(-D2) + (1 - D1) ReLU(D2); 0 for no segments."""
    return sum(_segment_loss(cubic) for cubic in cubics) / len(cubics) if len(cubics) else 0.0


def _segment_loss(cubic: NDArray[np.float64]) -> float:
    (a_x, a_y), (b_x, b_y), (c_x, c_y), (d_x, d_y) = cubic.tolist()
    ab, bc, cd = (b_x - a_x, b_y - a_y), (c_x - b_x, c_y - b_y), (d_x - c_x, d_y - c_y)
    if math.hypot(*ab) < SHORTEST or math.hypot(*cd) < SHORTEST:
        return 0.0
    d_2 = _cross(ab, cd) / (math.hypot(*ab) * math.hypot(*cd))
    return max(-d_2, 0.0) if _cross(ab, bc) > 0 else max(d_2, 0.0)


def _cross(p: tuple[float, float], q: tuple[float, float]) -> float:
    return p[0] * q[1] - p[1] * q[0]
