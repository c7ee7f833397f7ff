# SPDX-License-Identifier: Apache-2.0
"""Sources of images: read the bytes of a file, and open them with Pillow, not yet decoded."""

from __future__ import annotations

import io
import os
import stat
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from livecl.errors import ImageError, readable

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

#: Largest number of pixels read, about 1 GB as float32 RGB: larger images could be decompression bombs.
MAX_PIXELS = 89_000_000
TOO_LARGE = f"more than {MAX_PIXELS // 1_000_000} million pixels; scale it down first"
#: Largest file read, bytes: more than the largest picture has with four 32-bit channels.
MAX_BYTES = 1_500_000_000
#: Suffixes of picture files in folders; a file given by name may have any.
SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".gif", ".webp", ".tif", ".tiff", ".bmp"})
ADVICE = "give a whole PNG, JPEG, GIF, WebP, TIFF or BMP file"
IS_DRAWING = "is an SVG, a drawing and not a picture of pixels; export it as PNG, or refine it as the start"
_TIFF_STARTS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")


def content(source: str | os.PathLike[str] | bytes | BinaryIO) -> tuple[str, bytes]:
    """Return a name for messages, and the file's bytes; ImageError if there are none, or too many."""
    if isinstance(source, bytes):
        name, data = "picture data", source
    elif isinstance(source, (str, os.PathLike)):
        name = readable(os.fspath(source))
        try:
            data = _file_content(Path(source))
        except FileNotFoundError as error:
            raise ImageError(f"{name}: there is no such file; check the path") from error
        except IsADirectoryError as error:
            raise ImageError(f"{name}: is a directory; give a picture file in it") from error
        except (OSError, ValueError) as error:
            raise ImageError(f"{name}: cannot be read ({getattr(error, 'strerror', None) or error})") from error
    elif hasattr(source, "read"):
        name, data = str(getattr(source, "name", "picture data")), source.read(MAX_BYTES + 1)
        if not isinstance(data, bytes):
            raise TypeError("source: the file is open for text; open it in binary mode")
    else:
        raise TypeError(f"source: got {type(source).__name__}, wanted a path, bytes or a binary file")
    if not data:
        raise ImageError(f"{name}: the file is empty; {ADVICE}")
    if len(data) > MAX_BYTES:
        raise ImageError(f"{name}: more than {MAX_BYTES / 1e9:g} GB; scale the picture down first")
    return name, data


def _file_content(path: Path) -> bytes:
    """Return a file's bytes, cut one byte beyond the largest size; those of a pipe until its writer ends."""
    with path.open("rb") as stream:
        status = os.fstat(stream.fileno())
        whole = stat.S_ISREG(status.st_mode) and status.st_size <= MAX_BYTES
        return stream.read() if whole else stream.read(MAX_BYTES + 1)


def opened(name: str, data: bytes) -> ImageFile | None:
    """Open a picture with Pillow, its pixels not yet decoded; None for a TIFF that Pillow does not support.

    Raises ImageError if it is no picture, or has too many pixels.
    """
    from PIL import Image, ImageFile, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            image = Image.open(io.BytesIO(data))
    except (Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        raise ImageError(f"{name}: {TOO_LARGE}") from error
    except UnidentifiedImageError as error:
        if data.startswith(_TIFF_STARTS):
            return None
        if _is_svg(data):
            raise ImageError(f"{name}: {IS_DRAWING}") from error
        raise ImageError(f"{name}: not a picture of a kind that can be read; {ADVICE}") from error
    except MemoryError as error:
        raise ImageError(f"{name}: not enough memory; scale the picture down first") from error
    except Exception as error:  # damaged data can raise any exception
        raise ImageError(f"{name}: {damage(error)}") from error
    if image.format == "EPS" or isinstance(image, ImageFile.StubImageFile):
        raise ImageError(f"{name}: {image.format} needs another program to be drawn; export it as PNG")
    if image.width * image.height > MAX_PIXELS:
        raise ImageError(f"{name}: {TOO_LARGE}")
    return image


def _is_svg(data: bytes) -> bool:
    head = data[:4096].lstrip(b"\xef\xbb\xbf \t\r\n")
    return head.startswith(b"<") and b"<svg" in head and b"<html" not in head


def damage(error: Exception) -> str:
    """Return a decoder's message on damaged data as one line of printable characters."""
    reason = readable(str(error)[:150]) or type(error).__name__
    return f"the picture is damaged or cut off ({reason}); {ADVICE}"
