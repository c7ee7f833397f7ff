# SPDX-License-Identifier: Apache-2.0
"""Contact sheets, worst picture first: target, last stages, final picture, outlines."""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from evaluation.measures import resvg_picture, true_drawing, true_svg
from livecl import quality
from livecl.files import write_atomically
from livecl.image.reading import over_background, read_image
from livecl.svg import read_svg
from livecl.views.sheet import count_of, fitted_size, resized

#: Longest side of a picture, px; pictures of a sheet; stages shown before the final one.
CELL, ROWS, EARLIER = 200, 8, 4
_MARGIN, _LINE = 8, 18

Row = dict[str, Any]


def write_sheets(output: Path, rows: Iterable[Row], pictures: dict[str, Path]) -> list[Path]:
    """Write the sheets of each method and number of paths, and those of things if they are known.

    Returns the files.

    Parameters
    ----------
    output : Path
        Folder of the evaluation; sheets are written to its folder `sheets`, replacing those there.
    rows : iterable of dict
        Results, with `svg` relative to `output`.
    pictures : dict
        The targets' files by the pictures' names.
    """
    folder = output / "sheets"
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.png"):
        old.unlink()
    written = []
    by_kind: dict[tuple[str, int | str | None], list[Row]] = {}
    for row in rows:
        by_kind.setdefault((row["method"], row["asked"]), []).append(row)
    for (method, count), found in by_kind.items():
        name = f"{method}-{'free' if count is None else count}"
        found.sort(key=lambda row: (-row["mse"], row["picture"]))
        written += _pages(found, _strip, folder / name, output, pictures)
        known = sorted((row for row in found if row.get("things")), key=lambda row: (row["overlap"], row["picture"]))
        written += _pages(known, _things, folder / f"things-{name}", output, pictures)
    return written


def _pages(
    rows: Sequence[Row],
    strip: Callable[[Row, Path, Path], Image.Image],
    name: Path,
    output: Path,
    files: dict[str, Path],
) -> list[Path]:
    """Write strips below each other, several on a page; return the files."""
    written = []
    for page, first in enumerate(range(0, len(rows), ROWS), start=1):
        png = io.BytesIO()
        _stacked([strip(row, output, files[row["picture"]]) for row in rows[first : first + ROWS]]).save(png, "PNG")
        written.append(name.with_name(f"{name.name}-{page:02}.png"))
        write_atomically(written[-1], png.getvalue())
    return written


def _things(row: Row, output: Path, picture: Path) -> Image.Image:
    """Return the true things of a picture above those of the drawing, and both pictures before them."""
    drawing, svg = read_svg(output / row["svg"]), true_svg(picture)
    assert svg is not None
    true = quality.things_of_drawing(true_drawing(svg), drawing.size)
    title = (
        f"{row['picture']}   IoU {row['overlap']:.3f}   {row['found']} of {row['things']} at .9   hidden "
        f"{row['hidden_overlap']:.2f}   missed {row['missed']}   extra {row['extra']}   cubics {row['segments']} "
        f"(artist {row['true_segments']})   MSE {row['mse']:.1e}"
    )
    pictures = [resvg_picture(file.read_bytes(), drawing.size) for file in (svg, output / row["svg"])]
    return quality.draw_things(true, quality.things_of_drawing(drawing), title, pictures)


def _strip(row: Row, output: Path, picture: Path) -> Image.Image:
    """Return one picture's row: a line of text, and the labelled cells."""
    final = output / row["svg"]
    last = len(row["stages"])
    cells = [("target", _shown(over_background(read_image(picture), (1, 1, 1))))]
    for stage in range(max(1, last - EARLIER), last):
        file = final.with_name(re.sub(r"\d+", str(stage), final.name))
        cells.append((count_of(row["stages"][stage - 1], "path"), _shown(resvg_picture(file.read_bytes()))))
    whole = _shown(resvg_picture(final.read_bytes()))
    cells.append((f"final, {count_of(row['paths'], 'path')}", whole))
    cells.append(("outlines", quality.draw_outlines(read_svg(final), whole)))
    title = (
        f"{row['picture']}   MSE {row['mse']:.2e}   SSIM {row['ssim']:.3f}   {row['seconds']:.1f} s   "
        f"in one region {row['in_one_region']}/{row['paths']}   crossing {row['self_crossing']}   "
        f"needless {row['needless']}   mergeable {row['mergeable']}   nearly opaque {row['nearly_opaque']}"
    )
    font = ImageFont.load_default(12)
    width = max(len(cells) * (CELL + _MARGIN), int(font.getlength(title))) + _MARGIN
    strip = Image.new("RGB", (width, 2 * _LINE + CELL + _MARGIN), "white")
    pen = ImageDraw.Draw(strip)
    pen.text((_MARGIN, 2), title, fill="black", font=font)
    for column, (label, cell) in enumerate(cells):
        left = _MARGIN + column * (CELL + _MARGIN)
        pen.text((left, _LINE + 2), label, fill="#666666", font=font)
        top = 2 * _LINE
        pen.rectangle((left - 1, top - 1, left + cell.width, top + cell.height), outline="#cccccc")
        strip.paste(cell, (left, top))
    return strip


def _shown(image: Any) -> Image.Image:
    """Return an image (H, W, 3) in [0, 1] at the size of a cell."""
    return resized(image, fitted_size(np.shape(image)[:2], CELL))


def _stacked(strips: Sequence[Image.Image]) -> Image.Image:
    sheet = Image.new("RGB", (max(strip.width for strip in strips), sum(strip.height for strip in strips)), "white")
    tops = itertools.accumulate((strip.height for strip in strips), initial=0)
    for strip, top in zip(strips, tops, strict=False):
        sheet.paste(strip, (0, top))
    return sheet
