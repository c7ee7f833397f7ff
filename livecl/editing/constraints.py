# SPDX-License-Identifier: Apache-2.0
"""What an edited outline must stay under training: lines, level and plumb, smooth joins, circles, ellipses, rectangles.

All of it is read off the outlines themselves: a drawing that has lines keeps them.
"""

from __future__ import annotations

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

#: How far handles may be from the thirds of a line, px; sine up to which a join is smooth; length of a handle, px, from
#: which on it is a join.
STRAIGHT, SMOOTH, SHORT = 1e-6, 1e-4, 1e-3


_TURN = re.compile(r"rotate\((\S+)")


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
        points, self._next = drawing.points.copy(), drawing.next_segments
        rows = free[drawing.segment_layers]
        self._held = ~rows
        self._shapes = []
        for layer, shape in primitives(drawing, 9).items():
            if free[layer]:
                taken = slice(*drawing.segment_offsets[layer : layer + 2])
                points[taken], rows[taken] = shape.points, False
                self._shapes.append((taken, _projector(shape)))
        self.points = points
        ends = points[self._next, 0]
        thirds = points[:, :1] + (ends - points[:, 0])[:, None] * (np.array([[1.0], [2.0]]) / 3)
        chord = np.abs(ends - points[:, 0])
        self._lines = rows & (np.abs(points[:, 1:] - thirds).max(axis=(1, 2)) <= STRAIGHT) & (chord.max(axis=1) > SHORT)
        self._groups = [_groups(self._lines & (chord[:, axis] <= STRAIGHT), self._next) for axis in (0, 1)]
        self._before = np.empty(len(points), np.int64)
        self._before[self._next] = np.arange(len(points))
        into, out = self._directions(points)
        lengths = np.minimum(np.hypot(*into.T), np.hypot(*out.T))
        sine = np.abs(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0])
        smooth = rows & (lengths > SHORT) & (sine <= SMOOTH * np.hypot(*into.T) * np.hypot(*out.T))
        smooth &= ((into * out).sum(axis=1) > 0) & ~(self._lines & self._lines[self._before])
        self._smooth = np.flatnonzero(smooth)
        self._axes = np.abs(into + out) > SHORT * np.abs(into + out).max(axis=1, keepdims=True)  # else level or plumb

    def _directions(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the steps from the handle before each anchor to it, and on to the handle after it: (M, 2) each."""
        return points[:, 0] - points[self._before, 2], points[:, 1] - points[:, 0]

    def held(self, points: FloatArray) -> FloatArray:
        """Return points (M, 3, 2) moved to where all constraints hold."""
        points = points.copy()
        points[self._held] = self.points[self._held]
        for rows, projector in self._shapes:
            points[rows] = (projector @ points[rows].reshape(-1)).reshape(-1, 3, 2)
        for axis, groups in enumerate(self._groups):
            for members in groups:
                points[members, 0, axis] = points[members, 0, axis].mean()
        into, out = self._directions(points)
        line_in, line_out = self._lines[self._before], self._lines
        ends = points[self._next, 0]
        along = np.where(line_in[:, None], points[:, 0] - points[self._before, 0], into + out)
        along = np.where(line_out[:, None], ends - points[:, 0], along)
        along = np.where(self._axes, along, 0.0)
        along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
        k = self._smooth
        before = self._before[k]
        lengths_in, lengths_out = ((step[k] * along[k]).sum(axis=1, keepdims=True) for step in (into, out))
        free_in, free_out = ~line_in[k], ~line_out[k]
        points[before[free_in], 2] = (points[k, 0] - np.maximum(lengths_in, SHORT) * along[k])[free_in]
        points[k[free_out], 1] = (points[k, 0] + np.maximum(lengths_out, SHORT) * along[k])[free_out]
        lines = self._lines
        step = (ends - points[:, 0])[lines]
        points[lines, 1], points[lines, 2] = points[lines, 0] + step / 3, ends[lines] - step / 3
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
