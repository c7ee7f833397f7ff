# SPDX-License-Identifier: Apache-2.0
"""Decode pictures to colour and alpha: palettes, grey, more than 8 bits, frames, orientation."""

from __future__ import annotations

import io
import warnings
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from livecl.arrays import Float32Array
from livecl.errors import ImageError, readable
from livecl.image.source import MAX_PIXELS, TOO_LARGE
from livecl.image.srgb import in_srgb, other_profile, without_gamma
from livecl.image.tiff import decode_deep_tiff, is_deep_tiff, unit_floats

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFile import ImageFile

#: Pillow's names of 16-bit PNG layouts: the raw modes that unpack the high and the low byte of each number.
_DEEP_PNG = {"RGB;16B": ("RGB;16B", "RGB;16L"), "RGBA;16B": ("RGBA;16B", "RGBA;16L"), "LA;16B": ("RGBA", "RGBA")}
#: File formats whose further frames or pages are pictures like the first one; in others they are previews or layers.
_STACKS = ("GIF", "PNG", "WEBP", "TIFF", "AVIF")
#: EXIF and TIFF tag of the orientation, 1 to 8.
_ORIENTATION = 0x0112


def decoded(name: str, data: bytes, image: Image | None) -> tuple[Float32Array, Float32Array | None, int]:
    """Decode a picture.

    Parameters
    ----------
    name : str
        Name of the image in a warning.
    data : bytes
        The file's content.
    image : PIL.Image.Image or None
        The same, opened by Pillow, or a picture without a file; None for a TIFF that Pillow does not support.

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
        If the kind of picture is not supported; damaged data can raise any exception.
    """
    from PIL import Image

    if image is not None and image.format in _STACKS and getattr(image, "is_animated", False):
        warnings.warn(f"{name}: holds several pictures; the first is taken", stacklevel=4)
    if image is None or is_deep_tiff(image):
        color, alpha, orientation = decode_deep_tiff(data)
    else:
        if _is_deep_png(image):
            color, alpha = _deep_png(data, cast("ImageFile", image))
        elif image.mode in ("I", "F") or image.mode.startswith("I;16"):
            color, alpha = _deep_grey(image)
        else:
            flat, alpha = _flat(image)
            return in_srgb(name, flat, image.info), alpha, _orientation(name, image)
        orientation = _orientation(name, image)
    info = {} if image is None else image.info
    if other_profile(info) and np.isfinite(color).all():
        levels = np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)
        color = in_srgb(name, Image.fromarray(levels[..., 0] if levels.shape[2] == 1 else levels), info)
    else:
        color = without_gamma(color, info)
    return color, alpha, orientation


def _orientation(name: str, image: Image) -> int:
    """Return the EXIF orientation; 1, with a warning, if the metadata cannot be read.

    Call it after decoding the pixels, which turns those of a TIFF.
    """
    try:
        orientation: int = image.getexif().get(_ORIENTATION, 1)
    except Exception as error:  # damaged data can raise any exception, as in decoders
        reason = readable(str(error)[:150])
        warnings.warn(f"{name}: its EXIF data cannot be read ({reason}); it is not turned", stacklevel=5)
        return 1
    return orientation


def _flat(image: Image) -> tuple[Image, Float32Array | None]:
    """Return an 8-bit picture as Pillow's L, RGB or CMYK, and its alpha (H, W, 1) separately."""
    image.load()
    if image.width * image.height > MAX_PIXELS:  # an icon's picture may be larger than its header says
        raise ImageError(TOO_LARGE)
    alpha: Float32Array | None = None
    grey = image.mode in ("1", "L", "LA", "La")
    if "transparency" in image.info or image.mode in ("LA", "La", "PA", "RGBA", "RGBa"):
        image = (image.convert("LA") if image.mode == "La" else image).convert("RGBA")
        alpha = np.asarray(image.getchannel("A"), dtype=np.float32)[..., None] / np.float32(255)
    wanted = "L" if grey else image.mode if image.mode in ("CMYK", "LAB") else "RGB"
    return image.convert(wanted), alpha


def _is_deep_png(image: Image) -> bool:
    """Whether a picture is a PNG file of more than 8 bits with several channels."""
    tiles: Any = getattr(image, "tile", ())  # files only
    return image.format == "PNG" and bool(tiles) and tiles[0][3] in _DEEP_PNG


def _deep_png(data: bytes, image: ImageFile) -> tuple[Float32Array, Float32Array | None]:
    """Decode a 16-bit colour or grey-and-alpha PNG, which Pillow reduces to 8 bits, from high and low bytes.

    PNG's numbers are big-endian; read as little-endian, Pillow keeps their low bytes. Grey and alpha are four bytes per
    pixel, which Pillow unpacks as RGBA.
    """
    from PIL import Image

    layout = str(image.tile[0][3])
    halves = []
    for raw_mode in _DEEP_PNG[layout]:
        half = Image.open(io.BytesIO(data))
        half.tile = [type(tile)(*tile[:3], raw_mode) for tile in half.tile]
        halves.append(np.asarray(half, dtype=np.uint16))
    high, low = halves if layout != "LA;16B" else (halves[0][..., 0::2], halves[0][..., 1::2])
    pixels = high * np.uint16(256) + low
    num_colors = 1 if layout == "LA;16B" else 3
    alpha = None
    if "transparency" in image.info:
        clear = np.all(pixels == np.array(image.info["transparency"], dtype=np.uint16), axis=2, keepdims=True)
        alpha = 1 - clear.astype(np.float32)
    elif pixels.shape[2] > num_colors:
        alpha = unit_floats(pixels[..., num_colors:])
    return unit_floats(pixels[..., :num_colors]), alpha


def _deep_grey(image: Image) -> tuple[Float32Array, Float32Array | None]:
    """Return a grey picture of more than 8 bits, and its alpha if one grey level is transparent."""
    pixels = np.asarray(image)[..., None]
    if image.mode == "F":
        return pixels.astype(np.float32), None
    alpha = None
    if "transparency" in image.info:
        alpha = 1 - (pixels == image.info["transparency"]).astype(np.float32)
    bits, white_is_zero = 16, False
    if image.format == "TIFF":
        tags = image.tag_v2  # type: ignore[attr-defined]  # of Pillow's TIFF pictures
        bits, white_is_zero = tags[258][0], tags.get(262) == 0
    grey: Float32Array = (pixels / (2.0**bits - 1)).astype(np.float32)
    return (np.subtract(1, grey) if white_is_zero else grey), alpha
