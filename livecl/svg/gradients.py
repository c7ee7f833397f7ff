# SPDX-License-Identifier: Apache-2.0
"""Gradients of SVG, converted to the form of a drawing's fills: points in px and stops, padded.

A linear gradient is p0, p1: t = (p - p0) . (p1 - p0) / |p1 - p0|^2. A radial one is a centre and the ends of two axes:
t is the distance from the centre in the frame where the axes are of length 1 at right angles. Colours between stops are
linear in straight sRGB. Other forms of SVG are converted: exactly for units, transforms, repeats and an inner
radius; approximately for a focal point away from the centre.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray
from livecl.drawing.colors import premultiplied_colors

#: Most repeats of a gradient that are expanded into stops.
MAX_REPEATS = 64
#: Shortest linear gradient, px; shorter ones are edges.
MIN_LENGTH = 1e-6
#: Points on each side of the grid on which gradients are compared.
_GRID = 32
#: Candidate centres of a concentric gradient, as shares of the way from the focal point to the centre.
_CENTERS = np.linspace(0, 1, 9)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Gradient:
    """A gradient fill."""

    kind: Literal["linear", "radial"]  # meaning of `points`
    #: (2, 2) or (3, 2): linear: where t is 0 and 1. Radial: the centre, and the ends of two axes, where t is 1. px.
    points: FloatArray
    stops: FloatArray  # (K, 5), offset in [0, 1], not falling, and straight RGBA in [0, 1] of each stop

    def places(self, points: FloatArray) -> FloatArray:
        """Return t at points (..., 2)."""
        if self.kind == "linear":
            along = self.points[1] - self.points[0]
            return (points - self.points[0]) @ along / (along @ along)
        axes = (self.points[1:] - self.points[0]).T
        return np.linalg.norm((points - self.points[0]) @ np.linalg.inv(axes).T, axis=-1)

    def colors(self, t: FloatArray) -> FloatArray:
        """Return straight RGBA at t: (..., 4); of stops at one offset, the last counts behind it."""
        return stop_colors(self.stops, t)


def stop_colors(stops: FloatArray, t: FloatArray) -> FloatArray:
    """Return the straight RGBA of stops (K, 5) at t (...): (..., 4), padded at both ends."""
    after = np.searchsorted(stops[:, 0], t, side="right")
    low, high = stops[np.maximum(after - 1, 0)], stops[np.minimum(after, len(stops) - 1)]
    span = high[..., 0] - low[..., 0]
    share = np.where(span > 0, (t - low[..., 0]) / np.where(span > 0, span, 1), 0.0)[..., None]
    return low[..., 1:] * (1 - share) + high[..., 1:] * share


def linear(ends: FloatArray, matrix: FloatArray, stops: FloatArray) -> Gradient | None:
    """Return the linear gradient between `ends` (2, 2) under an affine matrix; None if it is degenerate.

    The lines of equal colour stay lines, but are no longer perpendicular to the image of the gradient vector: with the
    row g for which t = g . p + const, the new vector goes from the image of its start along g / |g|^2.
    """
    inverse = _inverse(matrix)
    along = ends[1] - ends[0]
    if inverse is None or not along.any():
        return None
    g = along @ inverse[:2, :2] / (along @ along)
    start = matrix[:2, :2] @ ends[0] + matrix[:2, 2]
    size = float(np.sqrt(g @ g))
    if not (np.isfinite(start).all() and 0 < size < math.inf):
        return None
    if size * MIN_LENGTH > 1:  # an edge between the first colour and the last
        stops = stops.copy()
        stops[:, 0] = 0
        return Gradient(kind="linear", points=np.stack([start, start + g / size]), stops=stops)
    return Gradient(kind="linear", points=np.stack([start, start + g / size**2]), stops=stops)


def radial(circle: FloatArray, matrix: FloatArray, stops: FloatArray) -> Gradient | None:
    """Return the radial gradient of a circle (x, y, radius) under an affine matrix; None if it is degenerate."""
    x, y, radius = circle
    if _inverse(matrix) is None or radius <= 0:
        return None
    points = np.array([[x, y], [x + radius, y], [x, y + radius]])
    return Gradient(kind="radial", points=points @ matrix[:2, :2].T + matrix[:2, 2], stops=stops)


def with_inner_radius(stops: FloatArray, share: float) -> FloatArray:
    """Return the stops of a radial gradient that begins at a share of its radius."""
    moved = stops.copy()
    moved[:, 0] = share + (1 - share) * stops[:, 0]
    return moved


def padded(gradient: Gradient, spread: str, bounds: FloatArray) -> tuple[Gradient, bool]:
    """Return a gradient without repeats that looks the same within bounds (x0, y0, x1, y1) px, and whether it does.

    `gradient` is one period; `spread` is ``pad``, ``reflect`` or ``repeat``.
    """
    if spread not in ("reflect", "repeat"):
        return gradient, True
    x0, y0, x1, y1 = bounds
    t = gradient.places(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))
    low = 0 if gradient.kind == "radial" else math.floor(t.min() + 1e-9)
    high = max(low + 1, math.ceil(t.max() - 1e-9))
    exact = high - low <= MAX_REPEATS
    if not exact:
        low, high = (low, low + MAX_REPEATS) if gradient.kind == "radial" else (0, MAX_REPEATS)
    first, last = gradient.stops[:1].copy(), gradient.stops[-1:].copy()
    first[:, 0], last[:, 0] = 0, 1
    period = np.concatenate([first, gradient.stops, last])
    mirrored = period[::-1].copy()
    mirrored[:, 0] = 1 - mirrored[:, 0]
    periods = []
    for k in range(low, high):
        part = (mirrored if spread == "reflect" and k % 2 else period).copy()
        part[:, 0] = (k - low + part[:, 0]) / (high - low)
        periods.append(part)
    origin = gradient.points[0]
    reach = gradient.points - origin
    if gradient.kind == "linear":
        points = np.stack([origin + low * reach[1], origin + high * reach[1]])
    else:
        points = origin + high * reach
    return dataclasses.replace(gradient, points=points, stops=without_needless(np.concatenate(periods))), exact


def narrowed(gradient: Gradient, bounds: FloatArray) -> Gradient:
    """Return a linear gradient clipped to bounds (4,), within which it looks the same."""
    x0, y0, x1, y1 = bounds
    t = gradient.places(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))
    low, high = float(t.min()), float(t.max())
    inside = gradient.stops[(gradient.stops[:, 0] > low) & (gradient.stops[:, 0] < high)]
    colors = gradient.colors(np.array([low, high]))
    stops = np.concatenate([[[low, *colors[0]]], inside, [[high, *colors[1]]]])
    stops[:, 0] = ((stops[:, 0] - low) / (high - low)).clip(0, 1)
    along = gradient.points[1] - gradient.points[0]
    center = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    at = float(gradient.places(center))
    return dataclasses.replace(
        gradient, points=np.stack([center + (low - at) * along, center + (high - at) * along]), stops=stops
    )


def without_needless(stops: FloatArray) -> FloatArray:
    """Remove redundant stops: repeated ones, and those between two others of their own colour."""
    kept = [stops[0]]
    for i in range(1, len(stops)):
        same_before = np.array_equal(stops[i, 1:], kept[-1][1:])
        same_after = i + 1 == len(stops) or np.array_equal(stops[i, 1:], stops[i + 1, 1:])
        if not (same_before and (same_after or stops[i, 0] == kept[-1][0])):
            kept.append(stops[i])
    return np.array(kept)


def concentric(
    circle: FloatArray, focus: FloatArray, inner: float, spread: str, stops: FloatArray, bounds: FloatArray
) -> tuple[FloatArray, float]:
    """Approximate a gradient with a focal point by a concentric one; return its circle and the error.

    A point p has the largest t for which it lies on the circle about f + t (c - f) of radius r0 + t (r - r0) (SVG 2,
    13.4.3). The candidates are circles about points between f and c that touch the outer circle on the far side.

    Parameters
    ----------
    circle : (3,)
        Centre c and radius r.
    focus : (2,)
        Focal point f.
    inner : float
        Radius r0 of the circle about f where t is 0.
    spread : str
        ``pad``, ``reflect`` or ``repeat``.
    stops : (K, 5)
        Its stops.
    bounds : (4,)
        (x_min, y_min, x_max, y_max) of the filled shape, in the frame of the circle.

    Returns
    -------
    (3,), float
        Centre and radius; the root of the mean square difference of premultiplied RGBA over the bounds.
    """
    axes = [np.linspace(bounds[i], bounds[i + 2], _GRID) for i in (0, 1)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    center, radius = circle[:2], circle[2]
    away, growth = center - focus, radius - inner
    offset = points - focus
    a = away @ away - growth**2
    b = offset @ away + inner * growth
    c = (offset**2).sum(axis=1) - inner**2
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    if abs(a) < 1e-9 * radius**2:
        t = c / np.where(b == 0, 1e-30, 2 * b)
    else:
        t = np.maximum((b + root) / a, (b - root) / a)
    wanted = premultiplied_colors(stop_colors(stops, _spread(t, spread)))
    best, least = circle, math.inf
    for share in _CENTERS:
        for size in (radius, radius * (1 + share) / 2, radius - (1 - share) * math.sqrt(away @ away) / 2):
            candidate = np.array([*(focus + share * away), max(size, 1e-3 * radius)])
            t = np.linalg.norm(points - candidate[:2], axis=1) / candidate[2]
            got = premultiplied_colors(stop_colors(with_inner_radius(stops, inner / radius), _spread(t, spread)))
            error = float(np.sqrt(np.square(got - wanted).mean()))
            if error < least:
                best, least = candidate, error
    return best, least


def mean_color(gradient: Gradient, bounds: FloatArray) -> tuple[FloatArray, float]:
    """Return the mean colour, straight RGBA, of a gradient within bounds, and the root mean square difference."""
    axes = [np.linspace(bounds[i], bounds[i + 2], _GRID) for i in (0, 1)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    shown = premultiplied_colors(gradient.colors(gradient.places(points)))
    mean = shown.mean(axis=0)
    alpha = mean[3]
    straight = np.array([*(mean[:3] / alpha), alpha]) if alpha > 0 else np.zeros(4)
    return straight.clip(0, 1), float(np.sqrt(np.square(shown - mean).mean()))


def _spread(t: FloatArray, spread: str) -> FloatArray:
    if spread == "repeat":
        return t - np.floor(t)
    return 1 - np.abs(t % 2 - 1) if spread == "reflect" else t


def is_flat(axes: ArrayLike) -> bool:
    """Return whether a (2, 2) matrix is singular, nearly singular or not finite."""
    axes = np.asarray(axes, dtype=np.float64)
    return not (np.isfinite(axes).all() and abs(np.linalg.det(axes)) > 1e-12 * np.abs(axes).max() ** 2)


def _inverse(matrix: FloatArray) -> NDArray[Any] | None:
    """Return the inverse of an affine matrix (3, 3); None if it is singular or nearly so."""
    return None if is_flat(matrix[:2, :2]) or not np.isfinite(matrix).all() else np.linalg.inv(matrix)
