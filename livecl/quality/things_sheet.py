# SPDX-License-Identifier: Apache-2.0
"""Plot matched shapes: the true ones above, the drawing's below, with their overlaps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from livecl.quality.things import HIDDEN_SHARE, Things, match_things

#: Longest side of a cell, cells of a row, px of a line of text and of a margin.
CELL, COLUMNS, LINE, MARGIN = 84, 14, 14, 4
#: Colours: beneath things, of their borders, of text.
_GROUND, _BORDER, _INK = (226, 226, 230), (40, 40, 40), (90, 90, 90)


def draw_things(
    true: Things, drawn: Things, title: str = "", pictures: Sequence[NDArray[np.float32]] = ()
) -> Image.Image:
    """Show each thing of a drawing below the true thing that it is matched with.

    Pairs are in the true drawing's order, bottom first, followed by unmatched true things and unmatched things of the
    drawing. Below each pair is its overlap, in percent, and "hidden" if others cover a part of the true one.

    Parameters
    ----------
    true, drawn : Things
        Of one canvas.
    title : str
        A line above.
    pictures : sequence of (H, W, 3) array, optional
        Those of both drawings in [0, 1], shown in front.
    """
    scores, partners = match_things(true, drawn)
    columns: list[tuple[int, int, str]] = []
    for thing in sorted(range(len(true)), key=lambda thing: partners[thing] < 0):
        note = " hidden" if true.hidden[thing] >= HIDDEN_SHARE else ""
        columns.append((thing, int(partners[thing]), f"{scores[thing]:.0%}{note}" if partners[thing] >= 0 else note))
    columns.extend((-1, thing, "") for thing in range(len(drawn)) if thing not in partners)
    font = ImageFont.load_default(LINE - 3)
    size = (true if len(true) else drawn).masks.shape[1:]
    scale = CELL / max(size)
    cell = max(1, round(size[1] * scale)), max(1, round(size[0] * scale))
    row = 2 * (cell[1] + MARGIN) + LINE
    rows = max(1, -(-len(columns) // COLUMNS))
    first = cell[0] + 3 * MARGIN if pictures else 0
    width = MARGIN + first + min(COLUMNS, len(columns)) * (cell[0] + MARGIN)
    sheet = Image.new("RGB", (max(width, int(font.getlength(title)) + 2 * MARGIN), LINE + MARGIN + rows * row), "white")
    pen = ImageDraw.Draw(sheet)
    pen.text((MARGIN, 1), title, fill="black", font=font)
    for place, image in enumerate(pictures):
        shown = Image.fromarray(np.rint(255 * np.clip(image, 0, 1)).astype(np.uint8)).resize(cell)
        sheet.paste(shown, (MARGIN, LINE + MARGIN + place * (cell[1] + MARGIN)))
    for place, (above, below, note) in enumerate(columns):
        left, top = MARGIN + first + place % COLUMNS * (cell[0] + MARGIN), LINE + MARGIN + place // COLUMNS * row
        for things, thing in ((true, above), (drawn, below)):
            if thing >= 0:
                sheet.paste(_drawn(things.masks[thing], things.colors[thing], cell), (left, top))
            top += cell[1] + MARGIN
        pen.text((left, top - MARGIN), note, fill=_INK, font=font)
    return sheet


def _drawn(mask: NDArray[np.bool_], color: NDArray[np.float64], size: tuple[int, int]) -> Image.Image:
    """Draw a mask (H, W) in a colour with a dark border, visible on any background, at a size (width, height)."""
    small = np.asarray(Image.fromarray(mask).resize(size, Image.Resampling.NEAREST))
    padded = np.pad(small, 1)
    core = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    pixels = np.full((*small.shape, 3), _GROUND, np.uint8)
    pixels[small] = _BORDER
    pixels[small & core] = np.rint(255 * np.clip(color, 0, 1)).astype(np.uint8)
    return Image.fromarray(pixels)
