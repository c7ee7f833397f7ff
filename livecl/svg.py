# SPDX-License-Identifier: Apache-2.0
"""`Drawing` to SVG: eight-bit colours, rounded coordinates, a group for each stage.

What is saved is what a drawing holds after :func:`quantize`, to the last digit: :func:`read_svg` gives it back equal.
"""

from __future__ import annotations

import itertools
import os

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import Drawing
from livecl.files import write_atomically
from livecl.svg_reader import INKSCAPE_NAMESPACE, SVG_NAMESPACE, read_svg
from livecl.svg_style import parse_color

__all__ = ["format_svg", "parse_color", "quantize", "read_svg", "save_svg"]

FloatArray = NDArray[np.float64]

#: Most decimals of a coordinate: beyond it float64 does not hold the largest coordinates exactly rounded.
MAX_PRECISION = 9


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
        Colours, opacities and background at multiples of 1/255, points at multiples of ``10**-precision``.
    """
    if precision not in range(MAX_PRECISION + 1):
        raise ValueError(f"precision: got {precision!r}, wanted 0 to {MAX_PRECISION} decimals")
    return drawing.replace(
        points=np.round(drawing.points, int(precision)) + 0.0,  # turns -0 into 0
        colors=np.round(drawing.colors * 255) / 255,
        background=None if drawing.background is None else np.round(drawing.background * 255) / 255,
    )


def format_svg(drawing: Drawing, precision: int = 3) -> str:
    """Return a drawing as SVG text.

    A ``<path>`` for each layer in paint order, filled by the nonzero rule; layers that one stage added, where they
    follow each other, form a group which Inkscape shows as a layer; the background is a rectangle beneath them.

    Parameters
    ----------
    drawing : Drawing
        Any drawing; it is quantized first.
    precision : int
        Decimals kept of coordinates in px, 0 to 9.
    """
    drawing = quantize(drawing, precision)
    height, width = drawing.size
    lines = [
        f'<svg xmlns="{SVG_NAMESPACE}" xmlns:inkscape="{INKSCAPE_NAMESPACE}" '
        f'width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
    ]
    if drawing.background is not None:
        lines.append(
            f'  <rect id="background" width="{width}" height="{height}" fill="{_format_rgb(drawing.background)}"/>'
        )
    runs_of_stage: dict[int, int] = {}
    for stage, layers in itertools.groupby(range(drawing.num_layers), lambda layer: int(drawing.stages[layer])):
        run = runs_of_stage[stage] = runs_of_stage.get(stage, 0) + 1
        group_id = f"stage-{stage + 1}" + (f"-{run}" if run > 1 else "")
        lines.append(f'  <g inkscape:groupmode="layer" inkscape:label="stage {stage + 1}" id="{group_id}">')
        lines.extend(f"    {_format_layer(drawing, layer, precision)}" for layer in layers)
        lines.append("  </g>")
    lines.append("</svg>\n")
    return "\n".join(lines)


def save_svg(drawing: Drawing, path: str | os.PathLike[str], precision: int = 3) -> None:
    """Write a drawing as an SVG file, replacing an existing one atomically; arguments as in :func:`format_svg`."""
    write_atomically(path, format_svg(drawing, precision))


def _format_layer(drawing: Drawing, layer: int, precision: int) -> str:
    rgba = drawing.colors[layer]
    first, end = drawing.layer_offsets[layer : layer + 2]
    subpaths = itertools.pairwise(drawing.subpath_offsets[first : end + 1])
    data = " ".join(_format_subpath(drawing.points[start:stop], precision) for start, stop in subpaths)
    opacity = f' fill-opacity="{_format_number(rgba[3], 5)}"' if rgba[3] < 1 else ""
    return f'<path id="layer-{layer + 1}" fill="{_format_rgb(rgba)}"{opacity} fill-rule="nonzero" d="{data}"/>'


def _format_subpath(points: FloatArray, precision: int) -> str:
    """Path data of one subpath (m, 3, 2), its last cubic written out to the first anchor before it is closed."""
    numbers = [_format_number(number, precision) for number in points.reshape(-1)]
    start = f"{numbers[0]} {numbers[1]}"
    return f"M {start} C {' '.join(numbers[2:])} {start} Z"


def _format_number(number: float, precision: int) -> str:
    text = f"{number:.{precision}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _format_rgb(rgb: FloatArray) -> str:
    red, green, blue = (round(level * 255) for level in rgb[:3].tolist())
    return f"#{red:02x}{green:02x}{blue:02x}"
