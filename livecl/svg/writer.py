# SPDX-License-Identifier: Apache-2.0
"""`Drawing` to SVG: 8-bit colours, rounded coordinates, named layers."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from livecl.drawing.borders import border_pairs, paired_rows
from livecl.drawing.colors import format_rgb
from livecl.drawing.fills import SOLID
from livecl.drawing.labels import name_from_id
from livecl.drawing.strokes import DEFAULT_MITER_LIMIT
from livecl.files import write_atomically
from livecl.geometry.strokes import CAPS, JOINS
from livecl.svg.groups import GroupKind, format_members, group_ids, groups_of, unique_ids
from livecl.svg.markup import escape, quoteattr
from livecl.svg.outline_data import MAX_PRECISION, format_outline, rounded_points
from livecl.svg.primitives import Primitive, primitive_of
from livecl.svg.servers import PaintServer, format_decimal, format_gradients, without_plain_gradients
from livecl.svg.swatches import swatches_of

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

LayerStyle = Literal["inkscape", "plain"]

SVG_NAMESPACE = "http://www.w3.org/2000/svg"
INKSCAPE_NAMESPACE = "http://www.inkscape.org/namespaces/inkscape"


def quantize(drawing: Drawing, precision: int = 3, *, cubics: bool = False) -> Drawing:
    """Round a drawing as a saved SVG does: colours to 8 bits, coordinates to decimals.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    precision : int
        Decimals kept of coordinates in px, 0 to 9.
    cubics : bool
        Whether it is to be written as cubics only, see :func:`format_svg`: points are then merely rounded.

    Returns
    -------
    Drawing
        Colours, opacities, stops and background are multiples of 1/255; points of outlines and gradients and widths of
        strokes are multiples of ``10**-precision``; handles of straight segments are at thirds; circles, ellipses and
        rectangles are those that the reader makes of rounded lengths; gradients that are then of one colour, or without
        extent, are solid.
    """
    if precision not in range(MAX_PRECISION + 1):
        raise ValueError(f"precision: got {precision!r}, wanted 0 to {MAX_PRECISION} decimals")
    drawn = np.full(drawing.num_segments, not cubics)
    drawn[drawing.subpath_offsets[1:][drawing.strokes.is_open] - 1] = False
    fills, colors = without_plain_gradients(drawing.fills.quantized(int(precision)), drawing.colors)
    points = rounded_points(drawing.points, drawing.next_segments, drawn, int(precision))
    found, rounded = {}, {}
    if not cubics:
        found = primitives(drawing, int(precision))
        rounded = primitives(drawing.moved(points.copy(), drawing.colors, None), int(precision))
    for layer, primitive in {**rounded, **found}.items():  # rounding may turn further outlines into shapes
        points[slice(*drawing.segment_offsets[layer : layer + 2])] = primitive.points
    fill_rows, stroke_rows = paired_rows(drawing, border_pairs(drawing))
    points[stroke_rows] = points[fill_rows]
    return drawing.replace(
        points=points,
        colors=np.round(colors * 255) / 255,
        background=None if drawing.background is None else np.round(drawing.background * 255) / 255,
        fills=fills,
        strokes=drawing.strokes.quantized(int(precision)),
    )


def primitives(drawing: Drawing, precision: int = 3) -> dict[int, Primitive]:
    """Return the circles, ellipses and rectangles among the filled layers, by layer, their lengths rounded."""
    found = {}
    can_turn = drawing.fills.kinds == SOLID  # a transform would turn a gradient, too
    pairs = border_pairs(drawing)
    can_turn[pairs[:, 0]] &= can_turn[pairs[:, 1]]
    for layer in np.flatnonzero((np.diff(drawing.layer_offsets) == 1) & (drawing.strokes.widths == 0)).tolist():
        rows = slice(*drawing.segment_offsets[layer : layer + 2])
        turned = can_turn[layer]
        primitive = primitive_of(drawing.points[rows], precision, upright=not turned)
        if primitive is not None:
            found[layer] = primitive
    return found


def layer_kinds(drawing: Drawing, precision: int = 3) -> list[str]:
    """Return the kind of each layer's element: "circle", "ellipse", "rectangle", "path" (filled) or "stroke"."""
    kinds = ["stroke" if width else "path" for width in drawing.strokes.widths.tolist()]
    for layer, primitive in primitives(drawing, precision).items():
        kinds[layer] = "rectangle" if primitive.tag == "rect" else primitive.tag
    return kinds


def format_svg(
    drawing: Drawing,
    precision: int = 3,
    layers: LayerStyle = "inkscape",
    *,
    groups: GroupKind | None = None,
    swatches: bool = False,
    cubics: bool = False,
) -> str:
    """Return a drawing as SVG text.

    Each layer becomes a ``<path>`` or a basic shape in paint order, filled by the nonzero rule, or stroked; a fill and
    the stroke around it (:func:`livecl.drawing.borders.border_pairs`) share one element. The background is a rectangle
    below them. Every element has an id and a name: the layer's own, or one made of colour, shape and place
    (:attr:`Drawing.labels`).

    Parameters
    ----------
    drawing : Drawing
        Any drawing; it is quantized first.
    precision : int
        Decimals kept of coordinates in px, 0 to 9.
    layers : {"inkscape", "plain"}
        ``inkscape``: with groups, and names as Inkscape's labels. ``plain``: neither groups nor Inkscape's attributes;
        names are ids, or a ``<title>`` if they are no valid id.
    groups : {"thing", "stage", "none"}, optional
        ``thing``: the drawing's own groups (:attr:`Drawing.groups`). ``stage``: consecutive layers of one stage form a
        group that Inkscape shows as a layer; only then are stages saved. ``none``: no groups. By default, the drawing's
        own groups, or if it has none, its stages.
    swatches : bool
        With `layers` "inkscape": whether colours are Inkscape swatches, which can be edited for all layers at once.
    cubics : bool
        Whether all layers are written as paths of cubics, as animations need. Otherwise straight segments are lines,
        and circles, ellipses and rectangles are elements of that kind.

    Examples
    --------
    >>> from livecl.svg import read_svg
    >>> circle = read_svg(b'<svg width="9" height="9"><circle r="4" fill="red"/></svg>')
    >>> print(format_svg(circle, layers="plain"), end="")
    <svg xmlns="http://www.w3.org/2000/svg" width="9" height="9" viewBox="0 0 9 9">
      <circle id="red-circle-top-left" fill="#ff0000" cx="0" cy="0" r="4"/>
    </svg>
    """
    if layers not in get_args(LayerStyle):
        raise ValueError(f"layers: got {layers!r}, wanted one of {', '.join(get_args(LayerStyle))}")
    drawing = quantize(drawing, precision, cubics=cubics)
    height, width = drawing.size
    namespaces = f'xmlns="{SVG_NAMESPACE}"'
    if layers == "inkscape":
        namespaces += f' xmlns:inkscape="{INKSCAPE_NAMESPACE}"'
    lines = [f'<svg {namespaces} width="{width}" height="{height}" viewBox="0 0 {width} {height}">']
    members = groups_of(drawing, groups if layers == "inkscape" else "none")
    labels, unique_id = drawing.labels, unique_ids(["background", *group_ids(members)])
    strokes_of = dict(border_pairs(drawing).tolist())
    absorbed = {stroke: layer for layer, stroke in strokes_of.items()}
    ids = ["" if layer in absorbed else unique_id(label) for layer, label in enumerate(labels)]
    for stroke, layer in absorbed.items():
        ids[stroke] = unique_id(f"{labels[layer]} stroke")
    servers = format_gradients(drawing, ids, precision)
    named = swatches_of(drawing, unique_id) if swatches and layers == "inkscape" else {}
    definitions = dict.fromkeys(server.definition for server in (*named.values(), *servers.values()))
    if definitions:
        lines += ["  <defs>", *(f"    {definition}" for definition in definitions), "  </defs>"]
    if drawing.background is not None:
        ground = _paint_of(format_rgb(drawing.background), named)
        lines.append(f'  <rect id="background" width="{width}" height="{height}" fill="{ground}"/>')
    shapes = {} if cubics else primitives(drawing, precision)
    paints = []
    for layer in range(drawing.num_layers):
        server = servers.get(layer)
        color = _paint_of(format_rgb(drawing.colors[layer]), named) if server is None else f"url(#{server.identifier})"
        paints.append(_format_paint(drawing, layer, precision, color))
    paths: list[str | None] = []
    for layer, (identifier, label) in enumerate(zip(ids, labels, strict=True)):
        if layer in absorbed:
            paths.append(None)
            continue
        shape = shapes.get(layer)
        tag = "path" if shape is None else shape.tag
        geometry = _format_data(drawing, layer, precision, cubics) if shape is None else shape.text
        paint, stroke = paints[layer], strokes_of.get(layer)
        if stroke is not None:
            paint += f" {paints[stroke]}" + (' paint-order="stroke"' if stroke < layer else "")
        elif drawing.strokes.widths[layer]:
            paint = f'fill="none" {paint}'
        paths.append(_format_element(tag, identifier, label, f"{paint} {geometry}", layers))
    lines.extend(format_members(members, paths))
    lines.append("</svg>\n")
    return "\n".join(lines)


def save_svg(
    drawing: Drawing,
    path: str | os.PathLike[str],
    precision: int = 3,
    layers: LayerStyle = "inkscape",
    *,
    groups: GroupKind | None = None,
    swatches: bool = False,
) -> None:
    """Write a drawing as an SVG file, replacing an existing one atomically; arguments as in :func:`format_svg`."""
    write_atomically(path, format_svg(drawing, precision, layers, groups=groups, swatches=swatches))


def _format_element(tag: str, identifier: str, label: str, attributes: str, layers: LayerStyle) -> str:
    if layers == "inkscape":
        return f'<{tag} id="{identifier}" inkscape:label={quoteattr(label)} {attributes}/>'
    if name_from_id(identifier) == label:
        return f'<{tag} id="{identifier}" {attributes}/>'
    return f'<{tag} id="{identifier}" {attributes}><title>{escape(label)}</title></{tag}>'


def _paint_of(code: str, swatches: dict[str, PaintServer]) -> str:
    return f"url(#{swatches[code].identifier})" if code in swatches else code


def _format_paint(drawing: Drawing, layer: int, precision: int, color: str) -> str:
    """Format the paint of a layer as attributes. The nonzero rule is SVG's default."""
    rgba, is_stroked = drawing.colors[layer], drawing.strokes.widths[layer] > 0
    name = "stroke" if is_stroked else "fill"
    paint = f'{name}="{color}"'
    if drawing.fills.kinds[layer] == SOLID and rgba[3] < 1:
        paint += f' {name}-opacity="{format_decimal(round(rgba[3] * 1e5), 5)}"'
    if is_stroked:
        paint += f" {format_pen(drawing, layer, precision)}"
    return paint


def _format_data(drawing: Drawing, layer: int, precision: int, cubics: bool) -> str:
    first = drawing.layer_offsets[layer]
    data = "".join(
        format_outline(drawing.points[rows], precision, bool(drawing.strokes.is_open[first + number]), cubics)
        for number, rows in enumerate(drawing.subpaths(layer))
    )
    return f'd="{data}"'


def format_pen(drawing: Drawing, layer: int, precision: int) -> str:
    """Format width, caps and joins of a stroked layer as attributes; SVG's defaults are left out."""
    strokes = drawing.strokes
    pen = f'stroke-width="{format_decimal(round(strokes.widths[layer] * 10**precision), precision)}"'
    if strokes.caps[layer]:
        pen += f' stroke-linecap="{CAPS[strokes.caps[layer]]}"'
    if strokes.joins[layer]:
        pen += f' stroke-linejoin="{JOINS[strokes.joins[layer]]}"'
    elif strokes.miter_limits[layer] != DEFAULT_MITER_LIMIT:
        pen += f' stroke-miterlimit="{strokes.miter_limits[layer]:.9g}"'
    return pen
