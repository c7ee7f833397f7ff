# SPDX-License-Identifier: Apache-2.0
"""Ellipse of a closed polyline's moments of area."""

from __future__ import annotations

import dataclasses

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry import cyclic

#: Length of the handles of a quarter of an ellipse as a share of its half axes: the cubic that meets the quarter circle
#: in its middle, 4 (sqrt 2 - 1) / 3, is off by at most 2.7e-4 of the radius.
KAPPA = 4 * (np.sqrt(2) - 1) / 3


@dataclasses.dataclass(frozen=True, eq=False)
class Ellipse:
    """An ellipse: centre (2,), its two half axes as vectors (2, 2), px, and the number of its parameters."""

    center: FloatArray
    axes: FloatArray
    numbers: int

    def cubics(self) -> FloatArray:
        """Return the quarters (4, 4, 2) from the end of one half axis to that of the next."""
        start = np.concatenate([self.axes, -self.axes])
        end = cyclic.following(start)
        return np.asarray(self.center + np.stack([start, start + KAPPA * end, end + KAPPA * start, end], axis=1))

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the distances of points (n, 2) near the ellipse, to first order, px; negative within it."""
        sizes = np.hypot(*self.axes.T)
        along = (points - self.center) @ (self.axes / sizes[:, None]).T / sizes
        value = (along**2).sum(axis=1)
        return np.asarray((value - 1) / np.maximum(2 * np.hypot(*(along / sizes).T), 1e-9))


def ellipse_through(points: FloatArray) -> Ellipse | None:
    """Fit an ellipse to points (n, 2) on a part of it; None if the conic through them is no ellipse.

    Least squares of a x^2 + b x y + c y^2 + d x + e y = 1 about their centre.
    """
    origin = points.mean(axis=0)
    scale = float(np.abs(points - origin).max())
    if not scale:
        return None
    x, y = ((points - origin) / scale).T
    a, b, c, d, e = np.linalg.lstsq(np.stack([x * x, x * y, y * y, x, y], axis=1), np.ones(len(x)), rcond=None)[0]
    form = np.array([[a, b / 2], [b / 2, c]])
    values, vectors = np.linalg.eigh(form)
    if values[0] <= 1e-3 * values[1]:
        return None
    center = np.linalg.solve(form, [-d / 2, -e / 2])
    lengths = np.sqrt((1 + center @ form @ center) / values)
    return Ellipse(origin + scale * center, scale * (lengths * vectors).T, 5)


def ellipses_of(points: FloatArray) -> list[Ellipse]:
    """Return the ellipses of the moments of the area within a closed polyline (n, 2): any, upright, and a circle.

    They turn the way the polyline does. The covariance of points evenly spread over an ellipse has the eigenvalues
    a^2 / 4 and b^2 / 4; each moment of the polygon is a sum over its sides (Green's theorem).
    """
    origin = points.mean(axis=0)
    p = points - origin
    q = cyclic.following(p)
    cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
    area = cross.sum() / 2
    if abs(area) < 1e-6:
        return []
    mean = ((p + q) * cross[:, None]).sum(axis=0) / (6 * area)
    moments = np.einsum("n,ni,nj->ij", cross, p, p) + np.einsum("n,ni,nj->ij", cross, q, q)
    mixed = np.einsum("n,ni,nj->ij", cross, p, q)
    covariance = (2 * moments + mixed + mixed.T) / (24 * area) - np.outer(mean, mean)
    values, vectors = np.linalg.eigh(covariance)
    if values[0] <= 1e-9:
        return []
    center, turn = origin + mean, np.sign(area)
    radius = np.sqrt(abs(area) / np.pi)
    first = vectors[:, 1] * (-1 if vectors[np.argmax(np.abs(vectors[:, 1])), 1] < 0 else 1)
    second = turn * np.array([-first[1], first[0]])
    wide, narrow = 2 * np.sqrt(values[::-1])
    return [
        Ellipse(center, np.stack([wide * first, narrow * second]), 5),
        Ellipse(center, np.diag(2 * np.sqrt(np.diag(covariance)) * (1, turn)), 4),
        Ellipse(center, np.diag((radius, turn * radius)), 3),
    ]
