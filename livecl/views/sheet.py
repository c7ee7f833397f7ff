# SPDX-License-Identifier: Apache-2.0
"""Sheets of a run: its stages side by side, and its error against the number of paths."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont

from livecl.arrays import Float32Array
from livecl.drawing.assembly import scaled
from livecl.drawing.checks import check_whole
from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.files import write_atomically
from livecl.image.reading import as_image, over_ground, premultiplied, save_image
from livecl.run.result import Result

#: Default longest side of a picture in a sheet, px, and the largest number of pictures in a row.
CELL, MAX_COLUMNS = 240, 7
#: Checkerboard below transparent pictures: its two greys, and the side of a square, px.
CHECKERBOARD, SQUARE = (1.0, 0.88), 8
_INK, _FAINT_INK, _FRAME = (32, 32, 32), (112, 112, 112), (204, 204, 204)


def stage_sheet(
    image: ArrayLike,
    result: Result,
    *,
    cell: int = CELL,
    columns: int | None = None,
    device: int | str | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Float32Array:
    """Show the target and the drawing after each stage side by side, as the paper's first figure does.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        The target, straight colours in [0, 1].
    result : Result
        The run.
    cell : int
        Longest side of each picture, px; drawings are rendered at that size.
    columns : int, optional
        Pictures in a row; by default, rows of about equal length, at most 7.
    device : int, str or None
        OpenCL device that renders.
    progress : callable, optional
        Called with the number of pictures rendered and that of all.

    Returns
    -------
    (H', W', 3) float32
        Straight RGB in [0, 1], captions included; transparent parts show a checkerboard.

    Raises
    ------
    ValueError
        If an argument is not usable; the message names it.
    """
    from livecl.rendering.rasterizer import Rasterizer

    pixels = checked_image(image, result.drawing)
    for name, value in (("cell", cell), ("columns", columns)):
        if value is not None:
            check_whole(name, value, 1)
    size = fitted_size(result.drawing.size, cell)
    rasterizer = Rasterizer(size, device)
    cells = [(_fitted_target(pixels, size), "target", "")]
    for done, stage in enumerate(result.stages, start=1):
        shown = over_checkerboard(rasterizer.forward(scaled(stage.drawing, size)))
        cells.append((shown, count_of(stage.paths, "path"), f"MSE {stage.mse:.3g}"))
        if progress is not None:
            progress(done, len(result.stages))
    columns = columns or math.ceil(len(cells) / math.ceil(len(cells) / MAX_COLUMNS))
    return _laid_out(cells, size, columns)


def save_sheet(
    path: str | os.PathLike[str],
    image: ArrayLike,
    result: Result,
    *,
    cell: int = CELL,
    columns: int | None = None,
    device: int | str | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Write the sheet of :func:`stage_sheet` as a PNG file, replacing an existing one atomically."""
    save_image(path, stage_sheet(image, result, cell=cell, columns=columns, device=device, progress=progress))


def save_plot(path: str | os.PathLike[str], result: Result) -> None:
    """Plot the mean squared error after each stage against the number of paths.

    Parameters
    ----------
    path : path
        File to write, ``.png`` or ``.svg``; an existing one is replaced atomically. The same result gives the same
        bytes.
    result : Result
        The run.

    Raises
    ------
    ValueError
        If `path` has another suffix.
    LiveclError
        If matplotlib is not installed; it comes with the extra ``plots``.
    """
    kind = Path(path).suffix.lower().removeprefix(".")
    if kind not in ("png", "svg"):
        raise ValueError(f"path: got {os.fspath(path)!r}, wanted a file name that ends in .png or .svg")
    try:
        import matplotlib
        from matplotlib.figure import Figure
        from matplotlib.ticker import MaxNLocator
    except ImportError as error:
        raise LiveclError("a plot needs matplotlib: pip install 'livecl[plots]'") from error
    figure = Figure(figsize=(5, 3.6), layout="constrained")
    axes = figure.subplots()
    counts = [stage.paths for stage in result.stages]
    axes.plot(counts, [stage.mse for stage in result.stages], marker="o", color="#2f6fab")
    if any(stage.mse > 0 for stage in result.stages):  # a logarithmic scale cannot show an error of 0
        axes.set_yscale("log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="paths", ylabel="mean squared error")
    axes.grid(visible=True, which="both", alpha=0.25)
    stream = io.BytesIO()
    # By default, ids in the SVG are hashes with a random salt, and the date changes with each run.
    with matplotlib.rc_context({"svg.hashsalt": "livecl"}):
        figure.savefig(stream, format=kind, dpi=144, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(path, stream.getvalue())


def fitted_size(size: tuple[int, int], side: int) -> tuple[int, int]:
    """Return the size (height, width) of the same shape whose longer side is `side` px."""
    factor = side / max(size)
    return max(1, round(size[0] * factor)), max(1, round(size[1] * factor))


def resized(image: ArrayLike, size: tuple[int, int]) -> Image.Image:
    """Resize a picture (H, W, 3 or 4) in [0, 1]: smoothed when reduced, in squares when enlarged."""
    picture = Image.fromarray(np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8))
    height, width = size
    smaller = width < picture.width
    return picture.resize((width, height), Image.Resampling.LANCZOS if smaller else Image.Resampling.NEAREST)


def over_checkerboard(image: ArrayLike) -> Float32Array:
    """Composite premultiplied RGBA (H, W, 4) over a checkerboard: RGB (H, W, 3); RGB is returned unchanged."""
    pixels = np.asarray(image, dtype=np.float32)
    if pixels.shape[2] == 3:
        return pixels
    rows, columns = np.indices(pixels.shape[:2]) // SQUARE
    ground = np.where((rows + columns) % 2, CHECKERBOARD[1], CHECKERBOARD[0])[..., None]
    return over_ground(pixels, ground)


def count_of(count: int, noun: str) -> str:
    """Return a number with its noun: ``1 path``, ``2 paths``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def checked_image(image: ArrayLike, drawing: Drawing) -> Float32Array:
    """Read a picture with :func:`livecl.image.reading.as_image`; ValueError unless it has the drawing's size."""
    pixels = as_image(image)
    if pixels.shape[:2] != drawing.size:
        raise ValueError(f"image: {pixels.shape[:2]} pixels, wanted the drawing's {drawing.size}")
    return pixels


def _fitted_target(pixels: Float32Array, size: tuple[int, int]) -> Float32Array:
    return over_checkerboard(premultiplied(np.asarray(resized(pixels, size), dtype=np.float32) / 255))


def _laid_out(cells: list[tuple[Float32Array, str, str]], size: tuple[int, int], columns: int) -> Float32Array:
    """Arrange pictures, each with two lines of caption below, in rows."""
    text = max(9, max(size) // 16)
    font = ImageFont.load_default(text)
    margin, line = max(4, text // 2), round(1.35 * text)
    width = max(size[1], *(math.ceil(font.getlength(caption)) for _, *captions in cells for caption in captions))
    step_x, step_y = width + 2 * margin, size[0] + 2 * line + 3 * margin
    rows = math.ceil(len(cells) / columns)
    sheet = Image.new("RGB", (min(columns, len(cells)) * step_x, rows * step_y), "white")
    pen = ImageDraw.Draw(sheet)
    for index, (picture, *captions) in enumerate(cells):
        left, top = index % columns * step_x + margin, index // columns * step_y + margin
        inner = left + (width - size[1]) // 2
        pen.rectangle((inner - 1, top - 1, inner + size[1], top + size[0]), outline=_FRAME)
        sheet.paste(resized(picture, size), (inner, top))
        for row, (caption, ink) in enumerate(zip(captions, (_INK, _FAINT_INK), strict=True)):
            place = left + width / 2, top + size[0] + margin + row * line
            pen.text(place, caption, fill=ink, font=font, anchor="ma")
    levels: Float32Array = np.asarray(sheet, dtype=np.float32) / np.float32(255)
    return levels
