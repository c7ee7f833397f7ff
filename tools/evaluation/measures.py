# SPDX-License-Identifier: Apache-2.0
"""What is measured of a saved SVG: closeness in an independent renderer's picture and in our own, size, layers."""

from __future__ import annotations

import dataclasses
import io
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from livecl import quality
from livecl.image.reading import over_background
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg import read_svg

FloatImage = NDArray[np.float32]


def resvg_picture(svg: bytes) -> FloatImage:
    """Return resvg's picture of an SVG at its own size, over white: (H, W, 3) in [0, 1]."""
    import resvg_py

    png = bytes(resvg_py.svg_to_bytes(svg_string=svg.decode()))
    with Image.open(io.BytesIO(png)) as image:
        rgba = np.asarray(image.convert("RGBA"), dtype=np.float32) / 255
    return over_background(rgba, (1, 1, 1))


def measure(svg: Path, target: FloatImage, rasterizer: Rasterizer) -> dict[str, Any]:
    """Return the measures of an SVG file by the names of the tables' columns.

    Without a prefix, errors are those of resvg's picture; `own_` stands for our rasterizer's. `renders_mse` and
    `renders_max` are the mean squared and the largest difference of the two pictures.

    Parameters
    ----------
    svg : Path
        A saved file.
    target : (H, W, 3) float32
        What it should look like.
    rasterizer : Rasterizer
        Of the target's size.
    """
    data = svg.read_bytes()
    drawing = read_svg(data)
    if drawing.background is None:
        drawing = drawing.replace(background=np.ones(3))
    independent, own = resvg_picture(data), rasterizer.forward(drawing)
    layers = dataclasses.asdict(quality.measure_layers(drawing, target, rasterizer))
    return {
        "paths": layers.pop("layers"),
        "segments": drawing.num_segments,
        "parameters": quality.num_parameters(drawing),
        "bytes": len(data),
        **_closeness(independent, target, ""),
        **_closeness(own, target, "own_"),
        "renders_mse": quality.mse(own, independent),
        "renders_max": float(np.abs(own - independent).max()),
        **layers,
    }


def _closeness(image: FloatImage, target: FloatImage, prefix: str) -> dict[str, float | None]:
    ratio = quality.psnr(image, target)
    return {
        f"{prefix}mse": quality.mse(image, target),
        f"{prefix}psnr": ratio if math.isfinite(ratio) else None,
        f"{prefix}ssim": quality.ssim(image, target),
    }
