# SPDX-License-Identifier: Apache-2.0
"""Gradients of a drawing as SVG: `<linearGradient>` and `<radialGradient>` elements, equal ones shared."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing.colors import format_rgb
from livecl.drawing.fills import LINEAR, POSITION_DECIMALS, SOLID, Fills
from livecl.svg.gradients import is_flat

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing


class PaintServer(NamedTuple):
    """A gradient element and its id."""

    identifier: str
    definition: str


def format_gradients(drawing: Drawing, ids: list[str], precision: int) -> dict[int, PaintServer]:
    """Return the gradient of each layer of a quantized drawing that has one, by layer.

    Its id is made from that of the first layer that uses it, of `ids`; `precision` are decimals of coordinates in px.
    """
    taken, known, servers = set(ids), dict[str, PaintServer](), dict[int, PaintServer]()
    for layer in drawing.fills.gradient_layers.tolist():
        content = format_gradient(drawing, layer, "", precision)
        if content not in known:
            identifier = f"{ids[layer]}-fill"
            while identifier in taken:
                identifier += "-fill"
            taken.add(identifier)
            known[content] = PaintServer(identifier, format_gradient(drawing, layer, identifier, precision))
        servers[layer] = known[content]
    return servers


def format_gradient(drawing: Drawing, layer: int, identifier: str, precision: int) -> str:
    """Return the gradient element of a layer; drawing and precision as for :func:`format_gradients`."""
    kind, geometry = _geometry(drawing, layer, precision)
    return f'<{kind} id="{identifier}" gradientUnits="userSpaceOnUse" {geometry}>{_stops(drawing, layer)}</{kind}>'


def without_plain_gradients(fills: Fills, colors: FloatArray) -> tuple[Fills, FloatArray]:
    """Make gradients of a single colour solid; return the fills and the layers' colours, straight RGBA (N, 4).

    `fills` are quantized. A gradient without extent shows its last stop's colour; written as a gradient, it could not
    be read back equal.
    """
    plain = np.zeros(len(fills), dtype=bool)
    colors = colors.copy()
    for layer in fills.gradient_layers.tolist():
        stops, points = fills.stop_colors[fills.stops(layer)], fills.geometry[layer]
        flat = (points[0] == points[1]).all() if fills.kinds[layer] == LINEAR else is_flat(points[1:] - points[0])
        if flat or (stops == stops[0]).all():
            plain[layer] = True
            colors[layer] = stops[-1]
    if not plain.any():
        return fills, colors
    counts = np.where(plain, 0, np.diff(fills.stop_offsets))
    rows = ~plain[fills.stop_layers]
    kept = Fills(
        kinds=np.where(plain, SOLID, fills.kinds),
        geometry=fills.geometry,
        stop_offsets=np.cumsum([0, *counts]),
        stop_positions=fills.stop_positions[rows],
        stop_colors=fills.stop_colors[rows],
    )
    return kept, colors


def _geometry(drawing: Drawing, layer: int, precision: int) -> tuple[str, str]:
    """Return the element's name and its geometric attributes; an ellipse is a transformed unit circle."""
    points = drawing.fills.geometry[layer]

    def number(value: float) -> str:
        return format_decimal(round(value * 10**precision), precision)

    if drawing.fills.kinds[layer] == LINEAR:
        (x1, y1), (x2, y2) = points[:2].tolist()
        return "linearGradient", f'x1="{number(x1)}" y1="{number(y1)}" x2="{number(x2)}" y2="{number(y2)}"'
    center, axes = points[0], points[1:] - points[0]
    if not round(float(np.abs(np.linalg.det(axes))), 2 * precision):  # SVG ignores or refuses singular transforms
        return "radialGradient", f'cx="{number(center[0])}" cy="{number(center[1])}" r="0"'
    values = " ".join(number(value) for value in [*axes.ravel().tolist(), *center.tolist()])
    return "radialGradient", f'cx="0" cy="0" r="1" gradientTransform="matrix({values})"'


def _stops(drawing: Drawing, layer: int) -> str:
    """Return the `<stop>` elements of a layer."""
    own = drawing.fills.stops(layer)
    return "".join(
        _stop(position, rgba)
        for position, rgba in zip(
            drawing.fills.stop_positions[own].tolist(), drawing.fills.stop_colors[own], strict=True
        )
    )


def _stop(position: float, rgba: FloatArray) -> str:
    opacity = f' stop-opacity="{format_decimal(round(rgba[3] * 1e5), 5)}"' if rgba[3] < 1 else ""
    offset = format_decimal(round(position * 10**POSITION_DECIMALS), POSITION_DECIMALS)
    return f'<stop offset="{offset}" stop-color="{format_rgb(rgba)}"{opacity}/>'


def format_decimal(number: int, precision: int) -> str:
    """Return ``number * 10**-precision`` in as few characters as possible."""
    whole, part = divmod(abs(number), 10**precision)
    decimals = f".{part:0{precision}d}".rstrip("0") if part else ""
    return ("-" if number < 0 else "") + (str(whole) if whole or not part else "") + decimals
