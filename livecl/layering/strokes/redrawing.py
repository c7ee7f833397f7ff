# SPDX-License-Identifier: Apache-2.0
"""Redraw trained strokes with fewer nodes: join lines whose ends meet, and fit curves of the fewest segments.

A line traced on a skeleton has nodes where its course was uncertain: at crossings, round corners, the start of a loop.
After training its course is known to a tenth of a pixel, and corners are where its direction breaks.
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.assembly import outlines_of, with_outlines
from livecl.drawing.drawing import Drawing
from livecl.geometry import cyclic
from livecl.geometry.bezier import cross, evaluate, meeting_point
from livecl.geometry.open_fitting import segment_along
from livecl.geometry.polylines import lengths_along, points_at
from livecl.layering.componentwise.candidates import SEGMENT_ERROR
from livecl.layering.context import Context

#: Largest distances, px, between a trained line and the redrawn one, tried in this order.
TOLERANCES = (0.2, 0.4, 0.8)
#: Least turn, radians, for two ends to meet in a corner; below it, one continues the other.
MIN_TURN = 0.35
#: Largest distance, in widths, between two ends that meet, and between them and their corner.
REACH = 1.0
#: The same for a line whose end overshoots its beginning, into a corner's tip.
TAIL = 4.0
#: Lengths, in widths, by which a line is longer without a hook at its end: it may end beneath another line.
LONGER = (0.0, 0.5, 1.0)
#: Rounds of reparametrization of the points along a chosen segment.
ROUNDS = 30
#: Share of the error added by a change that remains after training, as for editable outlines.
LEFT = 0.6
#: Samples of a cubic; most cubics replaced by one.
SAMPLES, SPAN = 24, 4


@dataclasses.dataclass(frozen=True)
class _Line:
    """Course of a line as a polyline (n, 2); if closed, the first point is repeated at the end."""

    points: FloatArray
    closed: bool

    def reversed(self) -> _Line:
        """Return the line in the opposite direction."""
        return _Line(self.points[::-1], self.closed)


def redrawn(context: Context, drawing: Drawing) -> Drawing:
    """Redraw strokes with fewer nodes; return the same object if none changes.

    Ends that meet are joined, the nearest first; then each line is redrawn with fewer segments, and without hooks at
    its ends, as where it meets another line, and the shortest lines are removed. A change is made if the nodes saved
    are worth the error added, of which training leaves a part.
    """
    found = drawing
    for layer in drawing.strokes.stroked_layers.tolist():
        subpaths = range(*drawing.layer_offsets[layer : layer + 2])
        parts = [drawing.subpaths()[subpath] for subpath in subpaths]
        opened = drawing.strokes.is_open[subpaths.start : subpaths.stop].tolist()
        lines = [_line_of(drawing.cubics[part], gap) for part, gap in zip(parts, opened, strict=True)]
        rows = [drawing.points[part] for part in parts]
        found = _Redrawing(context, layer, float(drawing.strokes.widths[layer]), lines, rows).of(found)
    return found


@dataclasses.dataclass
class _Redrawing:
    """The lines of one layer while they are joined, and the rows (s, 3, 2) that draw each of them."""

    context: Context
    layer: int
    width: float
    lines: list[_Line]
    rows: list[FloatArray]

    def of(self, drawing: Drawing) -> Drawing:
        """Return the drawing with the layer redrawn."""
        refused: set[tuple[bytes, bytes]] = set()
        while True:
            pairs = [pair for pair in _meetings(self.lines, self.width) if pair.key not in refused]
            if not pairs:
                break
            pair = min(pairs, key=lambda pair: pair.gap)
            lines, rows = self._without(pair.ends)
            changed = self._tried(drawing, [*lines, pair.line], [*rows, _rows_of(pair.line)])
            if changed is drawing:
                refused.add(pair.key)
            drawing = changed
        for tolerance in TOLERANCES:
            for index, line in enumerate(self.lines):
                interruption.check()
                fewer = _rows_of(line, tolerance)
                if len(fewer) < len(self.rows[index]):
                    drawing = self._tried(drawing, self.lines, [*self.rows[:index], fewer, *self.rows[index + 1 :]])
        for first, index, longer in itertools.product((True, False), range(len(self.rows)), LONGER):
            if not self.lines[index].closed and len(self.rows[index]) > 3:
                straight = _without_hook(self.rows[index], first, longer * self.width)
                rows = [*self.rows[:index], straight, *self.rows[index + 1 :]]
                drawing = self._tried(drawing, self.lines, rows)
        for own in sorted(self.rows, key=_extent):
            index = next(index for index, rows in enumerate(self.rows) if rows is own)
            if len(self.rows) > 1:
                drawing = self._tried(drawing, *self._without((index, index)))
        return drawing

    def _without(self, ends: tuple[int, int]) -> tuple[list[_Line], list[FloatArray]]:
        """Return lines and rows without two of them."""
        kept = [index for index in range(len(self.lines)) if index not in ends]
        return [self.lines[index] for index in kept], [self.rows[index] for index in kept]

    def _tried(self, drawing: Drawing, lines: list[_Line], rows: list[FloatArray]) -> Drawing:
        """Return the drawing with other lines, and adopt these, if that costs less; else the drawing unchanged."""
        interruption.check()
        changed = _with_lines(drawing, self.layer, lines, rows)
        rise = self.context.priced_error(changed) - self.context.priced_error(drawing)
        saved = drawing.num_segments - changed.num_segments
        if LEFT * rise >= saved * SEGMENT_ERROR:
            return drawing
        self.lines, self.rows = lines, rows
        return changed


def _with_lines(drawing: Drawing, layer: int, lines: list[_Line], rows: list[FloatArray]) -> Drawing:
    """Return a drawing with other lines in one layer."""
    outlines = outlines_of(drawing)
    outlines[layer] = rows
    first, last = drawing.layer_offsets[layer : layer + 2]
    strokes = drawing.strokes
    before, after = strokes.is_open[:first], strokes.is_open[last:]
    pens = dataclasses.replace(strokes, is_open=np.concatenate([before, [not line.closed for line in lines], after]))
    return with_outlines(drawing, outlines, strokes=pens)


def _line_of(cubics: FloatArray, is_open: bool) -> _Line:
    """Return the course of a trained line; a closed one starts at its sharpest turn."""
    cubics = cubics[:-1] if is_open else cubics
    sampled = [evaluate(cubic, np.linspace(0, 1, SAMPLES, endpoint=False)) for cubic in cubics]
    if is_open:
        return _Line(np.concatenate([*sampled, cubics[-1:, 3]]), closed=False)
    turns = [_turn(one, other) for one, other in zip(cyclic.preceding(cubics), cubics, strict=True)]
    start = int(np.argmax(turns))
    return _Line(np.concatenate([*sampled[start:], *sampled[:start], cubics[start : start + 1, 0]]), closed=True)


def _turn(before: FloatArray, after: FloatArray) -> float:
    """Return the angle, radians, between the directions of two consecutive cubics at their joint."""
    u, v = _direction(before[::-1]), _direction(after)
    return float(np.abs(np.arctan2(-u[0] * v[1] + u[1] * v[0], -u @ v)))


def _direction(points: FloatArray) -> FloatArray:
    """Return the unit tangent of a polyline at its first point; 0 if all points coincide."""
    steps = points - points[0]
    lengths = np.hypot(*steps.T)
    away = int(np.argmax(lengths > 1e-3 * max(float(lengths.max()), 1e-9)))
    return np.asarray(steps[away] / max(float(lengths[away]), 1e-12))


@dataclasses.dataclass(frozen=True)
class _Pair:
    """Two ends that meet, of lines by index, or of one line: their distance, px, and the joined line."""

    gap: float
    ends: tuple[int, int]
    line: _Line
    key: tuple[bytes, bytes]


def _meetings(lines: list[_Line], width: float) -> list[_Pair]:
    """Return the pairs of ends that meet, of lines of a width, px."""
    ends = [(index, at) for index, line in enumerate(lines) if not line.closed for at in (0, 1)]
    pairs = []
    for (i, one), (j, other) in itertools.combinations(ends, 2):
        first = lines[i] if one else lines[i].reversed()  # it ends where
        second = lines[j].reversed() if other else lines[j]  # this one begins
        corner = _meeting(first.points, second.points, REACH * width)
        if corner is None or (i == j and len(first.points) < 2 * SAMPLES):
            continue
        if i == j:
            line = _Line(np.concatenate([[corner], first.points[1:-1], [corner]]), closed=True)
        else:
            line = _Line(np.concatenate([first.points[:-1], [corner], second.points[1:]]), closed=False)
        gap = float(np.hypot(*(first.points[-1] - second.points[0])))
        pairs.append(_Pair(gap, (i, j), line, (first.points[-1].tobytes(), second.points[0].tobytes())))
    for index, line in enumerate(lines):
        for own in (line, line.reversed()) if not line.closed else ():
            whole = _without_tail(own.points, width)
            if whole is not None:
                pairs.append(_Pair(TAIL * width, (index, index), whole, (own.points[-1].tobytes(), b"")))
    return pairs


def _without_tail(points: FloatArray, width: float) -> _Line | None:
    """Close a line whose end overshoots its beginning, into a corner's tip; None for others.

    Bends within a width of the corner are ignored. Nodes stay `SAMPLES` points apart.
    """
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    last = lengths > max(lengths[-1] - TAIL * width, 3 * TAIL * width)
    if not last.any():
        return None
    away = np.hypot(*(points - points[0]).T) + np.where(last, 0, np.inf)
    kept = np.flatnonzero((lengths >= width) & (lengths <= lengths[int(np.argmin(away))] - width))
    corner = _meeting(points[kept], points[kept], TAIL * width) if away.min() <= width / 2 else None
    if corner is None:
        return None
    start, end = -(-kept[0] // SAMPLES) * SAMPLES, kept[-1] // SAMPLES * SAMPLES
    first = _evenly(np.concatenate([[corner], points[kept[0] : start + 1]]))
    rest = _evenly(np.concatenate([points[end : kept[-1] + 1], [corner]]))
    return _Line(np.concatenate([first[:-1], points[start:end], rest]), closed=True)


def _evenly(points: FloatArray) -> FloatArray:
    """Resample a polyline (n, 2) at even steps: (SAMPLES + 1, 2)."""
    lengths = lengths_along(points)
    return points_at(np.linspace(0, lengths[-1], SAMPLES + 1), points, lengths)


def _meeting(first: FloatArray, second: FloatArray, reach: float) -> FloatArray | None:
    """Return the corner where the end of one polyline and the beginning of another meet; None if they do not."""
    end, begin = first[-1], second[0]
    if np.hypot(*(end - begin)) > reach:
        return None
    u, v = -_direction(first[::-1]), _direction(second)
    middle = (end + begin) / 2
    if abs(cross(u, v)) < np.sin(MIN_TURN):
        return middle if u @ v > 0 else None
    corner = meeting_point(end, u, begin, v)
    return corner if np.hypot(*(corner - middle)) <= reach else None


def _without_hook(rows: FloatArray, first: bool, longer: float) -> FloatArray:
    """Return an open line whose first or last two segments are a straight one, longer than both by a length, px."""
    anchors = rows[:, 0] if first else rows[::-1, 0]
    hook, side = (float(np.hypot(*step)) for step in np.diff(anchors[:3], axis=0))
    end = anchors[1] + (anchors[1] - anchors[2]) * (hook + longer) / max(side, 1e-9)
    a, b = (end, anchors[2]) if first else (anchors[2], end)
    straight = np.stack([a, a + (b - a) / 3, b - (b - a) / 3])[None]
    if first:
        return np.concatenate([straight, rows[2:]])
    return np.concatenate([rows[:-3], straight, np.broadcast_to(b, (1, 3, 2))])


def _extent(rows: FloatArray) -> float:
    """Return the size of the box around a line's control points, px."""
    return float(np.ptp(rows.reshape(-1, 2), axis=0).max())


def _rows_of(line: _Line, tolerance: float = TOLERANCES[0]) -> FloatArray:
    """Return the rows of the fewest segments along a line; the last row of an open one is its end.

    Segments begin and end at nodes, or at quarters between two nodes. A segment across a corner exceeds the tolerance.
    """
    points = line.points
    places = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    stops = range(0, len(points), SAMPLES // 4)
    best: list[tuple[float, float, int]] = [(0, 0.0, -1)]
    for j in range(1, len(stops)):
        interruption.check()
        options: list[tuple[float, float, int]] = []
        for i in range(max(0, j - 4 * SPAN), j):
            if options and best[i][0] + 1 > min(options)[0]:
                continue  # more segments than from a place before
            part = slice(stops[i], stops[j] + 1)
            _, miss, squares = segment_along(points[part], places[part])
            if miss <= tolerance or j == i + 1:
                options.append((best[i][0] + 1, best[i][1] + squares, i))
        best.append(min(options))
    rows, at = [] if line.closed else [np.broadcast_to(points[-1], (3, 2))], len(stops) - 1
    while at > 0:
        part = slice(stops[best[at][2]], stops[at] + 1)
        rows.append(segment_along(points[part], places[part], ROUNDS)[0])
        at = best[at][2]
    return np.array(rows[::-1])
