# SPDX-License-Identifier: Apache-2.0
"""Good continuation: directions of the ends of outlines, and the curves that connect one end with another.

Lines, smooth curves in the directions of both ends, and corners in which their tangents meet ("relatable" ends: Kellman
and Shipley 1991).
"""

from __future__ import annotations

import functools
from collections.abc import Iterator

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry.bezier import cross

#: Start and end of a gap with the directions in which the outline runs there; None where it is too short to have one.
Gap = tuple[FloatArray, FloatArray | None, FloatArray, FloatArray | None]

#: Cosine of the largest angle between the direction of an end and the way to the other end; gaps shorter than `SHORT`,
#: px, are exempt.
AHEAD, SHORT = 0.75, 4.0
#: The same for ends in one line, which are connected however far they are.
ALIGNED = 0.998


def direction_at_end(points: FloatArray) -> FloatArray | None:
    """Return the unit tangent of a run of points (n, 2) at its last one, from a fitted parabola, if it has one."""
    found = tangent(points)
    return None if found is None else found[0]


def tangent(points: FloatArray) -> tuple[FloatArray, float] | None:
    """Return the unit tangent and the curvature, 1/px, of a run of points at its last one, from a fitted parabola.

    Fewer than seven points give a line, of curvature 0.
    """
    if len(points) < 2:
        return None
    bend = np.zeros(2)
    if len(points) < 3:
        slope = points[-1] - points[0]
    else:
        slope, *bends = _fit(len(points)) @ points
        if bends:
            bend = 2 * bends[0]
    length = float(np.hypot(*slope))
    if length <= 1e-9:
        return None
    return slope / length, float(cross(slope, bend)) / length**3


@functools.lru_cache(maxsize=256)
def _fit(count: int) -> FloatArray:
    """Return the matrix that maps points (n, 2) to slope and curvature of the line or parabola through them.

    At the last point, by least squares over steps of 1.
    """
    t = np.arange(1.0 - count, 1.0)
    return np.linalg.pinv(np.stack([np.ones(count), t] if count < 7 else [np.ones(count), t, t * t], axis=1))[1:]


def curves(gap: Gap) -> Iterator[FloatArray]:
    """Yield candidate curves that close a gap: points without its ends."""
    start, enter, end, leave = gap
    yield straight_line(start, end)
    if enter is None or leave is None:
        return
    yield smooth(start, enter, end, leave)
    determinant = cross(enter, leave)
    if abs(determinant) < 0.2:
        return
    way = end - start
    ahead = cross(way, leave) / determinant
    back = cross(enter, way) / determinant
    if ahead >= 0 and back >= 0 and max(ahead, back) <= 3 * np.hypot(*way) + 3:
        corner = start + ahead * enter
        yield np.concatenate([straight_line(start, corner), corner[None], straight_line(corner, end)])


def bridges(gap: Gap, other: Gap, longest: float) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield pairs of curves, from the start of one gap to the end of the other and back, if the ends are relatable.

    Both curves together are at most `longest` px, unless all ends lie in line.
    """
    (start, enter, end, leave), (start2, enter2, end2, leave2) = gap, other
    if enter is None or leave is None or enter2 is None or leave2 is None:
        return
    ways = end2 - start, end - start2
    lengths = [float(np.hypot(*way)) for way in ways]
    turns = [
        min(a @ way, b @ way) / max(length, 1e-9)
        for way, length, a, b in zip(ways, lengths, (enter, enter2), (leave2, leave), strict=True)
    ]
    if sum(lengths) > longest and min(turns) < ALIGNED:
        return
    if any(length > SHORT and turn < AHEAD for length, turn in zip(lengths, turns, strict=True)):
        return
    yield straight_line(start, end2), straight_line(start2, end)
    yield smooth(start, enter, end2, leave2), smooth(start2, enter2, end, leave)


def straight_line(start: FloatArray, end: FloatArray) -> FloatArray:
    """Sample the line between two points, px, at steps of about 1 px, without the two."""
    count = max(2, int(np.hypot(*(end - start))))
    return np.asarray(start + (end - start) * np.linspace(0, 1, count + 1)[1:-1, None])


def smooth(start: FloatArray, enter: FloatArray, end: FloatArray, leave: FloatArray) -> FloatArray:
    """Sample a cubic that has the directions of both ends, without these; an arc where both turn alike."""
    way = end - start
    distance = float(np.hypot(*way))
    unit = way / max(distance, 1e-9)
    turn = float(np.arccos(np.clip(unit @ enter, -1, 1)) + np.arccos(np.clip(unit @ leave, -1, 1))) / 2
    handle = distance * min(1.5, 2 / 3 / (1 + np.cos(turn)) if turn < 2.4 else 1.0)
    t = np.linspace(0, 1, max(4, int(1.5 * distance)) + 1)[1:-1, None]
    first, second = start + handle * enter, end - handle * leave
    return np.asarray((1 - t) ** 3 * start + 3 * (1 - t) ** 2 * t * first + 3 * (1 - t) * t**2 * second + t**3 * end)
