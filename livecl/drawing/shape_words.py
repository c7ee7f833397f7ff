# SPDX-License-Identifier: Apache-2.0
"""Shape names: classify the outline of a layer as "circle", "bar", "triangle" or others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry import bezier, cyclic
from livecl.geometry.ellipses import ellipses_of
from livecl.geometry.polylines import polygon_area

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing


#: All words.
SHAPE_WORDS = ("dot", "circle", "oval", "ring", "square", "rectangle", "bar", "frame", "triangle", "line", "shape")
#: Largest distance of an outline from an ellipse: share of its radius, and an additional distance, px.
ROUND, ROUND_MORE = 0.03, 0.15
#: Least share of its box that a rectangle fills; area of a triangle, as shares of that of the triangle of three of its
#: points.
FULL, TRIANGLE = 0.93, (0.88, 1.12)
#: Largest distance of an outline from the sides of that triangle, in square roots of its area.
BESIDE = 0.12
#: Largest ratio of the sides of a circle or square, and least ratio of a bar.
EQUAL_SIDES, BAR = 1.1, 4.0
#: Largest share of the canvas of a round shape that is a dot.
DOT = 4e-4
#: Least area of a subpath that counts, as a share of the layer's largest one.
COUNTED = 0.02
#: Number of sample points on each segment.
SAMPLES = 8


def shape_words(drawing: Drawing) -> list[str]:
    """Name the shape of each layer by one of `SHAPE_WORDS`."""
    area = drawing.size[0] * drawing.size[1]
    at, cubics = np.arange(SAMPLES) / SAMPLES, drawing.cubics
    words = []
    for layer in range(drawing.num_layers):
        if drawing.strokes.widths[layer]:
            words.append("line")
            continue
        words.append(
            _word([bezier.evaluate(cubics[rows], at).reshape(-1, 2) for rows in drawing.subpaths(layer)], area)
        )
    return words


def _word(polygons: list[FloatArray], canvas: float) -> str:
    """Return the word for a layer of closed polygons (n, 2), px."""
    areas = [polygon_area(points) for points in polygons]
    largest = int(np.argmax(np.abs(areas)))
    if not areas[largest]:
        return "shape"
    parts = [k for k, area in enumerate(areas) if abs(area) > COUNTED * abs(areas[largest])]
    word = _outline_word(polygons[largest], abs(areas[largest]))
    if len(parts) == 1:
        return "dot" if word == "circle" and abs(areas[largest]) <= DOT * canvas else word
    if len(parts) > 2 or areas[parts[0]] * areas[parts[1]] > 0:
        return "shape"
    hole = _outline_word(polygons[sum(parts) - largest], abs(areas[sum(parts) - largest]))
    kinds = [{"circle": "ring", "oval": "ring", "square": "frame", "rectangle": "frame"}.get(k) for k in (word, hole)]
    return kinds[0] if kinds[0] is not None and kinds[0] == kinds[1] else "shape"


def _outline_word(points: FloatArray, area: float) -> str:
    """Return the word for one closed outline (n, 2) of an area, px^2."""
    for ellipse in ellipses_of(points)[:1]:
        wide, narrow = np.hypot(*ellipse.axes.T)
        if np.abs(ellipse.distances(points)).max() <= ROUND * narrow + ROUND_MORE:
            return "circle" if wide <= EQUAL_SIDES * narrow else "oval"
    sides = cyclic.following(points) - points
    longest = sides[int(np.argmax(np.hypot(*sides.T)))]
    for along in ((1.0, 0.0), longest / max(float(np.hypot(*longest)), 1e-9)):
        turned = points @ np.array([[along[0], -along[1]], [along[1], along[0]]])
        width, height = np.sort(np.ptp(turned, axis=0))[::-1]
        if area >= FULL * width * height > 0:
            return "bar" if width >= BAR * height else "square" if width <= EQUAL_SIDES * height else "rectangle"
    first = points[int(np.argmax(np.hypot(*(points - points.mean(axis=0)).T)))]
    second = points[int(np.argmax(np.hypot(*(points - first).T)))]
    third = points[int(np.argmax(np.abs(bezier.cross(points - first, second - first))))]
    corners = np.array([first, second, third])
    whole = abs(float(bezier.cross(second - first, third - first))) / 2
    near = _distances(points, corners).max() <= BESIDE * np.sqrt(area)
    return "triangle" if near and TRIANGLE[0] * whole <= area <= TRIANGLE[1] * whole else "shape"


def _distances(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the distances of points (n, 2) from the nearest side of a closed polygon (m, 2)."""
    sides = cyclic.following(corners) - corners
    offsets = points[:, None] - corners
    along = (offsets * sides).sum(axis=2) / np.maximum((sides**2).sum(axis=1), 1e-12)
    rest = offsets - np.clip(along, 0, 1)[..., None] * sides
    return np.asarray(np.hypot(rest[..., 0], rest[..., 1]).min(axis=1))
