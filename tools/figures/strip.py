# SPDX-License-Identifier: Apache-2.0
"""Pictures side by side with captions, as small PNG files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.files import write_atomically
from livecl.rendering.single import render
from livecl.views.sheet import fitted_size, over_checkerboard, resized

#: Side of a picture, its margin, and the height of a line of its caption, px.
CELL, MARGIN, LINE = 150, 6, 16
#: Colours of a figure's palette.
COLORS = 128
Cell = tuple[NDArray[Any], str, str]


def shown(drawing: Drawing, side: int = CELL) -> NDArray[Any]:
    """Return a drawing's picture at a size, (H, W, 3); over a checkerboard where transparent."""
    return over_checkerboard(render(scaled(drawing, fitted_size(drawing.size, side))))


def save_strip(file: Path, cells: Sequence[Cell], columns: int | None = None, side: int = CELL) -> None:
    """Write pictures (H, W, 3) with two lines of caption each, in rows of `columns`, or one row."""
    columns = columns or len(cells)
    step_x, step_y = side + 2 * MARGIN, side + 2 * LINE + 2 * MARGIN
    sheet = Image.new("RGB", (columns * step_x, -(-len(cells) // columns) * step_y), "white")
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(12)
    for number, (picture, *captions) in enumerate(cells):
        left, top = number % columns * step_x + MARGIN, number // columns * step_y + MARGIN
        sheet.paste(resized(picture, fitted_size(picture.shape[:2], side)), (left, top))
        pen.rectangle((left - 1, top - 1, left + side, top + side), outline=(204, 204, 204))
        for row, caption in enumerate(captions):
            ink = (112, 112, 112) if row else (32, 32, 32)
            pen.text((left + side / 2, top + side + 3 + row * LINE), caption, fill=ink, font=font, anchor="ma")
    save_small(file, sheet)


def save_small(file: Path, picture: Image.Image | NDArray[Any]) -> None:
    """Write a picture with a palette, which is a third of the size."""
    image = picture if isinstance(picture, Image.Image) else Image.fromarray(np.asarray(picture, dtype=np.uint8))
    stream = io.BytesIO()
    image.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE).save(stream, format="PNG", optimize=True)
    write_atomically(file, stream.getvalue())
