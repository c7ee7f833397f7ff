# SPDX-License-Identifier: Apache-2.0
"""Outlines of SVG shapes as closed cubic subpaths: path data, rectangles, ellipses, polygons.

A subpath is (n, 4, 2): its cubics' control points, each starting where the one before it ends, the last ending at the
start of the first. Lines and quadratics are raised to cubics, which is exact. A turn of at most 90 degrees of an arc
becomes one cubic, which leaves the arc by at most 2.8e-4 of its radius.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.svg.coordinates import length_in_pixels

FloatArray = NDArray[np.float64]
#: Control points as complex numbers x + iy.
Cubic = tuple[complex, complex, complex, complex]

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


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
    if data[0] not in "Mm":
        raise ValueError(f"path data {_excerpt(data, 0)} cannot be read; it has to begin with M")
    data = re.sub(r"(\d)\.(?!\d)", r"\1", data)  # svgelements does not know "3." for 3
    path, lexer = Path(), SVGLexicalParser()
    try:
        lexer.parse(path, data)
    except (ValueError, TypeError, ZeroDivisionError, OverflowError) as error:
        raise ValueError(f"path data {_excerpt(data, lexer.pos)} cannot be read") from error
    if lexer.pos < lexer.limit:
        raise ValueError(f"path data {_excerpt(data, lexer.pos)} cannot be read")
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
    corners = [complex(x, y) for x, y in zip(numbers[::2], numbers[1::2], strict=False)]
    if len(corners) < 3:
        return []
    lines = [_line(start, end) for start, end in zip(corners, corners[1:] + corners[:1], strict=True)]
    return [_points([line for line in lines if line[0] != line[3]] or lines)]


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


def _excerpt(data: str, position: int) -> str:
    """Quote the text around a position, on one line."""
    start = max(0, position - 20)
    text = " ".join(data[start : start + 40].split())
    return f"'{'...' if start else ''}{text}{'...' if start + 40 < len(data) else ''}'"


def _complex(point: Any) -> complex:
    if point.x is None or point.y is None:
        raise ValueError("path data lacks a number")
    return complex(point.x, point.y)


def _line(a: complex, d: complex) -> Cubic:
    return a, a + (d - a) / 3, d - (d - a) / 3, d


def _arc(arc: Any) -> list[Cubic]:
    """Return the cubics of an elliptical arc: equal turns d of at most 90 degrees, handles 4/3 tan(d/4) radii long."""
    count = max(1, math.ceil(abs(arc.sweep) / (math.pi / 2) - 1e-9))
    t = arc.get_start_t() + arc.sweep * np.arange(count + 1) / count
    handle = 4 / 3 * math.tan(arc.sweep / count / 4)
    on_circle = np.stack([np.cos(t), np.sin(t)], axis=-1)
    tangent = handle * np.stack([-np.sin(t), np.cos(t)], axis=-1)
    circle = np.stack([on_circle[:-1], (on_circle + tangent)[:-1], (on_circle - tangent)[1:], on_circle[1:]], axis=1)
    cos, sin = math.cos(arc.get_rotation()), math.sin(arc.get_rotation())
    points = circle * [arc.rx, arc.ry] @ np.array([[cos, sin], [-sin, cos]]) + [arc.center.x, arc.center.y]
    rows = (points[..., 0] + 1j * points[..., 1]).tolist()
    rows[0][0], rows[-1][3] = _complex(arc.start), _complex(arc.end)
    return [(a, b, c, d) for a, b, c, d in rows]


def _points(cubics: list[Cubic]) -> FloatArray:
    """Return cubics of complex numbers as control points: (n, 4, 2)."""
    numbers = np.array(cubics)
    return np.stack([numbers.real, numbers.imag], axis=-1)


def _closed(segments: Iterable[Any]) -> list[FloatArray]:
    """Return the closed subpaths of svgelements' segments, each ended by a line where it does not end at its start.

    Points are complex numbers x + iy on the way: a path may have some hundred thousand segments.
    """
    from svgelements import Arc, Close, CubicBezier, Move, QuadraticBezier

    outline: list[FloatArray] = []
    cubics: list[Cubic] = []
    lines = 0
    start = point = control = 0j
    previous: Any = None

    def finish() -> None:
        nonlocal lines
        if cubics:
            scale = max(1.0, abs(start.real), abs(start.imag))
            if max(abs((point - start).real), abs((point - start).imag)) <= 1e-6 * scale:
                cubics[-1] = (*cubics[-1][:3], start)
            else:
                cubics.append(_line(point, start))
                lines += 1
            if lines < len(cubics) or lines > 2:
                outline.append(_points(cubics))
        cubics.clear()
        lines = 0

    for segment in segments:
        end = start if isinstance(segment, Close) else _complex(segment.end)
        if not cmath.isfinite(end):
            raise ValueError("path data holds a number that is not finite")
        if isinstance(segment, (Move, Close)):
            finish()
            start = end
        elif isinstance(segment, CubicBezier):
            # svgelements reflects a quadratic's handle too, where the standard wants none: so reflect here.
            reflected = 2 * point - control if isinstance(previous, CubicBezier) else point
            first = reflected if segment.smooth else _complex(segment.control1)
            control = _complex(segment.control2)
            cubics.append((point, first, control, end))
        elif isinstance(segment, QuadraticBezier):
            reflected = 2 * point - control if isinstance(previous, QuadraticBezier) else point
            control = reflected if segment.smooth else _complex(segment.control)
            cubics.append((point, point + 2 / 3 * (control - point), end + 2 / 3 * (control - end), end))
        elif isinstance(segment, Arc) and segment.rx and segment.ry:
            if end != point:
                cubics.extend(_arc(segment))
        elif end != point:
            cubics.append(_line(point, end))
            lines += 1
        point, previous = end, segment
    finish()
    if not all(np.isfinite(subpath).all() for subpath in outline):
        raise ValueError("path data holds a number that is not finite")
    return outline
