# SPDX-License-Identifier: Apache-2.0
"""Walk an SVG document in paint order: layers with styles, transforms, viewports and ``<use>`` resolved."""

from __future__ import annotations

import dataclasses
from typing import Literal
from xml.etree.ElementTree import Element

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing.checks import clean_name
from livecl.drawing.colors import Rgba
from livecl.drawing.fills import MAX_COORDINATE
from livecl.geometry import bezier
from livecl.svg import path_data, shapes
from livecl.svg.conditions import is_shown
from livecl.svg.coordinates import (
    Units,
    canvas_size,
    font_size,
    length_in_pixels,
    transform_matrix,
    transform_origin,
    translation,
    view_box,
    view_matrix,
)
from livecl.svg.document import MAX_DEPTH, MAX_ELEMENTS, tag_of
from livecl.svg.fill_rule import nonzero_from_even_odd
from livecl.svg.gradients import Gradient, mean_color
from livecl.svg.layer import LeftOut, ReadLayer, is_upright, layer_name, overlap, reach_over, stage_match
from livecl.svg.paint import background_color, count_left_out, is_stroked, opacity_of, parse_paint, solid_color
from livecl.svg.paint_servers import FilledShape, PaintServers
from livecl.svg.pens import drawn, lines_of_shape, pen_of
from livecl.svg.style import StyleSheet, inherit

#: Largest amount of path data, characters: some hundred thousand segments.
MAX_PATH_DATA = 5_000_000

_CONTAINERS = {"svg", "g", "a", "switch", "symbol"}
_SHAPES = {"path", "rect", "circle", "ellipse", "polygon", "polyline", "line"}
_LEFT_OUT = {
    **{"text": "text", "textArea": "text", "image": "images", "foreignObject": "foreign objects"},
    **{"video": "films", "animation": "animations"},
}
_KNOWN = _CONTAINERS | _SHAPES | _LEFT_OUT.keys() | {"use"}


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Context:
    """Inherited state of an element; `shown` has the <use>d elements that contain it."""

    matrix: FloatArray
    style: dict[str, str]
    own: dict[str, str]
    units: Units
    opacity: float
    stage: int
    viewport: tuple[float, float]
    depth: int
    shown: tuple[Element, ...] = ()
    groups: tuple[tuple[int, str], ...] = ()


class Walker:
    """Collects the layers of a document, from its ``<svg>`` element, and counts unsupported features.

    Attributes
    ----------
    layers : list of ReadLayer
        Bottom first.
    size : (float, float)
        Width and height of the canvas, px.
    left_out : LeftOut
        Counts of unsupported features by kind.

    Raises
    ------
    ValueError
        If the document cannot be read, or is too large.
    """

    def __init__(self, root: Element) -> None:
        self.left_out = LeftOut()
        self.layers: list[ReadLayer] = []
        self._ids: dict[str, Element] = {}
        self._num_elements = self._num_characters = 0
        for element in root.iter():
            tag = tag_of(element) or ""
            self._ids.setdefault(element.get("id", ""), element)
            if tag == "set" or tag.startswith("animate"):
                self.left_out["animations"] += 1
            elif tag == "script":
                self.left_out["scripts"] += 1
        self._sheet = StyleSheet(root, self.left_out)
        self._servers = PaintServers(root, self._ids, self._sheet, self.left_out)
        own = self._sheet.properties(root, {})
        size = font_size(own, Units())
        units = Units(font=size, root_font=size, guesses=self.left_out)
        self.size = canvas_size(root, own, units)
        units = dataclasses.replace(units, canvas=self.size)
        color = background_color(own, self.left_out)
        if color is not None and own.get("display") != "none" and is_shown(root):
            cover = shapes.rectangle_outline(0.0, 0.0, *self.size)
            self.layers.append(
                ReadLayer(outline=cover, color=color, stage=0, identifier="background", name="background")
            )
        start = _Context(
            matrix=np.eye(3), style={}, own={}, units=units, opacity=1.0, stage=0, viewport=self.size, depth=0
        )
        self._walk(root, start)

    def _walk(self, element: Element, around: _Context, size: dict[str, str] | None = None) -> None:
        """Walk an element; `size` has the width and height that a <use> states for it."""
        tag = tag_of(element)
        if tag not in _KNOWN or not is_shown(element):
            return
        self._num_elements += 1
        if self._num_elements > MAX_ELEMENTS or around.depth > MAX_DEPTH:
            raise ValueError(f"more than {MAX_ELEMENTS} elements, or nested deeper than {MAX_DEPTH}, counting <use>")
        own = self._sheet.properties(element, around.own) | (size or {})
        if own.get("display") == "none":
            return
        if tag in _LEFT_OUT:
            self.left_out[_LEFT_OUT[tag]] += 1
            return
        count_left_out(own, self.left_out)
        opacity = opacity_of(own.get("opacity"))
        units = dataclasses.replace(around.units, font=font_size(own, around.units))
        here = dataclasses.replace(
            around,
            matrix=around.matrix @ self._transform(tag, own, around.viewport, units),
            style=inherit(around.style, own),
            own=own,
            units=units,
            opacity=around.opacity * opacity,
            depth=around.depth + 1,
            shown=(*around.shown, element),
        )
        if tag in _SHAPES:
            self._add_shape(element, tag, own, here)
            return
        first = len(self.layers)
        if tag == "use":
            self._walk_used(element, own, here)
        elif tag in ("svg", "symbol"):
            self._walk_viewport(element, tag, own, here)
        else:
            self._walk_children(element, here)
        if opacity < 1 and overlap(self.layers[first:]):
            self.left_out["group opacity over overlapping shapes"] += 1

    def _transform(
        self, tag: str | None, own: dict[str, str], viewport: tuple[float, float], units: Units
    ) -> FloatArray:
        text = own.get("transform")
        if not text or text == "none":
            return np.eye(3)
        matrix = transform_matrix(text, viewport, units)
        if tag == "symbol":  # SVG 1.1 has none, SVG 2 does
            self.left_out["transforms of symbols"] += 1
        if "transform-origin" in own:
            if own.get("transform-box", "view-box") not in ("view-box", "border-box"):
                self.left_out["transform origins"] += 1
            x, y = transform_origin(own["transform-origin"], viewport, units)
            matrix = translation(x, y) @ matrix @ translation(-x, -y)
        return matrix

    def _walk_children(self, element: Element, here: _Context) -> None:
        if tag_of(element) == "g":
            if stage := stage_match(element):
                here = dataclasses.replace(here, stage=int(stage[1]) - 1)
            elif name := clean_name(layer_name(element, element.get("id", ""))):
                here = dataclasses.replace(here, groups=(*here.groups, (self._num_elements, name)))
        children = [child for child in element if tag_of(child) in _KNOWN - {"symbol"}]
        if tag_of(element) == "switch":
            children = [child for child in children if is_shown(child)][:1]
        for child in children:
            self._walk(child, here)

    def _walk_viewport(self, element: Element, tag: str, own: dict[str, str], here: _Context) -> None:
        """Walk the children of an ``<svg>`` or ``<symbol>``; count a clip if they extend beyond its edge."""
        width, height = here.viewport
        matrix, units = here.matrix, here.units
        is_root = here.depth == 1
        if not is_root:
            if tag == "svg":
                x = length_in_pixels(own.get("x"), 0.0, width, units)
                y = length_in_pixels(own.get("y"), 0.0, height, units)
                matrix = matrix @ translation(x, y)
            width = length_in_pixels(own.get("width"), width, width, units)
            height = length_in_pixels(own.get("height"), height, height, units)
        box = view_box(element)
        first = len(self.layers)
        viewport = (box[2], box[3]) if box else (width, height)
        inside = dataclasses.replace(here, matrix=matrix @ view_matrix(element, width, height), viewport=viewport)
        self._walk_children(element, inside)
        clips = not is_root and own.get("overflow", "hidden") not in ("visible", "auto")
        if clips and reach_over(self.layers[first:], matrix, width, height):
            self.left_out["clips"] += 1

    def _walk_used(self, element: Element, own: dict[str, str], here: _Context) -> None:
        target = element.get("href", element.get("{http://www.w3.org/1999/xlink}href", "")).strip()
        if target and not target.startswith("#"):
            raise ValueError(f"<use> refers to {target[:60]!r}, outside the file; copy it into the file")
        used = self._ids.get(target[1:]) if target else None
        if used is None:
            self.left_out["references to nothing"] += 1
            return
        if used in here.shown:
            self.left_out["uses of themselves"] += 1
            return
        width, height = here.viewport
        x = length_in_pixels(own.get("x"), 0.0, width, here.units)
        y = length_in_pixels(own.get("y"), 0.0, height, here.units)
        size = {}
        if tag_of(used) in ("symbol", "svg"):  # it has the size stated by <use>
            size = {name: own[name] for name in ("width", "height") if own.get(name, "auto") != "auto"}
        self._walk(used, dataclasses.replace(here, matrix=here.matrix @ translation(x, y)), size)

    def _add_shape(self, element: Element, tag: str, own: dict[str, str], here: _Context) -> None:
        if here.style.get("visibility", "visible") != "visible":
            return
        identifier = element.get("id", "")
        try:
            local = self._outline(tag, own, here)
            layers = [self._filled(local, here), self._stroked(tag, own, here) if is_stroked(here.style) else None]
        except ValueError as error:
            raise ValueError(f"<{tag}{f' id={identifier[:60]!r}' if identifier else ''}>: {error}") from error
        if _strokes_first(here.style.get("paint-order", "normal")):
            layers.reverse()
        name = layer_name(element, identifier)
        painted = [
            dataclasses.replace(layer, stage=here.stage, groups=here.groups, identifier=identifier, name=name)
            for layer in layers
            if layer
        ]
        if len(painted) > 1 and opacity_of(own.get("opacity")) < 1:
            self.left_out["group opacity over overlapping shapes"] += 1
        self.layers += painted

    def _filled(self, local: list[FloatArray], here: _Context) -> ReadLayer | None:
        """Return the layer of an outline's fill, if it has one; the outline is in user units."""
        outline = _finite(shapes.transformed(local, here.matrix))
        fill = self._paint("fill", local, here) if outline else None
        if fill is None:
            return None
        if here.style.get("shape-rendering") in ("crispedges", "optimizespeed") and not is_upright(outline):
            self.left_out["edges without antialiasing"] += 1
        if here.style.get("fill-rule") == "evenodd":
            outline, equal = nonzero_from_even_odd(outline)
            if not equal:
                self.left_out["even-odd fills of crossing outlines"] += 1
        return self._layer(fill, outline)

    def _stroked(self, tag: str, own: dict[str, str], here: _Context) -> ReadLayer | None:
        """Return the layer of a shape's stroke, if it has one."""
        pen = pen_of(here.style, here.viewport, here.units)
        lines = lines_of_shape(tag, own, here.viewport, here.units)
        paint = self._paint("stroke", lines.subpaths, here) if pen and lines.subpaths else None
        if pen is None or paint is None:
            return None
        if here.style.get("stroke-linejoin", "miter").lower() in ("miter-clip", "arcs"):
            self.left_out["joins of SVG 2, read as miters"] += 1
        if here.style.get("shape-rendering") in ("crispedges", "optimizespeed"):
            self.left_out["edges without antialiasing"] += 1
        scaled = own.get("vector-effect", "none").lower() != "non-scaling-stroke"
        lines, pen = drawn(lines, pen, here.matrix, scaled)
        if not lines.subpaths:
            return None
        layer = self._layer(paint, _finite(lines.subpaths))
        return layer if pen is None else dataclasses.replace(layer, pen=pen, is_open=lines.is_open)

    def _layer(self, paint: Gradient | Rgba, outline: list[FloatArray]) -> ReadLayer:
        """Return a layer without a name yet."""
        gradient, color = self._held(paint, outline) if isinstance(paint, Gradient) else (None, paint)
        return ReadLayer(outline=outline, color=color, stage=0, identifier="", name="", gradient=gradient)

    def _held(self, gradient: Gradient, outline: list[FloatArray]) -> tuple[Gradient | None, Rgba]:
        """Return a gradient, or None if its coordinates are out of bounds, and its mean colour."""
        (red, green, blue, alpha), difference = mean_color(gradient, bezier.curve_bounds(np.concatenate(outline)))
        if np.abs(gradient.points).max() <= MAX_COORDINATE:
            return gradient, (red, green, blue, alpha)
        self.left_out.approximate("gradients too far away, read as one colour", difference)
        return None, (red, green, blue, alpha)

    def _paint(
        self, name: Literal["fill", "stroke"], outline: list[FloatArray], here: _Context
    ) -> Gradient | Rgba | None:
        """Return the paint of an outline in user units: a gradient, straight RGBA, or nothing."""
        text = here.style.get(name, "black" if name == "fill" else "none")
        paint = parse_paint(text)
        if "icc-color" in text:
            self.left_out["colours of ICC profiles"] += 1
        if paint.server is not None and self._servers.knows(paint.server):
            opacity = here.opacity * opacity_of(here.style.get(f"{name}-opacity"))
            shape = FilledShape(
                outline=outline, matrix=here.matrix, viewport=here.viewport, units=here.units, opacity=opacity
            )
            fill = self._servers.fill(paint.server, shape)
            if fill is not None or paint.color is None:
                return fill
            self.left_out["gradients of nothing, with another colour in their place"] += 1
            return solid_color(paint.color, here.style, here.opacity, name)
        if paint.server is not None:
            known = paint.server in self._ids
            self.left_out["pattern fills" if known else "references to nothing"] += 1
        return solid_color(paint.color or "none", here.style, here.opacity, name)

    def _outline(self, tag: str, own: dict[str, str], here: _Context) -> list[FloatArray]:
        if tag in ("polygon", "polyline"):
            outline, whole = shapes.polygon_outline(own.get("points", ""))
        elif tag == "path":
            data = path_data.plain_data(own.get("d", ""))
            self._num_characters += len(data)
            if self._num_characters > MAX_PATH_DATA:
                raise ValueError(f"more than {MAX_PATH_DATA} characters of path data; simplify the paths first")
            outline, whole = path_data.path_outline(data)
        else:
            return shapes.shape_outline(tag, own, here.viewport, here.units)
        if not whole:
            self.left_out["errors in path data, drawn up to them"] += 1
        return outline


def _finite(outline: list[FloatArray]) -> list[FloatArray]:
    """Return the outline; ValueError if a coordinate is not finite."""
    if not all(np.isfinite(subpath).all() for subpath in outline):
        raise ValueError("coordinates are not finite")
    return outline


def _strokes_first(order: str) -> bool:
    """Whether ``paint-order`` puts the stroke beneath the fill."""
    words = order.lower().split()
    return "stroke" in words and "fill" not in words[: words.index("stroke")]
