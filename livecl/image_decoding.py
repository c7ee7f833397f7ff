# SPDX-License-Identifier: Apache-2.0
"""Pixels of opened pictures as colour and alpha: palettes, grey, CMYK, depths of more than 8 bits, colour profiles."""

from __future__ import annotations

import io
import logging
import warnings
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from livecl.errors import ImageError

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFile import ImageFile

#: Most pixels of a picture that is read, about 1 GB as float32 RGB: what claims more is taken for a decompression bomb.
MAX_PIXELS = 89_000_000
TOO_LARGE = f"more than {MAX_PIXELS // 1_000_000} million pixels; scale it down first"

#: Pillow's names of 16-bit PNG layouts: the raw modes that unpack the high and the low byte of each number.
_DEEP_PNG = {"RGB;16B": ("RGB;16B", "RGB;16L"), "RGBA;16B": ("RGBA;16B", "RGBA;16L"), "LA;16B": ("RGBA", "RGBA")}
#: TIFF compressions that need no codec package: none, deflate (two numbers), PackBits.
_TIFF_COMPRESSIONS = (1, 8, 32946, 32773)
#: EXIF and TIFF tag of the orientation, 1 to 8.
_ORIENTATION = 0x0112

FloatArray = NDArray[np.float32]


def decoded(name: str, data: bytes, image: Image | None) -> tuple[FloatArray, FloatArray | None, int]:
    """Decode a picture.

    Parameters
    ----------
    name : str
        What to call the picture in a warning.
    data : bytes
        The file's content.
    image : PIL.Image.Image or None
        The same, opened by Pillow, or a picture without a file; None for a TIFF of a kind that Pillow does not know.

    Returns
    -------
    color : (H, W, 1) or (H, W, 3) float32
        Straight grey or RGB, 1 for full intensity; a float picture's numbers are as in the file.
    alpha : (H, W, 1) float32 or None
        Alpha, where there is any.
    orientation : int
        EXIF orientation, still to be applied.

    Raises
    ------
    ImageError
        If the picture is of a kind that is not read; damaged data raises exceptions of every kind.
    """
    from PIL import Image

    if image is None or _is_deep_tiff(image):
        color, alpha, orientation = _deep_tiff(data)
        profile = None if image is None else image.info.get("icc_profile")
    else:
        if _is_deep_png(image):
            color, alpha = _deep_png(data, cast("ImageFile", image))
        elif image.mode in ("I", "F") or image.mode.startswith("I;16"):
            color, alpha = _deep_grey(image)
        else:
            flat, alpha = _flat(image)
            orientation = image.getexif().get(_ORIENTATION, 1)
            return _in_srgb(name, flat, image.info.get("icc_profile")), alpha, orientation
        orientation = image.getexif().get(_ORIENTATION, 1)
        profile = image.info.get("icc_profile")
    if profile and not _is_srgb(profile) and np.isfinite(color).all():
        levels = np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)
        color = _in_srgb(name, Image.fromarray(levels[..., 0] if levels.shape[2] == 1 else levels), profile)
    return color, alpha, orientation


def _flat(image: Image) -> tuple[Image, FloatArray | None]:
    """Return an 8-bit picture as Pillow's L, RGB or CMYK, and its alpha (H, W, 1) apart."""
    image.load()
    alpha: FloatArray | None = None
    grey = image.mode in ("1", "L", "LA", "La")
    if "transparency" in image.info or image.mode in ("LA", "La", "PA", "RGBA", "RGBa"):
        image = (image.convert("LA") if image.mode == "La" else image).convert("RGBA")
        alpha = np.asarray(image.getchannel("A"), dtype=np.float32)[..., None] / np.float32(255)
    wanted = "L" if grey else "CMYK" if image.mode == "CMYK" else "RGB"
    return image.convert(wanted), alpha


def _is_deep_png(image: Image) -> bool:
    """Whether a picture is an opened PNG of more than 8 bits in several channels."""
    tiles: Any = getattr(image, "tile", ())  # of files only
    return image.format == "PNG" and bool(tiles) and tiles[0][3] in _DEEP_PNG


def _deep_png(data: bytes, image: ImageFile) -> tuple[FloatArray, FloatArray | None]:
    """Decode a 16-bit colour or grey-and-alpha PNG, which Pillow cuts to 8 bits, from its high and its low bytes.

    PNG's numbers are big-endian: read as if they were little-endian, their low bytes are the ones that are kept.
    Grey and alpha are four bytes a pixel, which Pillow takes apart as if they were RGBA.
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
        alpha = _scaled(pixels[..., num_colors:])
    return _scaled(pixels[..., :num_colors]), alpha


def _deep_grey(image: Image) -> tuple[FloatArray, FloatArray | None]:
    """Return a grey picture that Pillow holds in more than 8 bits, and its alpha where one grey is transparent."""
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
    grey: FloatArray = (pixels / (2.0**bits - 1)).astype(np.float32)
    return (np.subtract(1, grey) if white_is_zero else grey), alpha


def _is_deep_tiff(image: Image) -> bool:
    """Whether a picture is a grey or RGB TIFF of more than 8 bits a number that imageio decodes without more packages.

    In other compressions Pillow reads it, colours at 8 bits.
    """
    if image.format != "TIFF":
        return False
    tags = image.tag_v2  # type: ignore[attr-defined]  # of Pillow's TIFF pictures
    deep = max(tags.get(258, (1,))) > 8 and tags.get(262) in (0, 1, 2)
    return deep and tags.get(259, 1) in _TIFF_COMPRESSIONS


def _deep_tiff(data: bytes) -> tuple[FloatArray, FloatArray | None, int]:
    """Decode a TIFF's numbers as they are; the third item is its orientation."""
    from imageio import v3 as imageio

    log = logging.getLogger("tifffile")
    if not log.hasHandlers():  # else what it says of damaged files is printed, beside the exception
        log.addHandler(logging.NullHandler())
    file: Any  # the plugin has arguments that the base class does not declare
    with imageio.imopen(data, "r", plugin="tifffile") as file:
        tags = file.metadata(index=0, page=0)
        if tags["ImageWidth"] * tags["ImageLength"] > MAX_PIXELS:
            raise ImageError(TOO_LARGE)
        pixels = np.asarray(file.read(index=0, page=0))
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    elif tags.get("PlanarConfiguration") == 2:
        pixels = np.moveaxis(pixels, 0, -1)
    photometric = int(tags.get("PhotometricInterpretation", -1))
    num_colors = {0: 1, 1: 1, 2: 3}.get(photometric, 0)
    if not num_colors or pixels.ndim != 3 or pixels.shape[2] < num_colors or pixels.dtype.kind not in "buf":
        raise ImageError("a TIFF of neither grey nor RGB in unsigned or float numbers; save it as such, or as PNG")
    numbers = _scaled(pixels)
    color: FloatArray = numbers[..., :num_colors]
    alpha: FloatArray | None = None
    if photometric == 0 and pixels.dtype.kind != "f":
        color = np.float32(1) - color
    extra = np.atleast_1d(tags.get("ExtraSamples", ()))
    if pixels.shape[2] > num_colors and extra.size and extra[0] in (1, 2):
        alpha = numbers[..., num_colors : num_colors + 1]
        if extra[0] == 1:
            color = np.divide(
                color, np.where(alpha > 0, alpha, 1), dtype=np.float32
            )  # the file holds premultiplied colours
    return color, alpha, int(tags.get("Orientation", 1))


def _scaled(pixels: NDArray[Any]) -> FloatArray:
    """Return unsigned numbers as shares of the largest of their type, and floats as they are."""
    largest = float(np.iinfo(pixels.dtype).max) if pixels.dtype.kind == "u" else 1.0
    with np.errstate(over="ignore"):  # a double beyond float32 becomes infinite, which read_image refuses
        shares: FloatArray = (pixels / largest).astype(np.float32)
    return shares


def _is_srgb(profile: bytes) -> bool:
    """Whether a colour profile calls itself sRGB; False where it cannot be read."""
    from PIL import ImageCms

    try:
        return "srgb" in ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(profile))).lower()
    except (ImageCms.PyCMSError, OSError):
        return False


def _in_srgb(name: str, image: Image, profile: bytes | None) -> FloatArray:
    """Return an 8-bit L, RGB or CMYK picture as sRGB, (H, W, 3), through its colour profile where it has one."""
    from PIL import ImageCms

    if profile and not _is_srgb(profile):
        try:
            source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
            converted = ImageCms.profileToProfile(image, source, ImageCms.createProfile("sRGB"), outputMode="RGB")
            image = converted or image
        except (ImageCms.PyCMSError, OSError, ValueError):
            warnings.warn(f"{name}: its colour profile cannot be applied; colours are taken as sRGB", stacklevel=4)
    rgb: FloatArray = np.asarray(image.convert("RGB"), dtype=np.float32) / np.float32(255)
    return rgb
