# SPDX-License-Identifier: Apache-2.0
"""Outlines that are circles, ellipses or rectangles, and how SVG writes them.

An outline counts as one if it equals the outline that the reader makes of the element, apart from start and direction.
So only those become shapes that were made as such: by the recognition of :mod:`livecl.editing`, or in the file that was
read.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterator

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry.outlines import reversed_path
from livecl.svg.coordinates import transform_matrix
from livecl.svg.outline_data import MAX_PRECISION
from livecl.svg.servers import format_decimal
from livecl.svg.shapes import shape_outline, transformed

_TURN = re.compile(r"rotate\((\S+)")

#: Largest distance of an outline from that of a shape, px; least and largest number of its segments.
SAME, FEWEST, MOST = 1e-6, 4, 8
#: Decimals of an angle in degrees: at 1000 px from the centre, the last one is .02 px.
ANGLE_DECIMALS = 3


@dataclasses.dataclass(frozen=True)
class Primitive:
    """An element of SVG: `tag` (circle, ellipse or rect) and attributes, lengths in px as text."""

    tag: str
    attributes: dict[str, str]

    @property
    def points(self) -> FloatArray:
        """Segments (m, 3, 2) of the outline as it is read, px."""
        attributes = dict(self.attributes)
        turn = attributes.pop("transform", "")
        outline = shape_outline(self.tag, attributes, (0.0, 0.0))
        if turn:
            outline = transformed(outline, transform_matrix(turn, (0.0, 0.0)))
        return np.round(outline[0][:, :3], MAX_PRECISION) + 0.0

    def scaled(self, factors: FloatArray) -> Primitive | None:
        """Return the shape on a canvas stretched by nearly equal factors (x, y): circles stay circles."""
        size = {name: float(value) for name, value in self.attributes.items() if name != "transform"}
        both = float(np.sqrt(factors[0] * factors[1]))
        if self.tag == "rect":
            low = np.array([size["x"], size["y"]])
            sides = np.array([size["width"], size["height"]]) * factors
            pill = 2 * size.get("rx", 0.0) >= min(size["width"], size["height"]) - SAME
            radius = float(sides.min()) / 2 if pill else size.get("rx", 0.0) * both
            return rectangle(low * factors, low * factors + sides, radius)
        center = np.array([size["cx"], size["cy"]]) * factors
        if self.tag == "circle":
            return ellipse(center, (size["r"] * both, size["r"] * both))
        if turn := _TURN.match(self.attributes.get("transform", "")):
            return ellipse(center, (size["rx"] * both, size["ry"] * both), float(turn[1]))
        return ellipse(center, (size["rx"] * float(factors[0]), size["ry"] * float(factors[1])))

    @property
    def text(self) -> str:
        """The attributes as they are written."""
        return " ".join(f'{name}="{value}"' for name, value in self.attributes.items())


def ellipse(center: FloatArray, radii: tuple[float, float], angle: float = 0.0, precision: int = 9) -> Primitive | None:
    """Return an ellipse, a circle if its radii are equal when rounded; None if one is 0. The angle is in degrees."""
    if abs(radii[0] - radii[1]) <= SAME:
        radii = (radii[0], radii[0])
    cx, cy, rx, ry = (_decimal(value, precision) for value in (*center.tolist(), *radii))
    turn = _decimal(angle, ANGLE_DECIMALS)
    if not (float(rx) > 0 and float(ry) > 0):
        return None
    if rx == ry:
        return Primitive("circle", {"cx": cx, "cy": cy, "r": rx})
    attributes = {"cx": cx, "cy": cy, "rx": rx, "ry": ry}
    if float(turn):
        attributes["transform"] = f"rotate({turn} {cx} {cy})"
    return Primitive("ellipse", attributes)


def rectangle(low: FloatArray, high: FloatArray, radius: float = 0.0, precision: int = 9) -> Primitive | None:
    """Return an upright rectangle from its low to its high corner; None if it has no area."""
    unit = 10**precision
    first, last = (np.rint(corner * unit).astype(np.int64).tolist() for corner in (low, high))
    width, height = last[0] - first[0], last[1] - first[1]
    if not (width > 0 and height > 0):
        return None
    sides = (*first, width, height)
    names = ("x", "y", "width", "height")
    attributes = {name: format_decimal(side, precision) for name, side in zip(names, sides, strict=True)}
    most = min(width, height)
    if 2 * radius >= min((high - low).min(), most / unit) - max(
        SAME, 0.5 / unit
    ):  # the quarters meet: half a side may need one decimal more
        attributes["rx"] = format_decimal(5 * most, precision + 1)
    elif (rounding := round(radius * unit)) > 0:
        attributes["rx"] = format_decimal(rounding, precision)
    return Primitive("rect", attributes)


def primitive_of(points: FloatArray, precision: int, *, upright: bool = False) -> Primitive | None:
    """Return a closed subpath (m, 3, 2) as a shape, its numbers rounded to `precision` decimals; None if it is none.

    With `upright`, rotated shapes are excluded.
    """
    if not FEWEST <= len(points) <= MOST:
        return None
    for whole, rounded in _shapes(points, precision):
        if whole is None or rounded is None or (upright and "transform" in whole.attributes):
            continue
        outline = whole.points
        if len(outline) == len(points) and _same(points, outline) and len(rounded.points) == len(points):
            return rounded
    return None


def _shapes(points: FloatArray, precision: int) -> Iterator[tuple[Primitive | None, Primitive | None]]:
    """Yield candidate shapes of a subpath: exact, and with rounded numbers."""
    anchors = points[:, 0]
    low, high = anchors.min(axis=0), anchors.max(axis=0)
    if len(points) == 4 and np.abs(anchors[0] + anchors[2] - anchors[1] - anchors[3]).max() <= 4 * SAME:
        center = anchors.mean(axis=0)
        spokes = anchors - center
        lengths = np.hypot(*spokes.T)
        longest = int(np.argmax(lengths[:2]))
        across = spokes[longest]
        upright = np.abs(spokes).min(axis=1).max() <= SAME
        if upright:
            radii = (float(np.abs(spokes[:, 0]).max()), float(np.abs(spokes[:, 1]).max()))
            yield ellipse(center, radii), ellipse(center, radii, precision=precision)
        else:
            radii = (float(lengths[longest]), float(lengths[1 - longest]))
            angle = math.degrees(math.atan2(across[1], across[0])) % 180
            yield ellipse(center, radii, angle), ellipse(center, radii, angle, precision)
    if np.minimum(np.abs(anchors - low), np.abs(anchors - high)).min(axis=1).max() > SAME:
        return  # not all anchors lie on the sides of the box
    on_top = anchors[np.abs(anchors[:, 1] - low[1]) <= SAME, 0]
    radius = float(on_top.min() - low[0])
    yield rectangle(low, high, radius), rectangle(low, high, radius, precision)


def _same(points: FloatArray, outline: FloatArray) -> bool:
    """Whether two closed subpaths (m, 3, 2) are equal, apart from start and direction."""
    for way in (outline, reversed_path(outline)):
        gaps = np.abs(way[:, 0] - points[0, 0]).max(axis=1)
        for first in np.flatnonzero(gaps <= SAME):
            if np.abs(np.roll(way, -int(first), axis=0) - points).max() <= SAME:
                return True
    return False


def _decimal(value: float, precision: int) -> str:
    return format_decimal(round(value * 10**precision), precision)
