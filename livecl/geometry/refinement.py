# SPDX-License-Identifier: Apache-2.0
"""Refine a path along an outline: smooth joins, lines that stay lines, least squared distance (Gauss-Newton).

The unknowns are fewer than the control points' coordinates: anchors; the direction of each smooth join (given by the
line beside it, if there is one); lengths of handles; both coordinates of handles at corners. Distances are measured
across the path, and the parameters of the outline's points are corrected by Newton's method between the steps.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.geometry import cyclic
from livecl.geometry.bezier import bernstein
from livecl.geometry.polylines import unit
from livecl.geometry.simplest import Draft, MeasuredOutline

#: Number of steps; damping (Levenberg), beside a weight of 1 for each px of the outline, and its factor after a step
#: that did not lower the error; shortest handle, as a share of the distance between the anchors, and longest, as one of
#: the outline's length between them: that of three quarters of a circle is 0.68.
STEPS, RIDGE, STIFFER, SHORTEST, LONGEST = 6, 0.02, 16.0, 0.05, 1.0
#: The steps end once the error is more than this share of the error before.
SETTLED = 0.97
#: Cosine of the largest angle between the directions of a smooth join; lines up to this length, px, give no direction.
SMOOTH, SHORT = 0.9, 4.0
#: Number of unknowns above which the equations are solved as sparse ones: below it, dense ones are as fast.
MANY = 100


@dataclasses.dataclass(frozen=True, eq=False)
class Refined:
    """A path with smooth joins along an outline."""

    cubics: FloatArray  # (S, 4, 2), control points
    error: float  # integral of the squared distance along the outline, px^3
    errors: FloatArray  # (S,), each segment's part of it
    smooth: NDArray[np.bool_]  # (S,), whether the join at the beginning of each segment is smooth


def refined(measured: MeasuredOutline, draft: Draft, steps: int = STEPS) -> Refined:
    """Make the joins of a draft smooth, and fit it to the outline."""
    points, places = measured.outline.points, measured.lengths[:-1]
    sizes = np.diff(measured.lengths)
    weights = (sizes + cyclic.preceding(sizes)) / 2
    weights[measured.outline.corners] = 0
    reach = (cyclic.following(draft.places) - draft.places) % measured.total
    reach[reach == 0] = measured.total
    order = np.argsort(draft.places)
    owner = order[np.searchsorted(draft.places[order], places, side="right") - 1]
    t = np.clip(((places - draft.places[owner]) % measured.total) / np.maximum(reach[owner], 1e-9), 0, 1)
    chain = _Chain.of(draft, reach)
    ridge = RIDGE
    cubics = chain.cubics()
    owner, t = _reparametrized(cubics, points, owner, t)
    misses, basis, normal = _misses(cubics, points, owner, t)
    error = float((weights * misses**2).sum())
    for _ in range(steps):
        interruption.check()
        rows = (basis[:, :, None] * normal[:, None, :]).reshape(len(t), 8)
        moved = chain.stepped(owner, rows * np.sqrt(weights)[:, None], misses * np.sqrt(weights), ridge)
        trial = moved.cubics()
        found = _reparametrized(trial, points, owner, t)
        missed = _misses(trial, points, *found)
        after = float((weights * missed[0] ** 2).sum())
        if after >= error:
            ridge *= STIFFER
            continue
        settled = after > SETTLED * error
        chain, cubics, error = moved, trial, after
        (owner, t), (misses, basis, normal) = found, missed
        if settled:
            break
    own = np.asarray(np.bincount(owner, weights * misses**2, len(cubics)), dtype=np.float64)
    return Refined(cubics, error, own, chain.smooth)


def _reparametrized(
    cubics: FloatArray, points: FloatArray, owner: IntArray, t: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Take a Newton step towards the nearest parameters; points beyond a segment's end move to the next segment."""
    corners, place = cubics @ (1, 1j), points @ (1, 1j)  # the dot product of a and b is the real part of a* b
    bends = corners[:, 2] - 2 * corners[:, 1] + corners[:, 0]
    powers = np.array(
        [
            corners[:, 0],
            3 * (corners[:, 1] - corners[:, 0]),
            3 * bends,
            corners[:, 3] - corners[:, 0] - 3 * (corners[:, 2] - corners[:, 1]),
        ]
    )
    for _ in range(2):
        zeroth, first, second, third = powers.take(owner, axis=1)
        away = ((third * t + second) * t + first) * t + zeroth - place
        half = 3 * third * t + second  # of the second derivative
        way = (half + second) * t + first
        slope = way.real**2 + way.imag**2 + np.maximum(2 * (away.conj() * half).real, 0)
        t = t - np.minimum(np.maximum((away.conj() * way).real / np.maximum(slope, 1e-9), -0.3), 0.3)
        after, before = t > 1, t < 0
        owner = (owner + after - before) % len(cubics)
        t = np.minimum(np.maximum(t - after + before, 0), 1)
    return owner, t


def _misses(
    cubics: FloatArray, points: FloatArray, owner: IntArray, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return distances across the path (n,), Bernstein weights (n, 4) and normals (n, 2)."""
    own, basis = cubics[owner], bernstein(t)
    steps = np.diff(own, axis=1)
    u = 1 - t
    way = (u**2)[:, None] * steps[:, 0] + (2 * u * t)[:, None] * steps[:, 1] + (t**2)[:, None] * steps[:, 2]
    normal = np.stack([-way[:, 1], way[:, 0]], axis=1) / np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    away = np.einsum("nk,nkd->nd", basis, own) - points
    return (away * normal).sum(axis=1), basis, normal


@dataclasses.dataclass(frozen=True, eq=False)
class _Side:
    """The handles after the anchors, or those before them."""

    rows: IntArray  # (S,), row of the x of each anchor's handle among the control points' coordinates
    sign: int  # 1 after the anchors, -1 before
    smooth: IntArray  # anchors of smooth joins, whose handle has a length
    free: IntArray  # other anchors, whose handle has two coordinates
    #: Anchors whose direction a line gives, and the line's ends: first the line before the anchor, then that after it.
    ties: list[tuple[IntArray, IntArray, IntArray]]


@dataclasses.dataclass(eq=False)
class _Chain:
    """The unknowns of a path."""

    anchors: FloatArray  # (S, 2), where segments begin
    straight: NDArray[np.bool_]  # (S,), segments that are lines
    smooth: NDArray[np.bool_]  # (S,), anchors of smooth joins
    ways: FloatArray  # (S, 2), unit direction at smooth anchors
    #: (S,): lengths of the handles after and before smooth anchors.
    out: FloatArray
    back: FloatArray
    #: (S, 2): handles after and before the other anchors, from the anchor.
    free_out: FloatArray
    free_back: FloatArray
    reach: FloatArray  # (S,), lengths of the segments

    @classmethod
    def of(cls, draft: Draft, reach: FloatArray) -> _Chain:
        cubics, straight = draft.cubics, draft.straight
        before = cyclic.preceding(straight)
        out, back = cubics[:, 1] - cubics[:, 0], cyclic.preceding(cubics[:, 3] - cubics[:, 2])
        long_out, long_back = np.hypot(*out.T), np.hypot(*back.T)
        unit_out, unit_back = unit(out), unit(back)
        short = reach < SHORT
        tied_to_short = (straight & short) | (before & cyclic.preceding(short))
        smooth = ~draft.corners & ~(straight & before) & ~tied_to_short & ((unit_out * unit_back).sum(axis=1) > SMOOTH)
        weight_out = np.where(straight, 1e3, long_out)[:, None]
        weight_back = np.where(before, 1e3, long_back)[:, None]
        ways = unit(weight_out * unit_out + weight_back * unit_back)
        chain = cls(cubics[:, 0].copy(), straight, smooth, ways, long_out, long_back, out, back, reach)
        chain._bound()
        return chain

    def _bound(self) -> None:
        """Align directions with the lines beside them, and bound the lengths of handles."""
        ahead = cyclic.following(self.anchors) - self.anchors
        least, most = SHORTEST * np.hypot(*ahead.T), LONGEST * self.reach
        for lines, way in ((self.straight, ahead), (cyclic.preceding(self.straight), cyclic.preceding(ahead))):
            tied = self.smooth & lines
            self.ways[tied] = unit(way[tied])
        self.out = np.clip(self.out, least, most)
        self.back = np.clip(self.back, cyclic.preceding(least), cyclic.preceding(most))

    def cubics(self) -> FloatArray:
        """Return the control points (S, 4, 2)."""
        end = cyclic.following(self.anchors)
        smooth = self.smooth[:, None]
        out = np.where(smooth, self.out[:, None] * self.ways, self.free_out)
        back = cyclic.following(np.where(smooth, self.back[:, None] * self.ways, self.free_back))
        lines = self.straight[:, None]
        first = np.where(lines, (2 * self.anchors + end) / 3, self.anchors + out)
        second = np.where(lines, (self.anchors + 2 * end) / 3, end - back)
        return np.stack([self.anchors, first, second, end], axis=1)

    def stepped(self, owner: IntArray, rows: FloatArray, misses: FloatArray, ridge: float) -> _Chain:
        """Return the chain after a Gauss-Newton step: rows (n, 8) are the derivatives of the distances (n,)."""
        count = len(self.anchors)
        order = np.argsort(owner, kind="stable")
        rows, misses, owner = rows[order], misses[order], owner[order]
        present, first = np.unique(owner, return_index=True)
        gram, right = np.zeros((count, 8, 8)), np.zeros((count, 8))
        gram[present] = np.add.reduceat(rows[:, :, None] * rows[:, None, :], first)
        right[present] = np.add.reduceat(rows * misses[:, None], first)
        columns = self._columns
        total = columns["total"]
        scale = np.ones(total)
        turns = columns["way"][columns["way"] < total]
        scale[turns] = np.maximum(self.out, self.back)[columns["way"] < total] ** 2
        (at_row, at_column), values = self._places, self._derivatives()
        if total > MANY:  # each unknown is coupled to those of neighbouring segments only
            inside = at_column < total
            entries = (values[inside], (at_row[inside], at_column[inside]))
            sparse_jacobian = sparse.csr_array(entries, shape=(count * 8, total))
            blocks = sparse.bsr_array((gram, np.arange(count), np.arange(count + 1)), shape=(count * 8, count * 8))
            equations = sparse_jacobian.T @ (blocks @ sparse_jacobian) + sparse.diags_array(ridge * scale)
            solution = sparse_linalg.spsolve(sparse.csc_array(equations), -(sparse_jacobian.T @ right.ravel()))
        else:
            jacobian = np.zeros((count * 8, total + 1))
            np.add.at(jacobian, (at_row, at_column), values)
            jacobian = jacobian[:, :total]
            left = jacobian.T @ (gram @ jacobian.reshape(count, 8, total)).reshape(count * 8, total)
            left[np.arange(total), np.arange(total)] += ridge * scale
            solution = np.linalg.solve(left, -jacobian.T @ right.ravel())
        return self._moved(np.append(solution, 0.0), columns)

    @functools.cached_property
    def _columns(self) -> dict[str, Any]:
        """Number the unknowns; `total` stands for none."""
        count = len(self.anchors)
        before = cyclic.preceding(self.straight)
        wanted = {
            "x": np.ones(count, bool),
            "y": np.ones(count, bool),
            "way": self.smooth & ~self.straight & ~before,
            "out": ~self.straight,
            "out_y": ~self.straight & ~self.smooth,
            "back": ~before,
            "back_y": ~before & ~self.smooth,
        }
        columns: dict[str, Any] = {}
        total = 0
        for name, mask in wanted.items():
            columns[name] = np.where(mask, total + np.cumsum(mask) - 1, -1)
            total += int(mask.sum())
        for name in wanted:
            columns[name][columns[name] < 0] = total
        columns["total"] = total
        return columns

    @functools.cached_property
    def _sides(self) -> tuple[_Side, _Side]:
        """Handles after the anchors, in the rows of their segments, and before them, in those of the one before."""
        count, before = len(self.anchors), cyclic.preceding(self.straight)
        own = np.arange(count)
        prev, following = (own - 1) % count, (own + 1) % count
        pairs = ((self.smooth & before, own, prev), (self.smooth & self.straight, following, own))
        sides = []
        for rows, sign, lines in ((8 * own + 2, 1, self.straight), (8 * prev + 4, -1, before)):
            curved = ~lines
            ties = [(np.flatnonzero(curved & tied), a[curved & tied], b[curved & tied]) for tied, a, b in pairs]
            smooth, free = np.flatnonzero(curved & self.smooth), np.flatnonzero(curved & ~self.smooth)
            sides.append(_Side(rows, sign, smooth, free, ties))
        return sides[0], sides[1]

    @functools.cached_property
    def _places(self) -> tuple[IntArray, IntArray]:
        """Rows and columns of the derivatives that :meth:`_derivatives` returns."""
        c, count = self._columns, len(self.anchors)
        own = np.arange(count)
        rows, columns = [], []
        for axis, name in enumerate(("x", "y")):
            following = cyclic.following(c[name])
            for row in (0, 2, 4):
                rows.append(8 * own + row + axis)
                columns.append(c[name])
            for row in (6, 2, 4):
                rows.append(8 * own + row + axis)
                columns.append(following)
        for side, kind in zip(self._sides, ("out", "back"), strict=True):
            for axis, free in enumerate((kind, kind + "_y")):
                at = side.rows + axis
                rows += [at[side.smooth], at[side.smooth], at[side.free]]
                columns += [c[kind][side.smooth], c["way"][side.smooth], c[free][side.free]]
                for tied, a, b in side.ties:
                    rows += 4 * [at[tied]]
                    columns += [c["x"][a], c["x"][b], c["y"][a], c["y"][b]]
        return np.concatenate(rows), np.concatenate(columns)

    @functools.cached_property
    def _anchor_shares(self) -> FloatArray:
        """Derivatives of the control points by the anchors, which also move the handles."""
        one, line = np.ones(len(self.anchors)), self.straight
        thirds = [np.where(line, share / 3, whole) for share, whole in ((2, 1.0), (1, 0.0))]
        return np.concatenate(2 * [one, *thirds, one, *(1 - third for third in thirds)])

    def _derivatives(self) -> FloatArray:
        """Return the derivatives of the control points by the unknowns, at `_places`, where they add up."""
        turned = np.stack([-self.ways[:, 1], self.ways[:, 0]], axis=1)
        values = [self._anchor_shares]
        for side, lengths in zip(self._sides, (self.out, self.back), strict=True):
            across, free = side.sign * lengths[:, None] * turned, np.full(len(side.free), float(side.sign))
            # A direction given by a line turns with the line's ends.
            reaches = [np.maximum(np.hypot(*(self.anchors[a] - self.anchors[b]).T), 1e-9) for _, a, b in side.ties]
            for axis in (0, 1):
                values += [side.sign * self.ways[side.smooth, axis], across[side.smooth, axis], free]
                for (tied, _, _), reach in zip(side.ties, reaches, strict=True):
                    by_x, by_y = across[tied, axis] * turned[tied].T / reach
                    values += [by_x, -by_x, by_y, -by_y]
        return np.concatenate(values)

    def _moved(self, change: FloatArray, c: dict[str, Any]) -> _Chain:
        """Return the chain with its numbers changed."""
        turn = np.clip(change[c["way"]], -0.5, 0.5)[:, None]
        turned = np.stack([-self.ways[:, 1], self.ways[:, 0]], axis=1)
        smooth = self.smooth[:, None]
        free = (np.where(smooth, 0, np.stack([change[c[k]], change[c[k + "_y"]]], axis=1)) for k in ("out", "back"))
        free_out, free_back = free
        moved = dataclasses.replace(
            self,
            anchors=self.anchors + np.stack([change[c["x"]], change[c["y"]]], axis=1),
            ways=np.cos(turn) * self.ways + np.sin(turn) * turned,
            out=self.out + np.where(self.smooth, change[c["out"]], 0),
            back=self.back + np.where(self.smooth, change[c["back"]], 0),
            free_out=self.free_out + free_out,
            free_back=self.free_back + free_back,
        )
        for name in ("_columns", "_sides", "_places", "_anchor_shares"):  # which unknowns there are stays
            moved.__dict__[name] = getattr(self, name)
        moved._bound()
        return moved
