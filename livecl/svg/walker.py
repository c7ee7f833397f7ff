# SPDX-License-Identifier: Apache-2.0
"""An SVG document's tree walked in paint order to layers, with styles, transforms, viewports and ``<use>`` resolved."""

from __future__ import annotations

import collections
import dataclasses
import functools
import re
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.colors import Rgba
from livecl.geometry import bezier
from livecl.svg import shapes as svg_outline
from livecl.svg.coordinates import canvas_size, length_in_pixels, transform_matrix, translation, view_box, view_matrix
from livecl.svg.document import MAX_DEPTH, tag_of
from livecl.svg.fill_rule import nonzero_from_even_odd
from livecl.svg.paint import count_left_out, fill_color, is_stroked, opacity_of
from livecl.svg.style import StyleSheet, inherit
from livecl.svg.writer import INKSCAPE_NAMESPACE, SVG_NAMESPACE, name_from_id

FloatArray = NDArray[np.float64]

#: Most path data read, characters: some ten thousand to hundred thousand segments.
MAX_PATH_DATA = 2_000_000
#: Most elements visited, counted anew each time a <use> shows them.
MAX_ELEMENTS = 100_000
#: Most layers of a translucent group that are compared with each other; more count as overlapping.
MAX_COMPARED = 1000

_CONTAINERS = {"svg", "g", "a", "switch", "symbol"}
_SHAPES = {"path", "rect", "circle", "ellipse", "polygon", "polyline", "line"}
_LEFT_OUT = {"text": "text", "image": "images", "foreignObject": "foreign objects"}
_KNOWN = _CONTAINERS | _SHAPES | _LEFT_OUT.keys() | {"use"}
_STAGE_LABEL, _STAGE_ID = re.compile(r"stage (-?\d{1,9})"), re.compile(r"stage-(-?\d{1,9})(-\d+)?")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layer:
    """A filled shape: closed subpaths (n, 4, 2), px; straight RGBA; stage; id; name."""

    outline: list[FloatArray]
    color: Rgba
    stage: int
    identifier: str
    name: str

    @functools.cached_property
    def bounds(self) -> FloatArray:
        """(x_min, y_min, x_max, y_max) of the control points."""
        return bezier.hull_bounds(np.concatenate(self.outline).reshape(-1, 2))


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Context:
    """What an element takes from those around it."""

    matrix: FloatArray
    style: dict[str, str]
    opacity: float
    stage: int
    viewport: tuple[float, float]
    depth: int


class Walker:
    """Collects the layers of a document, and counts what they cannot represent.

    Parameters
    ----------
    root : Element
        The ``<svg>`` element.

    Attributes
    ----------
    layers : list of Layer
        Bottom first.
    size : (float, float)
        Width and height of the canvas, px.
    left_out : Counter
        How often what was met that a drawing cannot represent.

    Raises
    ------
    ValueError
        If something cannot be read, or there is too much of it.
    """

    def __init__(self, root: Element) -> None:
        self.left_out: collections.Counter[str] = collections.Counter()
        self.layers: list[Layer] = []
        self._ids: dict[str, Element] = {}
        self._num_elements = self._num_characters = 0
        sheets = []
        for count, element in enumerate(root.iter(), 1):
            if count > MAX_ELEMENTS:
                raise ValueError(f"more than {MAX_ELEMENTS} elements; simplify it first")
            tag = tag_of(element) or ""
            self._ids.setdefault(element.get("id", ""), element)
            if tag == "style":
                sheets.append("".join(element.itertext()))
            elif tag == "set" or tag.startswith("animate"):
                self.left_out["animations"] += 1
        self._sheet = StyleSheet(sheets)
        if self._sheet.num_unknown:
            self.left_out["style rules"] = self._sheet.num_unknown
        self.size = canvas_size(root)
        start = _Context(matrix=np.eye(3), style={}, opacity=1.0, stage=0, viewport=self.size, depth=0)
        self._walk(root, start)

    def _walk(self, element: Element, around: _Context) -> None:
        tag = tag_of(element)
        if tag not in _KNOWN:
            return
        self._num_elements += 1
        if self._num_elements > MAX_ELEMENTS or around.depth > MAX_DEPTH:
            raise ValueError(f"more than {MAX_ELEMENTS} elements, or nested deeper than {MAX_DEPTH}, counting <use>")
        own = self._sheet.declarations(element, tag)
        if own.get("display") == "none":
            return
        if tag in _LEFT_OUT:
            self.left_out[_LEFT_OUT[tag]] += 1
            return
        count_left_out(own, self.left_out)
        opacity = opacity_of(own.get("opacity"))
        here = dataclasses.replace(
            around,
            matrix=around.matrix @ transform_matrix(own.get("transform")),
            style=inherit(around.style, own),
            opacity=around.opacity * opacity,
            depth=around.depth + 1,
        )
        if tag in _SHAPES:
            self._add_shape(element, tag, own, here)
            return
        first = len(self.layers)
        if tag == "use":
            self._walk_used(element, here)
        elif tag in ("svg", "symbol"):
            self._walk_viewport(element, tag, own.get("overflow", "hidden"), here)
        else:
            self._walk_children(element, here)
        if opacity < 1 and _overlap(self.layers[first:]):
            self.left_out["group opacity over overlapping shapes"] += 1

    def _walk_children(self, element: Element, here: _Context) -> None:
        if tag_of(element) == "g" and (stage := _stage(element)):
            here = dataclasses.replace(here, stage=int(stage[1]) - 1)
        children = [child for child in element if tag_of(child) in _KNOWN - {"symbol"}]
        if tag_of(element) == "switch":
            children = [child for child in children if _is_for_us(child)][:1]
        for child in children:
            self._walk(child, here)

    def _walk_viewport(self, element: Element, tag: str, overflow: str, here: _Context) -> None:
        """Walk the children of an ``<svg>`` or ``<symbol>``; count a clip where they reach over its edge."""
        width, height = here.viewport
        matrix = here.matrix
        is_root = here.depth == 1
        if not is_root:
            if tag == "svg":
                x = length_in_pixels(element.get("x"), 0.0, width)
                y = length_in_pixels(element.get("y"), 0.0, height)
                matrix = matrix @ translation(x, y)
            width = length_in_pixels(element.get("width"), width, width)
            height = length_in_pixels(element.get("height"), height, height)
        box = view_box(element)
        first = len(self.layers)
        viewport = (box[2], box[3]) if box else (width, height)
        inside = dataclasses.replace(here, matrix=matrix @ view_matrix(element, width, height), viewport=viewport)
        self._walk_children(element, inside)
        clips = not is_root and overflow not in ("visible", "auto")
        if clips and _reach_over(self.layers[first:], matrix, width, height):
            self.left_out["clips"] += 1

    def _walk_used(self, element: Element, here: _Context) -> None:
        target = element.get("href", element.get("{http://www.w3.org/1999/xlink}href", "")).strip()
        if not target.startswith("#"):
            raise ValueError(f"<use> refers to {target[:60]!r}, outside the file; copy it into the file")
        used = self._ids.get(target[1:])
        if used is None:
            self.left_out["references to nothing"] += 1
            return
        width, height = here.viewport
        x, y = length_in_pixels(element.get("x"), 0.0, width), length_in_pixels(element.get("y"), 0.0, height)
        if tag_of(used) in ("symbol", "svg"):  # takes the size that <use> states
            sides: dict[str, str] = {
                name: element.attrib[name] for name in ("width", "height") if name in element.attrib
            }
            resized = Element(used.tag, {**used.attrib, **sides})
            resized.extend(used)
            used = resized
        self._walk(used, dataclasses.replace(here, matrix=here.matrix @ translation(x, y)))

    def _add_shape(self, element: Element, tag: str, own: dict[str, str], here: _Context) -> None:
        if here.style.get("visibility", "visible") != "visible":
            return
        identifier = element.get("id", "")
        try:
            outline = svg_outline.transformed(self._outline(tag, own, here.viewport), here.matrix)
            if not all(np.isfinite(subpath).all() for subpath in outline):
                raise ValueError("coordinates are not finite")
        except ValueError as error:
            raise ValueError(f"<{tag}{f' id={identifier[:60]!r}' if identifier else ''}>: {error}") from error
        if is_stroked(here.style):
            self.left_out["strokes"] += 1
        color = fill_color(here.style, here.opacity, self.left_out)
        if color is None or not outline:
            return
        if here.style.get("fill-rule") == "evenodd":
            outline, equal = nonzero_from_even_odd(outline)
            if not equal:
                self.left_out["even-odd fills of crossing outlines"] += 1
        name = _name(element, identifier)
        self.layers.append(Layer(outline=outline, color=color, stage=here.stage, identifier=identifier, name=name))

    def _outline(self, tag: str, own: dict[str, str], viewport: tuple[float, float]) -> list[FloatArray]:
        if tag != "path":
            return svg_outline.shape_outline(tag, own, viewport)
        if "d" not in own:
            raise ValueError("has no path data; give it a d attribute or remove it")
        self._num_characters += len(own["d"])
        if self._num_characters > MAX_PATH_DATA:
            raise ValueError(f"more than {MAX_PATH_DATA} characters of path data; simplify the paths first")
        return svg_outline.path_outline(own["d"])


def _name(element: Element, identifier: str) -> str:
    """Return what a shape is called: its Inkscape label, or its title, or its id."""
    title = element.find(f"{{{SVG_NAMESPACE}}}title")
    texts = (
        element.get(f"{{{INKSCAPE_NAMESPACE}}}label", ""),
        "" if title is None else "".join(title.itertext()),
        name_from_id(identifier),
    )
    return next((text for text in texts if text.strip()), "")


def _stage(element: Element) -> re.Match[str] | None:
    """Match the stage that a group holds: in Inkscape's label, or, saved without Inkscape's attributes, in its id."""
    label = element.get(f"{{{INKSCAPE_NAMESPACE}}}label")
    if label is None:
        return _STAGE_ID.fullmatch(element.get("id", ""))
    is_layer = element.get(f"{{{INKSCAPE_NAMESPACE}}}groupmode") == "layer"
    return _STAGE_LABEL.fullmatch(label) if is_layer else None


def _is_for_us(element: Element) -> bool:
    """Whether a ``<switch>`` shows a child: in English, without extensions."""
    languages = element.get("systemLanguage", "en").replace(" ", "").split(",")
    extensions = element.get("requiredExtensions")
    return not extensions and any(language.split("-")[0] == "en" for language in languages)


def _overlap(layers: list[Layer]) -> bool:
    """Whether the boxes of any two layers overlap."""
    if len(layers) > MAX_COMPARED:
        return True
    bounds = np.array([layer.bounds for layer in layers]).reshape(-1, 4)
    for i, box in enumerate(bounds[:-1]):
        later = bounds[i + 1 :]
        if np.any(np.all((later[:, :2] < box[2:]) & (later[:, 2:] > box[:2]), axis=1)):
            return True
    return False


def _reach_over(layers: list[Layer], matrix: FloatArray, width: float, height: float) -> bool:
    """Whether a layer leaves the rectangle of `width` by `height` px that `matrix` puts on the canvas."""
    if not layers or not np.linalg.det(matrix):
        return False
    cubics = np.concatenate([subpath for layer in layers for subpath in layer.outline])
    points = bezier.evaluate(cubics, np.linspace(0, 1, 9)).reshape(-1, 2)
    x, y = (np.linalg.inv(matrix) @ np.column_stack([points, np.ones(len(points))]).T)[:2]
    slack = 1e-6 * max(width, height)
    return bool(min(x.min(), y.min()) < -slack or x.max() > width + slack or y.max() > height + slack)
