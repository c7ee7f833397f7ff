# SPDX-License-Identifier: Apache-2.0
"""Outlines for new layers: circles, polygons, random outlines; orientation."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray
from livecl.geometry import cyclic

#: Closed subpaths (s, 3, 2) of a layer, px: rows as in `Drawing.points`.
Outline: TypeAlias = list[FloatArray]


def circle(center: ArrayLike, radius: float, segments: int) -> FloatArray:
    """Return a closed path whose 3s control points lie evenly on a circle: (s, 3, 2) px."""
    angles = 2 * np.pi * np.arange(3 * segments) / (3 * segments)
    points = np.asarray(center) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points.reshape(segments, 3, 2)


def polygon_path(corners: ArrayLike) -> FloatArray:
    """Return the closed path (s, 3, 2) of straight sides between corners (s, 2), px."""
    corners = np.asarray(corners, dtype=np.float64)
    sides = cyclic.following(corners) - corners
    return np.stack([corners, corners + sides / 3, corners + 2 * sides / 3], axis=1)


def random_outline(center: ArrayLike, segments: int, size: tuple[int, int], rng: np.random.Generator) -> FloatArray:
    """Return a random closed path (s, 3, 2) px: each control point within 2.5 % of the canvas of the one before.

    The random paths of DiffVG's examples (Li et al. 2020), as in the paper's baseline and ablation.
    """
    steps = rng.uniform(-0.5, 0.5, size=(3 * segments, 2)) * 0.05 * np.array([size[1], size[0]])
    steps[0] = 0
    return (np.asarray(center) + np.cumsum(steps, axis=0)).reshape(segments, 3, 2)


def reversed_path(path: FloatArray) -> FloatArray:
    """Return a closed path (s, 3, 2) in the opposite direction, from the same anchor."""
    return cyclic.preceding(path.reshape(-1, 2)[::-1]).reshape(path.shape)
