# SPDX-License-Identifier: Apache-2.0
"""Cubic Bézier segments in float64 NumPy: basis, points, cuts, bounds, area, flattening.

A cubic is (..., 4, 2): its control points A, B, C, D as (x, y) in px, y down. Signed areas are positive where the
outline turns from the x axis towards the y axis (clockwise on the screen).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, IntArray


@dataclasses.dataclass(frozen=True)
class Polygon:
    """Cubics flattened into lines, of which one begins at each corner."""

    corners: FloatArray  # (L, 2), points on the curves, px
    segments: IntArray  # (L,), cubic of each line
    t: FloatArray  # (L,), parameter of each corner
    counts: NDArray[np.int32]  # (M,), lines of each cubic


def bernstein(t: ArrayLike) -> FloatArray:
    """Return the cubic Bernstein weights (1-t)^3, 3t(1-t)^2, 3t^2(1-t), t^3: (..., 4)."""
    t = np.asarray(t, dtype=np.float64)
    u = 1.0 - t
    weights = np.empty((*t.shape, 4))
    weights[..., 0], weights[..., 1], weights[..., 2], weights[..., 3] = (
        u * u * u,
        3 * t * u * u,
        3 * t * t * u,
        t * t * t,
    )
    return weights


def evaluate(cubics: ArrayLike, t: ArrayLike) -> FloatArray:
    """Return the points of cubics (..., 4, 2) at the parameters t (T,): (..., T, 2), px."""
    return np.einsum("tk,...kd->...td", bernstein(t), np.asarray(cubics, dtype=np.float64))


def derivative(cubics: ArrayLike, t: ArrayLike) -> FloatArray:
    """Return B'(t) of cubics (..., 4, 2) at one parameter each, (...): (..., 2), px per unit of t."""
    cubics, t = np.asarray(cubics, dtype=np.float64), np.asarray(t, dtype=np.float64)[..., None]
    steps, u = cubics[..., 1:, :] - cubics[..., :-1, :], 1 - t
    return np.asarray(3 * (u**2 * steps[..., 0, :] + 2 * t * u * steps[..., 1, :] + t * t * steps[..., 2, :]))


def subsegment(cubics: ArrayLike, begin: ArrayLike, end: ArrayLike) -> FloatArray:
    """Cut cubics (..., 4, 2): return their pieces from parameters `begin` to `end`, (...): (..., 4, 2).

    With b(u, v, w) the blossom of a cubic (de Casteljau's three rounds of linear interpolation, each at its own
    parameter), the piece from s to t has the control points b(s, s, s), b(s, s, t), b(s, t, t), b(t, t, t): exact for
    any s and t.
    """
    ends = np.stack(np.broadcast_arrays(np.asarray(begin, np.float64), np.asarray(end, np.float64)))
    points = np.asarray(cubics, dtype=np.float64)
    points = np.broadcast_to(points, np.broadcast_shapes(points.shape, (*ends.shape[1:], 1, 1)))[None]
    # (row before, parameter) of the rows of each round: b(s), b(t); b(s, s), b(s, t), b(t, t); ...
    for before, parameters in (([0, 0], [0, 1]), ([0, 0, 1], [0, 1, 1]), ([0, 0, 1, 2], [0, 1, 1, 1])):
        t = ends[parameters][..., None, None]
        points = points[before]
        points = (1 - t) * points[..., :-1, :] + t * points[..., 1:, :]
    return np.moveaxis(points[..., 0, :], 0, -2)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a_x b_y - a_y b_x of vectors (..., 2): (...)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def meeting_point(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
    """Return where lines through `p` along `u` meet lines through `q` along `v`: (..., 2), not finite for parallels."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = cross(q - p, v) / cross(u, v)
        return np.asarray(p + share[..., None] * u)


def hull_bounds(cubics: ArrayLike) -> FloatArray:
    """Return (x_min, y_min, x_max, y_max) of the control points of each cubic, which hold the curve: (..., 4), px."""
    cubics = np.asarray(cubics, dtype=np.float64)
    return np.concatenate([cubics.min(axis=-2), cubics.max(axis=-2)], axis=-1)


def outline_bounds(outline: Sequence[FloatArray]) -> FloatArray:
    """Return (x_min, y_min, x_max, y_max) of the control points of an outline's subpaths (m, 4, 2): (4,), px."""
    return hull_bounds(np.concatenate(outline).reshape(-1, 2))


def curve_bounds(cubics: ArrayLike) -> FloatArray:
    """Return the bounding box (x_min, y_min, x_max, y_max) of curves (..., 4, 2), px, from ends and extrema."""
    cubics = np.asarray(cubics, dtype=np.float64).reshape(-1, 4, 2)
    steps = np.diff(cubics, axis=1)  # the derivative's control points over 3
    a, b, c = steps[:, 0] - 2 * steps[:, 1] + steps[:, 2], steps[:, 1] - steps[:, 0], steps[:, 0]
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    with np.errstate(divide="ignore", invalid="ignore"):  # (-b +- root) / a, written so that a may be 0
        turns = [c / (-b - np.copysign(root, b)), (-b - np.copysign(root, b)) / a]
    found = [cubics[:, 0], cubics[:, 3]]
    for turn in turns:
        t = np.where((turn > 0) & (turn < 1), turn, 0.0)
        found.append(np.einsum("nik,nki->ni", bernstein(t), cubics))
    points = np.concatenate(found)
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


#: The antisymmetric form of :func:`signed_area`: 6 a x b + 3 a x c + a x d + 3 b x c + 3 b x d + 6 c x d.
_AREA = np.array([[0.0, 6, 3, 1], [-6, 0, 3, 3], [-3, -3, 0, 6], [-1, -3, -6, 0]])


def signed_area(cubics: ArrayLike) -> float:
    """Return the signed area of a closed outline of cubics (M, 4, 2), px^2.

    The sum over segments of half the integral of x dy - y dx, which for a cubic is a fixed bilinear form of its
    control points (Green's theorem, Bernstein products integrated).
    """
    x, y = np.moveaxis(np.asarray(cubics, dtype=np.float64), -1, 0)
    return float(np.vdot(x @ _AREA, y)) / 20


def pieces_for(cubics: ArrayLike, tolerance: float) -> NDArray[np.int32]:
    """Return the number of equal steps of t that flattens each cubic (M, 4, 2) to within `tolerance` px: (M,) int32.

    A chord of step 1/n leaves the curve by at most max |B''| / (8 n^2), and |B''| is at most 6 times the larger
    second difference of the control points.
    """
    cubics = np.asarray(cubics, dtype=np.float64)
    second = cubics[..., :-2, :] - 2 * cubics[..., 1:-1, :] + cubics[..., 2:, :]
    bend = np.sqrt((second * second).sum(axis=-1).max(axis=-1))
    return np.maximum(1, np.ceil(np.sqrt(0.75 * bend / tolerance))).astype(np.int32)


def flatten(cubics: ArrayLike, tolerance: float, most: int | None = None) -> Polygon:
    """Flatten cubics (M, 4, 2) into lines at most `tolerance` px away, or into `most` lines each."""
    cubics = np.asarray(cubics, dtype=np.float64)
    counts = pieces_for(cubics, tolerance)
    if most is not None:
        counts = np.minimum(counts, most)
    segments = np.repeat(np.arange(len(cubics)), counts)
    number = np.arange(len(segments)) - np.repeat(np.cumsum(counts) - counts, counts)
    t = number / counts[segments]
    return Polygon(np.einsum("lk,lkd->ld", bernstein(t), cubics[segments]), segments, t, counts)


def area_moments(cubics: ArrayLike) -> FloatArray:
    """Return the terms of each cubic (M, 4, 2) in the area of closed outlines and in its first moments in x and y.

    By Green's theorem the integrals over the area of 1, x and y are those along the outline of (x dy - y dx) / 2,
    x^2 / 2 dy and -y^2 / 2 dx: polynomials of degree 8 at most, which five Gauss-Legendre nodes integrate exactly.

    Returns
    -------
    (M, 3) float64
        px^2, px^3, px^3. Sums over an outline, the second and third divided by the first: its centre of area.
    """
    cubics = np.asarray(cubics, dtype=np.float64)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    t = (nodes + 1) / 2
    x, y = np.moveaxis(evaluate(cubics, t), -1, 0)
    u = 1 - t
    slope = np.stack([u * u, 2 * t * u, t * t], axis=-1)
    dx, dy = np.moveaxis(3 * np.einsum("tk,mkd->mtd", slope, np.diff(cubics, axis=1)), -1, 0)
    integrands = np.stack([(x * dy - y * dx) / 2, x * x / 2 * dy, -y * y / 2 * dx], axis=-1)
    return np.einsum("t,mtk->mk", weights / 2, integrands)
