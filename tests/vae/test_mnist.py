# SPDX-License-Identifier: Apache-2.0
"""Digits: those that are drawn, and the reading of IDX files."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from livecl.errors import ImageError
from livecl.vae import drawn_digits as digit_strokes
from livecl.vae.drawn_digits import SKELETONS, STAMPS, draw_digits
from livecl.vae.mnist import IMAGES_MAGIC, LABELS_MAGIC, SIDE, read_idx, read_mnist


def _idx(array: NDArray[np.uint8], magic: int) -> bytes:
    return struct.pack(f">{1 + array.ndim}I", magic, *array.shape) + array.tobytes()


def _images(count: int) -> NDArray[np.uint8]:
    return np.random.default_rng(count).integers(0, 256, (count, SIDE, SIDE), np.uint8)


def _write_mnist(folder: Path, images: NDArray[np.uint8], labels: NDArray[np.uint8], *, zipped: bool = False) -> None:
    for name, data in (
        ("train-images-idx3-ubyte", _idx(images, IMAGES_MAGIC)),
        ("train-labels-idx1-ubyte", _idx(labels, LABELS_MAGIC)),
    ):
        (folder / (f"{name}.gz" if zipped else name)).write_bytes(gzip.compress(data) if zipped else data)


def test_drawn_digits_are_grey_pictures_with_labels_that_go_round() -> None:
    digits = draw_digits(23)
    assert digits.images.shape == (23, SIDE, SIDE)
    assert digits.images.dtype == np.float32
    assert len(digits) == 23
    assert digits.labels.tolist() == [index % 10 for index in range(23)]
    assert digits.images.min() == 0
    # A pen of at least 1 px radius covers the centres of some pixels by half a pixel and more: full white.
    assert np.all(digits.images.max(axis=(1, 2)) == 1)
    assert digits.images.max() == 1


def test_drawn_digits_lie_within_the_picture() -> None:
    # The height is 20 px, the widest pen adds 1.7 + 0.5 px on each side, the shift 0.5 px: 1.3 px of 28 stay free.
    images = draw_digits(200).images
    frame = np.ones((SIDE, SIDE), bool)
    frame[1:-1, 1:-1] = False
    assert not images[:, frame].any()


def test_same_seed_same_digits() -> None:
    assert draw_digits(20, seed=3).images.tobytes() == draw_digits(20, seed=3).images.tobytes()
    assert not np.array_equal(draw_digits(20, seed=3).images, draw_digits(20, seed=4).images)


def test_drawn_digits_of_a_class_vary() -> None:
    images = draw_digits(40).images
    for label in range(10):
        same = images[label::10].reshape(4, -1)
        assert len(np.unique(same, axis=0)) == 4


def test_the_ten_classes_differ() -> None:
    # Nearest class mean, on digits that the means were not taken from. By chance a tenth would be right; 80 of 100 and
    # half of every class need each class to be its own shape.
    known, asked = draw_digits(400, seed=0), draw_digits(100, seed=1)
    means = np.stack([known.images[known.labels == label].mean(axis=0) for label in range(10)])
    squares = np.square(asked.images[:, None] - means).sum(axis=(2, 3))
    right = squares.argmin(axis=1) == asked.labels
    assert right.sum() >= 80
    for label in range(10):
        assert right[asked.labels == label].mean() >= 0.5


def test_skeletons_have_the_holes_of_their_digits() -> None:
    # Drawn as they are, by a thin pen on a fine grid; a 4, 6, 7 or 9 may or may not close.
    across = np.linspace(-0.7, 0.7, 141)
    grid = np.stack(np.meshgrid(across, across), axis=-1)
    for digit, holes in ((0, 1), (1, 0), (2, 0), (3, 0), (5, 0), (8, 2)):
        for skeleton in SKELETONS[digit]:
            distance = np.full((141, 141), np.inf)
            for stamp in skeleton.stamps() @ np.array(skeleton.points):
                distance = np.minimum(distance, np.linalg.norm(grid - stamp, axis=2))
            assert ndimage.label(distance > 0.03)[1] == holes + 1


def test_strokes_run_through_their_ends() -> None:
    # Weights and places come from a spline's few equations: a few eps.
    for ways in SKELETONS:
        for skeleton in ways:
            weights, points = skeleton.stamps(), np.array(skeleton.points)
            np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=0, atol=1e-13)
            strokes = (weights @ points).reshape(len(skeleton.strokes), STAMPS, 2)
            for stamps, stroke in zip(strokes, skeleton.strokes, strict=True):
                np.testing.assert_allclose(stamps[[0, -1]], points[[stroke[0], stroke[-1]]], rtol=0, atol=1e-13)


def test_stamps_lie_close_together(monkeypatch: pytest.MonkeyPatch) -> None:
    # The bound on the pen's scallops follows from it.
    placed = []
    stamped = digit_strokes.stamped

    def noted(stamps: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
        placed.append(stamps)
        return stamped(stamps, radius)

    monkeypatch.setattr(digit_strokes, "stamped", noted)
    draw_digits(1000)
    assert len(placed) == 1000
    for stamps in placed:
        assert np.linalg.norm(np.diff(stamps.reshape(-1, STAMPS, 2), axis=1), axis=2).max() <= 0.66


def test_no_digits_are_refused() -> None:
    with pytest.raises(ValueError, match="count: got 0"):
        draw_digits(0)


@pytest.mark.parametrize("zipped", [False, True])
def test_mnist_is_read(tmp_path: Path, zipped: bool) -> None:
    images, labels = _images(5), np.array([5, 0, 4, 1, 9], np.uint8)
    _write_mnist(tmp_path, images, labels, zipped=zipped)
    digits = read_mnist(tmp_path)
    assert digits.labels.tolist() == [5, 0, 4, 1, 9]
    assert digits.images.dtype == np.float32
    assert np.array_equal(digits.images, images.astype(np.float32) / np.float32(255))
    few = read_mnist(tmp_path, count=2)
    assert len(few) == 2
    assert np.array_equal(few.images, digits.images[:2])


def test_the_test_part_has_files_of_its_own(tmp_path: Path) -> None:
    _write_mnist(tmp_path, _images(2), np.array([1, 2], np.uint8))
    for file in list(tmp_path.iterdir()):
        file.rename(file.with_name(file.name.replace("train", "t10k")))
    assert read_mnist(tmp_path, part="test").labels.tolist() == [1, 2]
    with pytest.raises(ImageError, match="no train-images-idx3-ubyte"):
        read_mnist(tmp_path)


def test_idx_keeps_the_order_of_axes(tmp_path: Path) -> None:
    array = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)
    (tmp_path / "a").write_bytes(_idx(array, IMAGES_MAGIC))
    assert np.array_equal(read_idx(tmp_path / "a", magic=IMAGES_MAGIC), array)


WHOLE = _idx(np.arange(10, dtype=np.uint8), LABELS_MAGIC)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "begins with nothing, wanted the magic number 00000801"),
        (WHOLE[:3], "begins with 000008, wanted the magic number 00000801"),
        (_idx(_images(1), IMAGES_MAGIC), "begins with 00000803, wanted the magic number 00000801"),
        (WHOLE[:6], "6 bytes, wanted a head of 8; the file is cut off"),
        (WHOLE[:-1], r"9 bytes of data, wanted 10 for the shape \(10,\)"),
        (WHOLE + b"\0", r"11 bytes of data, wanted 10 for the shape \(10,\)"),
        (gzip.compress(WHOLE)[:-9], "cannot be read"),
        (gzip.compress(WHOLE)[:12] + b"\xff" * 20, "cannot be read"),
        (struct.pack(">II", LABELS_MAGIC, 2**32 - 1), "0 bytes of data, wanted 4294967295"),
    ],
    ids=[
        "empty",
        "short magic",
        "wrong magic",
        "short head",
        "cut off",
        "too long",
        "gzip cut off",
        "gzip damaged",
        "huge",
    ],
)
def test_damaged_idx_is_refused(tmp_path: Path, data: bytes, message: str) -> None:
    file = tmp_path / "labels"
    file.write_bytes(data)
    with pytest.raises(ImageError, match=message) as caught:
        read_idx(file, magic=LABELS_MAGIC)
    assert str(file) in str(caught.value)


def test_sizes_whose_product_overflows_are_refused(tmp_path: Path) -> None:
    # 2^32 * 2^32 wraps to 0 in 64 bits, which is the number of bytes there are.
    file = tmp_path / "images"
    file.write_bytes(struct.pack(">IIII", IMAGES_MAGIC, 2**31, 2**31, 4))
    with pytest.raises(ImageError, match="0 bytes of data, wanted 18446744073709551616"):
        read_idx(file, magic=IMAGES_MAGIC)


@pytest.mark.parametrize(
    ("images", "labels", "message"),
    [
        (_images(3), [1, 2], "3 pictures with 2 labels"),
        (_images(0), [], "0 pictures with 0 labels"),
        (_images(2)[:, :20], [1, 2], r"pictures of \(20, 28\) pixels"),
        (_images(2), [1, 10], "a label of 10"),
    ],
)
def test_files_that_do_not_belong_together_are_refused(
    tmp_path: Path, images: NDArray[np.uint8], labels: list[int], message: str
) -> None:
    _write_mnist(tmp_path, images, np.array(labels, np.uint8))
    with pytest.raises(ImageError, match=message):
        read_mnist(tmp_path)


def test_bad_arguments_name_themselves(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="part: got 'both'"):
        read_mnist(tmp_path, part="both")
    with pytest.raises(ValueError, match="count: got 0"):
        read_mnist(tmp_path, count=0)
