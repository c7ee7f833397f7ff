# SPDX-License-Identifier: Apache-2.0
"""Read pictures from files, memory and arrays as straight colours; write them; composite over a background."""

from __future__ import annotations

import io
import os
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import Float32Array
from livecl.errors import ImageError
from livecl.files import write_atomically
from livecl.image.decoding import decoded
from livecl.image.source import content, damage, opened

if TYPE_CHECKING:
    from PIL.Image import Image

#: Largest overshoot of a float picture beyond [0, 1] that is clipped (filters ring); more is refused as a wrong scale.
OVERSHOOT = 0.01

#: Types accepted as a picture.
Picture: TypeAlias = "ArrayLike | str | os.PathLike[str] | bytes | BinaryIO | Image"


def read_image(source: str | os.PathLike[str] | bytes | BinaryIO) -> Float32Array:
    """Read a picture as straight colours.

    The EXIF orientation, a palette and its transparency, colour profiles other than sRGB (at 8 bits), and a PNG's gamma
    are applied. Grey, CMYK and Lab become RGB; animations and stacks give their first picture. 16-bit PNG and TIFF, and
    float TIFF, keep their precision; other formats are read at 8 bits. A warning tells of further pictures, and of
    profiles or EXIF data that cannot be read and are ignored.

    Parameters
    ----------
    source : path, bytes or binary file
        The picture.

    Returns
    -------
    (H, W, 3) or (H, W, 4) float32
        Straight RGB in [0, 1]; RGBA if any alpha is below 1.

    Raises
    ------
    ImageError
        If there is no such file, or it holds no complete picture, more than 89 million pixels or 1.5 GB, or numbers
        that are not finite or not within [0, 1].
    """
    name, data = content(source)
    return _straight(name, data, opened(name, data))


def as_image(source: Picture) -> Float32Array:
    """Convert any kind of picture to straight colours.

    Parameters
    ----------
    source : array_like, path, bytes, binary file or PIL.Image.Image
        Arrays are (H, W) grey, (H, W, 3) RGB or (H, W, 4) straight RGBA: floats in [0, 1], or bool, uint8 or uint16,
        whose largest value becomes 1. Everything else is read as by :func:`read_image`.

    Returns
    -------
    (H, W, 3) or (H, W, 4) float32
        Straight RGB in [0, 1]; RGBA if any alpha is below 1.

    Raises
    ------
    ValueError
        If an array is of another shape or type, or holds numbers that are not finite and within [0, 1].
    ImageError
        If a file or picture cannot be read.

    Examples
    --------
    >>> as_image([[0.0, 1.0]]).tolist()
    [[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]]
    """
    if isinstance(source, (str, os.PathLike, bytes)) or hasattr(source, "read"):
        return read_image(cast("BinaryIO", source))
    if hasattr(source, "getbands"):  # a Pillow picture, recognized without importing Pillow
        return _straight("picture", b"", cast("Image", source).copy())
    try:
        array = np.asarray(source)
    except ValueError as error:
        raise ValueError("image: its rows differ in length, wanted an array of numbers") from error
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, axis=2)
    if array.ndim != 3 or array.shape[2] not in (3, 4) or 0 in array.shape:
        raise ValueError(f"image: shape {array.shape}, wanted (H, W, 3), or (H, W, 4) with straight alpha")
    if array.dtype in (np.bool_, np.uint8, np.uint16):
        array = array / np.float64(1 if array.dtype == np.bool_ else np.iinfo(array.dtype).max)
    if not np.issubdtype(array.dtype, np.floating):
        raise ValueError(f"image: numbers of type {array.dtype}, wanted floats in [0, 1], uint8, uint16 or bool")
    if not np.all((array >= 0) & (array <= 1)):
        raise ValueError("image: all numbers must be finite and within [0, 1]")
    return _without_needless_alpha(array.astype(np.float32))


def _without_needless_alpha(pixels: Float32Array) -> Float32Array:
    return pixels[..., :3] if pixels.shape[2] == 4 and pixels[..., 3].min() >= 1 else pixels


def premultiplied(image: ArrayLike) -> Float32Array:
    """Return straight RGB or RGBA (H, W, 3 or 4) as premultiplied RGBA: (H, W, 4) float32; without alpha it is 1.

    Examples
    --------
    >>> premultiplied([[[1, 0.5, 0, 0.5]]]).tolist()
    [[[0.5, 0.25, 0.0, 0.5]]]
    """
    pixels = _checked(image)
    alpha = pixels[..., 3:] if pixels.shape[2] == 4 else np.ones((*pixels.shape[:2], 1), np.float32)
    return np.concatenate([alpha * pixels[..., :3], alpha], axis=2)


def _straight(name: str, data: bytes, image: Image | None) -> Float32Array:
    """Decode a picture and turn it the right way up; see :func:`read_image`."""
    try:
        color, alpha, orientation = decoded(name, data, image)
    except ImageError as error:
        raise ImageError(f"{name}: {error}") from error
    except MemoryError as error:
        raise ImageError(f"{name}: not enough memory for its pixels; scale it down first") from error
    except Exception as error:  # damaged data can raise any exception
        raise ImageError(f"{name}: {damage(error)}") from error
    if not color.size:
        raise ImageError(f"{name}: has no pixels")
    pixels = np.empty((*color.shape[:2], 3 if alpha is None else 4), np.float32)
    pixels[..., :3] = color
    if alpha is not None:
        pixels[..., 3:] = alpha
    low, high = float(pixels.min()), float(pixels.max())
    if not np.isfinite(high - low):
        raise ImageError(f"{name}: some pixels are not finite numbers; replace them first")
    if low < -OVERSHOOT or high > 1 + OVERSHOOT:
        raise ImageError(f"{name}: pixels range from {low:g} to {high:g}; scale them to [0, 1]")
    pixels = _without_needless_alpha(np.clip(pixels, 0, 1, out=pixels))
    return np.ascontiguousarray(_turned(pixels, orientation))


def over_background(image: ArrayLike, background: ArrayLike) -> Float32Array:
    """Composite a picture over a colour.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        Straight RGB or RGBA in [0, 1].
    background : (3,) array_like
        Opaque RGB in [0, 1].

    Returns
    -------
    (H, W, 3) float32
        ``alpha * rgb + (1 - alpha) * background``; a copy of `image` if it has no alpha.

    Examples
    --------
    >>> over_background([[[1, 0.5, 0, 0.5]]], (1, 1, 1)).tolist()
    [[[1.0, 0.75, 0.5]]]
    """
    pixels = _checked(image)
    ground = np.asarray(background, dtype=np.float32)
    if ground.shape != (3,):
        raise ValueError(f"background: shape {ground.shape}, wanted (3,)")
    if pixels.shape[2] == 3:
        return np.array(pixels)
    return over_ground(premultiplied(pixels), ground)


def over_ground(image: NDArray[Any], ground: NDArray[Any]) -> Float32Array:
    """Composite a picture over an opaque one: premultiplied RGBA gives p + (1 - a) g, RGB itself; (H, W, 3) float32."""
    composite = image if image.shape[2] == 3 else image[..., :3] + (1 - image[..., 3:]) * ground
    return np.asarray(composite, dtype=np.float32)


def save_image(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Write a picture as an 8-bit PNG file, replacing an existing one atomically.

    Parameters
    ----------
    path : path
        File to write.
    image : (H, W, 3) or (H, W, 4) array_like
        Straight RGB or RGBA; numbers are clipped to [0, 1].

    Raises
    ------
    ValueError
        If `image` has another shape or holds numbers that are not finite.
    OSError
        If the file cannot be written.
    """
    from PIL import Image

    pixels = _checked(image)
    if not np.isfinite(pixels).all():
        raise ValueError("image: all numbers must be finite")
    stream = io.BytesIO()
    Image.fromarray(np.rint(np.clip(pixels, 0, 1) * 255).astype(np.uint8)).save(stream, "PNG")
    write_atomically(path, stream.getvalue())


def _checked(image: ArrayLike) -> Float32Array:
    pixels = np.asarray(image, dtype=np.float32)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or not pixels.size:
        raise ValueError(f"image: shape {pixels.shape}, wanted (H, W, 3) or (H, W, 4)")
    return pixels


def _turned(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Apply an EXIF orientation, 1 to 8, to (H, W, C): a transposition from 5 on, then flips."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    return pixels
