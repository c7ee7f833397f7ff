# SPDX-License-Identifier: Apache-2.0
"""Measures of a saved SVG: error in an independent renderer's picture and in our own, size, layers, things.

Things are measured if the true SVG, from which the picture was made, is beside it.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from compare_svg import shown_by_resvg
from numpy.typing import NDArray
from skimage.transform import resize

from livecl import quality
from livecl.drawing.drawing import Drawing
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg import read_svg

FloatImage = NDArray[np.float32]
#: Scale at which colours are compared, so that edges between pixels are visible.
ENLARGED = 4


def true_svg(picture: Path) -> Path | None:
    """Return the true SVG of a picture, the file of its name beside it; None if there is none."""
    file = picture.with_suffix(".svg")
    return file if file.is_file() else None


@functools.lru_cache(maxsize=2)
def true_drawing(svg: Path) -> Drawing:
    """Return the drawing of a true SVG, without unsupported features."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return read_svg(svg)


def resvg_picture(svg: bytes, size: tuple[int, int] | None = None) -> FloatImage:
    """Return resvg's picture of an SVG over white, at its own size or at (height, width): (H, W, 3) in [0, 1]."""
    height, width = size or (None, None)
    image = shown_by_resvg(svg, width=width, height=height)
    picture = (image[..., :3] + 1 - image[..., 3:]).astype(np.float32)
    if size is not None and picture.shape[:2] != size:  # resvg keeps proportions: rounding may cost a pixel
        picture = resize(picture, (*size, 3), order=1).astype(np.float32)
    return picture


def measure(svg: Path, target: FloatImage, rasterizer: Rasterizer, true: Path | None = None) -> dict[str, Any]:
    """Return the measures of an SVG file by the names of the tables' columns.

    Errors are those of resvg's picture; `own_mse` is our rasterizer's, `renders_mse` the difference of the two.

    Parameters
    ----------
    svg : Path
        A saved file.
    target : (H, W, 3) float32
        The picture.
    rasterizer : Rasterizer
        Of the target's size.
    true : Path, optional
        The true SVG.
    """
    data = svg.read_bytes()
    drawing = read_svg(data)
    if drawing.background is None:
        drawing = drawing.replace(background=np.ones(3))
    independent, own = resvg_picture(data), rasterizer.forward(drawing)
    ratio = quality.psnr(independent, target)
    colored, opaque = quality.colors_in_picture(drawing, target)
    layers = dataclasses.asdict(quality.measure_layers(drawing, target, rasterizer))
    return {
        "paths": layers.pop("layers"),
        "segments": drawing.num_segments,
        "parameters": quality.num_parameters(drawing),
        "bytes": len(data),
        "mse": quality.mse(independent, target),
        "psnr": ratio if math.isfinite(ratio) else None,
        "ssim": quality.ssim(independent, target),
        "own_mse": quality.mse(own, target),
        "renders_mse": quality.mse(own, independent),
        "gradients": len(drawing.fills.gradient_layers),
        "colored": colored,
        "opaque": opaque,
        **layers,
        **({} if true is None else _against(true, data, drawing)),
    }


def _against(true: Path, data: bytes, drawing: Drawing) -> dict[str, Any]:
    """Return the scores of an SVG and its drawing by the true SVG: shapes, outlines, centre lines, size, colours."""
    size = ENLARGED * drawing.size[0], ENLARGED * drawing.size[1]
    artist = true_drawing(true)
    return {
        **dataclasses.asdict(quality.score_drawing(artist, drawing)),
        **dataclasses.asdict(quality.score_outlines(artist, drawing)),
        **(dataclasses.asdict(quality.score_lines(artist, drawing)) if artist.strokes.any else {}),
        "numbers": quality.count_numbers(data),
        "true_numbers": quality.count_numbers(true.read_bytes()),
        "true_segments": artist.num_segments,
        "delta_e": quality.color_difference(resvg_picture(data, size), resvg_picture(true.read_bytes(), size)),
    }
