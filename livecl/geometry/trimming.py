# SPDX-License-Identifier: Apache-2.0
"""Trimming: cut closed outlines down to a rectangle, with the same winding numbers in it.

Half-plane by half-plane, after Sutherland and Hodgman (*Reentrant polygon clipping*, CACM 17 (1), 1974), with cubics in
place of edges: each part of an outline beyond the line is replaced by the piece of the line between its ends. Neither
enters the half-plane that is kept, so winding numbers there do not change.
"""

from __future__ import annotations

import itertools

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry import cyclic
from livecl.geometry.bezier import bernstein, subsegment

#: Shortest piece of a segment that is cut off, in its parameter.
SHORTEST = 1e-6
#: Parameters of the handles of a straight segment.
_THIRDS = np.linspace(0, 1, 4)[:, None]
#: Weights of a segment's control points in its middle.
_MIDDLE = bernstein(0.5)


def trimmed_outline(points: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray | None:
    """Return a closed outline, (s, 3, 2) px, cut down to a rectangle of two corners, (2,) px.

    Returns
    -------
    (t, 3, 2) or None
        The same array if all of it lies within; None if nothing does.
    """
    if (points >= low).all() and (points <= high).all():
        return points
    cubics = np.concatenate([points, cyclic.following(points[:, :1])], axis=1)
    whole = cubics
    for axis in (0, 1):
        for sign, limit in ((-1.0, low[axis]), (1.0, high[axis])):
            cubics = _cut(cubics, axis, sign, float(limit))
            if not len(cubics):
                return None
    return points if cubics is whole else np.ascontiguousarray(cubics[:, :3])


def _cut(cubics: FloatArray, axis: int, sign: float, limit: float) -> FloatArray:
    """Cut a closed row of cubics (s, 4, 2) down to the half-plane ``sign * (p[axis] - limit) <= 0``."""
    beyond = sign * (cubics[..., axis] - limit)
    if (beyond <= 0).all():
        return cubics
    pieces: list[tuple[FloatArray, bool]] = []
    for cubic, distance in zip(cubics, beyond, strict=True):
        ends = [0.0, *_roots(distance), 1.0]
        for begin, end in itertools.pairwise(ends):
            piece = subsegment(cubic, begin, end)
            middle = float(piece[:, axis] @ _MIDDLE)
            pieces.append((piece, sign * (middle - limit) <= 0))
    kept = [index for index, (_, inside) in enumerate(pieces) if inside]
    if len(kept) == len(pieces):
        return cubics  # only handles lie beyond
    if not kept:
        return np.zeros((0, 4, 2))
    row: list[FloatArray] = []
    for index, following in zip(kept, [*kept[1:], kept[0]], strict=True):
        row.append(pieces[index][0])
        if following != (index + 1) % len(pieces):
            start, stop = pieces[index][0][3].copy(), pieces[following][0][0].copy()
            start[axis] = stop[axis] = limit
            row[-1] = np.concatenate([row[-1][:3], start[None]])
            row.append(start + _THIRDS * (stop - start))
    cut = np.array(row)
    cut[:, 0] = cyclic.preceding(cut[:, 3])
    return cut


def _roots(values: FloatArray) -> list[float]:
    """Return the parameters in (0, 1) at which a cubic of Bernstein coefficients (4,) is 0, rising."""
    if (values <= 0).all() or (values > 0).all():
        return []
    a, b, c, d = values.tolist()
    found = np.roots([d - 3 * c + 3 * b - a, 3 * c - 6 * b + 3 * a, 3 * (b - a), a])
    real = np.sort(found[np.abs(found.imag) < 1e-9].real)
    return [t for t in real.tolist() if SHORTEST < t < 1 - SHORTEST]
