# SPDX-License-Identifier: Apache-2.0
"""SVG to `Drawing`: the document's tree walked in paint order, with styles, transforms and `<use>` resolved.

The same walk reads this project's own files, exactly, and foreign ones, as far as closed filled paths represent them;
the rest is named in one warning.
"""

from __future__ import annotations

import collections
import dataclasses
import math
import os
import re
import warnings
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from livecl import bezier, svg_outline
from livecl.colors import Rgba, parse_rgba, share
from livecl.drawing import Drawing
from livecl.errors import SvgError
from livecl.svg_coordinates import canvas_size, length_in_pixels, transform_matrix, translation, view_box, view_matrix
from livecl.svg_document import MAX_DEPTH, parse_document, read_document, tag_of
from livecl.svg_style import StyleSheet, inherit
from livecl.svg_writer import INKSCAPE_NAMESPACE, MAX_PRECISION, SVG_NAMESPACE, name_from_id

FloatArray = NDArray[np.float64]

#: Most path data read, characters: some hundred thousand segments.
MAX_PATH_DATA = 5_000_000
#: Most elements visited, counted anew each time a <use> shows them.
MAX_ELEMENTS = 100_000
#: What a side of the canvas may exceed whole pixels by without one more, px: converted units are off by so little.
NO_PIXEL = 1e-3

_CONTAINERS = {"svg", "g", "a", "switch", "symbol"}
_SHAPES = {"path", "rect", "circle", "ellipse", "polygon", "polyline", "line"}
_LEFT_OUT = {"text": "text", "image": "images", "foreignObject": "foreign objects"}
_LEFT_OUT_PROPERTIES = {
    "clip-path": "clips",
    "mask": "masks",
    "filter": "filters",
    "mix-blend-mode": "blend modes",
    "marker-start": "markers",
    "marker-mid": "markers",
    "marker-end": "markers",
}
_STAGE = re.compile(r"stage (-?\d{1,9})")
_URL = re.compile(r"url\([^)]*\)\s*(.*)", re.DOTALL)


def read_svg(source: str | os.PathLike[str] | bytes) -> Drawing:
    """Read an SVG of closed filled paths.

    Lines, quadratics, arcs and basic shapes become cubics; transforms are applied; a group's opacity goes into its
    layers'; open subpaths are closed as filling does; even-odd fills are turned into equal nonzero ones where
    possible; a canvas of a fractional size is rounded up. What a `Drawing` cannot represent (strokes, text, images,
    gradients, clips, ...) is named, with counts, in one :class:`UserWarning`. A drawing saved by
    :func:`livecl.svg.save_svg` is read back equal.

    Parameters
    ----------
    source : path or bytes
        An SVG file, or its content.

    Returns
    -------
    Drawing
        A layer for each shape, bottom first; the background is that of a rectangle ``id="background"`` which covers
        the canvas beneath them, and None without one.

    Raises
    ------
    SvgError
        If the file cannot be read, is cut off, larger than 50 MB, refers to entities or other files, states no size,
        or holds a path without data or with numbers that are not finite.
    """
    name, data = read_document(source)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is not finite, and refused where it shows
            walker = _Walker(parse_document(data))
            drawing = walker.drawing()
    except ValueError as error:
        raise SvgError(f"{name}: {error}") from error
    if walker.left_out:
        counts = ", ".join(f"{kind} ({count})" for kind, count in sorted(walker.left_out.items()))
        warnings.warn(f"{name}: not representable as closed filled paths: {counts}", stacklevel=2)
    return drawing


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Layer:
    outline: list[FloatArray]
    color: Rgba
    stage: int
    identifier: str
    name: str

    @property
    def bounds(self) -> FloatArray:
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


class _Walker:
    """Collects the layers of a document, and counts what they cannot represent."""

    def __init__(self, root: ElementTree.Element) -> None:
        self.left_out: collections.Counter[str] = collections.Counter()
        self._layers: list[_Layer] = []
        self._ids: dict[str, ElementTree.Element] = {}
        self._num_elements = self._num_characters = 0
        sheets = []
        for element in root.iter():
            tag = tag_of(element) or ""
            self._ids.setdefault(element.get("id", ""), element)
            if tag == "style":
                sheets.append("".join(element.itertext()))
            elif tag == "set" or tag.startswith("animate"):
                self.left_out["animations"] += 1
        self._sheet = StyleSheet(sheets)
        if self._sheet.num_unknown:
            self.left_out["style rules"] = self._sheet.num_unknown
        self._size = canvas_size(root)
        start = _Context(matrix=np.eye(3), style={}, opacity=1.0, stage=0, viewport=self._size, depth=0)
        self._walk(root, start)

    def drawing(self) -> Drawing:
        """Return the layers as a drawing; ValueError where its coordinates or sides are too large."""
        layers, background = self._layers, None
        width, height = self._size
        if layers and self._is_background(layers[0]):
            background = np.array(layers[0].color[:3])
            layers = layers[1:]
        subpaths = [subpath for layer in layers for subpath in layer.outline]
        return Drawing(
            # Relative coordinates that a reader has added up are rounded to what was written.
            points=np.round(
                np.concatenate([np.zeros((0, 3, 2)), *(subpath[:, :3] for subpath in subpaths)]), MAX_PRECISION
            )
            + 0.0,
            colors=np.array([layer.color for layer in layers]).reshape(-1, 4),
            size=(max(1, math.ceil(height - NO_PIXEL)), max(1, math.ceil(width - NO_PIXEL))),
            background=background,
            subpath_offsets=np.cumsum([0, *(len(subpath) for subpath in subpaths)]),
            layer_offsets=np.cumsum([0, *(len(layer.outline) for layer in layers)]),
            stages=np.array([layer.stage for layer in layers], dtype=np.int32),
            names=[layer.name for layer in layers],
        )

    def _is_background(self, layer: _Layer) -> bool:
        if layer.identifier != "background" or layer.color[3] < 1 or len(layer.outline) != 1:
            return False
        x0, y0, x1, y1 = layer.bounds
        width, height = self._size
        covers = max(x0, y0) <= NO_PIXEL and x1 >= width - NO_PIXEL and y1 >= height - NO_PIXEL
        box_area = float((x1 - x0) * (y1 - y0))
        return bool(covers) and abs(bezier.signed_area(layer.outline[0])) >= box_area * (1 - 1e-9)

    def _walk(self, element: ElementTree.Element, around: _Context) -> None:
        tag = tag_of(element)
        if tag not in _CONTAINERS and tag not in _SHAPES and tag not in _LEFT_OUT and tag != "use":
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
        for name, kind in _LEFT_OUT_PROPERTIES.items():
            if own.get(name, "none") not in ("none", "normal"):
                self.left_out[kind] += 1
        opacity = _share_or_one(own.get("opacity"))
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
        first = len(self._layers)
        if tag == "use":
            self._walk_used(element, here)
        else:
            self._walk_children(element, tag, here)
        if opacity < 1 and _overlap(self._layers[first:]):
            self.left_out["group opacity over overlapping shapes"] += 1

    def _walk_children(self, element: ElementTree.Element, tag: str, here: _Context) -> None:
        if tag in ("svg", "symbol"):
            width, height = here.viewport
            corner = np.zeros(2)
            if here.depth > 1:
                if tag == "svg":
                    corner[:] = (
                        length_in_pixels(element.get("x"), 0.0, width),
                        length_in_pixels(element.get("y"), 0.0, height),
                    )
                width = length_in_pixels(element.get("width"), width, width)
                height = length_in_pixels(element.get("height"), height, height)
            box = view_box(element)
            here = dataclasses.replace(
                here,
                matrix=here.matrix @ translation(*corner) @ view_matrix(element, width, height),
                viewport=(box[2], box[3]) if box else (width, height),
            )
        label = _STAGE.fullmatch(element.get(f"{{{INKSCAPE_NAMESPACE}}}label", ""))
        if label and element.get(f"{{{INKSCAPE_NAMESPACE}}}groupmode") == "layer":
            here = dataclasses.replace(here, stage=int(label[1]) - 1)
        for child in element:
            if tag_of(child) != "symbol":
                self._walk(child, here)

    def _walk_used(self, element: ElementTree.Element, here: _Context) -> None:
        target = element.get("href", element.get("{http://www.w3.org/1999/xlink}href", "")).strip()
        if not target.startswith("#"):
            raise ValueError(f"<use> refers to {target[:60]!r}, outside the file; copy it into the file")
        used = self._ids.get(target[1:])
        if used is None:
            self.left_out["references to nothing"] += 1
            return
        width, height = here.viewport
        x, y = length_in_pixels(element.get("x"), 0.0, width), length_in_pixels(element.get("y"), 0.0, height)
        if tag_of(used) == "symbol":
            viewport = (
                length_in_pixels(element.get("width"), width, width),
                length_in_pixels(element.get("height"), height, height),
            )
            here = dataclasses.replace(here, viewport=viewport)
        self._walk(used, dataclasses.replace(here, matrix=here.matrix @ translation(x, y)))

    def _add_shape(self, element: ElementTree.Element, tag: str, own: dict[str, str], here: _Context) -> None:
        identifier = element.get("id", "")
        if here.style.get("visibility", "visible") != "visible":
            return
        try:
            outline = svg_outline.transformed(self._outline(tag, own, here.viewport), here.matrix)
            if not all(np.isfinite(subpath).all() for subpath in outline):
                raise ValueError("coordinates are not finite")
        except ValueError as error:
            raise ValueError(f"<{tag}{f' id={identifier[:60]!r}' if identifier else ''}>: {error}") from error
        if self._is_stroked(here.style):
            self.left_out["strokes"] += 1
        color = self._fill(here)
        if color is None or not outline:
            return
        if here.style.get("fill-rule") == "evenodd":
            outline, equal = svg_outline.nonzero_from_even_odd(outline)
            if not equal:
                self.left_out["even-odd fills of crossing outlines"] += 1
        self._layers.append(
            _Layer(
                outline=outline, color=color, stage=here.stage, identifier=identifier, name=_name(element, identifier)
            )
        )

    def _outline(self, tag: str, own: dict[str, str], viewport: tuple[float, float]) -> list[FloatArray]:
        if tag != "path":
            return svg_outline.shape_outline(tag, own, viewport)
        if "d" not in own:
            raise ValueError("has no path data; give it a d attribute or remove it")
        self._num_characters += len(own["d"])
        if self._num_characters > MAX_PATH_DATA:
            raise ValueError(f"more than {MAX_PATH_DATA} characters of path data; simplify the paths first")
        return svg_outline.path_outline(own["d"])

    def _is_stroked(self, style: dict[str, str]) -> bool:
        width = style.get("stroke-width", "1").strip()
        return (
            style.get("stroke", "none") not in ("none", "transparent")
            and _share_or_one(style.get("stroke-opacity")) > 0
            and re.fullmatch(r"0*\.?0*[a-z%]*", width) is None
        )

    def _fill(self, here: _Context) -> Rgba | None:
        """Straight RGBA of the fill, None where nothing is filled."""
        paint = here.style.get("fill", "black").strip()
        if match := _URL.fullmatch(paint):
            self.left_out["gradient or pattern fills"] += 1
            paint = match[1].strip() or "none"
        if paint.lower() == "currentcolor":
            paint = here.style.get("color", "black")
        if paint == "none":
            return None
        try:
            red, green, blue, alpha = parse_rgba(paint)
        except ValueError:
            self.left_out["unknown colours read as black"] += 1
            red, green, blue, alpha = 0.0, 0.0, 0.0, 1.0
        opacity = alpha * _share_or_one(here.style.get("fill-opacity")) * here.opacity
        level = round(opacity * 255) / 255  # a saved opacity is a multiple of 1/255, written to five decimals
        return red, green, blue, level if abs(opacity - level) < 6e-6 else opacity


def _name(element: ElementTree.Element, identifier: str) -> str:
    """Return what a shape is called: its Inkscape label, or its title, or its id."""
    title = element.find(f"{{{SVG_NAMESPACE}}}title")
    texts = (
        element.get(f"{{{INKSCAPE_NAMESPACE}}}label", ""),
        "" if title is None else "".join(title.itertext()),
        name_from_id(identifier),
    )
    return next((text for text in texts if text.strip()), "")


def _share_or_one(text: str | None) -> float:
    """Return an opacity; one that is not given or cannot be read is 1, as CSS ignores it."""
    try:
        return 1.0 if text is None else share(text)
    except ValueError:
        return 1.0


def _overlap(layers: list[_Layer]) -> bool:
    """Whether the boxes of any two layers overlap."""
    bounds = np.array([layer.bounds for layer in layers]).reshape(-1, 4)
    for i, box in enumerate(bounds[:-1]):
        later = bounds[i + 1 :]
        if np.any(np.all((later[:, :2] < box[2:]) & (later[:, 2:] > box[:2]), axis=1)):
            return True
    return False
