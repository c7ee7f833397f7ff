# SPDX-License-Identifier: Apache-2.0
"""Extend polylines beyond their ends: to a corner, to a junction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from livecl.arrays import FloatArray

#: Largest distance, px, of points from a line up to which they are extended straight.
BENT = 0.5
#: Least spread of directions for a meeting point: the smaller eigenvalue of the mean projection across them, which is
#: the squared sine of half the angle between two.
SPREAD = 0.03


def extended(points: FloatArray, corner: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where points (n, 2), extended, come to a corner, and the unit direction from there towards the points.

    They are extended by a line, or by a parabola if they bend and that follows them much better.
    """
    middle = points.mean(axis=0)
    if len(points) < 2:
        return middle, (middle - corner) / max(float(np.hypot(*(middle - corner))), 1e-9)
    along = np.linalg.svd(points - middle)[2][0]
    along = along if along @ (middle - corner) > 0 else -along
    across = np.array([-along[1], along[0]])
    x, y = (points - middle) @ along, (points - middle) @ across
    if len(points) < 6 or np.abs(y).max() <= BENT:
        return middle, along
    powers = np.stack([np.ones(len(x)), x, x * x], axis=1)
    bend = np.linalg.lstsq(powers, y, rcond=None)[0]
    if np.abs(powers @ bend - y).max() > np.abs(y).max() / 2:
        return middle, along
    at = float((corner - middle) @ along)
    slope = bend[1] + 2 * bend[2] * at
    place = middle + at * along + (bend @ [1, at, at * at]) * across
    return place, (along + slope * across) / np.hypot(1, slope)


def meeting_of(lines: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray | None:
    """Return the point of least squared distance from lines, each a point and a unit direction; None if parallel.

    With P = I - d d^T, which projects across the direction d, the squared distance of x from a line through p is
    |P (x - p)|^2, so that x solves (sum P) x = sum P p.
    """
    across = [np.eye(2) - np.outer(direction, direction) for _, direction in lines]
    total = np.sum(across, axis=0)
    if np.linalg.eigvalsh(total)[0] < SPREAD * len(lines):
        return None
    summed = np.sum([part @ place for part, (place, _) in zip(across, lines, strict=True)], axis=0)
    return np.asarray(np.linalg.solve(total, summed))
