# SPDX-License-Identifier: Apache-2.0
"""Convert SVG's basic shapes, rectangles, ellipses and polygons, to closed cubic subpaths."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray
from livecl.svg.coordinates import Units, length_in_pixels
from livecl.svg.path_data import Cubic, control_points, line_cubic, number_list


def shape_outline(
    tag: str, attributes: Mapping[str, str], viewport: tuple[float, float], units: Units | None = None
) -> list[FloatArray]:
    """Return the closed subpaths of a basic shape, px.

    Parameters
    ----------
    tag : str
        ``rect``, ``circle``, ``ellipse``; a ``line`` encloses nothing.
    attributes : mapping of str
        Its attributes, and properties of its style.
    viewport : (float, float)
        Width and height that percentages refer to, px.
    units : Units, optional
        Reference of relative units.

    Raises
    ------
    ValueError
        If a length cannot be read.
    """
    width, height = viewport
    diagonal = math.hypot(width, height) / math.sqrt(2)

    def length(name: str, reference: float, default: float = 0.0) -> float:
        return length_in_pixels(attributes.get(name), default, reference, units)

    if tag == "circle":
        radius = length("r", diagonal)
        return ellipse_outline(length("cx", width), length("cy", height), radius, radius)
    if tag not in ("rect", "ellipse"):
        return []
    rx, ry = length("rx", width, -1.0), length("ry", height, -1.0)
    rx, ry = (ry if rx < 0 else rx), (rx if ry < 0 else ry)  # a radius not given equals the other
    if tag == "ellipse":
        return ellipse_outline(length("cx", width), length("cy", height), rx, ry)
    sides = length("width", width), length("height", height)
    return rectangle_outline(length("x", width), length("y", height), *sides, max(rx, 0.0), max(ry, 0.0))


def polygon_outline(points: str) -> tuple[list[FloatArray], bool]:
    """Return the closed subpath through a ``points`` list, up to an error, and whether there was none."""
    numbers, whole = number_list(points)
    if not all(map(math.isfinite, numbers)):
        raise ValueError("points hold a number that is not finite")
    whole = whole and len(numbers) % 2 == 0
    corners = [complex(x, y) for x, y in zip(numbers[::2], numbers[1::2], strict=False)]
    if len(corners) < 3:
        return [], whole
    lines = [line_cubic(start, end) for start, end in zip(corners, corners[1:] + corners[:1], strict=True)]
    return [control_points([side for side in lines if side[0] != side[3]] or lines)], whole


def rectangle_outline(
    x: float, y: float, width: float, height: float, rx: float = 0.0, ry: float = 0.0
) -> list[FloatArray]:
    """Return the outline of a rectangle with corner radii `rx`, `ry`, px; empty if it has no area."""
    if not (width > 0 and height > 0):
        return []
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    left, right, top, bottom = x, x + width, y, y + height
    if not (rx > 0 and ry > 0):
        corners = [complex(left, top), complex(right, top), complex(right, bottom), complex(left, bottom)]
        return [control_points([line_cubic(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)])]
    cubics: list[Cubic] = []
    centers = [(right - rx, top + ry), (right - rx, bottom - ry), (left + rx, bottom - ry), (left + rx, top + ry)]
    for i, (cx, cy) in enumerate(centers):  # clockwise on the screen, from the top edge
        quarter = _quarter(i - 1, cx, cy, rx, ry)
        before = cubics[-1][3] if cubics else complex(left + rx, top)
        if (2 * rx, 2 * ry)[i % 2] < (width, height)[i % 2]:  # else the quarters meet
            cubics.append(line_cubic(before, quarter[0]))
        cubics.append(quarter)
    return [control_points(cubics)]


def ellipse_outline(cx: float, cy: float, rx: float, ry: float) -> list[FloatArray]:
    """Return the outline of an ellipse as four cubics; empty if it has no area."""
    if not (rx > 0 and ry > 0):
        return []
    return [control_points([_quarter(i, cx, cy, rx, ry) for i in range(4)])]


def _quarter(turns: int, cx: float, cy: float, rx: float, ry: float) -> Cubic:
    """Return a quarter of an ellipse, clockwise on the screen, that starts `turns` quarters after its right end."""
    handle = 4 / 3 * (math.sqrt(2) - 1)
    u, v = ((1 + 0j, 1j), (1j, -1 + 0j), (-1 + 0j, -1j), (-1j, 1 + 0j))[turns % 4]
    a, b, c, d = (
        complex(cx + rx * point.real, cy + ry * point.imag) for point in (u, u + handle * v, v + handle * u, v)
    )
    return a, b, c, d


def transformed(outline: Iterable[FloatArray], matrix: ArrayLike) -> list[FloatArray]:
    """Return an outline under an affine matrix (3, 3), which maps column vectors (x, y, 1)."""
    matrix = np.asarray(matrix, dtype=np.float64)
    return [subpath @ matrix[:2, :2].T + matrix[:2, 2] for subpath in outline]
