# SPDX-License-Identifier: Apache-2.0
"""Fit open or closed cubic paths of the fewest segments to a polyline, within a tolerance.

Corners are found first, where the polyline turns sharply within a short reach; between them, every run from one place
to another is a candidate segment: the line between them if that is close enough, else the least-squares cubic with the
length along the polyline as parameter. Dynamic programming finds the fewest segments that are all close enough, and
among those the smallest sum of squared distances.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.geometry.bezier import bernstein, cross
from livecl.geometry.extending import extended
from livecl.geometry.polylines import lengths_along, points_at

IsSharp = Callable[[FloatArray, FloatArray, float], bool]

#: Least turn of a corner within its reach, radians; set on the line drawings of docs/strokes.md.
MIN_TURN = 0.75
#: Maximum number of candidate nodes between two corners: the time grows with its square.
MAX_PLACES = 28
#: Largest distance, px, of a segment from its chord at which it becomes a line: less than is visible.
NO_BEND = 0.05


def fit_line(
    points: FloatArray, tolerance: float, reach: float, closed: bool = False, is_sharp: IsSharp | None = None
) -> FloatArray:
    """Return the path of fewest segments along a polyline.

    Parameters
    ----------
    points : (n, 2) float
        Polyline of two points or more, px; closed ones do not repeat the first.
    tolerance : float
        Largest distance of a point of the polyline from the path, px.
    reach : float
        Length, px, before and after a point within which the turn of a corner is measured.
    closed : bool
        Whether the polyline is closed.
    is_sharp : callable, optional
        Whether the course has a corner, given where the lines before and after a turn meet, the unit direction
        outwards, and the cosine of half the turn. The middle of a pen's mark does not tell: it is round at corners.

    Returns
    -------
    (s, 3, 2) float
        Rows (anchor, handle, handle); the last row of an open path is its end.
    """
    if closed:
        points = np.concatenate([points, points[:1]])
    places = lengths_along(points)
    corners: list[tuple[int, FloatArray]] = []
    for before, at, after in _with_neighbors(_turns(points, places, reach), len(points) - 1):
        sides = [
            _side(points, places, at, (side, abs(float(places[end] - places[at])), reach))
            for side, end in ((-1, before), (1, after))
        ]
        tip = _tip(points[at], sides, reach, is_sharp)
        if tip is not None:
            corners.append((at, tip))
    ends = [0, *(at for at, _ in corners), len(points) - 1]
    tips = [points[0], *(tip for _, tip in corners), points[-1]]
    rows = []
    for k, (first, last) in enumerate(itertools.pairwise(ends)):
        inside = np.arange(first + 1, last)
        if k > 0:
            inside = inside[places[inside] > places[first] + reach / 2]
        if k + 2 < len(ends):
            inside = inside[places[inside] < places[last] - reach / 2]
        rows += _smooth_rows(np.stack([tips[k], *points[inside], tips[k + 1]]), tolerance)
    if not closed:
        rows.append(np.broadcast_to(points[-1], (3, 2)))
    return np.array(rows)


def _turns(points: FloatArray, places: FloatArray, reach: float) -> list[int]:
    """Return the points of locally largest turn, if that is large enough, one within each reach."""
    u, v = points - points_at(places - reach, points, places), points_at(places + reach, points, places) - points
    turns = np.abs(np.arctan2(cross(u, v), (u * v).sum(axis=1)))
    inside = (places > reach / 2) & (places < places[-1] - reach / 2)
    turns[~inside] = 0
    found: list[int] = []
    for at in np.argsort(-turns, kind="stable"):
        if turns[at] < MIN_TURN:
            break
        if all(abs(places[at] - places[other]) > reach for other in found):
            found.append(int(at))
    return sorted(found)


def _with_neighbors(turns: list[int], last: int) -> list[tuple[int, int, int]]:
    """Return each turn between the one before and the one after, or the ends of the polyline."""
    around = [0, *turns, last]
    return list(zip(around, turns, around[2:], strict=False))


def _side(
    points: FloatArray, places: FloatArray, at: int, reach: tuple[int, float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return where the side of a turn, extended, comes to it, and the side's unit direction away from it there.

    `reach` is the side, -1 before and 1 after, its length to the next turn, px, and the reach: half of it is left out
    next to turns, a third of the side at most, and one and a half of it is followed.
    """
    way, length, near_by = reach
    beyond = way * (places - places[at])
    left_out = min(near_by / 2, length / 3)
    near = points[(beyond >= left_out) & (beyond <= min(1.5 * near_by, length - left_out))]
    return extended(near if len(near) else points[np.argmin(np.abs(beyond - length))][None], points[at])


def _tip(
    turn: FloatArray, sides: list[tuple[FloatArray, FloatArray]], reach: float, is_sharp: IsSharp | None
) -> FloatArray | None:
    """Return the corner of a turn, where its sides, extended, meet; None where the course is round."""
    (p, u), (q, v) = sides
    across = float(cross(u, v))
    if abs(across) < 0.2:  # nearly parallel
        return None
    tip = np.asarray(p + cross(q - p, v) / across * u)
    if np.hypot(*(tip - turn)) > reach:
        return None
    half = float(np.sqrt((1 - u @ v) / 2))  # both point away from the corner
    outwards = -(u + v) / np.hypot(*(u + v))
    return tip if is_sharp is None or is_sharp(tip, outwards, half) else None


def _smooth_rows(points: FloatArray, tolerance: float) -> list[FloatArray]:
    """Return the rows of the fewest segments from the first point to the last."""
    places = lengths_along(points)
    count = int(np.clip((places[-1] - places[0]) / 4, 1, MAX_PLACES))
    stops = np.unique(np.searchsorted(places, np.linspace(places[0], places[-1], count + 1)).clip(0, len(points) - 1))
    best: list[tuple[float, float, int, FloatArray]] = [(0, 0.0, -1, np.zeros((3, 2)))]
    for j in range(1, len(stops)):
        interruption.check()
        options: list[tuple[float, float, int, FloatArray]] = []
        for i in range(j):
            if options and best[i][0] + 1 > min(option[0] for option in options):
                continue  # more segments than from an earlier place
            row, miss, squares = segment_along(points[stops[i] : stops[j] + 1], places[stops[i] : stops[j] + 1])
            close = miss <= tolerance or j - i == 1
            if close:
                options.append((best[i][0] + 1, best[i][1] + squares, i, row))
        best.append(min(options, key=lambda option: option[:2]))
    rows, at = [], len(stops) - 1
    while at > 0:
        rows.append(best[at][3])
        at = best[at][2]
    return rows[::-1]


def segment_along(points: FloatArray, places: FloatArray, rounds: int = 3) -> tuple[FloatArray, float, float]:
    """Return the row of the segment along a polyline (n, 2), its largest distance, and the sum of squares.

    `places` (n,) are the lengths along the polyline, parameters of its points at first; rounds find better ones.
    """
    a, d = points[0], points[-1]
    share = np.clip((points - a) @ (d - a) / max(float((d - a) @ (d - a)), 1e-12), 0, 1)
    off = np.hypot(*(points - a - share[:, None] * (d - a)).T)
    line = np.stack([a, a + (d - a) / 3, d - (d - a) / 3]), float(off.max()), float((off**2).sum())
    if off.max() <= NO_BEND:
        return line
    t = (places - places[0]) / max(places[-1] - places[0], 1e-12)
    weights = bernstein(t)
    controls = np.stack([a, a, d, d])
    if len(points) < 6:
        handles = line[0][1:]
    else:
        for _ in range(rounds):
            rest = points - weights[:, :1] * a - weights[:, 3:] * d
            handles = _solved(weights[:, 1:3], rest)
            controls[1:3] = handles
            slope = 3 * (controls[1:] - controls[:-1])
            u = 1 - t
            velocity = np.stack([u * u, 2 * t * u, t * t], axis=1) @ slope
            speed = np.maximum(np.einsum("ij,ij->i", velocity, velocity), 1e-12)
            t = np.clip(t + np.einsum("ij,ij->i", points - weights @ controls, velocity) / speed, 0, 1)
            t[0], t[-1] = 0, 1
            weights = bernstein(t)
    controls[1:3] = handles
    distance = np.hypot(*(weights @ controls - points).T)
    if off.max() <= 1.15 * distance.max() + NO_BEND:  # a line is as good
        return line
    return np.stack([a, *handles]), float(distance.max()), float((distance**2).sum())


def _solved(weights: FloatArray, rest: FloatArray) -> FloatArray:
    """Return the least-squares solution of ``weights @ x = rest``, (n, 2) both, by its normal equations.

    Two handles' weights never are nearly parallel unless all points lie at an end, where any handles do.
    """
    (p, q), (_, r) = weights.T @ weights
    determinant = p * r - q * q
    if determinant <= 1e-12 * p * r:
        return np.asarray(np.linalg.lstsq(weights, rest, rcond=None)[0])
    return np.asarray(np.array([[r, -q], [-q, p]]) @ (weights.T @ rest) / determinant)
