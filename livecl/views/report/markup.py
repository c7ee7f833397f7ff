# SPDX-License-Identifier: Apache-2.0
"""Parts of the report's page: drawings and tables as HTML and SVG, with all external text escaped."""

from __future__ import annotations

import base64
import hashlib
import html
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from livecl.drawing.colors import format_rgb
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import KINDS, LINEAR, RADIAL
from livecl.drawing.labels import layer_labels
from livecl.run.result import Stage
from livecl.svg.servers import format_gradient
from livecl.svg.writer import format_pen, quantize
from livecl.views.sheet import count_of

#: Decimals of coordinates in the page, px: of the finished drawing, as saved, and of the stages' drawings.
PRECISION, STAGE_PRECISION = 3, 2
#: Prefix of the ids of the finished drawing's gradients.
PREFIX = "fill"
#: Element and extent of a swatch's gradient, by the kind of fill.
SWATCHES = {
    LINEAR: ("linearGradient", 'x1="0" y1="0" x2="1" y2="0"'),
    RADIAL: ("radialGradient", 'cx=".5" cy=".5" r=".707" gradientTransform="scale(1)"'),
}


def text(value: object) -> str:
    """Escape a value for HTML text and attributes."""
    return html.escape(str(value), quote=True)


def png_uri(pixels: NDArray[Any], palette: NDArray[np.uint8] | None = None) -> str:
    """Return a picture as the ``data:`` address of a PNG file.

    Parameters
    ----------
    pixels : (H, W, 3) or (H, W, 4) float in [0, 1], or (H, W) uint8 with a palette
        Straight colours, or indices.
    palette : (256, 4) uint8, optional
        Straight RGBA of each index.
    """
    stream = io.BytesIO()
    if palette is None:
        Image.fromarray(np.rint(np.clip(pixels, 0, 1) * 255).astype(np.uint8)).save(stream, "PNG", optimize=True)
    else:
        picture = Image.fromarray(pixels, "P")
        picture.putpalette(palette[:, :3].tobytes())
        picture.save(stream, "PNG", optimize=True, transparency=palette[:, 3].tobytes())
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode('ascii')}"


def drawing_svg(
    drawing: Drawing, precision: int, attributes: str = "", *, facts: bool = False, prefix: str = ""
) -> str:
    """Return a drawing as an ``<svg>`` element; its paths are ``M``, ``C`` and ``Z`` in absolute numbers.

    With `facts`, each path has its layer's label and fill in ``data-facts``. Only gradients have ids, which begin with
    `prefix`, by default a digest of the gradients, as a page may hold several drawings.
    """
    height, width = drawing.size
    ground = ""
    if drawing.background is not None:
        ground = f'<rect class="ground" width="{width}" height="{height}" fill="{format_rgb(drawing.background)}"/>'
    saved = quantize(drawing, precision)
    if not prefix:
        digest = hashlib.sha256(
            b"".join(array.tobytes() for array in vars(saved.fills).values() if isinstance(array, np.ndarray))
        )
        prefix = f"fill-{digest.hexdigest()[:12]}"
    gradients = {layer: f"{prefix}-{layer}" for layer in saved.fills.gradient_layers.tolist()}
    elements = "".join(format_gradient(saved, layer, name, precision) for layer, name in gradients.items())
    definitions = f"<defs>{elements}</defs>" if elements else ""
    paths = []
    labels = layer_labels(drawing) if facts else ("",) * drawing.num_layers
    for layer, label in enumerate(labels):
        paint = f'fill="url(#{gradients[layer]})"' if layer in gradients else solid_paint(saved.colors[layer])
        if saved.strokes.widths[layer]:
            paint = f'{paint.replace("fill", "stroke", 1).replace(" fill-", " stroke-")} fill="none"'
            paint += f" {format_pen(saved, layer, precision)}"
        said = f' data-facts="{text(f"{label} · {fill_of(saved, layer)}")}"' if facts else ""
        paths.append(f'<path {paint}{said} d="{_path_data(drawing, layer, precision)}"/>')
    return (
        f'<svg viewBox="0 0 {width} {height}" {attributes}>{definitions}{ground}'
        f'<g class="layers">{"".join(paths)}</g><g class="overlay"></g></svg>'
    )


def solid_paint(rgba: NDArray[np.float64]) -> str:
    """Return a colour as SVG attributes."""
    return f'fill="{format_rgb(rgba)}"' + (f' fill-opacity="{number_text(rgba[3], 5)}"' if rgba[3] < 1 else "")


def fill_of(drawing: Drawing, layer: int) -> str:
    """Describe a layer's fill: ``#ff8800``, with its opacity if below 1; or a gradient's stops."""
    fills, width = drawing.fills, drawing.strokes.widths[layer]
    pen = f", a line of {width:.4g} px" if width else ""
    if not fills.kinds[layer]:
        return color_of(drawing.colors[layer]) + pen
    stops = " to ".join(color_of(rgba) for rgba in fills.stop_colors[fills.stops(layer)])
    return f"{KINDS[fills.kinds[layer]]}, {stops}{pen}"


def color_of(rgba: NDArray[np.float64]) -> str:
    """Describe a colour: ``#ff8800``, with its opacity if below 1."""
    return format_rgb(rgba) + (f" at {100 * rgba[3]:.3g} %" if rgba[3] < 1 else "")


def swatch(drawing: Drawing, layer: int) -> str:
    """Return a small square with a layer's fill; a gradient goes across it, or from its middle to its corners.

    It refers to the stops of the finished drawing's gradients in the page, whose prefix is `PREFIX`.
    """
    paint, definition = solid_paint(drawing.colors[layer]), ""
    if kind := drawing.fills.kinds[layer]:
        own = f'id="swatch-{layer}" href="#{PREFIX}-{layer}" gradientUnits="objectBoundingBox"'
        definition = f"<{SWATCHES[kind][0]} {own} {SWATCHES[kind][1]}/>"
        paint = f'fill="url(#swatch-{layer})"'
    return f'<svg class="swatch" aria-hidden="true">{definition}<rect width="100%" height="100%" {paint}/></svg>'


def table(head: Sequence[str], rows: Iterable[tuple[str, Sequence[str]]], attributes: str) -> str:
    """Return a table; each row has its own attributes, and cells of markup, the first of which is its header."""
    top = "".join(f'<th scope="col">{text(name)}</th>' for name in head)
    body = "\n".join(
        f'<tr{own}><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in others)}</tr>'
        for own, (first, *others) in rows
    )
    return f"<table {attributes}>\n<thead><tr>{top}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>"


def facts_table(facts: Mapping[str, object]) -> str:
    """Return a table of names and values, both escaped."""
    rows = "\n".join(f'<tr><th scope="row">{text(k)}</th><td>{text(v)}</td></tr>' for k, v in facts.items())
    return f'<table class="words">\n<tbody>\n{rows}\n</tbody>\n</table>'


def psnr_text(mse: float) -> str:
    """Format a mean squared error as a peak signal-to-noise ratio, dB."""
    return f"{-10 * math.log10(mse):.1f}" if mse > 0 else "∞"


def stage_table(stages: Sequence[Stage]) -> str:
    """Return the table of the stages."""
    rows = []
    for index, stage in enumerate(stages, start=1):
        figures = f"{stage.mse:.3g}", psnr_text(stage.mse), str(stage.iterations), f"{stage.seconds:.2f}"
        rows.append(("", [str(index), str(stage.paths), *figures]))
    return table(("Stage", "Paths", "MSE", "PSNR, dB", "Iterations", "Seconds"), rows, 'id="stages"')


def stage_strip(stages: Sequence[Stage], differences: Sequence[str]) -> str:
    """Return the stages' drawings as a strip of links, each with the address of its difference picture."""
    items = []
    for index, (stage, difference) in enumerate(zip(stages, differences, strict=True), start=1):
        paths, error = count_of(stage.paths, "path"), f"MSE {stage.mse:.3g}"
        picture = drawing_svg(
            stage.drawing, STAGE_PRECISION, 'aria-hidden="true"', facts=True, prefix=f"{PREFIX}-stage-{index}"
        )
        items.append(
            f'<li><a href="#stage={index}" data-facts="{paths}, {error}" data-difference="{difference}" '
            f'aria-label="Stage {index}: {paths}, {error}">{picture}{paths}<br>{error}</a></li>'
        )
    return f'<ol class="strip">\n{chr(10).join(items)}\n</ol>'


def _path_data(drawing: Drawing, layer: int, precision: int) -> str:
    parts = []
    first = drawing.layer_offsets[layer]
    for index, subpath in enumerate(drawing.subpaths(layer), start=first):
        points = drawing.points[subpath].reshape(-1, 2)
        is_open = drawing.strokes.is_open[index]  # the last row is then the end of the line, without handles
        row = points[:-2] if is_open else np.concatenate([points, points[:1]])
        x, y, *others = (number_text(value, precision) for value in row.ravel())
        parts.append(f"M{x} {y}C{' '.join(others)}{'' if is_open else 'Z'}")
    return "".join(parts)


def number_text(value: float, precision: int) -> str:
    """Format a number with a maximum of decimals."""
    shown = f"{value:.{precision}f}"
    shown = shown.rstrip("0").rstrip(".") if "." in shown else shown
    return "0" if shown == "-0" else shown
