# SPDX-License-Identifier: Apache-2.0
"""Constraints on edited outlines in training: lines, level and plumb sides, smooth joins, circles, rectangles.

All are derived from the outlines themselves: a drawing that has lines keeps them.
"""

from __future__ import annotations

import dataclasses
import itertools
import re

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import BoolArray, FloatArray
from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import cross
from livecl.svg.primitives import Primitive
from livecl.svg.shapes import ellipse_outline, rectangle_outline
from livecl.svg.writer import primitives

IntArray = NDArray[np.integer]

#: Length of a handle, px, from which it makes a join.
SHORT = 1e-3

_TURN = re.compile(r"rotate\((\S+)")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Slack:
    """Tolerances within which an outline counts as straight, level, plumb or smooth."""

    #: Largest distance of a line's handles from the line, px, and from its thirds, as a share of its length.
    straight: float
    along: float
    level: float  # largest height of a level line, and width of a plumb one, px
    tilt: float  # sine up to which lines and smooth joins are level or plumb
    turn: float  # sine up to which a join is smooth


#: Exact except for rounding.
EXACT = Slack(straight=1e-6, along=1e-6, level=1e-6, tilt=1e-3, turn=1e-4)


class Joins:
    """Straight, level and plumb segments, and smooth joins of closed outlines.

    Parameters
    ----------
    points : (M, 3, 2) float64
        Segments, px.
    following : (M,) int
        Segment whose anchor ends each segment.
    rows : (M,) bool
        Segments that are looked at.
    slack : Slack
        What counts as a line and as smooth.

    Attributes
    ----------
    lines : (M,) bool
        Segments that are lines.
    smooth : (M,) bool
        Anchors at which two segments, one of them a curve, join smoothly.
    turns : (M,) float64
        Sine of the angle at each anchor; 1 beyond right angles, and where a handle has no length.
    level : two lists of (k,) int
        Anchors that share x, along plumb lines, and y, along level ones.
    """

    def __init__(self, points: FloatArray, following: IntArray, rows: BoolArray, slack: Slack = EXACT) -> None:
        self._next = following
        chords = points[following, 0] - points[:, 0]
        lengths = np.hypot(*chords.T)
        units = chords / np.maximum(lengths, 1e-12)[:, None]
        rest = points[:, 1:] - points[:, :1]
        across = np.abs(rest[..., 0] * units[:, None, 1] - rest[..., 1] * units[:, None, 0]).max(axis=1)
        thirds = np.einsum("mkd,md->mk", rest, units) - lengths[:, None] * (np.array([1.0, 2.0]) / 3)
        reach = np.maximum(slack.along * lengths, slack.straight)
        self.lines = rows & (across <= slack.straight) & (np.abs(thirds).max(axis=1) <= reach) & (lengths > SHORT)
        limits = np.minimum(slack.level, np.maximum(slack.tilt * lengths, EXACT.level))
        self.level = [_groups(self.lines & (np.abs(chords[:, axis]) <= limits), following) for axis in (0, 1)]
        self._before = np.empty(len(points), np.int64)
        self._before[following] = np.arange(len(points))
        into, out = self._steps(points)
        both = np.stack([np.hypot(*into.T), np.hypot(*out.T)])
        sine = np.abs(cross(into, out)) / np.maximum(both.prod(axis=0), 1e-12)
        self.turns = np.where((both.min(axis=0) > SHORT) & ((into * out).sum(axis=1) > 0), sine, 1.0)
        self.smooth = rows & (self.turns <= slack.turn) & ~(self.lines & self.lines[self._before])
        self._axes = np.abs(into + out) > slack.tilt * np.abs(into + out).max(
            axis=1, keepdims=True
        )  # else level, plumb

    def _steps(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the steps from the handle before each anchor to it, and on to the handle after it: (M, 2) each.

        Beside a line they are the line.
        """
        line_in, line_out = self.lines[self._before, None], self.lines[:, None]
        into = np.where(line_in, points[:, 0] - points[self._before, 0], points[:, 0] - points[self._before, 2])
        return into, np.where(line_out, points[self._next, 0] - points[:, 0], points[:, 1] - points[:, 0])

    def directions(self, points: FloatArray) -> FloatArray:
        """Return the unit tangent at each smooth anchor of points (M, 3, 2): (M, 2)."""
        into, out = self._steps(points)
        along = np.where(self.lines[self._before, None], into, into + out)
        along = np.where(self.lines[:, None], out, along)
        along = np.where(self._axes, along, 0.0)
        return np.asarray(along / np.maximum(np.hypot(*along.T), 1e-12)[:, None])

    def hold(self, points: FloatArray) -> None:
        """Project points (M, 3, 2) onto straight lines and smooth joins."""
        share_levels(points[:, 0], self.level)
        into, out = self._steps(points)
        along = self.directions(points)
        k = np.flatnonzero(self.smooth)
        before = self._before[k]
        lengths_in, lengths_out = ((step[k] * along[k]).sum(axis=1, keepdims=True) for step in (into, out))
        free_in, free_out = ~self.lines[before], ~self.lines[k]
        points[before[free_in], 2] = (points[k, 0] - np.maximum(lengths_in, SHORT) * along[k])[free_in]
        points[k[free_out], 1] = (points[k, 0] + np.maximum(lengths_out, SHORT) * along[k])[free_out]
        lines, ends = self.lines, points[self._next, 0]
        step = (ends - points[:, 0])[lines]
        points[lines, 1], points[lines, 2] = points[lines, 0] + step / 3, ends[lines] - step / 3


class Constraints:
    """Free coordinates of a drawing's points under which lines, joins and shapes are kept.

    They are anchors, of which level and plumb lines share one coordinate; from each anchor, the two handles, which at a
    smooth join are two lengths along one direction, which turns; and position and size of shapes. Handles of lines, and
    directions beside lines and along the axes, follow.
    The drawing is edited, not yet rounded; layers that are not `free`, (N,) bool, stay as they are.

    Attributes
    ----------
    start : (M, 3, 2) float64
        The drawing's coordinates, px. Of each segment: its anchor; the handle after that, or at a smooth join its
        length and an arc of the direction's turn; and the same of the handle before. Of a shape, the changes of its
        numbers in the first places of its rows, and zeros.
    """

    def __init__(self, drawing: Drawing, free: BoolArray) -> None:
        points = drawing.points.copy()
        rows = free[drawing.segment_layers]
        self._fixed = points
        self._held = ~rows
        self._shapes = []
        for layer, shape in primitives(drawing, 9).items():
            if free[layer]:
                taken = slice(*drawing.segment_offsets[layer : layer + 2])
                points[taken], rows[taken] = shape.points, False
                self._shapes.append((taken, _changes(shape)))
        self._next = drawing.next_segments
        self._before = np.empty(len(points), np.int64)
        self._before[self._next] = np.arange(len(points))
        joins = Joins(points, self._next, rows)
        self._smooth, self._lines, self._level = joins.smooth, joins.lines, joins.level
        self._line_before = joins.lines[self._before]
        self._ways = joins.directions(points)
        self._turning = joins.smooth & ~self._lines & ~self._line_before & (np.abs(self._ways).min(axis=1) > 0)
        self._rows = rows
        out, back = points[:, 1] - points[:, 0], points[:, 0] - points[self._before, 2]
        lengths = [np.maximum((handle * self._ways).sum(axis=1), SHORT) for handle in (out, back)]
        self._reach = np.maximum(np.maximum(*lengths), SHORT)
        self.start = np.stack([points[:, 0], out, back], axis=1)
        for handle, length in zip((1, 2), lengths, strict=True):
            along = np.stack([length, np.zeros(len(points))], axis=1)
            self.start[:, handle] = np.where(self._smooth[:, None], along, self.start[:, handle])
        share_levels(self.start[:, 0], self._level)
        for taken, _ in self._shapes:
            self.start[taken] = 0.0

    def _directions(self, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the directions at smooth joins, (M, 2), and the distances of the anchors before and after, (2, M)."""
        angle = np.where(self._turning, coordinates[:, 1, 1] / self._reach, 0.0)
        turned = np.cos(angle)[:, None] * self._ways + np.sin(angle)[:, None] * _turned(self._ways)
        anchors = coordinates[:, 0]
        steps = anchors - anchors[self._before], anchors[self._next] - anchors
        lengths = np.maximum(np.hypot(*np.moveaxis(np.stack(steps), -1, 0)), 1e-12)
        for step, length, beside in zip(steps, lengths, (self._line_before, self._lines), strict=True):
            turned = np.where(beside[:, None], step / length[:, None], turned)
        return turned, lengths

    def points(self, coordinates: FloatArray) -> FloatArray:
        """Compute the points (M, 3, 2) from coordinates (M, 3, 2), px."""
        anchors, out, back = np.moveaxis(coordinates, 1, 0)
        ways, _ = self._directions(coordinates)
        smooth = self._smooth[:, None]
        out, back = (np.where(smooth, np.maximum(handle[:, :1], SHORT) * ways, handle) for handle in (out, back))
        ends = anchors[self._next]
        lines, step = self._lines[:, None], (ends - anchors) / 3
        first = np.where(lines, anchors + step, anchors + out)
        last = np.where(lines, ends - step, ends - back[self._next])
        points = np.stack([anchors, first, last], axis=1)
        points[~self._rows] = self._fixed[~self._rows]
        for taken, changes in self._shapes:
            found = coordinates[taken].ravel()[: len(changes)]
            points[taken] = self._fixed[taken] + np.tensordot(found, changes, 1)
        return points

    def gradient(self, coordinates: FloatArray, d_points: FloatArray) -> FloatArray:
        """Return the derivatives by coordinates of what has the derivatives d_points (M, 3, 2) by points.

        Of coordinates that several anchors share each has the mean.
        """
        anchors, before, smooth = d_points[:, 0].copy(), self._before, self._smooth
        lines, line_before = self._lines, self._line_before
        first, last = d_points[:, 1], d_points[before, 2]
        # Handles of lines lie at their thirds; the others move with their anchor.
        anchors += np.where(lines[:, None], (2 * first + d_points[:, 2]) / 3, first)
        anchors += np.where(line_before[:, None], (d_points[before, 1] + 2 * last) / 3, last)
        first, last = np.where(lines[:, None], 0.0, first), -np.where(line_before[:, None], 0.0, last)
        ways, lengths = self._directions(coordinates)
        across = _turned(ways)
        torque = np.where(smooth, coordinates[:, 1, 0] * (first * across).sum(axis=1), 0.0)
        torque += np.where(smooth, coordinates[:, 2, 0] * (last * across).sum(axis=1), 0.0)
        for beside, other, length, sign in ((line_before, before, lengths[0], 1), (lines, self._next, lengths[1], -1)):
            k = np.flatnonzero(smooth & beside)
            turn = sign * (torque / length)[k, None] * across[k]
            np.add.at(anchors, k, turn)
            np.add.at(anchors, other[k], -turn)
        along = [np.stack([(handle * ways).sum(axis=1), np.zeros(len(ways))], axis=1) for handle in (first, last)]
        along[0][:, 1] = np.where(self._turning, torque / self._reach, 0.0)
        first, last = (np.where(smooth[:, None], *pair) for pair in zip(along, (first, last), strict=True))
        share_levels(anchors, self._level)
        found = np.stack([anchors, first, last], axis=1)
        found[~self._rows] = 0.0
        for taken, changes in self._shapes:
            own = found[taken].ravel()
            own[: len(changes)] = np.tensordot(changes, d_points[taken], 3)
            found[taken] = own.reshape(-1, 3, 2)
        return found


def share_levels(anchors: FloatArray, level: list[list[IntArray]]) -> None:
    """Average the coordinates of anchors (M, 2) shared by level and plumb lines (:attr:`Joins.level`)."""
    for axis, groups in enumerate(level):
        for members in groups:
            anchors[members, axis] = anchors[members, axis].mean()


def _turned(vectors: FloatArray) -> FloatArray:
    """Rotate vectors (n, 2) by a right angle."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)


def _groups(level: BoolArray, following: IntArray) -> list[IntArray]:
    """Return the anchors that lines (M,) bool hold on one coordinate, each run of them together."""
    groups: list[set[int]] = []
    of: dict[int, set[int]] = {}
    for row in np.flatnonzero(level).tolist():
        pair = [row, int(following[row])]
        joined = set(itertools.chain(pair, *(of.get(anchor, ()) for anchor in pair)))
        for anchor in joined:
            of[anchor] = joined
        groups.append(joined)
    unique = {id(group): group for group in of.values()}
    return [np.array(sorted(group)) for group in unique.values()]


def _changes(shape: Primitive) -> FloatArray:
    """Return how the outline of a shape changes with its position, size and radius, by 1 px each at most: (k, m, 3, 2).

    Outlines are linear in them, an angle being given.
    """
    size = {name: float(value) for name, value in shape.attributes.items() if name != "transform"}
    ones = np.zeros((2, len(shape.points), 3, 2))
    ones[0, ..., 0], ones[1, ..., 1] = 1, 1
    if shape.tag == "rect":
        width, height, radius = size["width"], size["height"], size.get("rx", 0.0)

        def outline(wider: float, higher: float, rounder: float) -> FloatArray:
            sides = width + wider, height + higher
            rounding = min(sides) / 2 if 2 * radius >= min(width, height) else radius + rounder
            return rectangle_outline(0.0, 0.0, *sides, rounding, rounding)[0][:, :3]

        small = min(width, height, radius or 1.0) / 8
        steps = [(small, 0.0, 0.0), (0.0, small, 0.0), (0.0, 0.0, -small if radius else 0.0)]
        changes = [outline(*step) - outline(0.0, 0.0, 0.0) for step in steps]
    else:
        unit = ellipse_outline(0.0, 0.0, 1.0, 1.0)[0][:, :3]
        changes = [unit] if shape.tag == "circle" else [unit * (1.0, 0.0), unit * (0.0, 1.0)]
        turn = np.array(_TURN.findall(shape.attributes.get("transform", "")), dtype=float)
        if len(turn):
            angle = np.radians(turn[0])
            rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            changes = [change @ rotation for change in changes]
    every = np.array([*ones, *changes])
    sizes = np.abs(every).max(axis=(1, 2, 3), keepdims=True)
    return np.asarray((every / np.where(sizes, sizes, 1.0))[sizes.ravel() > 1e-9])
