# SPDX-License-Identifier: Apache-2.0
"""What an edited outline must stay under training: lines, level and plumb, smooth joins, circles, ellipses, rectangles.

All of it is read off the outlines themselves: a drawing that has lines keeps them.
"""

from __future__ import annotations

import dataclasses
import itertools
import re

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.svg.primitives import Primitive
from livecl.svg.shapes import ellipse_outline, rectangle_outline
from livecl.svg.writer import primitives

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.integer]
BoolArray = NDArray[np.bool_]

#: Length of a handle, px, from which on it is a join.
SHORT = 1e-3

_TURN = re.compile(r"rotate\((\S+)")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Slack:
    """How far an outline may be from what it is taken for.

    Attributes
    ----------
    straight, along : float
        Largest distance of a line's handles from it, px, and from its thirds along it, in its length.
    level : float
        Largest height of a level line, and width of a plumb one, px.
    tilt : float
        Sine up to which lines and smooth joins are level or plumb.
    turn : float
        Sine up to which a join is smooth.
    """

    straight: float
    along: float
    level: float
    tilt: float
    turn: float


#: What is exact but for rounding.
EXACT = Slack(straight=1e-6, along=1e-6, level=1e-6, tilt=1e-3, turn=1e-4)


class Joins:
    """Lines, level and plumb ones, and smooth joins of closed outlines.

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
        Sine of the angle at each anchor.
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
        self._groups = [_groups(self.lines & (np.abs(chords[:, axis]) <= limits), following) for axis in (0, 1)]
        self._before = np.empty(len(points), np.int64)
        self._before[following] = np.arange(len(points))
        into, out = self._steps(points)
        both = np.stack([np.hypot(*into.T), np.hypot(*out.T)])
        sine = np.abs(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]) / np.maximum(both.prod(axis=0), 1e-12)
        self.turns = sine
        smooth = rows & (both.min(axis=0) > SHORT) & (sine <= slack.turn)
        self.smooth = smooth & ((into * out).sum(axis=1) > 0) & ~(self.lines & self.lines[self._before])
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
        """Return the unit direction of travel at each smooth anchor of points (M, 3, 2): (M, 2)."""
        into, out = self._steps(points)
        along = np.where(self.lines[self._before, None], into, into + out)
        along = np.where(self.lines[:, None], out, along)
        along = np.where(self._axes, along, 0.0)
        return np.asarray(along / np.maximum(np.hypot(*along.T), 1e-12)[:, None])

    def hold(self, points: FloatArray) -> None:
        """Move points (M, 3, 2) to where lines are lines and smooth joins smooth."""
        for axis, groups in enumerate(self._groups):
            for members in groups:
                points[members, 0, axis] = points[members, 0, axis].mean()
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
    """Nearest points that keep a drawing's lines, joins and shapes.

    Parameters
    ----------
    drawing : Drawing
        Edited, not yet rounded.
    free : (N,) bool
        Layers that move; the others stay as they are.

    Attributes
    ----------
    points : (M, 3, 2) float64
        The drawing's points, shapes beginning where the reader lets them begin.
    """

    def __init__(self, drawing: Drawing, free: BoolArray) -> None:
        points = drawing.points.copy()
        rows = free[drawing.segment_layers]
        self._held = ~rows
        self._shapes = []
        for layer, shape in primitives(drawing, 9).items():
            if free[layer]:
                taken = slice(*drawing.segment_offsets[layer : layer + 2])
                points[taken], rows[taken] = shape.points, False
                self._shapes.append((taken, _projector(shape)))
        self.points = points
        self._joins = Joins(points, drawing.next_segments, rows)

    def held(self, points: FloatArray) -> FloatArray:
        """Return points (M, 3, 2) moved to where all constraints hold."""
        points = points.copy()
        points[self._held] = self.points[self._held]
        for rows, projector in self._shapes:
            points[rows] = (projector @ points[rows].reshape(-1)).reshape(-1, 3, 2)
        self._joins.hold(points)
        return points


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


def _projector(shape: Primitive) -> FloatArray:
    """Return the projection of an outline's numbers, (6 m, 6 m), onto the outlines of shapes of its kind.

    Outlines are linear in position, size and radius, an angle being given; so their differences span them.
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
    basis = np.array([*ones, *changes]).reshape(len(changes) + 2, -1).T
    return np.asarray(basis @ np.linalg.pinv(basis))
