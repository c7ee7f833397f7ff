# SPDX-License-Identifier: Apache-2.0
"""Outline polylines as strokes: polygons that the nonzero rule fills as a pen of some width paints, and their gradient.

Every corner of such a polygon belongs to a vertex v of the centre line and to the lines before and after it. With the
lines' direction angles phi_1, phi_2, the turn delta = phi_2 - phi_1 in (-pi, pi], the half width r and N(psi) =
(cos psi, sin psi), it is

    p = v + r f g N(psi),      psi = phi_1 + beta delta + gamma,      g = 1 / cos(delta / 2) at a miter, else 1

where beta in [0, 1], gamma and f are constants: an offset point has f = 1, gamma = +-pi/2 and beta 0 (before the
vertex) or 1 (after it), a miter beta 1/2, an arc of a round join some beta between, of a round cap some gamma between,
a corner of a square cap f = sqrt(2), gamma = +-pi/4, and the vertex itself f = 0.

Where the inner offset lines of a join meet before the middle of both lines, the inner side has a miter too. Elsewhere
(tight curves, sharp turns of short lines) it passes through the vertex: the polygon then is the sum of the rectangles
of its lines, whose winding numbers are all positive, so that no overlap cancels what lies there.

Gradient.  With d_p = dL/dp, N' = (-sin psi, cos psi), and the sums over the corners that belong to each:

    d_v   = d_p                            d_psi   = r f g N' . d_p
    d_r   = f g N . d_p                    d_delta = beta d_psi + r f g tan(delta / 2) / 2 N . d_p   (last term: miters)
    d_phi_1 = d_psi - d_delta              d_phi_2 = d_delta
    d_e   = d_phi (-e_y, e_x) / |e|^2      of a line e = v_after - v_before, subtracted from one and added to the other

The choice of corners (miter or not, number of lines of an arc) is held fixed in it.
"""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, IntArray
from livecl.geometry.center_lines import CenterLines

__all__ = ["BEVEL", "BUTT", "CAPS", "JOINS", "MITER", "ROUND", "SQUARE", "Pens", "StrokeOutlines", "outline_strokes"]


#: Caps, by index; ROUND is that of joins too.
BUTT, ROUND, SQUARE = 0, 1, 2
CAPS = ("butt", "round", "square")
#: Joins, by index.
MITER, BEVEL = 0, 2
JOINS = ("miter", "round", "bevel")


@dataclasses.dataclass(frozen=True)
class _Corners:
    """Corners of the polygons; see the module's equations."""

    vertex: IntArray
    before: IntArray  # line before the vertex
    after: IntArray
    beta: FloatArray
    gamma: FloatArray
    factor: FloatArray
    miter: NDArray[np.bool_]
    loop: IntArray
    place: IntArray  # order along the loop, with `rank` at one vertex
    rank: IntArray


@dataclasses.dataclass(frozen=True)
class StrokeOutlines:
    """Polygons of strokes."""

    points: FloatArray  # (P, 2), corners, px; each loop is closed
    loop_offsets: IntArray  # (L + 1,), loop l has the corners ``loop_offsets[l]:loop_offsets[l + 1]``
    loop_strokes: IntArray  # (L,), stroke of each loop; a closed stroke has two, an open one one
    _corners: _Corners
    _lines: CenterLines
    _radii: FloatArray

    def pull_back(self, d_points: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the gradient with respect to centre lines and widths from that of the corners, (P, 2), loss per pixel.

        Returns
        -------
        (V, 2), (S,) float64
            Loss per pixel of displacement of each vertex, and of each stroke's width.
        """
        corners, lines = self._corners, self._lines
        d_points = np.asarray(d_points, dtype=np.float64)
        strokes = lines.strokes[corners.vertex]
        radii, delta = self._radii[strokes], lines.turns(corners.before, corners.after)
        size, normal = _sizes(corners, delta), _normals(corners, lines, delta)
        along = (normal * d_points).sum(1)
        across = normal[:, 0] * d_points[:, 1] - normal[:, 1] * d_points[:, 0]
        d_psi = radii * size * across
        d_delta = corners.beta * d_psi
        d_delta += np.where(corners.miter, radii * size * np.tan(delta / 2) / 2 * along, 0)
        num = len(lines.vertices)
        d_phi = np.bincount(corners.before, d_psi - d_delta, num) + np.bincount(corners.after, d_delta, num)
        d_lines = d_phi[:, None] * lines.perpendicular
        d_vertices = np.stack([np.bincount(corners.vertex, d_points[:, axis], num) for axis in (0, 1)], axis=1)
        np.add.at(d_vertices, lines.next, d_lines)
        d_kept = np.zeros((lines.num_given, 2))
        d_kept[lines.kept] = d_vertices - d_lines
        return d_kept, np.bincount(strokes, size * along, len(self._radii)) / 2


class Pens(NamedTuple):
    """Widths, caps and joins of S strokes; a single number applies to all of them."""

    widths: ArrayLike  # (S,), width of each stroke, px
    #: (S,): indices into CAPS and JOINS.
    caps: ArrayLike
    joins: ArrayLike
    #: (S,): largest length of a miter, in widths; beyond it, joins are bevels (SVG's ``stroke-miterlimit``).
    miter_limits: ArrayLike


def outline_strokes(
    vertices: ArrayLike,
    offsets: ArrayLike,
    pens: Pens,
    *,
    closed: ArrayLike,
    smooth: ArrayLike | None = None,
    tolerance: float = 0.02,
) -> StrokeOutlines:
    """Outline polylines as strokes of some width.

    Parameters
    ----------
    vertices : (V, 2) array_like
        Vertices (x, y) of all centre lines, px.
    offsets : (S + 1,) array_like of int
        Stroke s has the vertices ``offsets[s]:offsets[s + 1]``, at least one.
    pens : Pens
        Widths, caps and joins.
    closed : (S,) array_like of bool
        Whether each stroke is closed.
    smooth : (V,) array_like of bool, optional
        Vertices within a curve: their joins are always round.
    tolerance : float
        Largest distance between an arc and its lines, px.

    Returns
    -------
    StrokeOutlines
        Polygons to be filled by the nonzero rule. A stroke of no length is a dot: a disc or a square by its cap.
    """
    num_strokes = len(np.asarray(offsets)) - 1
    radii = np.broadcast_to(np.asarray(pens.widths, dtype=np.float64) / 2, num_strokes)
    lines = CenterLines.of(np.asarray(vertices, np.float64), np.asarray(offsets), np.asarray(closed, bool), smooth)
    caps, joins = (np.broadcast_to(np.asarray(value, dtype=np.int64), num_strokes) for value in (pens.caps, pens.joins))
    limits = np.broadcast_to(np.asarray(pens.miter_limits, np.float64), num_strokes)
    parts: list[Part] = [
        *_join_corners(lines, radii, joins, limits, tolerance),
        *_cap_corners(lines, radii, caps, tolerance),
    ]
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    order = np.lexsort((columns[-1], columns[-2], columns[-3]))
    corners = _Corners(*(column[order] for column in columns))
    delta = lines.turns(corners.before, corners.after)
    strokes = lines.strokes[corners.vertex]
    reach = (radii[strokes] * _sizes(corners, delta))[:, None]
    points = lines.vertices[corners.vertex] + reach * _normals(corners, lines, delta)
    starts = np.flatnonzero(np.diff(corners.loop, prepend=-1))
    return StrokeOutlines(points, np.append(starts, len(points)), corners.loop[starts] // 2, corners, lines, radii)


def _sizes(corners: _Corners, delta: FloatArray) -> FloatArray:
    """Return f g of each corner."""
    return np.where(corners.miter, corners.factor / np.cos(delta / 2), corners.factor)


def _normals(corners: _Corners, lines: CenterLines, delta: FloatArray) -> FloatArray:
    """Return N(psi) of each corner: (P, 2)."""
    psi = lines.angles[corners.before] + corners.beta * delta + corners.gamma
    return np.stack([np.cos(psi), np.sin(psi)], axis=1)


Part = tuple[NDArray[Any], ...]


class _Joins(NamedTuple):
    """Sides of joins: the vertex of each, its side (-1 or +1) of the line, and its place: loop and order along it."""

    vertices: IntArray
    sides: IntArray
    loops: IntArray
    places: IntArray

    def subset(self, rows: NDArray[Any]) -> _Joins:
        """Return some of the sides, by mask or index."""
        return _Joins(*(column[rows] for column in self))


def _sides_of(lines: CenterLines, vertices: IntArray) -> _Joins:
    """Return both sides of some vertices: one runs forward, the other back."""
    num = len(lines.vertices)
    strokes = lines.strokes[vertices]
    is_open = np.zeros(int(strokes.max(initial=0)) + 1, bool)
    first = lines.strokes[lines.is_first]
    is_open[first[first < len(is_open)]] = True
    return _Joins(
        np.concatenate([vertices, vertices]),
        np.repeat([-1, 1], len(vertices)),
        np.concatenate([2 * strokes, 2 * strokes + ~is_open[strokes]]),
        np.concatenate([vertices, 3 * num - vertices]),
    )


def _part(
    lines: CenterLines,
    joins: _Joins,
    rank: IntArray | int,
    *,
    beta: FloatArray | float,
    factor: float = 1.0,
    miter: bool = False,
) -> Part:
    """Return corners at sides of joins; `rank` orders those of one vertex in the line's direction."""
    vertices, num = joins.vertices, len(joins.vertices)
    betas = beta if isinstance(beta, np.ndarray) else np.full(num, beta)
    turns, factors = joins.sides * (np.pi / 2), np.full(num, factor)
    ranks = -joins.sides * rank
    return (
        vertices,
        lines.previous[vertices],
        vertices,
        betas,
        turns,
        factors,
        np.full(num, miter),
        joins.loops,
        joins.places,
        ranks,
    )


def _join_corners(
    lines: CenterLines, radii: FloatArray, joins: IntArray, limits: FloatArray, tolerance: float
) -> list[Part]:
    """Return the corners at vertices between two lines, on both sides."""
    inside = np.flatnonzero(~lines.is_first & ~lines.is_last)
    delta = lines.turns(lines.previous[inside], inside)
    stroke = lines.strokes[inside]
    radius, style = radii[stroke], np.where(lines.smooth[inside], ROUND, joins[stroke])
    stretch = 1 / np.maximum(np.cos(delta / 2), 1e-9)  # of a miter over a half width
    shorter = np.minimum(lines.lengths[inside], lines.lengths[lines.previous[inside]])
    meets = radius * np.tan(np.abs(delta) / 2) <= shorter / 2
    flat = radius * (stretch - 1) <= tolerance
    outer = flat & (style == ROUND) | (style == MITER) & (stretch <= limits[stroke])
    both = _sides_of(lines, inside)
    is_inner = np.concatenate([np.sign(delta) == -1, np.sign(delta) == 1])
    mitered = np.where(is_inner, np.tile(meets, 2), np.tile(outer, 2))
    rounded = ~is_inner & ~mitered & np.tile(style == ROUND, 2)
    bent = ~mitered & ~rounded
    around, sharp, inner = both.subset(rounded), both.subset(bent), both.subset(bent & is_inner)
    size, reach = (np.tile(values, 2)[rounded] for values in (np.abs(delta), radius))
    counts = _arc_lines(size, reach, tolerance)
    index, step = _repeated(counts + 1)
    return [
        _part(lines, both.subset(mitered), 0, beta=0.5, miter=True),
        _part(lines, sharp, -1, beta=0.0),
        _part(lines, inner, 0, beta=0.0, factor=0.0),
        _part(lines, sharp, 1, beta=1.0),
        _part(lines, around.subset(index), step, beta=step / counts[index]),
    ]


def _cap_corners(lines: CenterLines, radii: FloatArray, caps: IntArray, tolerance: float) -> list[Part]:
    """Return the corners at the ends of open strokes."""
    parts: list[Part] = []
    num = len(lines.vertices)
    for ends, own, opposite, place in (
        (np.flatnonzero(lines.is_last), lines.previous, 0.0, None),
        (np.flatnonzero(lines.is_first), None, np.pi, 4 * num),
    ):
        line = ends if own is None else np.where(lines.is_first[ends], ends, own[ends])
        stroke = lines.strokes[ends]
        style = caps[stroke]
        counts = np.where(style == ROUND, _arc_lines(np.full(len(ends), np.pi), radii[stroke], tolerance), 1)
        index, step = _repeated(counts + 1)
        share = step / counts[index] - 0.5
        is_square = style[index] == SQUARE
        turn = opposite + np.where(is_square, np.pi / 2, np.pi) * share
        factor = np.where(is_square, np.sqrt(2), 1.0)
        zeros = np.zeros(len(index))
        at = ends[index] if place is None else np.full(len(index), place)
        loop = 2 * stroke[index]
        parts.append((ends[index], line[index], line[index], zeros, turn, factor, zeros.astype(bool), loop, at, step))
    return parts


def _arc_lines(angle: FloatArray, radius: FloatArray, tolerance: float) -> IntArray:
    """Return the number of lines that keep an arc within the tolerance."""
    largest = 2 * np.arccos(np.clip(1 - tolerance / np.maximum(radius, tolerance), -1, 1))
    return np.maximum(1, np.ceil(angle / largest)).astype(np.int64)


def _repeated(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Return, for each of `counts` items of an index, the index and the number of the item: two (sum of counts,)."""
    index = np.repeat(np.arange(len(counts)), counts)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
