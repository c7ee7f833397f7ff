# SPDX-License-Identifier: Apache-2.0
"""Compare a drawing's picture with another renderer's, in premultiplied RGBA.

Renderers differ at pixels crossed by outlines, so the squared difference is given per pixel of outline (`edge`), and
the largest difference (`flat`, in levels of 255) of pixels away from outlines. tools/sweep_svg.py sweeps folders.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

import livecl
from livecl.arrays import FloatArray
from livecl.drawing.drawing import Drawing
from livecl.geometry import bezier
from livecl.rendering.device_canvas import TOLERANCE
from livecl.rendering.single import render
from livecl.rendering.strokes import filled

#: Squared difference at a pixel that an outline crosses, for a step from 0 to 1. resvg and skia sample coverage on a
#: grid of 4 x 4 a pixel, so an edge lies up to an eighth of a pixel from its place; where edges lie anywhere, the mean
#: square is a third of that.
EDGE = 0.125**2
#: Largest difference elsewhere, levels of 255: both round a colour, and resvg each blending.
FLAT = 2.5


def outline_pixels(drawing: Drawing) -> NDArray[np.bool_]:
    """Return the pixels that outlines pass through, sampled at steps of at most a quarter of a pixel: (H, W)."""
    height, width = drawing.size
    mask = np.zeros((height, width), dtype=bool)
    for cubic in filled(drawing, None, TOLERANCE).drawing.cubics:  # of strokes, both sides
        length = np.abs(np.diff(cubic, axis=0)).sum()
        x, y = bezier.evaluate(cubic, np.linspace(0, 1, 2 + int(min(4 * length, 1e5)))).T
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        mask[y[inside].astype(int), x[inside].astype(int)] = True
    return mask


def shown_by_resvg(
    svg: str | bytes, folder: Path | None = None, width: int | None = None, height: int | None = None
) -> FloatArray:
    """Return resvg's picture of an SVG in premultiplied RGBA: (H, W, 4).

    Parameters
    ----------
    svg : str or bytes
        The SVG.
    folder : path, optional
        Folder of files that it refers to.
    width, height : int, optional
        Size of the picture, px (default: the SVG's own).
    """
    import resvg_py

    text = svg if isinstance(svg, str) else svg.decode("utf-8")
    shown = resvg_py.svg_to_bytes(
        svg_string=text,
        dpi=96,
        languages=["en"],
        resources_dir=None if folder is None else str(folder),
        width=width,
        height=height,
    )
    return premultiplied(livecl.read_image(bytes(shown)))


def premultiplied(image: NDArray[Any]) -> FloatArray:
    """Return RGB or straight RGBA as premultiplied RGBA."""
    image = np.asarray(image, dtype=np.float64)
    alpha = image[..., 3:] if image.shape[2] == 4 else np.ones_like(image[..., :1])
    return np.concatenate([image[..., :3] * alpha, alpha], axis=2)


def rendered(drawing: Drawing) -> FloatArray:
    """Return our picture of a drawing in premultiplied RGBA: (H, W, 4)."""
    image = np.asarray(render(drawing), dtype=np.float64)
    return image if image.shape[2] == 4 else premultiplied(image)


def differences(
    drawing: Drawing, picture: FloatArray, ignored: NDArray[np.bool_] | None = None
) -> tuple[float, float, float]:
    """Return the mean squared difference, that per pixel of outline, and the largest away from outlines in levels.

    A canvas of a fractional size is rounded up here and rounded there: the common part is compared, without the pixels
    `ignored` (H, W).
    """
    height, width = np.minimum(drawing.size, picture.shape[:2])
    if np.abs(np.subtract(drawing.size, picture.shape[:2])).max() > 1:
        raise ValueError(f"sizes {drawing.size} and {picture.shape[:2]}")
    compared = np.ones((height, width), bool) if ignored is None else ~ignored[:height, :width]
    error = (rendered(drawing)[:height, :width] - picture[:height, :width]) * compared[..., None]
    squares = np.square(error).mean(axis=2)
    crossed = outline_pixels(drawing)[:height, :width]
    near = ndimage.binary_dilation(crossed, np.ones((3, 3)))
    edge = float(squares[near].sum() / max(1, crossed.sum()))
    return float(squares.mean()), edge, float(255 * np.abs(error)[~near].max(initial=0))
