# SPDX-License-Identifier: Apache-2.0
"""Render drawings to frames, and write frames as a GIF."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from livecl.drawing.assembly import stretched
from livecl.drawing.canvas import check_canvases
from livecl.drawing.drawing import Drawing
from livecl.image.reading import over_ground

#: Size of a GIF's palette.
PALETTE = 256
#: Number of pixels, of all frames together, from which the palette of a GIF is computed.
PALETTE_PIXELS = 1 << 20
#: Shortest time of a frame, s, as browsers slow down shorter ones; and longest hold, as 16 bits count hundredths of a
#: second.
MIN_GIF_FRAME, MAX_GIF_HOLD = 0.02, 600
#: Largest number of pixels of a scaled canvas.
MAX_PIXELS = 1 << 26


def render_frames(
    drawings: Sequence[Drawing], scale: float = 1.0, device: int | str | None = None
) -> Iterator[NDArray[np.float32]]:
    """Render drawings, scaled, over white; yield the pictures.

    Parameters
    ----------
    drawings : sequence of Drawing
        One or more on canvases of one size.
    scale : float
        Pixels of the pictures for each px of the canvas.
    device : int, str or None
        OpenCL device that renders.

    Yields
    ------
    (H, W, 3) float32
        RGB in [0, 1].

    Raises
    ------
    ValueError
        If there are no drawings, their sizes differ, or the scale is out of range.
    """
    from livecl.rendering.rasterizer import Rasterizer

    check_canvases(drawings)
    if not (math.isfinite(scale) and scale > 0):
        raise ValueError(f"scale: got {scale!r}, wanted a positive number of pixels")
    height, width = drawings[0].size
    size = (max(1, round(height * scale)), max(1, round(width * scale)))
    if size[0] * size[1] > MAX_PIXELS:
        raise ValueError(f"scale: got {scale!r}, which makes pictures of {size[1]} x {size[0]}; wanted a smaller one")
    rasterizer = Rasterizer(size, device)
    stretch = np.array([size[1] / width, size[0] / height])
    for drawing in drawings:
        image = rasterizer.forward(stretched(drawing, stretch, size))
        yield over_ground(image, np.ones(3, np.float32))


def encode_gif(frames: Sequence[NDArray[Any]], durations: Sequence[float]) -> bytes:
    """Encode pictures as a GIF that loops.

    All frames share one palette, so that static areas do not flicker. The most frequent colours are exact, the
    others the nearest of the palette, without dithering.

    Parameters
    ----------
    frames : sequence of (H, W, 3) array
        RGB in [0, 1].
    durations : sequence of float
        Seconds for which each is shown, rounded to hundredths; browsers slow down frames below two of them.

    Returns
    -------
    bytes
    """
    from PIL import Image

    codes = [_codes(frame) for frame in frames]
    palette = _palette(codes)
    nearest = _nearest(codes, palette)
    pictures = [Image.fromarray(nearest[frame]) for frame in codes]
    for picture in pictures:
        picture.putpalette(palette.tobytes())
    stream = io.BytesIO()
    pictures[0].save(
        stream,
        "GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=[10 * round(100 * duration) for duration in durations],
        loop=0,
        optimize=False,
    )
    return stream.getvalue()


def _codes(frame: NDArray[Any]) -> NDArray[np.int32]:
    """Return the colours of a picture (H, W, 3) in [0, 1] as 0xrrggbb: (H, W)."""
    levels = np.rint(np.clip(frame, 0, 1) * 255).astype(np.int32)
    return (levels[..., 0] << 16) | (levels[..., 1] << 8) | levels[..., 2]


def _levels(codes: NDArray[Any]) -> NDArray[np.uint8]:
    """Return 0xrrggbb as levels of 8 bits: (..., 3)."""
    return np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=-1).astype(np.uint8)


def _palette(frames: Sequence[NDArray[np.int32]]) -> NDArray[np.uint8]:
    """Return a palette (K, 3) for all frames, K at most `PALETTE`.

    Half of it are the most frequent colours, so that flat areas are exact; the others are medians of the rest.
    """
    from PIL import Image

    step = max(1, math.ceil(sum(frame.size for frame in frames) / PALETTE_PIXELS))
    pixels = np.concatenate([frame.ravel()[::step] for frame in frames])
    colors, inverse, counts = np.unique(pixels, return_inverse=True, return_counts=True)
    if len(colors) <= PALETTE:
        return _levels(colors)
    order = np.argsort(-counts, kind="stable")
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    rest = _levels(pixels[rank[inverse] >= PALETTE // 2])
    medians = Image.fromarray(rest[None]).quantize(PALETTE // 2, method=Image.Quantize.MEDIANCUT).getpalette()
    return np.concatenate([_levels(colors[order[: PALETTE // 2]]), np.array(medians, np.uint8).reshape(-1, 3)])


def _nearest(frames: Sequence[NDArray[np.int32]], palette: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the index of the nearest colour of the palette for each 0xrrggbb that occurs.

    Each distinct colour is searched once. Pillow's own search is not exact.
    """
    occurs = np.zeros(1 << 24, bool)
    for frame in frames:
        occurs[frame] = True
    colors = np.flatnonzero(occurs)
    nearest = np.zeros(1 << 24, np.uint8)
    nearest[colors] = cKDTree(palette).query(_levels(colors))[1]
    return nearest
