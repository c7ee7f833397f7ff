# SPDX-License-Identifier: Apache-2.0
"""Swatches: colours that an editor lists and can change for all layers at once.

In Inkscape, a swatch is a gradient of one stop with ``inkscape:swatch="solid"``, which fills refer to; viewers show it
as that colour.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from livecl.drawing.color_words import color_names
from livecl.drawing.colors import format_rgb
from livecl.drawing.fills import SOLID
from livecl.svg.servers import PaintServer

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing


def swatches_of(drawing: Drawing, unique_id: Callable[[str], str]) -> dict[str, PaintServer]:
    """Return the swatch of each colour of solid layers and the background of a quantized drawing, by its ``#rrggbb``.

    Its id is made from the colour's name, as ``swatch-dark-blue``.
    """
    colors = [] if drawing.background is None else [drawing.background]
    colors += [rgba for rgba, kind in zip(drawing.colors, drawing.fills.kinds, strict=True) if kind == SOLID]
    swatches = {}
    for code, rgb in {format_rgb(color): color[:3] for color in colors}.items():
        identifier = unique_id(f"swatch {color_names([rgb])[0]}")
        stop = f'<stop offset="0" stop-color="{code}"/>'
        # In user space: a shape without height, as a horizontal stroke, has no bounding box.
        attributes = f'id="{identifier}" inkscape:swatch="solid" gradientUnits="userSpaceOnUse"'
        swatches[code] = PaintServer(identifier, f"<linearGradient {attributes}>{stop}</linearGradient>")
    return swatches
