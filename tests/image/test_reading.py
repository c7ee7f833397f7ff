# SPDX-License-Identifier: Apache-2.0
"""`read_image` on every kind of picture, its errors, `over_background`, `save_image`."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageCms
from support.picture_files import encoded, png16, png_chunk, tiff

from livecl.errors import ImageError
from livecl.image.reading import as_image, over_background, premultiplied, read_image, save_image

RNG = np.random.default_rng(7)
LEVELS = RNG.integers(0, 256, (5, 7, 3), dtype=np.uint8)
DEEP = RNG.integers(0, 65536, (5, 7, 4), dtype=np.uint16)


def as_shares(pixels: NDArray[Any]) -> NDArray[np.float64]:
    return pixels / float(np.iinfo(pixels.dtype).max)


def check(data: bytes, wanted: NDArray[Any], tolerance: float = 1e-7) -> None:
    got = read_image(data)
    assert got.dtype == np.float32
    assert got.shape == wanted.shape
    assert got.flags.c_contiguous
    np.testing.assert_allclose(got, wanted, rtol=0, atol=tolerance)


def test_sources(tmp_path: Path) -> None:
    data = encoded(Image.fromarray(LEVELS))
    path = tmp_path / "picture.png"
    path.write_bytes(data)
    for source in (path, str(path), data, io.BytesIO(data)):
        np.testing.assert_array_equal(read_image(source), (LEVELS / np.float32(255)).astype(np.float32))
    with path.open("rb") as stream:
        assert read_image(stream).shape == (5, 7, 3)


@pytest.mark.parametrize("kind", ["PNG", "BMP", "TIFF", "PPM", "WEBP"])
def test_rgb(kind: str) -> None:
    options = {"lossless": True} if kind == "WEBP" else {}
    check(encoded(Image.fromarray(LEVELS), kind, **options), as_shares(LEVELS))


def test_alpha() -> None:
    rgba = np.dstack([LEVELS, LEVELS[..., 0]])
    check(encoded(Image.fromarray(rgba)), as_shares(rgba))
    rgba[..., 3] = 255
    check(encoded(Image.fromarray(rgba)), as_shares(LEVELS))


def test_palette() -> None:
    image = Image.fromarray(np.array([[0, 1, 2]], dtype=np.uint8))
    image.putpalette([255, 0, 0, 0, 51, 0, 0, 0, 102])
    assert image.mode == "P"
    rgb = np.array([[[1, 0, 0], [0, 0.2, 0], [0, 0, 0.4]]])
    check(encoded(image), rgb)
    check(encoded(image, transparency=1), np.dstack([rgb, [[1, 0, 1]]]))
    check(encoded(image, transparency=bytes([255, 51, 255])), np.dstack([rgb, [[1, 0.2, 1]]]))


def test_grey_and_one_bit() -> None:
    grey = LEVELS[..., 0]
    check(encoded(Image.fromarray(grey)), np.repeat(as_shares(grey)[..., None], 3, axis=2))
    with_alpha = Image.merge("LA", [Image.fromarray(grey), Image.fromarray(LEVELS[..., 1])])
    check(encoded(with_alpha), as_shares(LEVELS[..., [0, 0, 0, 1]]))
    bits = grey > 127
    check(encoded(Image.fromarray(bits)), np.repeat(bits[..., None], 3, axis=2))
    transparent = read_image(encoded(Image.fromarray(grey), transparency=int(grey[0, 0])))
    np.testing.assert_array_equal(transparent[..., 3], grey != grey[0, 0])


def test_cmyk() -> None:
    image = Image.new("CMYK", (3, 2), (0, 255, 255, 0))
    check(encoded(image, "TIFF"), np.broadcast_to([1.0, 0.0, 0.0], (2, 3, 3)))
    check(encoded(image, "JPEG", quality=100), np.broadcast_to([1.0, 0.0, 0.0], (2, 3, 3)), 0.02)


@pytest.mark.parametrize(
    ("channels", "shown"),
    [([0], [0, 0, 0]), ([0, 1], [0, 0, 0, 1]), ([0, 1, 2], [0, 1, 2]), ([0, 1, 2, 3], [0, 1, 2, 3])],
)
def test_sixteen_bit_png_keeps_its_precision(channels: list[int], shown: list[int]) -> None:
    check(png16(DEEP[..., channels]), as_shares(DEEP[..., channels])[..., shown])


def test_sixteen_bit_png_with_one_transparent_colour() -> None:
    rgb = DEEP[..., :3].copy()
    rgb[2, 3] = rgb[0, 0]
    rgb[1, 1] = rgb[0, 0] ^ 1  # differs in the low byte only
    clear = np.zeros((5, 7))
    clear[0, 0] = clear[2, 3] = 1
    marker = png_chunk(b"tRNS", struct.pack(">HHH", *rgb[0, 0].tolist()))
    check(png16(rgb, marker), np.dstack([as_shares(rgb), 1 - clear]))
    grey = rgb[..., :1]
    got = read_image(png16(grey, png_chunk(b"tRNS", struct.pack(">H", int(grey[0, 0, 0])))))
    np.testing.assert_array_equal(got[..., 3], grey[..., 0] != grey[0, 0, 0])


def test_deep_tiff() -> None:
    rgb, grey = DEEP[..., :3], DEEP[..., 0]
    check(tiff(rgb, photometric="rgb"), as_shares(rgb))
    check(tiff(rgb, photometric="rgb", compression="zlib", predictor=True), as_shares(rgb))
    planes = np.ascontiguousarray(np.moveaxis(rgb, -1, 0))
    check(tiff(planes, photometric="rgb", planarconfig="separate"), as_shares(rgb))
    check(tiff(DEEP, photometric="rgb", extrasamples=["unassalpha"]), as_shares(DEEP))
    check(tiff(grey, photometric="minisblack"), as_shares(grey)[..., None].repeat(3, axis=2))
    check(tiff(grey, photometric="miniswhite"), 1 - as_shares(grey)[..., None].repeat(3, axis=2))


def test_premultiplied_tiff_becomes_straight() -> None:
    straight = as_shares(DEEP)
    premultiplied = straight.copy()
    premultiplied[..., :3] *= straight[..., 3:]
    data = tiff(premultiplied.astype(np.float32), photometric="rgb", extrasamples=["assocalpha"])
    check(data, straight, 1e-5)


def test_float_tiff() -> None:
    shares = RNG.random((4, 6, 3)).astype(np.float32)
    check(tiff(shares, photometric="rgb"), shares)
    check(tiff(shares[..., 0], photometric="minisblack"), shares[..., :1].repeat(3, axis=2))
    ringing = shares.copy()
    ringing[0, 0] = (1.005, -0.005, 0.5)
    assert read_image(tiff(ringing, photometric="rgb"))[0, 0].tolist() == [1.0, 0.0, 0.5]


@pytest.mark.parametrize(("value", "words"), [(np.nan, "finite"), (np.inf, "finite"), (200.0, "range from")])
def test_float_tiff_with_other_numbers(value: float, words: str) -> None:
    pixels = np.full((3, 4, 3), 0.5, dtype=np.float32)
    pixels[1, 2, 0] = value
    with pytest.raises(ImageError, match=words):
        read_image(tiff(pixels, photometric="rgb"))


def test_tiff_of_signed_numbers_is_refused() -> None:
    with pytest.raises(ImageError, match="unsigned or float"):
        read_image(tiff(DEEP[..., 0].astype(np.int16), photometric="minisblack"))


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["PNG", "TIFF", "deep PNG", "deep TIFF"])
def test_orientation(kind: str, orientation: int) -> None:
    """EXIF's definition: which side of the shown picture row 0 and column 0 of the stored one are."""
    stored = DEEP[..., :3]
    upright = {
        1: stored,
        2: stored[:, ::-1],
        3: stored[::-1, ::-1],
        4: stored[::-1],
        5: stored.transpose(1, 0, 2),
        6: np.rot90(stored, -1),
        7: np.rot90(stored, 2).transpose(1, 0, 2),
        8: np.rot90(stored, 1),
    }[orientation]
    exif = Image.Exif()
    exif[0x0112] = orientation
    levels = (stored >> 8).astype(np.uint8)
    if kind == "deep PNG":
        data = png16(stored, png_chunk(b"eXIf", exif.tobytes().removeprefix(b"Exif\0\0")))
    elif kind == "deep TIFF":
        data = tiff(stored, photometric="rgb", extratags=[(274, 3, 1, orientation, True)])
    else:
        data = encoded(Image.fromarray(levels), kind, exif=exif)
    check(data, as_shares(upright if kind.startswith("deep") else (upright >> 8).astype(np.uint8)))


def swapped_profile() -> bytes:
    """Return an RGB profile in which red and blue have changed places."""
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    profile = profile.replace("sRGB".encode("utf-16-be"), "Swap".encode("utf-16-be"))
    return profile.replace(b"rXYZ", b"tXYZ").replace(b"bXYZ", b"rXYZ").replace(b"tXYZ", b"bXYZ")


def test_colour_profile() -> None:
    image = Image.fromarray(LEVELS)
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    check(encoded(image, icc_profile=srgb), as_shares(LEVELS))
    check(encoded(image, icc_profile=swapped_profile()), as_shares(LEVELS[..., ::-1]), 2 / 255)
    rgba = np.dstack([LEVELS, LEVELS[..., 1]])
    got = read_image(encoded(Image.fromarray(rgba), icc_profile=swapped_profile()))
    np.testing.assert_allclose(got, as_shares(rgba[..., [2, 1, 0, 3]]), rtol=0, atol=2 / 255)
    chunk = png_chunk(b"iCCP", b"Swap\0\0" + zlib.compress(swapped_profile()))
    check(png16(DEEP[..., :3], chunk), as_shares(DEEP[..., [2, 1, 0]]), 2.5 / 255)


def test_unusable_colour_profile_is_named() -> None:
    data = encoded(Image.fromarray(LEVELS), icc_profile=b"no profile at all")
    with pytest.warns(UserWarning, match="picture data: its colour profile"):
        got = read_image(data)
    np.testing.assert_allclose(got, as_shares(LEVELS), atol=1e-7)


def one_line(path: Path, *words: str) -> None:
    with pytest.raises(ImageError) as caught:
        read_image(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    for word in words:
        assert word in message


def test_errors_name_the_file(tmp_path: Path) -> None:
    one_line(tmp_path / "missing.png", "no such file")
    one_line(tmp_path, "directory")
    (tmp_path / "text.png").write_text("hello there")
    one_line(tmp_path / "text.png", "not a picture", "PNG")
    (tmp_path / "empty.png").touch()
    one_line(tmp_path / "empty.png", "empty")


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF", "BMP", "deep PNG", "deep TIFF"])
def test_truncated_picture(tmp_path: Path, kind: str) -> None:
    noise = RNG.integers(0, 65536, (40, 50, 3), dtype=np.uint16)
    if kind == "deep PNG":
        data = png16(noise)
    elif kind == "deep TIFF":
        data = tiff(noise, photometric="rgb")
    else:
        data = encoded(Image.fromarray((noise >> 8).astype(np.uint8)), kind)
    path = tmp_path / "cut"
    path.write_bytes(data[: len(data) // 2])
    one_line(path, "damaged or cut off")


@pytest.mark.parametrize("side", [9_500, 40_000])
def test_decompression_bomb_is_refused_unread(tmp_path: Path, side: int) -> None:
    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    path = tmp_path / "bomb.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + png_chunk(b"IDAT", zlib.compress(b"")))
    one_line(path, "million pixels", "scale it down")


def test_wrong_sources() -> None:
    with pytest.raises(TypeError, match="source"):
        read_image(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="binary"):
        read_image(io.StringIO("x"))  # type: ignore[arg-type]


def test_over_background() -> None:
    pixels = np.array([[[1.0, 0.5, 0.0, 0.25], [0.2, 0.2, 0.2, 1.0], [0.9, 0.9, 0.9, 0.0]]], dtype=np.float32)
    got = over_background(pixels, (0.0, 1.0, 0.4))
    assert got.dtype == np.float32
    np.testing.assert_allclose(got, [[[0.25, 0.875, 0.3], [0.2, 0.2, 0.2], [0.0, 1.0, 0.4]]], atol=1e-6)
    opaque = pixels[..., :3]
    copy = over_background(opaque, (0, 0, 0))
    np.testing.assert_array_equal(copy, opaque)
    assert not np.shares_memory(copy, opaque)
    with pytest.raises(ValueError, match="background"):
        over_background(pixels, (0, 0))
    with pytest.raises(ValueError, match="image"):
        over_background(pixels[0], (0, 0, 0))


@pytest.mark.parametrize("num_channels", [3, 4])
def test_save_image(tmp_path: Path, num_channels: int) -> None:
    levels = RNG.integers(0, 256, (4, 3, num_channels))
    path = tmp_path / "out.png"
    save_image(path, levels / 255 + RNG.uniform(-0.4, 0.4, levels.shape) / 255)
    np.testing.assert_allclose(read_image(path), levels / 255, atol=1e-6)
    assert list(tmp_path.iterdir()) == [path]


def test_save_image_refuses(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="finite"):
        save_image(tmp_path / "a.png", np.full((2, 2, 3), np.nan))
    with pytest.raises(ValueError, match="shape"):
        save_image(tmp_path / "a.png", np.zeros((2, 2)))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("dtype", "largest"), [(np.uint8, 255), (np.uint16, 65535), (np.bool_, 1)])
def test_integers_are_shares_of_their_largest(dtype: type, largest: int) -> None:
    levels = np.linspace(0, largest, 24).reshape(2, 4, 3).astype(dtype)
    np.testing.assert_allclose(as_image(levels), levels / largest, atol=1e-7)
    assert as_image(levels).dtype == np.float32


def test_pictures_of_every_kind_are_alike(tmp_path: Path) -> None:
    levels = LEVELS
    save_image(tmp_path / "in.png", levels / 255)
    expected = levels / np.float32(255)
    data = (tmp_path / "in.png").read_bytes()
    with Image.open(tmp_path / "in.png") as opened:
        sources = [tmp_path / "in.png", str(tmp_path / "in.png"), data, io.BytesIO(data), opened, levels, expected]
        for source in sources:
            np.testing.assert_allclose(as_image(source), expected, atol=1e-7)


def test_pillow_s_pictures() -> None:
    rgba = Image.fromarray(np.array([[[255, 0, 0, 51]]], np.uint8))
    np.testing.assert_allclose(as_image(rgba), [[[1, 0, 0, 0.2]]], atol=1e-7)
    np.testing.assert_allclose(as_image(rgba.convert("L")), np.full((1, 1, 3), 76 / 255), atol=1e-7)
    assert as_image(Image.new("CMYK", (3, 2))).shape == (2, 3, 3)
    deep = Image.fromarray(np.array([[0, 32768, 65535]], np.uint16))
    np.testing.assert_allclose(as_image(deep)[0, :, 1], [0, 32768 / 65535, 1], atol=1e-6)


def test_premultiplied() -> None:
    np.testing.assert_allclose(premultiplied([[[1, 0.5, 0, 0.5]]]), [[[0.5, 0.25, 0, 0.5]]])
    np.testing.assert_allclose(premultiplied([[[1, 0.5, 0]]]), [[[1, 0.5, 0, 1]]])
