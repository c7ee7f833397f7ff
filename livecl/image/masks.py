# SPDX-License-Identifier: Apache-2.0
"""Masks of the things in a picture: a folder of pictures, or one picture of labels."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.checks import clean_name
from livecl.errors import ImageError
from livecl.image.reading import premultiplied, read_image
from livecl.image.resizing import reduced
from livecl.image.source import SUFFIXES

#: Maximum number of masks.
MOST = 256


@dataclasses.dataclass(frozen=True, eq=False)
class Masks:
    """Masks of K things: `names`, and `pixels` (K, H, W) float32, 1 inside and 0 outside; hidden parts may be inside.

    Raises
    ------
    ValueError
        If shapes or numbers do not fit together, or a mask is empty.
    """

    names: tuple[str, ...]
    pixels: NDArray[np.float32]

    def __post_init__(self) -> None:
        shape = np.shape(self.pixels)
        if len(shape) != 3 or shape[0] != len(self.names) or not 1 <= shape[0] <= MOST:
            raise ValueError(f"masks: shape {shape} and {len(self.names)} names, wanted (K, H, W), K from 1 to {MOST}")
        if not (np.min(self.pixels) >= 0 and np.max(self.pixels) <= 1):
            raise ValueError("masks: all numbers must be finite and within [0, 1]")
        for name, mask in zip(self.names, self.pixels, strict=True):
            if not (mask >= 0.5).any():
                raise ValueError(f"masks: {name!r} is empty: no pixel of it is more than half inside")

    @property
    def digest(self) -> str:
        """Digest of names and pixels."""
        content = "\n".join(self.names).encode() + np.ascontiguousarray(self.pixels).tobytes()
        return hashlib.sha256(content + str(self.pixels.shape).encode()).hexdigest()

    def on(self, size: tuple[int, int], smaller: tuple[int, int]) -> NDArray[np.float32]:
        """Return the masks of a picture of a size (height, width), averaged over the pixels of a smaller size.

        Raises
        ------
        ValueError
            If they are of another size.
        """
        own = self.pixels.shape[1:]
        if own != tuple(size):
            raise ValueError(f"masks: {own[1]}x{own[0]} px, wanted the picture's {size[1]}x{size[0]} px")
        return np.stack([reduced(np.repeat(mask[..., None], 3, axis=2), smaller)[..., 0] for mask in self.pixels])


def read_masks(source: str | os.PathLike[str]) -> Masks:
    """Read masks.

    Parameters
    ----------
    source : path
        A folder of pictures, one for each mask, in the order of their names (numbers by value), which become the names
        of the masks: white pixels are inside, or, in a picture with alpha, opaque pixels. Or one picture, in which all
        pixels of one value or colour are a mask, except black and transparent ones.

    Raises
    ------
    ImageError
        If there are no masks, too many, or one cannot be read or differs in size from the first; the message is one
        line.
    """
    path = Path(source)
    try:
        return _of_folder(path) if path.is_dir() else _of_labels(path)
    except ValueError as error:
        raise ImageError(f"{path}: {str(error).removeprefix('masks: ')}") from error


def _of_folder(folder: Path) -> Masks:
    files = sorted((file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES), key=_natural)
    if not files:
        raise ValueError(f"holds no masks, wanted pictures ({' '.join(sorted(SUFFIXES))})")
    if len(files) > MOST:
        raise ValueError(f"holds {len(files)} pictures, wanted at most {MOST} masks")
    pixels: list[NDArray[np.float32]] = []
    for file in files:
        image = read_image(file)
        mask = image[..., 3] if image.shape[2] == 4 else image.mean(axis=2, dtype=np.float32)
        if pixels and mask.shape != pixels[0].shape:
            (height, width), (first_height, first_width) = mask.shape, pixels[0].shape
            raise ValueError(
                f"{file.name} has {width}x{height} px, wanted the {first_width}x{first_height} px of {files[0].name}"
            )
        pixels.append(mask / max(float(mask.max()), 1e-9))  # some programs write 1, of 255, inside
    return Masks(tuple(clean_name(file.stem) or f"mask {k}" for k, file in enumerate(files, 1)), np.stack(pixels))


def _of_labels(path: Path) -> Masks:
    image = premultiplied(read_image(path))
    values, labels = np.unique(image.reshape(-1, image.shape[2]), axis=0, return_inverse=True)
    shown = np.flatnonzero(values[:, :3].any(axis=1))
    if not len(shown):
        raise ValueError("holds no masks: all pixels are black or clear")
    if len(shown) > MOST:
        raise ValueError(
            f"holds {len(shown)} values, wanted at most {MOST}, one per mask, without smooth edges or lossy compression"
        )
    labels = labels.reshape(image.shape[:2])
    pixels = np.stack([labels == value for value in shown]).astype(np.float32)
    return Masks(tuple(f"mask {k}" for k in range(1, len(shown) + 1)), pixels)


def _natural(file: Path) -> list[tuple[int, str]]:
    """Sorting key of files by name, with 2 before 10."""
    parts = re.split(r"(\d+)", file.name)
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]
