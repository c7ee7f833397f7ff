# SPDX-License-Identifier: Apache-2.0
"""Read the strokes of an SVG element: pen, lines, dashes."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Mapping

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing.fills import MAX_COORDINATE
from livecl.geometry import bezier, cyclic
from livecl.geometry.strokes import CAPS, JOINS, Pens, outline_strokes
from livecl.svg import shapes
from livecl.svg.coordinates import Units, length_in_pixels
from livecl.svg.path_data import control_points, line_cubic, number_list, path_lines

#: Most dashes of one stroke.
MAX_DASHES = 10_000
#: Points of a cubic at which its length is measured for dashes.
LENGTH_STEPS = 64
#: Largest distance between a curve and the lines of an outline, px.
TOLERANCE = 0.01


@dataclasses.dataclass(frozen=True)
class Pen:
    """Width, px; cap and join (indices into CAPS and JOINS); miter limit; lengths of dashes and gaps, px."""

    width: float
    cap: int
    join: int
    miter_limit: float
    dashes: tuple[float, ...] = ()
    dash_offset: float = 0.0


@dataclasses.dataclass(frozen=True)
class Lines:
    """Subpaths (n, 4, 2) to be stroked, and whether each is open."""

    subpaths: list[FloatArray]
    is_open: list[bool]


def lines_of_shape(tag: str, own: Mapping[str, str], viewport: tuple[float, float], units: Units) -> Lines:
    """Return the lines that a shape's stroke follows, user units."""
    if tag == "path":
        return Lines(*path_lines(own.get("d", ""))[:2])
    if tag in ("polyline", "polygon"):
        numbers = number_list(own.get("points", ""))[0]
        corners = [complex(x, y) for x, y in zip(numbers[::2], numbers[1::2], strict=False)]
        if tag == "polygon" and corners:
            corners.append(corners[0])
        sides = [line_cubic(a, b) for a, b in itertools.pairwise(corners)]
        return Lines([control_points(sides)], [tag == "polyline"]) if sides else Lines([], [])
    if tag == "line":
        width, height = viewport
        x1, y1, x2, y2 = (
            length_in_pixels(own.get(name), 0.0, side, units)
            for name, side in (("x1", width), ("y1", height), ("x2", width), ("y2", height))
        )
        return Lines([control_points([line_cubic(complex(x1, y1), complex(x2, y2))])], [True])
    outline = shapes.shape_outline(tag, own, viewport, units)
    return Lines(outline, [False] * len(outline))


def pen_of(style: Mapping[str, str], viewport: tuple[float, float], units: Units) -> Pen | None:
    """Return the pen of a style, user units; None if it draws nothing."""
    diagonal = math.hypot(*viewport) / math.sqrt(2)
    width = length_in_pixels(style.get("stroke-width"), 1.0, diagonal, units)
    limit = number_list(style.get("stroke-miterlimit", "4"))[0]
    join = style.get("stroke-linejoin", "miter").lower()
    if width <= 0 or (limit and limit[0] < 1):
        return None
    return Pen(
        width,
        CAPS.index(style.get("stroke-linecap", "butt").lower()),
        JOINS.index(join if join in JOINS else "miter"),
        min(limit[0], 1e4) if limit else 4.0,
        _dashes(style.get("stroke-dasharray", "none"), diagonal, units),
        length_in_pixels(style.get("stroke-dashoffset"), 0.0, diagonal, units),
    )


def _dashes(text: str, diagonal: float, units: Units) -> tuple[float, ...]:
    """Return the alternating lengths of dashes and gaps; none for a solid line."""
    if text.strip().lower() == "none":
        return ()
    lengths = [length_in_pixels(part, 0.0, diagonal, units) for part in re.split(r"[\s,]+", text.strip()) if part]
    lengths *= 1 + len(lengths) % 2
    return tuple(lengths) if min(lengths, default=-1.0) >= 0 and any(lengths) else ()


def drawn(lines: Lines, pen: Pen, matrix: FloatArray, scaled: bool) -> tuple[Lines, Pen | None]:
    """Transform lines and pen to the canvas, and cut dashes.

    Parameters
    ----------
    lines : Lines
        User units.
    pen : Pen
        In user units, or in px if not `scaled`.
    matrix : (3, 3)
        From user units to px.
    scaled : bool
        Whether the transform acts on the stroke (not with ``vector-effect: non-scaling-stroke``).

    Returns
    -------
    Lines, Pen or None
        In px. If the transform stretches the stroke unevenly, there is no pen, and the lines are the stroke's outline.

    Raises
    ------
    ValueError
        If lines are too far away for a drawing.
    """
    if not scaled:
        lines = dataclasses.replace(lines, subpaths=shapes.transformed(lines.subpaths, matrix))
        return (dashed(lines, pen) if pen.dashes else lines), pen
    lines = dashed(lines, pen) if pen.dashes else lines
    largest, smallest = np.linalg.svd(matrix[:2, :2], compute_uv=False)
    if largest - smallest <= 1e-6 * largest:
        pen = dataclasses.replace(pen, width=pen.width * float(largest), dashes=())
        return dataclasses.replace(lines, subpaths=shapes.transformed(lines.subpaths, matrix)), pen
    ends = shapes.transformed(lines.subpaths, matrix)
    if not all((np.abs(subpath) <= MAX_COORDINATE).all() for subpath in ends):  # before millions of lines are made
        raise ValueError(f"points: all numbers must be finite and within [{-MAX_COORDINATE:g}, {MAX_COORDINATE:g}]")
    outline = shapes.transformed(outlined(lines, pen, TOLERANCE / max(float(largest), 1e-9)), matrix)
    if np.linalg.det(matrix[:2, :2]) < 0:
        outline = [subpath[::-1, ::-1] for subpath in outline]
    return Lines(outline, [False] * len(outline)), None


def outlined(lines: Lines, pen: Pen, tolerance: float) -> list[FloatArray]:
    """Return the outline of a stroke: polygons of straight cubics."""
    vertices, smooth, counts = [np.zeros((0, 2))], [np.zeros(0, bool)], []
    for cubics, is_open in zip(lines.subpaths, lines.is_open, strict=True):
        pieces = bezier.pieces_for(cubics, tolerance) * 2
        t = [np.arange(count) / count for count in pieces]
        points = [bezier.evaluate(cubic, own) for cubic, own in zip(cubics, t, strict=True)]
        vertices += [*points, cubics[-1:, 3]] if is_open else points
        smooth += [*(own > 0 for own in t), np.zeros(int(is_open), bool)]
        counts.append(int(pieces.sum()) + is_open)
    outlines = outline_strokes(
        np.concatenate(vertices),
        np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]),
        Pens(pen.width, pen.cap, pen.join, pen.miter_limit),
        closed=~np.array(lines.is_open),
        smooth=np.concatenate(smooth),
        tolerance=tolerance,
    )
    polygons = np.split(outlines.points, outlines.loop_offsets[1:-1]) if len(outlines.points) else []
    return [np.stack([a, a + (b - a) / 3, b - (b - a) / 3, b], 1) for a in polygons for b in [cyclic.following(a)]]


def dashed(lines: Lines, pen: Pen) -> Lines:
    """Cut lines into dashes, beginning at each subpath's start; those that meet at a closed one's start are joined.

    Raises ValueError if there are more than MAX_DASHES.
    """
    dashes: list[FloatArray] = []
    for cubics, is_open in zip(lines.subpaths, lines.is_open, strict=True):
        t = np.linspace(0, 1, LENGTH_STEPS + 1)
        steps = np.linalg.norm(np.diff(bezier.evaluate(cubics, t), axis=1), axis=2)
        places = np.concatenate([[0], np.cumsum(steps)])
        if places[-1] / (sum(pen.dashes) / len(pen.dashes)) > MAX_DASHES:
            raise ValueError(f"more than {MAX_DASHES} dashes")
        parameters = np.append((np.arange(len(cubics))[:, None] + t[:-1]).ravel(), len(cubics))
        at = -(pen.dash_offset % sum(pen.dashes))
        num_before, is_on = len(dashes), [False, False]  # at the start and at the end
        for number, length in zip(range(2 * MAX_DASHES), itertools.cycle(pen.dashes), strict=False):
            if at >= places[-1]:
                break
            if number % 2 == 0 and at + length >= 0:
                ends = np.interp([max(at, 0), min(at + length, places[-1])], places, parameters)
                dashes.append(_between(cubics, *ends))
                is_on = [is_on[0] or at <= 0, at + length >= places[-1]]
            at += length
        if not is_open and all(is_on) and len(dashes) - num_before > 1:
            dashes[num_before] = np.concatenate([dashes.pop(), dashes[num_before]])
    return Lines(dashes, [True] * len(dashes))


def _between(cubics: FloatArray, begin: float, end: float) -> FloatArray:
    """Return the cubics of a subpath between two parameters, each the index of a cubic plus a parameter on it."""
    first, last = min(int(begin), len(cubics) - 1), max(min(math.ceil(end), len(cubics)) - 1, int(begin))
    numbers = np.arange(first, min(last, len(cubics) - 1) + 1)
    return bezier.subsegment(cubics[numbers], np.clip(begin - numbers, 0, 1), np.clip(end - numbers, 0, 1))
