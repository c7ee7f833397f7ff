# SPDX-License-Identifier: Apache-2.0
"""Paint servers of an SVG: gradient elements and their inheritance, resolved for the filled shapes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing.colors import Rgba, parse_rgba
from livecl.drawing.fills import MAX_COORDINATE
from livecl.geometry import bezier
from livecl.svg import gradients
from livecl.svg.coordinates import Units, length_in_pixels, transform_matrix, transform_origin, translation
from livecl.svg.document import tag_of
from livecl.svg.gradients import Gradient
from livecl.svg.layer import LeftOut
from livecl.svg.paint import as_saved, opacity_of
from livecl.svg.style import StyleSheet

#: Longest chain of gradients that refer to each other, and most stops of one.
MAX_CHAIN, MAX_STOPS = 32, 1000

_HREF = "{http://www.w3.org/1999/xlink}href"
_GEOMETRY = {"linearGradient": ("x1", "y1", "x2", "y2"), "radialGradient": ("cx", "cy", "r", "fx", "fy", "fr")}
_COMMON = ("gradientUnits", "gradientTransform", "spreadMethod", "transform-origin")


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class FilledShape:
    """A shape filled by a gradient: outline, matrix to the canvas, and units."""

    outline: list[FloatArray]  # closed subpaths, user units
    matrix: FloatArray  # (3, 3), from user units to px
    viewport: tuple[float, float]  # width and height that percentages refer to, user units
    units: Units  # reference of relative units
    opacity: float  # factor of the stops' opacities


class PaintServers:
    """The gradients of a document.

    Parameters
    ----------
    root : Element
        The ``<svg>`` element.
    ids : dict of Element
        Elements by id.
    sheet : StyleSheet
        Styles of the document.
    left_out : LeftOut
        Counter of unsupported and approximated features.
    """

    def __init__(self, root: Element, ids: Mapping[str, Element], sheet: StyleSheet, left_out: LeftOut) -> None:
        self._root = root
        self._ids = ids
        self._sheet = sheet
        self._left_out = left_out
        self._parents: dict[Element, Element] = {}
        self._stops: dict[Element, FloatArray] = {}

    def knows(self, identifier: str) -> bool:
        """Return whether an id is that of a gradient."""
        element = self._ids.get(identifier)
        return element is not None and tag_of(element) in _GEOMETRY

    def fill(self, identifier: str, shape: FilledShape) -> Gradient | Rgba | None:
        """Return a shape's fill by the gradient of an id; None if it paints nothing, as without stops."""
        chain = self._chain(self._ids[identifier])
        stops = self._stops_of(chain)
        if not len(stops):
            return None
        stops = stops * (1, 1, 1, 1, shape.opacity)
        stops[:, 4] = [as_saved(opacity) for opacity in stops[:, 4].tolist()]
        red, green, blue, alpha = stops[-1, 1:].tolist()
        last: Rgba = (red, green, blue, alpha)
        if all(np.array_equal(stop, stops[0, 1:]) for stop in stops[1:, 1:]):
            return last
        gradient = self._placed(chain, stops, shape)
        if gradient is None or isinstance(gradient, Gradient):
            return gradient
        return last

    def _chain(self, element: Element) -> list[Element]:
        """Return a gradient and those that it refers to, nearest first."""
        chain = [element]
        while len(chain) <= MAX_CHAIN:
            target = chain[-1].get("href", chain[-1].get(_HREF, "")).strip()
            if not target:
                return chain
            following = self._ids.get(target[1:]) if target.startswith("#") else None
            if following is None or tag_of(following) not in _GEOMETRY:
                self._left_out["references of gradients to nothing"] += 1
                return chain
            if following in chain:
                self._left_out["gradients that refer to themselves"] += 1
                return chain
            chain.append(following)
        raise ValueError(f"gradients refer to each other in a chain of more than {MAX_CHAIN}")

    def _stops_of(self, chain: list[Element]) -> FloatArray:
        """Return the stops of the first gradient of a chain that has any: (K, 5)."""
        owner = next((element for element in chain if any(tag_of(child) == "stop" for child in element)), None)
        if owner is None:
            return np.zeros((0, 5))
        if owner not in self._stops:
            around = self._around(owner)
            if around.get("color-interpolation", "srgb") == "linearrgb":
                self._left_out["gradients in linear RGB, read in sRGB"] += 1
            stops = [child for child in owner if tag_of(child) == "stop"]
            if len(stops) > MAX_STOPS:
                raise ValueError(f"a gradient of more than {MAX_STOPS} stops")
            rows = np.array([self._stop(child, around) for child in stops])
            rows[:, 0] = np.maximum.accumulate(rows[:, 0])
            self._stops[owner] = rows
        return self._stops[owner]

    def _around(self, element: Element) -> dict[str, str]:
        """Return the properties of a gradient, with the colour that it inherits in the document's tree."""
        if not self._parents:
            self._parents = {child: parent for parent in self._root.iter() for child in parent}
        path = [element]
        while path[-1] in self._parents:
            path.append(self._parents[path[-1]])
        properties: dict[str, str] = {}
        for ancestor in reversed(path):
            own = self._sheet.properties(ancestor, properties)
            inherited = {name: properties[name] for name in ("color", "color-interpolation") if name in properties}
            properties = inherited | own
        return properties

    def _stop(self, element: Element, around: Mapping[str, str]) -> list[float]:
        own = self._sheet.properties(element, around)
        color = own.get("stop-color", "black")
        if color.lower() == "currentcolor":
            color = own.get("color", around.get("color", "black"))
        red, green, blue, alpha = (0.0, 0.0, 0.0, 1.0) if color.lower() == "currentcolor" else parse_rgba(color)
        return [self._offset(own.get("offset", "0")), red, green, blue, alpha * opacity_of(own.get("stop-opacity"))]

    def _offset(self, text: str) -> float:
        text = text.strip()
        try:
            value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
        except ValueError:
            self._left_out["unknown values of properties"] += 1
            return 0.0
        return min(max(value, 0.0), 1.0)

    def _placed(self, chain: list[Element], stops: FloatArray, shape: FilledShape) -> Gradient | str | None:
        """Return a gradient in px; "degenerate" if its last colour fills the shape; None if nothing does."""
        common = {name: element.get(name) for element in reversed(chain) for name in _COMMON if name in element.attrib}
        kind = tag_of(chain[0]) or ""
        own = {
            name: element.attrib[name]
            for element in reversed(chain)
            if tag_of(element) == kind
            for name in _GEOMETRY[kind]
            if name in element.attrib
        }
        box = bezier.curve_bounds(np.concatenate(shape.outline))
        matrix, viewport, units = shape.matrix, shape.viewport, shape.units
        if common.get("gradientUnits", "objectBoundingBox") != "userSpaceOnUse":
            width, height = box[2:] - box[:2]
            if not (width > 0 and height > 0):
                return None
            matrix = matrix @ translation(box[0], box[1]) @ np.diag([width, height, 1.0])
            viewport = (1.0, 1.0)
        try:
            transform = transform_matrix(common.get("gradientTransform"), viewport, units)
        except ValueError:
            self._left_out["unknown values of properties"] += 1
            transform = np.eye(3)
        if "transform-origin" in common:
            x, y = transform_origin(common["transform-origin"], viewport, units)
            transform = translation(x, y) @ transform @ translation(-x, -y)
        if not np.linalg.det(transform):
            self._left_out["transforms of gradients without an inverse, ignored"] += 1
            transform = np.eye(3)
        matrix = matrix @ transform
        bounds = bezier.curve_bounds(np.concatenate(shape.outline) @ shape.matrix[:2, :2].T + shape.matrix[:2, 2])
        spread = common.get("spreadMethod") or "pad"
        if kind == "linearGradient":
            ends = np.array([self._length(own, name, viewport, units) for name in _GEOMETRY[kind]]).reshape(2, 2)
            gradient = gradients.linear(ends, matrix, stops)
        else:
            gradient = self._radial(own, matrix, stops, spread, bounds, (viewport, units))
        if gradient is None:
            return "degenerate"
        gradient, exact = gradients.padded(gradient, spread, bounds)
        if not exact:
            self._left_out[f"gradients of more than {gradients.MAX_REPEATS} repeats"] += 1
        if (
            np.abs(gradient.points).max() > MAX_COORDINATE
            and gradient.kind == "linear"
            and (bounds[2:] > bounds[:2]).all()
        ):
            gradient = gradients.narrowed(gradient, bounds)
        return gradient

    def _radial(
        self,
        own: Mapping[str, str],
        matrix: FloatArray,
        stops: FloatArray,
        spread: str,
        bounds: FloatArray,
        sizes: tuple[tuple[float, float], Units],
    ) -> Gradient | None:
        cx, cy, radius = (self._length(own, name, *sizes) for name in ("cx", "cy", "r"))
        fx, fy = (self._length(own, name, *sizes) if name in own else c for name, c in (("fx", cx), ("fy", cy)))
        inner = max(0.0, self._length(own, "fr", *sizes))
        circle, focus = np.array([cx, cy, radius]), np.array([fx, fy])
        if radius <= 0 or not np.linalg.det(matrix):
            return None
        if inner > radius:
            self._left_out.approximate("radial gradients whose inner circle is the wider one", 1.0)
            return None
        if not np.array_equal(circle[:2], focus):
            x0, y0, x1, y1 = bounds
            corners = np.array([[x0, y0, 1], [x1, y0, 1], [x1, y1, 1], [x0, y1, 1]]) @ np.linalg.inv(matrix).T
            frame = np.concatenate([corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)])
            circle, error = gradients.concentric(circle, focus, inner, spread, stops, frame)
            self._left_out.approximate("radial gradients with a focal point off the centre", error)
        if inner:
            if spread != "pad":
                self._left_out.approximate("repeated radial gradients with an inner circle", 1.0)
            stops = gradients.with_inner_radius(stops, inner / radius)
        return gradients.radial(circle, matrix, stops)

    def _length(self, own: Mapping[str, str], name: str, viewport: tuple[float, float], units: Units) -> float:
        """Return a length of a gradient, user units or shares of the box; percentages refer to the viewport."""
        width, height = viewport
        diagonal = float(np.hypot(width, height) / np.sqrt(2))
        reference = {"x": width, "y": height}.get(name.strip("12cf"), diagonal)
        default = {"x1": 0.0, "y1": 0.0, "x2": 1.0, "y2": 0.0, "fr": 0.0}.get(name, 0.5) * reference
        try:
            return length_in_pixels(own.get(name), default, reference, units)
        except ValueError:
            self._left_out["unknown values of properties"] += 1
            return default
