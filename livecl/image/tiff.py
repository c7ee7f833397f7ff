# SPDX-License-Identifier: Apache-2.0
"""Read TIFF of more than 8 bits per sample, which Pillow truncates or rejects: grey and RGB, unsigned and float."""

from __future__ import annotations

import logging
import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import Float32Array
from livecl.errors import ImageError
from livecl.image.source import MAX_PIXELS, TOO_LARGE

if TYPE_CHECKING:
    from PIL.Image import Image

#: Compressions that need no codec package: none, deflate (two numbers), PackBits.
_DEFLATE = (8, 32946)
_COMPRESSIONS = (1, *_DEFLATE, 32773)
#: Maximum number of samples per pixel: colours, alpha, and others, which are ignored.
_MAX_SAMPLES = 8
#: Any strip or tile may be inflated to this number of bytes; larger ones to the size of the whole picture.
_MAX_INFLATED = 16_000_000


def is_deep_tiff(image: Image) -> bool:
    """Whether a picture is a grey or RGB TIFF of more than 8 bits that imageio decodes without further packages.

    With other compressions, Pillow reads it, colours at 8 bits.
    """
    if image.format != "TIFF":
        return False
    tags = image.tag_v2  # type: ignore[attr-defined]  # of Pillow's TIFF pictures
    deep = max(tags.get(258, (1,))) > 8 and tags.get(262) in (0, 1, 2)
    return deep and tags.get(259, 1) in _COMPRESSIONS


def decode_deep_tiff(data: bytes) -> tuple[Float32Array, Float32Array | None, int]:
    """Decode a TIFF's first picture.

    Returns
    -------
    color : (H, W, 1) or (H, W, 3) float32
        Straight grey or RGB, 1 for full intensity; numbers of float pictures are not scaled.
    alpha : (H, W, 1) float32 or None
        Alpha; None if the image has none.
    orientation : int
        EXIF orientation, not yet applied.

    Raises
    ------
    ImageError
        If the kind of picture is not supported, or it is too large; damaged data can raise any exception.
    """
    from imageio import v3 as imageio

    log = logging.getLogger("tifffile")
    if not log.hasHandlers():  # otherwise its messages on damaged files are printed in addition to the exception
        log.addHandler(logging.NullHandler())
    file: Any  # the plugin has arguments that the base class does not declare
    with imageio.imopen(data, "r", plugin="tifffile") as file:
        # Any index except `...` first lists all pages, which may be billions in damaged files.
        tags = file.metadata(index=..., page=0)
        _refuse_bombs(data, tags)
        pixels = np.asarray(file.read(index=..., page=0))
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    elif tags.get("PlanarConfiguration") == 2:
        pixels = np.moveaxis(pixels, 0, -1)
    photometric = int(tags.get("PhotometricInterpretation", -1))
    num_colors = {0: 1, 1: 1, 2: 3}.get(photometric, 0)
    if not num_colors or pixels.ndim != 3 or pixels.shape[2] < num_colors or pixels.dtype.kind not in "buf":
        raise ImageError("a TIFF of neither grey nor RGB in unsigned or float numbers; save it as such, or as PNG")
    numbers = unit_floats(pixels)
    color: Float32Array = numbers[..., :num_colors]
    alpha: Float32Array | None = None
    if photometric == 0 and pixels.dtype.kind != "f":
        color = np.float32(1) - color
    extra = np.atleast_1d(tags.get("ExtraSamples", ()))
    if pixels.shape[2] > num_colors and extra.size and extra[0] in (1, 2):
        alpha = numbers[..., num_colors : num_colors + 1]
        if extra[0] == 1:
            color = np.divide(
                color, np.where(alpha > 0, alpha, 1), dtype=np.float32
            )  # colours in the file are premultiplied
    return color, alpha, int(tags.get("Orientation", 1))


def unit_floats(pixels: NDArray[Any]) -> Float32Array:
    """Scale unsigned numbers by the largest of their type; return floats unchanged."""
    largest = float(np.iinfo(pixels.dtype).max) if pixels.dtype.kind == "u" else 1.0
    with np.errstate(over="ignore"):  # doubles beyond float32 become infinite, which read_image refuses
        shares: Float32Array = (pixels / largest).astype(np.float32)
    return shares


def _refuse_bombs(data: bytes, tags: Mapping[str, Any]) -> None:
    """Raise ImageError, before memory is allocated, for too large a picture or data that inflates to more."""
    num_pixels = tags["ImageWidth"] * tags["ImageLength"] * tags.get("ImageDepth", 1)
    samples = tags.get("SamplesPerPixel", 1)
    if num_pixels > MAX_PIXELS or samples > _MAX_SAMPLES:
        raise ImageError(TOO_LARGE)
    if tags.get("Compression", 1) not in _DEFLATE:
        return
    most = max(_MAX_INFLATED, num_pixels * samples * int(np.max(tags.get("BitsPerSample", 1))) // 8)
    part = "Tile" if "TileOffsets" in tags else "Strip"
    for offset, count in zip(
        np.atleast_1d(tags[f"{part}Offsets"]), np.atleast_1d(tags[f"{part}ByteCounts"]), strict=False
    ):
        inflate = zlib.decompressobj()
        inflate.decompress(data[offset : offset + count], most)
        if inflate.unconsumed_tail:
            raise ImageError(TOO_LARGE)
