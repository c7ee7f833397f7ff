# SPDX-License-Identifier: Apache-2.0
"""Digits as strokes of a pen, and what lies between two of them: pictures of the project's own for sequences."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

#: Points (x, y) that the pen passes, as shares of the picture.
DIGITS = {
    "2": [
        (0.30, 0.32),
        (0.38, 0.20),
        (0.55, 0.17),
        (0.68, 0.28),
        (0.62, 0.46),
        (0.45, 0.62),
        (0.31, 0.80),
        (0.70, 0.80),
    ],
    "3": [
        (0.33, 0.24),
        (0.48, 0.16),
        (0.64, 0.24),
        (0.60, 0.41),
        (0.46, 0.47),
        (0.66, 0.58),
        (0.62, 0.78),
        (0.33, 0.79),
    ],
    "6": [
        (0.62, 0.18),
        (0.44, 0.29),
        (0.33, 0.51),
        (0.36, 0.75),
        (0.53, 0.82),
        (0.66, 0.69),
        (0.57, 0.54),
        (0.38, 0.62),
    ],
    "7": [
        (0.30, 0.20),
        (0.43, 0.19),
        (0.56, 0.20),
        (0.69, 0.20),
        (0.62, 0.36),
        (0.54, 0.52),
        (0.48, 0.67),
        (0.43, 0.83),
    ],
}
#: Half of the pen's width, as a share of the picture.
PEN = 0.065
#: Points of the pen's course that distances are measured from.
SAMPLES = 200
#: Rows and columns of a pixel at which it is looked up whether the pen covers it.
SUPERSAMPLING = 4


def draw_frames(first: str, last: str, count: int, side: int = 64) -> list[np.ndarray]:
    """Return pictures from one digit to another, white on black: `count` of (side, side, 3) in [0, 1]."""
    a, b = (np.array(DIGITS[digit]) for digit in (first, last))
    return [_draw((1 - t) * a + t * b, side) for t in np.linspace(0, 1, count)]


def _draw(points: np.ndarray, side: int) -> np.ndarray:
    course = CubicSpline(np.linspace(0, 1, len(points)), points)(np.linspace(0, 1, SAMPLES))
    at = (np.arange(side * SUPERSAMPLING) + 0.5) / (side * SUPERSAMPLING)
    squares = np.full((len(at), len(at)), np.inf)
    for x, y in course:
        squares = np.minimum(squares, (at[None] - x) ** 2 + (at[:, None] - y) ** 2)
    inside = (squares < PEN**2).astype(np.float32).reshape(side, SUPERSAMPLING, side, SUPERSAMPLING)
    return np.repeat(inside.mean(axis=(1, 3))[..., None], 3, axis=2)
