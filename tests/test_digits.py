# SPDX-License-Identifier: Apache-2.0
"""IDX files, whole and damaged, and the digits that are drawn where there are none."""

from __future__ import annotations

import gzip
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from livecl.digit_strokes import SHIFTS, SKELETONS, STAMPS, draw_digits
from livecl.digits import IMAGES_MAGIC, LABELS_MAGIC, Digits, read_idx, read_mnist
from livecl.errors import ImageError

IMAGES, LABELS = "train-images-idx3-ubyte", "train-labels-idx1-ubyte"


def idx(array: np.ndarray, magic: int) -> bytes:
    return struct.pack(f">I{array.ndim}I", magic, *array.shape) + array.astype(np.uint8).tobytes()


@pytest.fixture
def pictures() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, size=(5, 28, 28)).astype(np.uint8)


@pytest.fixture
def write(tmp_path: Path, pictures: np.ndarray) -> Callable[..., Path]:
    """Return a function that writes the two files, with what is given in place of what is right."""

    def function(images: bytes = b"", labels: bytes = b"", suffix: str = "", stem: str = "train") -> Path:
        images = images or idx(pictures, IMAGES_MAGIC)
        labels = labels or idx(np.arange(5), LABELS_MAGIC)
        if suffix == ".gz":
            images, labels = gzip.compress(images), gzip.compress(labels)
        (tmp_path / f"{IMAGES}{suffix}".replace("train", stem)).write_bytes(images)
        (tmp_path / f"{LABELS}{suffix}".replace("train", stem)).write_bytes(labels)
        return tmp_path

    return function


@pytest.mark.parametrize("suffix", ["", ".gz"])
@pytest.mark.parametrize(("part", "stem"), [("train", "train"), ("test", "t10k")])
def test_reads_mnist(write: Callable[..., Path], pictures: np.ndarray, suffix: str, part: str, stem: str) -> None:
    digits = read_mnist(write(suffix=suffix, stem=stem), part=part)
    assert len(digits) == 5
    assert digits.images.dtype == np.float32
    np.testing.assert_array_equal(np.rint(digits.images * 255), pictures)
    np.testing.assert_array_equal(digits.labels, np.arange(5))


def test_keeps_the_first(write: Callable[..., Path], pictures: np.ndarray) -> None:
    digits = read_mnist(write(), count=2)
    np.testing.assert_array_equal(np.rint(digits.images * 255), pictures[:2])
    np.testing.assert_array_equal(digits.labels, [0, 1])


def test_name_with_a_dot(write: Callable[..., Path]) -> None:
    folder = write()
    for name in (IMAGES, LABELS):
        (folder / name).rename(folder / name.replace("-idx", ".idx"))
    assert len(read_mnist(folder)) == 5


@pytest.mark.parametrize(
    ("images", "labels", "message"),
    [
        (idx(np.zeros((5, 28, 28)), LABELS_MAGIC), b"", "begins with 00000801, wanted the magic number 00000803"),
        (b"\x00\x00", b"", "begins with 0000, wanted"),
        (b"\x89PNG....", b"", "begins with 89504e47, wanted"),
        (idx(np.zeros((5, 28, 28)), IMAGES_MAGIC)[:10], b"", "10 bytes, wanted a head of 16"),
        (idx(np.zeros((5, 28, 28)), IMAGES_MAGIC)[:-1], b"", "3919 bytes of data, wanted 3920"),
        (idx(np.zeros((5, 28, 28)), IMAGES_MAGIC) + b"x", b"", "3921 bytes of data, wanted 3920"),
        (
            struct.pack(">4I", IMAGES_MAGIC, *[2**32 - 1] * 3),
            b"",
            "0 bytes of data, wanted 79228162458924105385300197375",
        ),
        (idx(np.zeros((5, 27, 28)), IMAGES_MAGIC), b"", r"pictures of \(27, 28\) pixels, wanted \(28, 28\)"),
        (b"", idx(np.arange(4), LABELS_MAGIC), "5 pictures with 4 labels"),
        (b"", idx(np.arange(8, 13), LABELS_MAGIC), "a label of 12, wanted 0 to 9"),
        (gzip.compress(b"x" * 100)[:-12], b"", "cannot be read"),
        (b"\x1f\x8b\x08\x00" + b"\xff" * 40, b"", "cannot be read"),
    ],
)
def test_damaged_files(write: Callable[..., Path], images: bytes, labels: bytes, message: str) -> None:
    with pytest.raises(ImageError, match=message):
        read_mnist(write(images, labels))


def test_missing_files(tmp_path: Path, write: Callable[..., Path]) -> None:
    with pytest.raises(ImageError, match=f"there is no {IMAGES} or {IMAGES}.gz in it"):
        read_mnist(tmp_path / "nowhere")
    write()
    with pytest.raises(ImageError, match="t10k-images"):
        read_mnist(tmp_path, part="test")
    with pytest.raises(ImageError, match="cannot be read"):
        read_idx(tmp_path, magic=IMAGES_MAGIC)


def test_arguments(write: Callable[..., Path]) -> None:
    with pytest.raises(ValueError, match="part: got 'all', wanted 'train' or 'test'"):
        read_mnist(write(), part="all")
    with pytest.raises(ValueError, match="count: got 0, wanted at least 1"):
        read_mnist(write(), count=0)
    with pytest.raises(ValueError, match="count: got 0, wanted at least 1"):
        draw_digits(0)


@pytest.fixture(scope="module")
def drawn() -> Digits:
    return draw_digits(400, seed=3)


def test_drawn_digits(drawn: Digits) -> None:
    assert drawn.images.shape == (400, 28, 28)
    assert drawn.images.dtype == np.float32
    np.testing.assert_array_equal(drawn.labels, np.arange(400) % 10)
    # White strokes, black ground, nothing cut off at the border.
    assert drawn.images.max() == 1
    assert (np.median(drawn.images, axis=(1, 2)) == 0).all()
    for edge in (drawn.images[:, [0, -1]], drawn.images[:, :, [0, -1]]):
        assert not edge.any()
    # All differ.
    assert len(np.unique(drawn.images.reshape(400, -1), axis=0)) == 400


def test_drawn_digits_are_centred(drawn: Digits) -> None:
    # The box's centre is off by the shift; seen in pixels, each side of the box by up to half a pixel more.
    for image in drawn.images:
        for axis in (0, 1):
            inked = np.flatnonzero(image.max(axis=axis) > 0.5)
            assert abs((inked[0] + inked[-1] + 1) / 2 - 14) <= max(SHIFTS) + 0.5


@pytest.mark.parametrize(("digit", "holes"), [(0, 1), (1, 0), (2, 0), (3, 0), (5, 0), (7, 0), (8, 2)])
def test_drawn_digits_have_their_holes(digit: int, holes: int) -> None:
    # At rest, without jitter, the skeletons themselves; a thin pen on a fine grid.
    for skeleton in SKELETONS[digit]:
        stamps = skeleton.stamps() @ np.array(skeleton.points)
        grid = np.stack(np.meshgrid(np.linspace(-0.7, 0.7, 141), np.linspace(-0.7, 0.7, 141)), axis=-1)
        distance = np.linalg.norm(grid[:, :, None] - stamps, axis=3).min(axis=2)
        assert ndimage.label(distance > 0.03)[1] == holes + 1


def test_strokes_run_through_their_points() -> None:
    for ways in SKELETONS:
        for skeleton in ways:
            weights = skeleton.stamps()
            assert weights.shape == (STAMPS * len(skeleton.strokes), len(skeleton.points))
            # The weights of a stamp add up to 1, so that a shift of the points shifts it; a spline's solution of K
            # equations leaves a few eps.
            np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-13)
            for index, stroke in enumerate(skeleton.strokes):
                run = weights[index * STAMPS : (index + 1) * STAMPS] @ np.array(skeleton.points)
                np.testing.assert_allclose(
                    run[[0, -1]], [skeleton.points[stroke[0]], skeleton.points[stroke[-1]]], atol=1e-13
                )


def test_seed() -> None:
    first, again, other = draw_digits(20, seed=5), draw_digits(20, seed=5), draw_digits(20, seed=6)
    assert first.images.tobytes() == again.images.tobytes()
    assert first.images.tobytes() != other.images.tobytes()
