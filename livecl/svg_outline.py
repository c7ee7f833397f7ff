# SPDX-License-Identifier: Apache-2.0
"""Outlines of SVG shapes as closed cubic subpaths: path data, rectangles, ellipses, polygons, the even-odd rule.

A subpath is (n, 4, 2): its cubics' control points, each starting where the one before it ends, the last ending at the
start of the first. Lines and quadratics are raised to cubics, which is exact. A turn of at most 90 degrees of an arc
becomes one cubic, which leaves the arc by at most 2.8e-4 of its radius.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl import bezier
from livecl.svg_coordinates import length_in_pixels

FloatArray = NDArray[np.float64]

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
#: Horizontal lines on which the fill rules are compared.
_NUM_ROWS = 256


def path_outline(data: str) -> list[FloatArray]:
    """Return the closed subpaths of path data; subpaths of a single point or line, which enclose nothing, are dropped.

    Raises
    ------
    ValueError
        If `data` breaks the grammar of path data, is cut off, or holds numbers that are not finite.
    """
    from svgelements import Path
    from svgelements.svgelements import SVGLexicalParser

    data = data.strip()
    if data in ("", "none"):
        return []
    data = re.sub(r"(\d)\.(?!\d)", r"\1", data)  # svgelements does not know "3." for 3
    path, lexer = Path(), SVGLexicalParser()
    try:
        lexer.parse(path, data)
    except (ValueError, TypeError, ZeroDivisionError, OverflowError) as error:
        raise ValueError(f"path data {_excerpt(data, lexer.pos)} cannot be read") from error
    if data[0] not in "Mm" or lexer.pos < lexer.limit:
        raise ValueError(f"path data {_excerpt(data, lexer.pos if data[0] in 'Mm' else 0)} cannot be read")
    return _closed(path)


def shape_outline(tag: str, attributes: Mapping[str, str], viewport: tuple[float, float]) -> list[FloatArray]:
    """Return the closed subpaths of a basic shape, px.

    Parameters
    ----------
    tag : str
        ``rect``, ``circle``, ``ellipse``, ``polygon``, ``polyline``; a ``line`` encloses nothing.
    attributes : mapping of str
        Its attributes, and properties of its style.
    viewport : (float, float)
        Width and height that percentages refer to, px.

    Raises
    ------
    ValueError
        If a length or the points cannot be read.
    """
    width, height = viewport
    diagonal = math.hypot(width, height) / math.sqrt(2)

    def length(name: str, reference: float, default: float = 0.0) -> float:
        return length_in_pixels(attributes.get(name), default, reference)

    if tag in ("polygon", "polyline"):
        return polygon_outline(attributes.get("points", ""))
    if tag == "circle":
        radius = length("r", diagonal)
        return ellipse_outline(length("cx", width), length("cy", height), radius, radius)
    if tag not in ("rect", "ellipse"):
        return []
    rx, ry = length("rx", width, -1.0), length("ry", height, -1.0)
    rx, ry = (ry if rx < 0 else rx), (rx if ry < 0 else ry)  # a radius not given is the other one
    if tag == "ellipse":
        return ellipse_outline(length("cx", width), length("cy", height), rx, ry)
    sides = length("width", width), length("height", height)
    return rectangle_outline(length("x", width), length("y", height), *sides, max(rx, 0.0), max(ry, 0.0))


def polygon_outline(points: str) -> list[FloatArray]:
    """Return the closed subpath through a ``points`` list; ValueError where it holds anything but numbers."""
    numbers = [float(number) for number in _NUMBER.findall(points)]
    if _NUMBER.sub("", points).strip(" \t\r\n\f,"):
        raise ValueError(f"points {_excerpt(points, 0)} cannot be read")
    corners = np.array(numbers[: len(numbers) // 2 * 2], dtype=np.float64).reshape(-1, 2)
    if len(corners) < 3:
        return []
    lines = [_line(start, end) for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    return [np.stack([line for line in lines if line[0].tolist() != line[3].tolist()] or lines)]


def rectangle_outline(
    x: float, y: float, width: float, height: float, rx: float = 0.0, ry: float = 0.0
) -> list[FloatArray]:
    """Return the outline of a rectangle with corner radii `rx`, `ry`, px; nothing where it has no area."""
    from svgelements import Rect

    if not (width > 0 and height > 0):
        return []
    return _closed(Rect(x, y, width, height, min(rx, width / 2), min(ry, height / 2)).segments(False))


def ellipse_outline(cx: float, cy: float, rx: float, ry: float) -> list[FloatArray]:
    """Return the outline of an ellipse as four cubics; nothing where it has no area."""
    from svgelements import Ellipse

    if not (rx > 0 and ry > 0):
        return []
    return _closed(Ellipse(cx, cy, rx, ry).segments(False))


def transformed(outline: Iterable[FloatArray], matrix: ArrayLike) -> list[FloatArray]:
    """Return an outline under an affine matrix (3, 3), which maps column vectors (x, y, 1)."""
    matrix = np.asarray(matrix, dtype=np.float64)
    return [subpath @ matrix[:2, :2].T + matrix[:2, 2] for subpath in outline]


def nonzero_from_even_odd(outline: list[FloatArray]) -> tuple[list[FloatArray], bool]:
    """Return an outline that the nonzero rule fills as the even-odd rule fills the one given, where there is one.

    The two rules agree where no winding number is even but nonzero. Where they differ, subpaths that lie inside an
    odd number of others are made to turn against the rest, which settles nested subpaths and few crossing ones. The
    rules are compared along 256 rows, where stretches narrower than 1/1024 of the outline's size do not count.

    Returns
    -------
    (list of (n, 4, 2), bool)
        The outline, and whether the rules agree on it; where they do not, it is the one given.
    """
    if not outline:
        return outline, True
    bounds = bezier.hull_bounds(np.concatenate(outline).reshape(-1, 2))
    extent = float(max(bounds[2] - bounds[0], bounds[3] - bounds[1])) or 1.0
    polylines = [_flattened(subpath, extent / 4096) for subpath in outline]
    if _rules_agree(polylines, extent / 1024):
        return outline, True
    turned, turned_lines = [], []
    for i, (subpath, polyline) in enumerate(zip(outline, polylines, strict=True)):
        others = [other for j, other in enumerate(polylines) if j != i]
        x, y = polyline[0]
        inside = sum(int(np.sum(_crossings(other, y)[0] < x)) for other in others) % 2 == 1
        against = inside == (bezier.signed_area(subpath) > 0)
        turned.append(subpath[::-1, ::-1] if against else subpath)
        turned_lines.append(polyline[::-1] if against else polyline)
    return (turned, True) if _rules_agree(turned_lines, extent / 1024) else (outline, False)


def _excerpt(data: str, position: int) -> str:
    """Quote the text around a position, on one line."""
    start = max(0, position - 20)
    text = " ".join(data[start : start + 40].split())
    return f"'{'...' if start else ''}{text}{'...' if start + 40 < len(data) else ''}'"


def _line(start: ArrayLike, end: ArrayLike) -> FloatArray:
    a, d = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    return np.stack([a, a + (d - a) / 3, d - (d - a) / 3, d])


def _arc(arc: Any) -> FloatArray:
    """Return the cubics of an elliptical arc: equal turns d of at most 90 degrees, handles 4/3 tan(d/4) radii long."""
    count = max(1, math.ceil(abs(arc.sweep) / (math.pi / 2) - 1e-9))
    t = arc.get_start_t() + arc.sweep * np.arange(count + 1) / count
    handle = 4 / 3 * math.tan(arc.sweep / count / 4)
    on_circle = np.stack([np.cos(t), np.sin(t)], axis=-1)
    tangent = handle * np.stack([-np.sin(t), np.cos(t)], axis=-1)
    circle = np.stack([on_circle[:-1], (on_circle + tangent)[:-1], (on_circle - tangent)[1:], on_circle[1:]], axis=1)
    cos, sin = math.cos(arc.get_rotation()), math.sin(arc.get_rotation())
    cubics: FloatArray = circle * [arc.rx, arc.ry] @ np.array([[cos, sin], [-sin, cos]]) + [arc.center.x, arc.center.y]
    cubics[0, 0] = arc.start.x, arc.start.y
    cubics[-1, 3] = arc.end.x, arc.end.y
    return cubics


def _closed(segments: Iterable[Any]) -> list[FloatArray]:
    """Return the closed subpaths of svgelements' segments, each ended by a line where it does not end at its start."""
    from svgelements import Arc, Close, CubicBezier, Move, QuadraticBezier

    outline: list[FloatArray] = []
    cubics: list[FloatArray] = []
    lines = 0
    start = point = np.zeros(2)
    previous: Any = None
    control = point

    def finish() -> None:
        nonlocal lines
        if cubics:
            scale = max(1.0, float(np.abs(start).max()))
            if np.abs(point - start).max() <= 1e-6 * scale:
                cubics[-1][3] = start
            else:
                cubics.append(_line(point, start))
                lines += 1
            if lines < len(cubics) or lines > 2:
                outline.append(np.stack(cubics))
        cubics.clear()
        lines = 0

    for segment in segments:
        end = start if isinstance(segment, Close) else np.array([segment.end.x, segment.end.y], dtype=np.float64)
        if not np.isfinite(end).all():
            raise ValueError("path data holds a number that is not finite")
        if isinstance(segment, (Move, Close)):
            finish()
            start = end
        elif isinstance(segment, CubicBezier):
            # svgelements reflects a quadratic's handle too, where the standard wants none: so reflect here.
            reflected = 2 * point - control if isinstance(previous, CubicBezier) else point
            first = reflected if segment.smooth else np.array([segment.control1.x, segment.control1.y])
            control = np.array([segment.control2.x, segment.control2.y])
            cubics.append(np.stack([point, first, control, end]))
        elif isinstance(segment, QuadraticBezier):
            reflected = 2 * point - control if isinstance(previous, QuadraticBezier) else point
            control = reflected if segment.smooth else np.array([segment.control.x, segment.control.y])
            cubics.append(np.stack([point, point + 2 / 3 * (control - point), end + 2 / 3 * (control - end), end]))
        elif isinstance(segment, Arc) and segment.rx and segment.ry:
            if (end != point).any():
                cubics.extend(_arc(segment))
        elif (end != point).any():
            cubics.append(_line(point, end))
            lines += 1
        point, previous = end, segment
    finish()
    if not all(np.isfinite(subpath).all() for subpath in outline):
        raise ValueError("path data holds a number that is not finite")
    return outline


def _flattened(subpath: FloatArray, tolerance: float) -> FloatArray:
    """Return the corners (K, 2) of a subpath flattened to `tolerance`, the first repeated at the end."""
    pieces = bezier.pieces_for(subpath, tolerance)
    parts = [bezier.evaluate(cubic, np.arange(n) / n) for cubic, n in zip(subpath, pieces, strict=True)]
    return np.concatenate([*parts, subpath[:1, 0]])


def _crossings(polyline: FloatArray, y: float) -> tuple[FloatArray, FloatArray]:
    """Return the abscissae at which a polyline crosses a row, and the direction, +1 downwards, of each crossing."""
    below = polyline[:, 1] > y
    at = np.flatnonzero(below[1:] != below[:-1])
    (x0, y0), (x1, y1) = polyline[at].T, polyline[at + 1].T
    return x0 + (y - y0) / (y1 - y0) * (x1 - x0), np.where(below[at + 1], 1.0, -1.0)


def _rules_agree(polylines: list[FloatArray], narrow: float) -> bool:
    """Return whether no stretch of a row, wider than `narrow`, has an even winding number other than zero."""
    low = min(float(polyline[:, 1].min()) for polyline in polylines)
    high = max(float(polyline[:, 1].max()) for polyline in polylines)
    for y in low + (high - low) * (np.arange(_NUM_ROWS) + 0.5) / _NUM_ROWS:
        found = [_crossings(polyline, y) for polyline in polylines]
        x = np.concatenate([item[0] for item in found])
        order = np.argsort(x, kind="stable")
        winding = np.cumsum(np.concatenate([item[1] for item in found])[order])[:-1]
        wide = np.diff(x[order]) > narrow
        if np.any(wide & (winding != 0) & (winding % 2 == 0)):
            return False
    return True
