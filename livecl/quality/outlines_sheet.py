# SPDX-License-Identifier: Apache-2.0
"""Plot the outlines of a drawing, each layer in its own colour."""

from __future__ import annotations

import colorsys

import numpy as np
from PIL import Image, ImageDraw

from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import flatten

#: Factor by which outlines are drawn larger and then reduced, which smooths them.
_FINER = 3
#: Step of hue between layers: the golden section, so that neighbours differ.
_HUE_STEP = 0.618


def draw_outlines(drawing: Drawing, image: Image.Image) -> Image.Image:
    """Draw the outline of each layer in its own colour over a faded picture of any size."""
    scale = np.array(image.size) / (drawing.size[1], drawing.size[0]) * _FINER
    size = (image.width * _FINER, image.height * _FINER)
    canvas = Image.blend(image, Image.new("RGB", image.size, "white"), 0.75).resize(size)
    pen = ImageDraw.Draw(canvas)
    for layer in range(drawing.num_layers):
        red, green, blue = colorsys.hsv_to_rgb(layer * _HUE_STEP % 1, 1, 0.8)
        ink = round(255 * red), round(255 * green), round(255 * blue)
        for subpath in drawing.subpaths(layer):
            corners = flatten(drawing.cubics[subpath], tolerance=0.1).corners * scale
            closed = [(float(x), float(y)) for x, y in [*corners, corners[0]]]
            pen.line(closed, fill=ink, width=_FINER)
    return canvas.resize(image.size, Image.Resampling.LANCZOS)
