# SPDX-License-Identifier: Apache-2.0
"""Circles and ellipses fitted to the visible part of an outline: a partly hidden disc as a whole."""

from __future__ import annotations

import numpy as np

from livecl.arrays import FloatArray

#: Largest root-mean-square and maximum distance, px, between an outline and its primitive: anti-aliased borders of true
#: discs are located to a tenth of a pixel, their junctions to about one.
DEVIATION, FARTHEST = 0.2, 0.8
#: Least visible arc, radians of the curve's parameter, that determines a circle and an ellipse (3 and 5 unknowns).
CIRCLE_ARC, ELLIPSE_ARC = 1.0, 3.5
#: Fewest visible points, and least sagitta, px, that tells an arc from a straight line.
LEAST_POINTS, LEAST_SAGITTA = 12, 2.0
#: Largest ratio of an ellipse's axes.
SLIMMEST = 6.0


def fitted_primitive(points: FloatArray) -> FloatArray | None:
    """Fit a circle or an ellipse to points; return it as a closed polyline (n, 2) at 1 px steps, or None."""
    if len(points) < LEAST_POINTS:
        return None
    found = _circle(points)
    if found is None:
        found = _ellipse(points)
    if found is None:
        return None
    center, axes, turn = found
    count = int(np.clip(np.pi * axes.sum(), 12, 4096))
    at = 2 * np.pi * np.arange(count) / count
    return np.asarray(center + np.stack([axes[0] * np.cos(at), axes[1] * np.sin(at)], axis=1) @ turn.T)


def _circle(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Fit the circle |p|^2 = 2 c . p + d by least squares (Kasa 1976); return center, axes and rotation, if close."""
    mean = points.mean(axis=0)
    local = points - mean
    system = np.concatenate([2 * local, np.ones((len(local), 1))], axis=1)
    solution, _, rank, _ = np.linalg.lstsq(system, np.square(local).sum(axis=1), rcond=1e-9)
    radius = np.sqrt(max(solution[2] + solution[:2] @ solution[:2], 0.0))
    if rank < 3:
        return None
    away = np.hypot(*(local - solution[:2]).T) - radius
    arc = _arc(local - solution[:2])
    if not _close(away) or arc < CIRCLE_ARC or radius * (1 - np.cos(min(arc, np.pi) / 2)) < LEAST_SAGITTA:
        return None
    return mean + solution[:2], np.array([radius, radius]), np.eye(2)


def _ellipse(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Fit the ellipse of least algebraic distance; return center, axes and rotation, if close.

    The conic is constrained to an ellipse as by Halir and Flusser (1998), after Fitzgibbon, Pilu and Fisher (1999).
    """
    mean, scale = points.mean(axis=0), max(float(points.std()), 1e-9)
    x, y = ((points - mean) / scale).T
    square, linear = np.stack([x * x, x * y, y * y], axis=1), np.stack([x, y, np.ones_like(x)], axis=1)
    try:
        back = -np.linalg.solve(linear.T @ linear, linear.T @ square)
        reduced = square.T @ square + (square.T @ linear) @ back
        values, vectors = np.linalg.eig(np.stack([reduced[2] / 2, -reduced[1], reduced[0] / 2]))
    except np.linalg.LinAlgError:
        return None
    vectors = np.real(vectors)
    good = np.flatnonzero(4 * vectors[0] * vectors[2] - vectors[1] ** 2 > 0)
    if not len(good):
        return None
    conic = vectors[:, good[np.argmin(np.abs(values[good]))]]
    a, b, c = conic
    d, e, f = back @ conic
    matrix = np.array([[a, b / 2], [b / 2, c]])
    sizes, turn = np.linalg.eigh(matrix)
    if np.abs(sizes).min() * SLIMMEST**2 < np.abs(sizes).max():  # too slim; of points on a line it is singular
        return None
    center = -0.5 * np.linalg.solve(matrix, [d, e])
    level = center @ matrix @ center - f
    if level == 0 or (sizes / level <= 0).any():
        return None
    axes = np.sqrt(level / sizes)
    inside = (np.stack([x, y], axis=1) - center) @ turn / axes
    radial = np.hypot(*inside.T)
    # Distance to first order (Sampson): the implicit function by the length of its gradient.
    away = scale * (radial**2 - 1) / np.maximum(2 * np.hypot(*(inside / axes).T), 1e-9)
    if not _close(away) or _arc(inside) < ELLIPSE_ARC:
        return None
    return mean + scale * center, scale * axes, turn


def _close(away: FloatArray) -> bool:
    return bool(np.sqrt(np.mean(away**2)) <= DEVIATION and np.abs(away).max() <= FARTHEST)


def _arc(around: FloatArray) -> float:
    """Return the angle, radians, that points subtend at the origin: a full turn less the largest gap."""
    angles = np.sort(np.arctan2(around[:, 1], around[:, 0]))
    return float(2 * np.pi - np.diff(np.concatenate([angles, angles[:1] + 2 * np.pi])).max())
