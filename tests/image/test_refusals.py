# SPDX-License-Identifier: Apache-2.0
"""Files and arrays that are no pictures, not whole, or too large: refused in one line, and before memory is taken."""

from __future__ import annotations

import io
import os
import struct
import subprocess
import sys
import threading
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support.picture_files import PNG_SIGNATURE, encoded, png, png_chunk

from livecl.errors import ImageError
from livecl.image import source as image_source
from livecl.image.reading import as_image, read_image

RNG = np.random.default_rng(12)
NOISE = Image.fromarray(RNG.integers(0, 256, (48, 64, 3), dtype=np.uint8))
#: Address space that refusing a picture may take, bytes: what one of the smallest bombs below would need is more.
ROOM = 250_000_000


def refusal(source: Any, *words: str) -> str:
    """Return the line that a picture is refused with."""
    with pytest.raises(ImageError) as caught:
        read_image(source)
    message = str(caught.value)
    assert message.isprintable() and len(message) < 400
    for word in words:
        assert word in message
    return message


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        *[
            (kind, {})
            for kind in ("PNG", "JPEG", "GIF", "WEBP", "TIFF", "BMP", "PPM", "JPEG2000", "AVIF", "SGI", "PCX")
        ],
        *[("TIFF", {"compression": name}) for name in ("tiff_lzw", "tiff_adobe_deflate", "jpeg")],
        *[("WEBP", {"lossless": True}), ("JPEG", {"progressive": True}), ("TGA", {}), ("QOI", {}), ("DDS", {})],
    ],
)
@pytest.mark.parametrize("share", [0.5, 0.95])
def test_no_part_of_a_picture_is_taken_for_all(kind: str, options: dict[str, Any], share: float) -> None:
    data = encoded(NOISE.quantize(256) if kind == "GIF" else NOISE, kind, **options)
    refusal(data[: int(share * len(data))], "picture data: ")


def tiff_of(
    width: int, height: int, samples: int = 1, bits: int = 8, strip: bytes = b"", compression: int = 1
) -> bytes:
    """Return a grey TIFF of one strip, whatever its head says of it."""
    entries = [
        (256, 4, width),
        (257, 4, height),
        (258, 3, bits),
        (259, 3, compression),
        (262, 3, 1),
        (273, 4, 8),
        (277, 3, samples),
        (278, 4, height),
        (279, 4, len(strip)),
    ]
    pages = struct.pack("<H", len(entries)) + b"".join(
        struct.pack("<HHII", tag, kind, 1, n) for tag, kind, n in entries
    )
    return struct.pack("<2sHI", b"II", 42, 8 + len(strip)) + strip + pages + bytes(4)


def patched(data: bytes, marker: bytes, offset: int, form: str, *numbers: int) -> bytes:
    """Return data with numbers written some bytes after a marker."""
    place = data.index(marker) + offset
    return data[:place] + struct.pack(form, *numbers) + data[place + struct.calcsize(form) :]


def icon(picture: bytes) -> bytes:
    """Return an icon that says of a PNG in it that it has 16 x 16 pixels."""
    return struct.pack("<HHHBBBBHHII", 0, 1, 1, 16, 16, 0, 0, 1, 32, len(picture), 22) + picture


BOMBS: dict[str, Callable[[], bytes]] = {
    "png": lambda: png(9_500, 9_500, 8, 2, b""),
    "png 16": lambda: png(30_000, 30_000, 16, 2, b""),
    "gif": lambda: patched(encoded(NOISE.quantize(4), "GIF"), b"GIF8", 6, "<HH", 60_000, 60_000),
    "jpeg": lambda: patched(encoded(NOISE, "JPEG"), b"\xff\xc0", 5, ">HH", 60_000, 60_000),
    "bmp": lambda: patched(encoded(NOISE, "BMP"), b"BM", 18, "<ii", 60_000, 60_000),
    "webp": lambda: patched(encoded(NOISE, "WEBP", lossless=True), b"VP8L", 9, "<I", 0x0FFF_FFFF),
    "webp animated": lambda: patched(
        encoded(NOISE, "WEBP", save_all=True, append_images=[NOISE.rotate(90)]),
        b"VP8X",
        12,
        "<HBHB",
        16_000,
        0,
        16_000,
        0,
    ),
    "jpeg 2000": lambda: patched(encoded(NOISE, "JPEG2000", no_jp2=True), b"\xff\x51", 6, ">II", 60_000, 60_000),
    "ppm": lambda: b"P6 60000 60000 255\n" + bytes(99),
    "tga": lambda: patched(encoded(NOISE, "TGA"), b"", 12, "<HH", 60_000, 60_000),
    "tiff": lambda: tiff_of(60_000, 60_000, strip=bytes(99)),
    "tiff 16": lambda: tiff_of(60_000, 60_000, bits=16, strip=bytes(99)),
    "tiff of many channels": lambda: tiff_of(9_000, 9_000, samples=60_000, bits=16, strip=bytes(99)),
    "tiff that inflates": lambda: tiff_of(9, 9, bits=16, strip=zlib.compress(bytes(300_000_000), 1), compression=8),
    "icon": lambda: icon(png(9_500, 9_500, 8, 6, b"")),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_bombs_are_refused(kind: str) -> None:
    refusal(BOMBS[kind](), "million pixels" if kind not in ("tiff of many channels", "webp animated") else "")


def test_bombs_are_refused_before_memory_is_taken(tmp_path: Path) -> None:
    """In a process that has no room for them."""
    for kind, bomb in BOMBS.items():
        (tmp_path / kind).write_bytes(bomb())
    code = f"""
import pathlib, resource, sys
import livecl, tifffile
from imageio import v3
from livecl.errors import ImageError
from PIL import Image, ImageCms
Image.init()
has = int(pathlib.Path("/proc/self/statm").read_text(encoding="utf-8").split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (has + {ROOM}, has + {ROOM}))
for path in sorted(pathlib.Path(sys.argv[1]).iterdir()):
    try:
        livecl.read_image(path)
    except ImageError as error:
        print(path.name, "refused, for want of memory" if "memory" in str(error) else "refused")
"""
    done = subprocess.run([sys.executable, "-c", code, tmp_path], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == [f"{kind} refused" for kind in sorted(BOMBS)], done.stderr


def test_text_of_a_png_that_inflates() -> None:
    text = png_chunk(b"zTXt", b"Comment\0\0" + zlib.compress(bytes(200_000_000), 1))
    refusal(png(1, 1, 8, 2, bytes(4), text), "damaged")


def test_want_of_memory_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_memory(*_: Any) -> None:
        raise MemoryError

    data = encoded(NOISE)
    monkeypatch.setattr(Image.Image, "convert", no_memory)
    refusal(data, "not enough memory", "scale it down")


def test_damaged_tiff_that_chains_pages_without_end() -> None:
    """A list of its pages takes tifffile hours: 16 tags of nothing, and the next page far behind the file's end."""
    data = bytearray(268)
    data[:16] = b"II*\0\x08\0\0\0\x10\0\0\0\x04\0\0\0"
    data[205], data[265] = 16, 1
    refusal(bytes(data), "damaged or cut off")


@pytest.mark.parametrize("size", [(0, 5), (5, 0)])
def test_pictures_without_pixels(size: tuple[int, int]) -> None:
    width, height = size
    bitmap = encoded(NOISE, "BMP")
    refusal(patched(bitmap, b"BM", 18, "<ii", width, height))
    refusal(patched(encoded(NOISE, "TGA"), b"", 12, "<HH", width, height))
    refusal(tiff_of(width, height, bits=16, strip=bytes(99)), "has no pixels")


def test_documents_and_programs_are_no_pictures() -> None:
    postscript = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n%%EndComments\nshowpage\n"
    refusal(postscript, "EPS needs another program to be drawn; export it as PNG")
    refusal(b"\xd7\xcd\xc6\x9a" + bytes(36) + b"\1\0\x09\0" + bytes(100))
    refusal(b"<svg xmlns='http://www.w3.org/2000/svg' width='5' height='5'/>", "not a picture")
    refusal(b"%PDF-1.7\n", "not a picture")
    refusal(bytes(1000), "not a picture")
    refusal(b"\x7fELF" + bytes(1000), "not a picture")
    refusal(PNG_SIGNATURE)


def test_messages_hold_visible_characters_only(tmp_path: Path) -> None:
    """What a decoder says of a file may quote it."""
    for name in (b"IHDR", b"\x1b[2J", b"a\nb\0"):
        refusal(PNG_SIGNATURE + png_chunk(name, b"\x1b]0;x\x07" * 3))


def test_a_pipe_is_read_to_its_end(tmp_path: Path) -> None:
    """As shells make one of ``<(convert ...)``."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(encoded(NOISE),))
    writer.start()
    got = read_image(pipe)
    writer.join()
    np.testing.assert_allclose(got, np.asarray(NOISE) / 255, atol=1e-7)


def test_endless_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(image_source, "MAX_BYTES", 5_000_000)
    refusal("/dev/zero", "/dev/zero: more than 0.005 GB")
    with Path("/dev/zero").open("rb") as stream:
        refusal(stream, "more than 0.005 GB")
    large = tmp_path / "large.png"
    with large.open("wb") as stream:
        stream.truncate(10**12)  # takes no space
    refusal(large, "large.png: more than 0.005 GB")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(encoded(NOISE))
    refusal(tmp_path / "file" / "in.png", "cannot be read (Not a directory)")
    refusal("a\0b.png", "a b.png: cannot be read")
    refusal("/dev/null", "/dev/null: the file is empty")
    refusal(io.BytesIO(), "the file is empty")


def test_a_file_without_permission(tmp_path: Path) -> None:
    """In a process that gives up the rights of the superuser, who may read all files."""
    (tmp_path / "in.png").write_bytes(encoded(NOISE))
    (tmp_path / "in.png").chmod(0)
    code = "import os, sys; import livecl; from livecl.image import read_image; os.geteuid() or os.setuid(65534); "
    done = subprocess.run(
        [sys.executable, "-c", f"{code} read_image(sys.argv[1])", tmp_path / "in.png"], capture_output=True, text=True
    )
    assert done.stderr.splitlines()[-1].endswith("in.png: cannot be read (Permission denied)")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1e-3, 1.001])
def test_arrays_of_other_numbers(value: float) -> None:
    array = np.full((4, 5, 3), 0.5)
    array[2, 3, 1] = value
    with pytest.raises(ValueError, match="image: all numbers must be finite and within"):
        as_image(array)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((0, 5, 3)), r"image: shape \(0, 5, 3\)"),
        (np.zeros((4, 5, 2)), r"image: shape \(4, 5, 2\)"),
        (np.zeros((4, 5, 5)), r"image: shape \(4, 5, 5\)"),
        (np.zeros(7), r"image: shape \(7,\)"),
        (np.zeros((1, 4, 5, 3)), r"image: shape \(1, 4, 5, 3\)"),
        (3.0, r"image: shape \(\)"),
        (np.zeros((4, 5), np.int32), "image: numbers of type int32"),
        (np.zeros((4, 5), np.int8), "image: numbers of type int8"),
        (np.zeros((4, 5), np.complex64), "image: numbers of type complex64"),
        (np.full((4, 5), "a"), "image: numbers of type <U1"),
        (np.full((4, 5), None), "image: numbers of type object"),
        (None, "image: shape"),
        ([[0.0, 1.0], [0.5]], "image: its rows differ in length"),
        (np.zeros((4, 5), "datetime64[s]"), "image: numbers of type datetime64"),
    ],
)
def test_arrays_of_other_shapes_and_types(array: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        as_image(array)
