# SPDX-License-Identifier: Apache-2.0
"""MNIST: reading handwritten digits and their labels from IDX files."""

from __future__ import annotations

import dataclasses
import gzip
import os
import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from livecl.errors import ImageError

#: Pixels along a side of a digit.
SIDE = 28
#: Magic numbers of IDX files: two zero bytes, the type (8: unsigned bytes), the number of axes.
IMAGES_MAGIC, LABELS_MAGIC = 0x00000803, 0x00000801
_STEMS = {"train": "train", "test": "t10k"}


@dataclasses.dataclass(frozen=True)
class Digits:
    """A set of digits, white on black.

    Attributes
    ----------
    images : (N, 28, 28) float32
        Grey in [0, 1].
    labels : (N,) uint8
        Digit of each image, 0 to 9.
    """

    images: NDArray[np.float32]
    labels: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.labels)


def read_mnist(folder: str | os.PathLike[str], *, part: str = "train", count: int | None = None) -> Digits:
    """Read MNIST, or a set in the same files, from a folder with its IDX files, gzipped or not.

    Parameters
    ----------
    folder : path
        Folder with ``train-images-idx3-ubyte`` and ``train-labels-idx1-ubyte`` (``t10k-...`` for the test part), with
        or without ``.gz``; a dot in place of the second hyphen is accepted too.
    part : "train" or "test"
        Which of the two parts.
    count : int, optional
        Number of digits to read, from the beginning of the file (default: all).

    Returns
    -------
    Digits
        Grey values divided by 255.

    Raises
    ------
    ImageError
        If a file is missing, truncated or no IDX file of that kind, or the two do not match.
    """
    if part not in _STEMS:
        raise ValueError(f"part: got {part!r}, wanted 'train' or 'test'")
    if count is not None and count < 1:
        raise ValueError(f"count: got {count}, wanted at least 1")
    stem = _STEMS[part]
    images_file = _find(Path(folder), f"{stem}-images-idx3-ubyte")
    labels_file = _find(Path(folder), f"{stem}-labels-idx1-ubyte")
    images, labels = read_idx(images_file, magic=IMAGES_MAGIC), read_idx(labels_file, magic=LABELS_MAGIC)
    if images.shape[1:] != (SIDE, SIDE):
        raise ImageError(f"{images_file}: pictures of {images.shape[1:]} pixels, wanted {(SIDE, SIDE)}")
    if len(images) != len(labels) or not len(images):
        raise ImageError(f"{images_file}: {len(images)} pictures with {len(labels)} labels, wanted as many, not none")
    if labels.max() > 9:
        raise ImageError(f"{labels_file}: a label of {labels.max()}, wanted 0 to 9")
    return Digits(images[:count].astype(np.float32) / np.float32(255), labels[:count])


def read_idx(path: str | os.PathLike[str], *, magic: int) -> NDArray[np.uint8]:
    """Read an array of unsigned bytes from an IDX file, gzipped or not.

    The file begins with the magic number and the length of each axis, 32 bits each, big-endian; the bytes follow, last
    axis fastest.

    Parameters
    ----------
    path : path
        The file; gzip is recognized by its content.
    magic : int
        The expected magic number; its last byte is the number of axes.

    Returns
    -------
    (N, ...) uint8
        The array.

    Raises
    ------
    ImageError
        If the file cannot be read, has another magic number, or more or fewer bytes than it announces.
    """
    name = os.fspath(path)
    try:
        data = Path(path).read_bytes()
        if data.startswith(b"\x1f\x8b"):
            data = gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as error:
        raise ImageError(f"{name}: cannot be read ({error})") from error
    axes = magic & 0xFF
    head = 4 + 4 * axes
    found = data[:4].hex() or "nothing"
    if data[:4] != struct.pack(">I", magic):
        raise ImageError(f"{name}: begins with {found}, wanted the magic number {magic:08x} of an IDX file")
    if len(data) < head:
        raise ImageError(f"{name}: {len(data)} bytes, wanted a head of {head}; the file is cut off")
    shape = struct.unpack(f">{axes}I", data[4:head])
    size = int(np.prod(shape, dtype=object))
    if len(data) != head + size:
        raise ImageError(f"{name}: {len(data) - head} bytes of data, wanted {size} for the shape {shape}")
    return np.frombuffer(data, np.uint8, offset=head).reshape(shape)


def _find(folder: Path, name: str) -> Path:
    for candidate in (folder / name, folder / f"{name}.gz", folder / name.replace("-idx", ".idx")):
        if candidate.is_file():
            return candidate
    raise ImageError(f"{folder}: there is no {name} or {name}.gz in it; give the folder with MNIST's IDX files")
