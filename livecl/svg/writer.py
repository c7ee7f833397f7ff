# SPDX-License-Identifier: Apache-2.0
"""`Drawing` to SVG: eight-bit colours, rounded coordinates, layers that an editor lists by name."""

from __future__ import annotations

import itertools
import os
import re
from typing import TYPE_CHECKING, Literal, get_args
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.colors import format_rgb
from livecl.drawing.strokes import DEFAULT_MITER_LIMIT
from livecl.files import write_atomically
from livecl.geometry.strokes import CAPS, JOINS
from livecl.svg.servers import PaintServer, format_decimal, format_gradients, without_plain_gradients

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
LayerStyle = Literal["inkscape", "plain"]

SVG_NAMESPACE = "http://www.w3.org/2000/svg"
INKSCAPE_NAMESPACE = "http://www.inkscape.org/namespaces/inkscape"
#: Most decimals of a coordinate, and what the reader rounds to: beyond it float64 does not hold the largest ones.
MAX_PRECISION = 9

_OWN_ID = re.compile(r"(layer-\d+)((?:-[a-z]+)+)")


def quantize(drawing: Drawing, precision: int = 3) -> Drawing:
    """Return the drawing that a saved SVG holds: colours of 8 bits, coordinates rounded.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    precision : int
        Decimals kept of coordinates in px, 0 to 9.

    Returns
    -------
    Drawing
        Colours, opacities, stops and background at multiples of 1/255, points of outlines and gradients at multiples of
        ``10**-precision``, and so widths of strokes; gradients that are of one colour then, or without extent, are
        solid.
    """
    if precision not in range(MAX_PRECISION + 1):
        raise ValueError(f"precision: got {precision!r}, wanted 0 to {MAX_PRECISION} decimals")
    fills, colors = without_plain_gradients(drawing.fills.quantized(int(precision)), drawing.colors)
    return drawing.replace(
        points=np.round(drawing.points, int(precision)) + 0.0,  # turns -0 into 0
        colors=np.round(colors * 255) / 255,
        background=None if drawing.background is None else np.round(drawing.background * 255) / 255,
        fills=fills,
        strokes=drawing.strokes.quantized(int(precision)),
    )


def format_svg(drawing: Drawing, precision: int = 3, layers: LayerStyle = "inkscape") -> str:
    """Return a drawing as SVG text.

    A ``<path>`` for each layer in paint order, filled by the nonzero rule, or stroked; the background is a rectangle
    beneath them.
    Every path has an id and a name: its own, or one of index, colour and place (:attr:`Drawing.labels`).

    Parameters
    ----------
    drawing : Drawing
        Any drawing; it is quantized first.
    precision : int
        Decimals kept of coordinates in px, 0 to 9.
    layers : {"inkscape", "plain"}
        ``inkscape``: layers that one stage added, where they follow each other, form a group which Inkscape shows as a
        layer, and names are Inkscape's labels. ``plain``: neither groups nor Inkscape's attributes; names are ids, or
        a ``<title>`` where an id cannot say them. The stages are not kept.
    """
    if layers not in get_args(LayerStyle):
        raise ValueError(f"layers: got {layers!r}, wanted one of {', '.join(get_args(LayerStyle))}")
    drawing = quantize(drawing, precision)
    height, width = drawing.size
    namespaces = f'xmlns="{SVG_NAMESPACE}"'
    if layers == "inkscape":
        namespaces += f' xmlns:inkscape="{INKSCAPE_NAMESPACE}"'
    lines = [f'<svg {namespaces} width="{width}" height="{height}" viewBox="0 0 {width} {height}">']
    if drawing.background is not None:
        lines.append(
            f'  <rect id="background" width="{width}" height="{height}" fill="{format_rgb(drawing.background)}"/>'
        )
    groups = _stage_groups(drawing) if layers == "inkscape" else []
    labels = drawing.labels
    ids = _unique_ids(labels, reserved=["background", *(group_id for group_id, _, _ in groups)])
    servers = format_gradients(drawing, ids, precision)
    if servers:
        definitions = dict.fromkeys(server.definition for server in servers.values())
        lines += ["  <defs>", *(f"    {definition}" for definition in definitions), "  </defs>"]
    paths = [
        _format_path(identifier, label, _format_paint(drawing, layer, precision, servers.get(layer)), layers)
        for layer, (identifier, label) in enumerate(zip(ids, labels, strict=True))
    ]
    if layers == "plain":
        lines.extend(f"  {path}" for path in paths)
    for group_id, label, members in groups:
        lines.append(f'  <g inkscape:groupmode="layer" inkscape:label="{label}" id="{group_id}">')
        lines.extend(f"    {paths[layer]}" for layer in members)
        lines.append("  </g>")
    lines.append("</svg>\n")
    return "\n".join(lines)


def save_svg(
    drawing: Drawing, path: str | os.PathLike[str], precision: int = 3, layers: LayerStyle = "inkscape"
) -> None:
    """Write a drawing as an SVG file, replacing an existing one atomically; arguments as in :func:`format_svg`."""
    write_atomically(path, format_svg(drawing, precision, layers))


def name_from_id(identifier: str) -> str:
    """Return the name that an id stands for: an id made of a label of this program's gives back the label's spaces."""
    own = _OWN_ID.fullmatch(identifier)
    return own[1] + own[2].replace("-", " ") if own else identifier


def _stage_groups(drawing: Drawing) -> list[tuple[str, str, list[int]]]:
    """Return id, label and layers of each run of layers of one stage."""
    groups = []
    runs_of_stage: dict[int, int] = {}
    for stage, members in itertools.groupby(range(drawing.num_layers), lambda layer: int(drawing.stages[layer])):
        run = runs_of_stage[stage] = runs_of_stage.get(stage, 0) + 1
        group_id = f"stage-{stage + 1}" + (f"-{run}" if run > 1 else "")
        groups.append((group_id, f"stage {stage + 1}", list(members)))
    return groups


def _unique_ids(labels: tuple[str, ...], reserved: list[str]) -> list[str]:
    """Return an id for each label: without spaces and signs, numbered where it is taken."""
    taken, ids, counts = set(reserved), [], dict.fromkeys(reserved, 1)
    for label in labels:
        base = identifier = re.sub(r"[^\w.-]+", "-", label)
        while identifier in taken:
            counts[base] = counts.get(base, 1) + 1
            identifier = f"{base}-{counts[base]}"
        taken.add(identifier)
        ids.append(identifier)
    return ids


def _format_path(identifier: str, label: str, paint: str, layers: LayerStyle) -> str:
    if layers == "inkscape":
        return f'<path id="{identifier}" inkscape:label={quoteattr(label)} {paint}/>'
    if name_from_id(identifier) == label:
        return f'<path id="{identifier}" {paint}/>'
    return f'<path id="{identifier}" {paint}><title>{escape(label)}</title></path>'


def _format_paint(drawing: Drawing, layer: int, precision: int, server: PaintServer | None) -> str:
    """Paint and path data of a layer, as attributes. The nonzero rule is SVG's default."""
    rgba, is_stroked = drawing.colors[layer], drawing.strokes.widths[layer] > 0
    name = "stroke" if is_stroked else "fill"
    paint = f'{name}="{format_rgb(rgba) if server is None else f"url(#{server.identifier})"}"'
    if server is None and rgba[3] < 1:
        paint += f' {name}-opacity="{format_decimal(round(rgba[3] * 1e5), 5)}"'
    if is_stroked:
        paint = f'fill="none" {paint} {_format_pen(drawing, layer, precision)}'
    first = drawing.layer_offsets[layer]
    data = "".join(
        _format_subpath(drawing.points[rows], precision, is_open=bool(drawing.strokes.is_open[first + number]))
        for number, rows in enumerate(drawing.subpaths(layer))
    )
    return f'{paint} d="{data}"'


def _format_pen(drawing: Drawing, layer: int, precision: int) -> str:
    """Width, caps and joins of a stroked layer, as attributes; SVG's defaults are left out."""
    strokes = drawing.strokes
    pen = f'stroke-width="{format_decimal(round(strokes.widths[layer] * 10**precision), precision)}"'
    if strokes.caps[layer]:
        pen += f' stroke-linecap="{CAPS[strokes.caps[layer]]}"'
    if strokes.joins[layer]:
        pen += f' stroke-linejoin="{JOINS[strokes.joins[layer]]}"'
    elif strokes.miter_limits[layer] != DEFAULT_MITER_LIMIT:
        pen += f' stroke-miterlimit="{strokes.miter_limits[layer]:.9g}"'
    return pen


def _format_subpath(points: FloatArray, precision: int, is_open: bool) -> str:
    """Path data of one subpath (m, 3, 2); a closed one's last cubic is written out to the first anchor.

    Coordinates are relative, which is a fifth shorter, unless the subpath is so long or so far away that a reader in
    float64, which adds them up, could miss a rounded coordinate by half of the last decimal that it rounds to.
    """
    units = np.rint(points * 10**precision).astype(np.int64)
    row = units.reshape(-1, 2)[:-2] if is_open else np.concatenate([units.reshape(-1, 2), units[0, :1]])
    drift = 2 * (len(points) + 1) * np.spacing(np.abs(points).max())
    relative = drift < 0.5 * 10**-MAX_PRECISION
    moves = row[1:] - np.repeat(row[:-1:3], 3, axis=0) if relative else row[1:]
    data = f"M{_format_numbers(row[:1], precision)}{'c' if relative else 'C'}{_format_numbers(moves, precision)}"
    return data if is_open else f"{data}Z"


def _format_numbers(units: IntArray, precision: int) -> str:
    """Return numbers of the last decimal, spaced only where no sign or point parts them already."""
    numbers = [format_decimal(number, precision) for number in units.reshape(-1).tolist()]
    parts = [
        number if number[0] == "-" or (number[0] == "." and "." in before) else " " + number
        for before, number in itertools.pairwise(numbers)
    ]
    return numbers[0] + "".join(parts)
