# SPDX-License-Identifier: Apache-2.0
"""Masks from files: folders and labels of any kind, and one clear line for files that are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from livecl.errors import ImageError
from livecl.image.masks import MOST, Masks, read_masks


def save(path: Path, pixels: Any, mode: str | None = None) -> Path:
    Image.fromarray(np.asarray(pixels, dtype=np.uint8), mode).save(path)
    return path


def square(high: int = 255) -> NDArray[np.uint8]:
    pixels = np.zeros((6, 8), np.uint8)
    pixels[1:4, 2:5] = high
    return pixels


def test_a_folder_of_masks_in_the_order_of_numbers(tmp_path: Path) -> None:
    save(tmp_path / "10 eye.png", square())
    save(tmp_path / "2 head.png", square(1))  # 1 for inside, of 255
    clear = np.dstack([np.full((6, 8, 3), 90, np.uint8), square()])
    save(tmp_path / "1 body.png", clear)
    (tmp_path / "notes.txt").write_text("no mask")
    masks = read_masks(tmp_path)
    assert masks.names == ("1 body", "2 head", "10 eye")
    for mask in masks.pixels:
        np.testing.assert_array_equal(mask, square() / 255)


def test_labels_are_values_or_colours(tmp_path: Path) -> None:
    values = np.zeros((6, 8), np.uint8)
    values[:2], values[4:] = 7, 3
    for name, pixels in (("grey.png", values), ("palette.png", values)):
        image = Image.fromarray(pixels)
        if name == "palette.png":
            image = Image.fromarray(pixels, "P")
            image.putpalette([0, 0, 0, *(n for k in range(1, 256) for n in (k, 255 - k, 0))])
        image.save(tmp_path / name)
        masks = read_masks(tmp_path / name)
        assert masks.names == ("mask 1", "mask 2")
        np.testing.assert_array_equal(masks.pixels, [values == 3, values == 7])
    deep = values.astype(np.uint16) * 300
    Image.fromarray(deep).save(tmp_path / "deep.png")
    np.testing.assert_array_equal(read_masks(tmp_path / "deep.png").pixels, [values == 3, values == 7])


def test_what_is_no_mask_is_refused_in_one_line(tmp_path: Path) -> None:
    def refused(path: Path, reason: str) -> None:
        with pytest.raises(ImageError) as caught:
            read_masks(path)
        message = str(caught.value)
        assert str(path) in message and reason in message and "\n" not in message

    folder = tmp_path / "masks"
    folder.mkdir()
    refused(folder, "holds no masks, wanted pictures")
    save(folder / "a.png", square())
    save(folder / "b.png", np.full((6, 9), 255))
    refused(folder, "b.png has 9x6 px, wanted the 8x6 px of a.png")
    save(folder / "b.png", np.zeros((6, 8)))
    refused(folder, "'b' is empty")
    (folder / "b.png").write_bytes(b"no picture")
    refused(folder, "b.png")
    refused(save(tmp_path / "black.png", np.zeros((6, 8))), "holds no masks: all pixels are black or clear")
    noise = np.random.default_rng(0).integers(1, 255, (40, 40, 3))
    refused(save(tmp_path / "noise.png", noise), f"wanted at most {MOST}, one per mask, without smooth edges")
    refused(tmp_path / "nowhere.png", "nowhere.png")


def test_masks_fit_a_picture() -> None:
    masks = Masks(("a",), (square() / 255).astype(np.float32)[None])
    np.testing.assert_allclose(masks.on((6, 8), (3, 4))[0, 0], [0, 0.5, 0.25, 0], atol=1e-6)
    assert masks.on((6, 8), (6, 8)).shape == (1, 6, 8)
    with pytest.raises(ValueError, match="masks: 8x6 px, wanted the picture's 9x6 px"):
        masks.on((6, 9), (6, 9))
    assert masks.digest != Masks(("b",), masks.pixels).digest
    with pytest.raises(ValueError, match="names, wanted"):
        Masks(("a", "b"), masks.pixels)
