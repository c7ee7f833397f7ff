# SPDX-License-Identifier: Apache-2.0
"""Digits as strokes of a pen, and what lies between two of them: pictures of the project's own for sequences."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from livecl.vae.drawn_digits import SKELETONS, stamped

#: Skeletons of the digits that a pen writes without being lifted: one digit's course can turn into another's.
DIGITS = {
    str(digit): ways[0]
    for digit, ways in enumerate(SKELETONS)
    if all(first[-1] == second[0] for first, second in pairwise(ways[0].strokes))
}
#: Half of the pen's width, and a digit's height, as shares of the picture.
PEN, HEIGHT = 0.065, 0.66
#: Stamps of the pen along its course.
SAMPLES = 200


def draw_frames(first: str, last: str, count: int, side: int = 64) -> list[np.ndarray]:
    """Return pictures from one digit to another, white on black: `count` of (side, side, 3) in [0, 1]."""
    a, b = _course(first), _course(last)
    images = [stamped(side * ((1 - t) * a + t * b), side * PEN, side) for t in np.linspace(0, 1, count)]
    return [np.repeat(image[..., None].astype(np.float32), 3, axis=2) for image in images]


def _course(digit: str) -> np.ndarray:
    """Return the pen's places (x, y) at equal shares of its course, as shares of the picture: (SAMPLES, 2)."""
    skeleton = DIGITS[digit]
    stamps = 0.5 + HEIGHT * skeleton.stamps() @ np.array(skeleton.points)
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(stamps, axis=0).T))])
    shares = np.linspace(0, lengths[-1], SAMPLES)
    return np.stack([np.interp(shares, lengths, stamps[:, axis]) for axis in (0, 1)], axis=1)
