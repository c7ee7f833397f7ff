# SPDX-License-Identifier: Apache-2.0
"""Offset closed outlines by a distance: lines stay lines, and circular arcs stay arcs.

An anchor moves to where the offsets of its two tangents meet, as at a miter: by d (n_1 + n_2) / (1 + n_1 . n_2) with
the unit normals n_1 and n_2 there. Handles keep their directions and grow as the chord does, which is exact for lines
and circular arcs. Segments that the offset reverses, as arcs of a smaller radius than d, are left out.
"""

from __future__ import annotations

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry import cyclic
from livecl.geometry.bezier import cross, meeting_point, signed_area

#: Area, px^2, below which an outline is empty.
SMALL = 1e-6
#: Least 1 + n_1 . n_2 of a mitred corner.
SHARPEST = 0.1


def offset_outline(points: FloatArray, distance: float, shortest: float = 0.0) -> FloatArray | None:
    """Offset a closed subpath (m, 3, 2) by a signed distance, px, along the normals (t_y, -t_x) of its tangents t.

    Positive distances move it outwards if its signed area is positive. Segments with a chord below `shortest`, px, are
    left out; None if nothing is left.
    """
    cubics = np.concatenate([points, cyclic.following(points)[:, :1]], axis=1)
    turn = np.sign(signed_area(cubics))
    cubics = cubics[np.abs(np.diff(cubics, axis=1)).sum(axis=(1, 2)) > 1e-9]
    if shortest:
        cubics = cubics[np.hypot(*(cubics[:, 3] - cubics[:, 0]).T) >= shortest]
    while len(cubics) > 1:
        out, into = _directions(cubics), -_directions(cubics[:, ::-1])
        before = cyclic.preceding(into)
        anchors = _meetings(cyclic.preceding(cubics[:, 3]), before, cubics[:, 0], out, distance)
        ends = cyclic.following(anchors)
        old, new = cubics[:, 3] - cubics[:, 0], ends - anchors
        turned = (old * new).sum(axis=1) <= 0
        turned &= np.hypot(*old.T) > 1e-9
        if not turned.any():
            ratio = np.hypot(*new.T) / np.maximum(np.hypot(*old.T), 1e-9)
            first = anchors + ratio[:, None] * (cubics[:, 1] - cubics[:, 0])
            last = ends + ratio[:, None] * (cubics[:, 2] - cubics[:, 3])
            found = np.stack([anchors, first, last, ends], axis=1)
            return found[:, :3] if signed_area(found) * turn > SMALL else None
        cubics = cubics[~turned]
    return None


def _directions(cubics: FloatArray) -> FloatArray:
    """Return the unit direction in which each cubic (m, 4, 2) leaves its first point: (m, 2)."""
    steps = cubics[:, 1:] - cubics[:, :1]
    lengths = np.hypot(*np.moveaxis(steps, -1, 0))
    first = np.argmax(lengths > 1e-6 * lengths.max(axis=1, keepdims=True), axis=1)
    rows = np.arange(len(cubics))
    return np.asarray(steps[rows, first] / np.maximum(lengths[rows, first], 1e-12)[:, None])


def _meetings(ends: FloatArray, into: FloatArray, starts: FloatArray, out: FloatArray, distance: float) -> FloatArray:
    """Return the intersections of the offsets of two tangents: one that ends and one that starts, at points (m, 2)."""
    first, second = (np.stack([way[:, 1], -way[:, 0]], axis=1) for way in (into, out))
    a, b = ends + distance * first, starts + distance * second
    meets = (np.abs(cross(into, out)) > 0.05) & (1 + (first * second).sum(axis=1) > SHARPEST)
    return np.where(meets[:, None], meeting_point(a, into, b, out), (a + b) / 2)
