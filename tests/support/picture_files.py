# SPDX-License-Identifier: Apache-2.0
"""Picture files made byte by byte, or by Pillow and tifffile: what tests of reading pictures, and the fuzzer, share."""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray
from PIL import Image

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def encoded(image: Image.Image, kind: str = "PNG", **options: Any) -> bytes:
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()


def png_chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def png(width: int, height: int, depth: int, color_type: int, rows: bytes, *chunks: bytes) -> bytes:
    """Return a PNG of filtered rows, with further chunks before them."""
    header = struct.pack(">IIBBBBB", width, height, depth, color_type, 0, 0, 0)
    parts = [png_chunk(b"IHDR", header), *chunks, png_chunk(b"IDAT", zlib.compress(rows)), png_chunk(b"IEND", b"")]
    return PNG_SIGNATURE + b"".join(parts)


def png16(pixels: NDArray[np.uint16], *chunks: bytes) -> bytes:
    """Return a 16-bit PNG whose rows use the filters none, sub and up in turn."""
    height, width, num_channels = pixels.shape
    color_type = {1: 0, 2: 4, 3: 2, 4: 6}[num_channels]
    rows = pixels.astype(">u2").reshape(height, -1).view(np.uint8).astype(np.int64)
    body, above = b"", np.zeros(rows.shape[1], dtype=np.int64)
    for i, row in enumerate(rows):
        left = np.concatenate([np.zeros(2 * num_channels, dtype=np.int64), row[: -2 * num_channels]])
        filtered = row - (np.zeros_like(row), left, above)[i % 3]
        body += bytes([i % 3]) + (filtered % 256).astype(np.uint8).tobytes()
        above = row
    return png(width, height, 16, color_type, body, *chunks)


def tiff(pixels: NDArray[Any], **options: Any) -> bytes:
    stream = io.BytesIO()
    tifffile.imwrite(stream, pixels, **options)
    return stream.getvalue()
