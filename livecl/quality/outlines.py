# SPDX-License-Identifier: Apache-2.0
"""Outline scores: agreement of a drawing's nodes, lines and shapes with those of the true drawing.

The outlines of matched things (livecl/quality/things.py) are compared where the picture shows them: where no layer
above covers them, and the colours on both sides differ.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import BoolArray, FloatArray
from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.editing.shapes import shape_within
from livecl.geometry import cyclic
from livecl.geometry.bezier import cross, flatten
from livecl.geometry.polylines import lengths_along, points_at, unit
from livecl.quality.things import FOUND, INSIDE, MISSED, Things, match_things, things_of_drawing
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg.primitives import primitive_of

#: Largest turn of a smooth join, least turn of a corner, and least turn of a curve that counts as a corner, degrees.
SMOOTH, CORNER, TIGHT = 2.0, 20.0, 90.0
#: Largest distance, px, of a kept corner, and of a line from its side; largest angle between these, degrees; and
#: distance, px, within which joins belong to a true corner.
NEAR, ALIGNED, APART = 0.5, 3.0, 1.5
#: Length of the shortest side that counts, px; largest distance of a line's handles from it, px; and least share of a
#: side's places that are visible, and that lie on lines.
SHORTEST, STRAIGHT, ENOUGH = 3.0, 1e-3, 0.75
#: Length, px, of negligible segments of the true outline, whose ends count as one node; reach about a corner, px, that
#: must be visible for it to count.
UNSEEN, ARM = 0.25, 2.5
#: Visibility of outlines: scale of the picture, distance of the points compared on both sides, px, and least difference
#: between them in a channel.
SCALE, ASIDE, SHOWN = 4, 0.5, 0.02
#: Largest distance, px, between outlines of the same edge.
SAME_EDGE = 1.0
#: Largest distance of a true outline from its circle, ellipse or rectangle, px; decimals for those of the drawing.
SAME_SHAPE, PRECISION = 0.1, 9
#: Distance between places of an outline, px.
STEP = 0.5
#: Counts of found things that are taken of all things, too: their names there.
OF_ALL = {
    "joins": "joins_all",
    "joins_smooth": "joins_all_smooth",
    "corners": "corners_all",
    "corners_kept": "corners_all_kept",
    "sides": "sides_all",
    "sides_straight": "sides_all_straight",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class OutlineScores:
    """Agreement of a drawing's outlines with those of a true one.

    Attributes
    ----------
    shapes, shapes_found, shapes_drawn : int
        True things that are circles, ellipses or upright (rounded) rectangles; those of them that are matched; and
        those that are written as the same element.
    shapes_written, shapes_false : int
        Such elements written for matched things, and those whose match is no such shape.
    joins, joins_smooth : int
        Joins of found things' cubics and lines within half a pixel of the true outline where that is smooth and turns
        by less than a right angle within 3 px; and those that turn by 2 degrees or less.
    corners, corners_kept : int
        Visible corners of the true things that are found, and those with a corner of the drawing within half a pixel.
    sides, sides_straight : int
        Visible straight sides of the true things that are found, and those along which the drawing has lines.
    joins_all, joins_all_smooth, corners_all, corners_all_kept, sides_all, sides_all_straight : int
        The same of all things, found or not: joins of all that are matched; corners and sides of all true things, kept
        by any outline of the drawing.
    level, level_exact : int
        Of these, horizontal and vertical sides of the true drawing that are lines in the other; and those that are
        exactly horizontal or vertical there.
    edge, edge_missed, displacement : float
        Length of the visible true outlines, px; the part farther than a pixel from the drawing's outlines; and the mean
        distance of the rest, px, 0 if there is none.
    """

    shapes: int
    shapes_found: int
    shapes_drawn: int
    shapes_written: int
    shapes_false: int
    joins: int
    joins_smooth: int
    corners: int
    corners_kept: int
    sides: int
    sides_straight: int
    joins_all: int
    joins_all_smooth: int
    corners_all: int
    corners_all_kept: int
    sides_all: int
    sides_all_straight: int
    level: int
    level_exact: int
    edge: float
    edge_missed: float
    displacement: float


def score_outlines(true: Drawing, drawing: Drawing) -> OutlineScores:
    """Score a drawing's outlines by those of the drawing that its picture was made from.

    Parameters
    ----------
    true : Drawing
        The original drawing; it is stretched to `drawing`'s canvas.
    drawing : Drawing
        Drawing made from the picture alone, as saved.
    """
    true, rasterizer = scaled(true, drawing.size), Rasterizer(drawing.size)
    things, ours = things_of_drawing(true, rasterizer=rasterizer), things_of_drawing(drawing, rasterizer=rasterizer)
    overlap, partner = match_things(things, ours)
    covers, picture = rasterizer.coverages(true) >= INSIDE, _picture(true)
    counts: dict[str, Any] = dict.fromkeys((field.name for field in dataclasses.fields(OutlineScores)), 0)
    distances: list[FloatArray] = []
    every = [drawing.cubics[rows] for layer in range(drawing.num_layers) for rows in drawing.subpaths(layer)]
    whole = _Outline(every) if every else None
    for k in range(len(things)):
        subpaths = _subpaths(true, things, k)
        shape = _shape_within(subpaths)
        counts["shapes"] += shape is not None
        uncovered = np.logical_not(covers[int(things.layers[k]) + 1 :].any(axis=0))
        if subpaths and whole is not None:
            anyone = _Pair(_Outline(subpaths, UNSEEN), whole, uncovered, picture)
            _add(counts, {**anyone.corners(), **anyone.sides()}, OF_ALL)
        if overlap[k] < MISSED:
            continue
        own = _subpaths(drawing, ours, int(partner[k]))
        written = _written(own)
        counts["shapes_written"] += written is not None
        counts["shapes_false"] += written is not None and written != shape
        pair = _Pair(_Outline(subpaths, UNSEEN), _Outline(own), uncovered, picture) if subpaths and own else None
        if pair is not None:
            _add(counts, pair.joins(), OF_ALL)
        if overlap[k] < FOUND:
            continue
        counts["shapes_found"] += shape is not None
        counts["shapes_drawn"] += shape is not None and written == shape
        if pair is not None:
            _add(counts, {**pair.joins(), **pair.corners(), **pair.sides()})
            distances.append(pair.distances())
    gaps = np.concatenate([np.zeros(0), *distances])
    near = gaps[gaps <= SAME_EDGE]
    counts["edge"], counts["edge_missed"] = len(gaps) * STEP, (len(gaps) - len(near)) * STEP
    counts["displacement"] = float(near.mean()) if len(near) else 0.0
    return OutlineScores(**counts)


def _add(counts: dict[str, Any], found: dict[str, int], names: dict[str, str] | None = None) -> None:
    """Add what was found to the counts; with names, only what has one there, under that."""
    for name, count in found.items():
        key = name if names is None else names.get(name)
        if key is not None:
            counts[key] += count


def _picture(drawing: Drawing) -> NDArray[Any]:
    """Render a drawing at SCALE times its size."""
    size = SCALE * drawing.size[0], SCALE * drawing.size[1]
    return Rasterizer(size).forward(scaled(drawing, size))


def _subpaths(drawing: Drawing, things: Things, thing: int) -> list[FloatArray]:
    """Return the subpaths, (m, 4, 2) cubics each, that run along a thing of a drawing."""
    from scipy.ndimage import binary_dilation

    wide = binary_dilation(things.masks[thing], iterations=2)
    found = []
    for rows in drawing.subpaths(int(things.layers[thing])):
        cubics = drawing.cubics[rows]
        columns, lines = np.floor(flatten(cubics, 0.1).corners).astype(np.int64).T
        height, width = wide.shape
        near = wide[np.clip(lines, 0, height - 1), np.clip(columns, 0, width - 1)]
        if near.mean() > 0.5:
            found.append(cubics)
    return found


def _shape_within(subpaths: list[FloatArray]) -> str | None:
    """Return the kind of shape of a true outline, however it is written; None if it is none."""
    if len(subpaths) != 1:
        return None
    shape = shape_within(_places(subpaths[0])[0], SAME_SHAPE)
    return None if shape is None else shape.tag


def _written(subpaths: list[FloatArray]) -> str | None:
    """Return the element as which an outline is written, None for a path."""
    shape = primitive_of(subpaths[0][:, :3], PRECISION) if len(subpaths) == 1 else None
    return None if shape is None else shape.tag


def _places(cubics: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points at steps of STEP px along a closed subpath, and its polyline: (n, 2), (p, 2)."""
    corners = flatten(cubics, 0.002).corners
    closed = np.concatenate([corners, corners[:1]])
    lengths = lengths_along(closed)
    return points_at(np.arange(0, lengths[-1], STEP), closed, lengths), closed


class _Outline:
    """Joins, lines and places of a thing's subpaths, without segments up to a length, px."""

    def __init__(self, subpaths: list[FloatArray], shortest: float = 1e-6) -> None:
        parts = [_whole_segments(cubics, shortest) for cubics in subpaths]
        cubics = np.concatenate(parts)
        before = np.concatenate([cyclic.preceding(part) for part in parts])
        self.anchors = cubics[:, 0]
        after, into = _first_step(cubics), _first_step(before[:, ::-1])
        cosine = -(after * into).sum(axis=1)
        sine = cross(after, into)
        self.turns = np.degrees(np.abs(np.arctan2(sine, cosine)))
        way = unit(cubics[:, 3] - cubics[:, 0])
        rest = cubics[:, 1:3] - cubics[:, :1]
        off = np.abs(cross(rest, way[:, None])).max(axis=1)
        self.lines = cubics[off <= STRAIGHT][:, [0, 3]]
        places, self.polylines = zip(*map(_places, subpaths), strict=True)
        self.tight = np.concatenate([_tight(part) for part in places])
        self.places = np.concatenate(places)
        self.ways = np.concatenate([unit(cyclic.following(part) - cyclic.preceding(part)) for part in places])

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the distances of points (n, 2) from the outline, px: (n,)."""
        lines = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in self.polylines])
        return np.concatenate([np.zeros(0), *(_from_lines(part, lines).min(axis=1) for part in _parts(points))])


def _tight(places: FloatArray) -> FloatArray:
    """Return the places (n, 2) of a closed subpath that turns by TIGHT or more within APART before and after them."""
    steps = (cyclic.following(places) - places) @ (1, 1j)
    angles = np.angle(steps / np.where(cyclic.preceding(steps) == 0, 1, cyclic.preceding(steps)))
    reach = round(APART / STEP)
    turn = np.sum([np.roll(angles, shift) for shift in range(-reach, reach + 1)], axis=0)
    return places[np.abs(turn) >= np.radians(TIGHT)]


def _whole_segments(cubics: FloatArray, shortest: float) -> FloatArray:
    """Return the cubics of a subpath that are longer than a length, px."""
    kept = cubics[np.abs(cubics - cubics[:, :1]).max(axis=(1, 2)) > shortest]
    return kept if len(kept) else cubics


def _first_step(cubics: FloatArray) -> FloatArray:
    """Return the unit direction at the start of each cubic (m, 4, 2): (m, 2)."""
    steps = cubics[:, 1:] - cubics[:, :1]
    lengths = np.hypot(*np.moveaxis(steps, -1, 0))
    first = np.argmax(lengths > 1e-4, axis=1)
    rows = np.arange(len(cubics))
    return np.asarray(steps[rows, first] / np.maximum(lengths[rows, first], 1e-12)[:, None])


def _parts(points: FloatArray) -> list[FloatArray]:
    return [points[k : k + 256] for k in range(0, len(points), 256)]


def _from_lines(points: FloatArray, lines: FloatArray) -> FloatArray:
    """Return the distance of each point (n, 2) from each line (m, 2, 2), px: (n, m)."""
    start, step = lines[:, 0], lines[:, 1] - lines[:, 0]
    rest = points[:, None] - start
    share = np.clip((rest * step).sum(-1) / np.maximum((step * step).sum(-1), 1e-18), 0, 1)
    return np.asarray(np.hypot(*np.moveaxis(rest - share[..., None] * step, -1, 0)))


class _Pair:
    """A thing of the true drawing and the one found for it."""

    def __init__(self, true: _Outline, ours: _Outline, uncovered: BoolArray, picture: NDArray[Any]) -> None:
        self._true, self._ours, self._uncovered, self._picture = true, ours, uncovered, picture
        self._places_shown = self._shown(true.places, true.ways)

    def _shown(self, points: FloatArray, ways: FloatArray) -> BoolArray:
        """Return which points (n, 2) of directions (n, 2) are uncovered, with different colours on both sides: (n,)."""
        height, width = self._uncovered.shape
        columns, rows = np.floor(points).astype(np.int64).T
        inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
        inside &= self._uncovered[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
        across = ASIDE * np.stack([-ways[:, 1], ways[:, 0]], axis=1)
        columns, rows = (
            np.floor(SCALE * np.stack([points + across, points - across])).astype(np.int64).transpose(2, 0, 1)
        )
        sides = self._picture[np.clip(rows, 0, SCALE * height - 1), np.clip(columns, 0, SCALE * width - 1)]
        return np.asarray(inside & (np.abs(sides[0] - sides[1]).max(axis=-1) >= SHOWN))

    def joins(self) -> dict[str, int]:
        """Count the drawing's joins where the true outline is smooth and turns by less than 90 degrees within 3 px."""
        bends = np.concatenate([self._true.anchors[self._true.turns > SMOOTH], self._true.tight])
        gaps = np.hypot(*np.moveaxis(self._ours.anchors[:, None] - bends, -1, 0)).min(axis=1, initial=np.inf)
        turns = self._ours.turns[(gaps > APART) & (self._true.distances(self._ours.anchors) <= NEAR)]
        return {"joins": len(turns), "joins_smooth": int(np.count_nonzero(turns <= SMOOTH))}

    def corners(self) -> dict[str, int]:
        """Count the visible true corners: most of the outline about them is visible."""
        points = self._true.anchors[self._true.turns >= CORNER]
        arms = np.hypot(*np.moveaxis(points[:, None] - self._true.places, -1, 0)) <= ARM
        points = points[(arms & self._places_shown).sum(axis=1) >= ENOUGH * np.maximum(arms.sum(axis=1), 1)]
        bends = self._ours.anchors[self._ours.turns >= CORNER / 2]
        gaps = np.hypot(*np.moveaxis(points[:, None] - bends, -1, 0)).min(axis=1, initial=np.inf)
        return {"corners": len(points), "corners_kept": int(np.count_nonzero(gaps <= NEAR))}

    def sides(self) -> dict[str, int]:
        """Count the visible straight sides of the true outline."""
        counts = dict.fromkeys(("sides", "sides_straight", "level", "level_exact"), 0)
        steps = self._ours.lines[:, 1] - self._ours.lines[:, 0]
        for start, end in self._true.lines:
            chord = end - start
            length = np.hypot(*chord)
            at = start + chord * np.linspace(0.15, 0.85, 8)[:, None]
            ways = np.broadcast_to(chord / max(length, 1e-12), at.shape)
            if length < SHORTEST or self._shown(at, ways).mean() < ENOUGH:
                continue
            counts["sides"] += 1
            sine = np.abs(steps[:, 0] * chord[1] - steps[:, 1] * chord[0])
            along = sine <= np.sin(np.radians(ALIGNED)) * np.hypot(*steps.T) * length
            if not along.any():
                continue
            gaps = _from_lines(at, self._ours.lines[along])
            straight = bool((gaps.min(axis=1) <= NEAR).mean() >= ENOUGH)
            counts["sides_straight"] += straight
            if straight and np.abs(chord).min() <= STRAIGHT:
                nearest = steps[along][int(np.argmin(gaps.mean(axis=0)))]
                counts["level"] += 1
                counts["level_exact"] += bool(np.abs(nearest).min() <= 1e-9)
        return counts

    def distances(self) -> FloatArray:
        """Return the distances of the true outline's visible places from the drawing's outline, px."""
        return self._ours.distances(self._true.places[self._places_shown])
