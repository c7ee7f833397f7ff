# SPDX-License-Identifier: Apache-2.0
"""`read_image` on kinds of files and on colours: turns, frames, profiles, gamma, CMYK, Lab, depths, extreme sizes."""

from __future__ import annotations

import io
import struct
import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageCms
from support.picture_files import encoded, png, png16, png_chunk, tiff

from livecl.errors import ImageError
from livecl.image.reading import as_image, read_image

RNG = np.random.default_rng(11)
#: Areas of one colour, of 8 px: what lossy kinds keep.
AREAS = np.kron(RNG.integers(0, 256, (3, 4, 4)), np.ones((8, 8, 1))).astype(np.uint8)
AREAS[..., 3] |= 1  # nothing is all transparent, as colours there need not be kept
DEEP = RNG.integers(0, 65536, (5, 7, 4), dtype=np.uint16)


def shares(pixels: NDArray[Any]) -> NDArray[np.float64]:
    """Return whole numbers as shares of their type's largest."""
    return pixels / float(np.iinfo(pixels.dtype).max)


def read_quietly(data: bytes) -> NDArray[np.float32]:
    """Read a picture that nothing is said of."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return read_image(data)


@pytest.mark.parametrize(
    ("kind", "mode", "options"),
    [
        *[(kind, "RGB", {}) for kind in ("PNG", "BMP", "PPM", "TIFF", "TGA", "SGI", "PCX", "QOI", "DDS", "DIB")],
        *[(kind, "RGBA", {}) for kind in ("PNG", "TIFF", "TGA", "SGI", "QOI", "DDS")],
        *[("TIFF", "RGB", {"compression": name}) for name in ("tiff_lzw", "tiff_adobe_deflate", "packbits", "zstd")],
        *[("WEBP", mode, {"lossless": True, "exact": True}) for mode in ("RGB", "RGBA")],
        *[("JPEG2000", mode, {}) for mode in ("RGB", "RGBA")],
        ("GIF", "P", {}),
        ("PNG", "P", {}),
        ("TIFF", "P", {}),
    ],
)
def test_lossless_kinds(kind: str, mode: str, options: dict[str, Any]) -> None:
    image = Image.fromarray(AREAS if mode == "RGBA" else AREAS[..., :3])
    if mode == "P":
        image = image.quantize(16)
    wanted = shares(np.asarray(image.convert("RGB" if mode == "P" else mode)))
    np.testing.assert_allclose(read_quietly(encoded(image, kind, **options)), wanted, rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("JPEG", {"quality": 95}),
        ("JPEG", {"quality": 95, "progressive": True}),
        ("JPEG", {"quality": 95, "subsampling": 2}),
        ("WEBP", {"quality": 95}),
        ("AVIF", {"quality": 95}),
        ("MPO", {"quality": 95}),
        ("TIFF", {"compression": "jpeg", "quality": 95}),
    ],
)
def test_lossy_kinds(kind: str, options: dict[str, Any]) -> None:
    """Right to a few levels inside the areas, where neither blocks nor half the colours' resolution matter much."""
    got = read_quietly(encoded(Image.fromarray(AREAS[..., :3]), kind, **options))
    assert got.shape == (*AREAS.shape[:2], 3)
    inside = np.s_[3::8, 3::8]
    np.testing.assert_allclose(got[inside], shares(AREAS[..., :3])[inside], rtol=0, atol=12 / 255)


@pytest.mark.parametrize("kind", ["ICO", "ICNS"])
def test_icons_give_their_largest_picture(kind: str) -> None:
    large, small = Image.new("RGBA", (64, 64), "red"), Image.new("RGBA", (32, 32), "lime")
    got = read_quietly(encoded(large, kind, sizes=[(64, 64), (32, 32)], append_images=[small]))
    assert got.shape[0] >= 64
    np.testing.assert_array_equal(got, np.broadcast_to(np.float32((1, 0, 0)), got.shape))


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["JPEG", "WEBP", "AVIF"])
def test_turns_of_lossy_kinds(kind: str, orientation: int) -> None:
    """A picture of which each corner differs: where the light and the red one come to lie tells all eight turns."""
    stored = np.zeros((32, 48, 3), np.uint8)
    stored[:16, :24], stored[16:, 24:] = 255, (255, 0, 0)
    stored[:16, 24:] = (0, 0, 255)
    exif = Image.Exif()
    exif[0x0112] = orientation
    # EXIF's own words for where row 0 and column 0 of the stored picture are in the one shown.
    row, column = {
        1: ("top", "left"),
        2: ("top", "right"),
        3: ("bottom", "right"),
        4: ("bottom", "left"),
        5: ("left", "top"),
        6: ("right", "top"),
        7: ("right", "bottom"),
        8: ("left", "bottom"),
    }[orientation]
    got = read_quietly(encoded(Image.fromarray(stored), kind, quality=95, exif=exif))
    assert got.shape == ((48, 32, 3) if orientation > 4 else (32, 48, 3))

    def corner(*sides: str) -> NDArray[np.float32]:
        return got[4 if "top" in sides else -5, 4 if "left" in sides else -5]

    opposite = {"top": "bottom", "bottom": "top", "left": "right", "right": "left"}
    np.testing.assert_allclose(corner(row, column), (1, 1, 1), atol=0.1)
    np.testing.assert_allclose(corner(row, opposite[column]), (0, 0, 1), atol=0.1)
    np.testing.assert_allclose(corner(opposite[row], opposite[column]), (1, 0, 0), atol=0.1)


def test_exif_data_that_cannot_be_read() -> None:
    image = Image.fromarray(AREAS[..., :3])
    with pytest.warns(UserWarning, match="picture data: its EXIF data cannot be read"):
        got = read_image(encoded(image, exif=b"Exif\0\0no TIFF at all"))
    np.testing.assert_allclose(got, shares(AREAS[..., :3]), atol=1e-7)


@pytest.mark.parametrize("kind", ["GIF", "PNG", "WEBP", "TIFF", "AVIF"])
def test_of_several_pictures_the_first_is_taken_and_that_is_said(kind: str) -> None:
    frames = [Image.new("RGB", (16, 16), color) for color in ("red", "lime", "blue")]
    data = encoded(
        frames[0], kind, save_all=True, append_images=frames[1:], **({"lossless": True} if kind == "WEBP" else {})
    )
    with pytest.warns(UserWarning, match="picture data: holds several pictures; the first is taken"):
        got = read_image(data)
    np.testing.assert_allclose(got, np.broadcast_to((1, 0, 0), (16, 16, 3)), atol=0.02 if kind == "AVIF" else 1e-7)


def test_previews_beside_a_picture_are_no_frames() -> None:
    frames = [Image.new("RGB", (16, 16), color) for color in ("red", "lime")]
    data = encoded(frames[0], "MPO", save_all=True, append_images=frames[1:])
    np.testing.assert_allclose(read_quietly(data), np.broadcast_to((1, 0, 0), (16, 16, 3)), atol=0.02)


def test_pages_of_deep_tiff() -> None:
    pages = np.stack([DEEP[..., :3], DEEP[..., 1:]])
    with pytest.warns(UserWarning, match="several pictures"):
        np.testing.assert_allclose(read_image(tiff(pages, photometric="rgb")), shares(pages[0]), atol=1e-7)


def linear_profile() -> bytes:
    """Return an RGB profile of sRGB's primaries, whose numbers are light itself."""
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    profile = profile.replace("sRGB".encode("utf-16-be"), "line".encode("utf-16-be"))
    (count,) = struct.unpack_from(">I", profile, 128)
    for i in range(count):
        name, offset, length = struct.unpack_from(">4sII", profile, 132 + 12 * i)
        if name in (b"rTRC", b"gTRC", b"bTRC"):
            curve = b"curv" + bytes(8)  # no points: the curve y = x
            profile = profile[:offset] + curve + bytes(length - len(curve)) + profile[offset + length :]
    return profile


@pytest.mark.parametrize(("kind", "options"), [("PNG", {}), ("TIFF", {}), ("JPEG", {}), ("WEBP", {"lossless": True})])
def test_a_profile_of_linear_light(kind: str, options: dict[str, Any]) -> None:
    """The number .2140 of light is .5 in sRGB, by its definition."""
    level = round(255 * ((0.5 + 0.055) / 1.055) ** 2.4)
    grey = Image.new("RGB", (3, 2), (level, level, level))
    for kind in ("PNG", "TIFF", "JPEG", "WEBP"):
        got = read_quietly(
            encoded(grey, kind, icc_profile=linear_profile(), **({"lossless": True} if kind == "WEBP" else {}))
        )
        # 2 levels beside half a level of rounding before: sRGB is 1.7 times as steep there.
        np.testing.assert_allclose(got, np.full((2, 3, 3), 0.5), atol=3 / 255)


@pytest.mark.parametrize("profile", [b"x", b"no profile at all" * 20, linear_profile()[:200], linear_profile()[:-300]])
def test_broken_profiles_are_named_and_ignored(profile: bytes) -> None:
    with pytest.warns(UserWarning, match="picture data: its colour profile cannot be applied"):
        got = read_image(encoded(Image.fromarray(AREAS[..., :3]), icc_profile=profile))
    np.testing.assert_allclose(got, shares(AREAS[..., :3]), atol=1e-7)


def test_a_profile_of_another_number_of_channels_is_ignored() -> None:
    with pytest.warns(UserWarning, match="colour profile cannot be applied"):
        read_image(encoded(Image.new("CMYK", (3, 2), (0, 255, 255, 0)), "TIFF", icc_profile=linear_profile()))


@pytest.mark.parametrize(
    ("gamma", "chunks", "wanted"),
    [
        (45455, [], 0.25),  # what writers of sRGB state
        (100000, [], 0.25 ** (1 / 2.2)),  # numbers that are light itself
        (50000, [], 0.25 ** (1 / 1.1)),
        (100000, [png_chunk(b"sRGB", b"\0")], 0.25),  # comes first
        (0, [], 0.25),
        (4_000_000_000, [], 0.25),
    ],
)
def test_gamma_of_png(gamma: int, chunks: list[bytes], wanted: float) -> None:
    level = round(0.25 * 65535)
    chunk = png_chunk(b"gAMA", struct.pack(">I", gamma))
    deep = png16(np.full((2, 3, 3), level, np.uint16), chunk, *chunks)
    np.testing.assert_allclose(read_quietly(deep), np.full((2, 3, 3), wanted), atol=1e-5)
    eight = png(3, 1, 8, 2, b"\0" + bytes([64] * 9), chunk, *chunks)
    exponent = np.log(wanted) / np.log(0.25)
    np.testing.assert_allclose(read_quietly(eight), np.full((1, 3, 3), (64 / 255) ** exponent), atol=1e-6)


def test_lab() -> None:
    """L*a*b* under D50, by the definition: white is (100, 0, 0), sRGB's red (54.3, 80.8, 69.9).

    The file has whole a* and b*, half of one of which is worth some levels.
    """
    pixels = np.array([[[255, 0, 0], [138, 81, 70], [0, 0, 0]]], np.uint8)
    image = Image.frombytes("LAB", (3, 1), pixels.tobytes())
    got = read_quietly(encoded(image, "TIFF"))
    np.testing.assert_allclose(got, [[(1, 1, 1), (1, 0, 0), (0, 0, 0)]], atol=6 / 255)


@pytest.mark.parametrize(
    ("kind", "options"), [("JPEG", {"quality": 100}), ("TIFF", {}), ("TIFF", {"compression": "tiff_lzw"})]
)
def test_cmyk_of_many_inks(kind: str, options: dict[str, Any]) -> None:
    """(1 - ink) (1 - black), which is what Pillow makes of inks without a profile."""
    inks = np.kron(np.array([[(0, 0, 0, 0), (255, 0, 0, 0), (0, 128, 255, 0), (0, 0, 0, 255)]]), np.ones((8, 8, 1)))
    image = Image.frombytes("CMYK", (32, 8), inks.astype(np.uint8).tobytes())
    got = read_quietly(encoded(image, kind, **options))
    wanted = (1 - inks[..., :3] / 255) * (1 - inks[..., 3:] / 255)
    np.testing.assert_allclose(got, wanted, atol=3 / 255)


def test_cmyk_jpeg_as_adobe_writes_it() -> None:
    """Adobe's programs store inks inverted and say so in a marker; so does Pillow, whose file has that very marker."""
    data = encoded(Image.new("CMYK", (8, 8), (0, 255, 255, 0)), "JPEG", quality=100)
    assert b"\xff\xee\x00\x0eAdobe" in data
    np.testing.assert_allclose(read_quietly(data), np.broadcast_to((1, 0, 0), (8, 8, 3)), atol=3 / 255)


def test_sixteen_bits_of_netpbm() -> None:
    """Grey keeps its 16 bits; of colours Pillow keeps 8."""
    grey = b"P5 7 5 65535\n" + DEEP[..., 0].astype(">u2").tobytes()
    np.testing.assert_allclose(read_quietly(grey), shares(DEEP[..., [0, 0, 0]]), atol=1e-6)
    color = b"P6 7 5 65535\n" + DEEP[..., :3].astype(">u2").tobytes()
    np.testing.assert_allclose(read_quietly(color), shares(DEEP[..., :3]), atol=1 / 255)
    real = b"Pf 7 5 -1.0\n" + shares(DEEP[::-1, :, 0]).astype("<f4").tobytes()  # its rows go upwards
    np.testing.assert_allclose(read_quietly(real), shares(DEEP[..., [0, 0, 0]]), atol=1e-6)


@pytest.mark.parametrize(
    "mode", ["1", "L", "LA", "La", "P", "PA", "RGB", "RGBA", "RGBa", "RGBX", "CMYK", "YCbCr", "HSV", "LAB"]
)
def test_modes_of_pillow_s_pictures(mode: str) -> None:
    """White, in each of Pillow's modes of 8 bits, is white."""
    white = {"CMYK": (0, 0, 0, 0), "YCbCr": (255, 128, 128), "HSV": (0, 0, 255), "LAB": (255, 128, 128)}
    source = Image.new("RGB", (3, 2), "white")
    if mode in ("La", "PA", "RGBa"):
        image = source.convert({"La": "LA", "PA": "P", "RGBa": "RGBA"}[mode]).convert(mode)
    else:
        image = Image.new(mode, (3, 2), white[mode]) if mode in white else source.convert(mode)
    assert image.mode == mode
    np.testing.assert_allclose(as_image(image), np.ones((2, 3, 3)), atol=2 / 255)


def test_modes_of_more_bits() -> None:
    np.testing.assert_allclose(as_image(Image.new("I", (2, 1), 65535)), np.ones((1, 2, 3)))
    np.testing.assert_allclose(as_image(Image.new("I;16", (2, 1), 65535)), np.ones((1, 2, 3)))
    np.testing.assert_allclose(as_image(Image.new("F", (2, 1), 0.25)), np.full((1, 2, 3), 0.25))
    with pytest.raises(ImageError, match="picture: pixels range from 0 to 2; scale them"):
        as_image(Image.fromarray(np.array([[0.0, 2.0]], np.float32)))


@pytest.mark.parametrize("size", [(1, 1), (1, 20_000), (20_000, 1)])
@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
def test_extreme_sizes(kind: str, size: tuple[int, int]) -> None:
    levels = RNG.integers(0, 256, (*size, 3), dtype=np.uint8)
    np.testing.assert_allclose(read_quietly(encoded(Image.fromarray(levels), kind)), shares(levels), atol=1e-7)


@pytest.mark.full
def test_eight_thousand_squared(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Read whole, worked on at 512 px, which is said, and drawn in its own coordinates."""
    from livecl import read_svg
    from livecl.cli import command as cli

    stream = io.BytesIO()
    pixels = np.zeros((8000, 8000, 3), np.uint8)
    pixels[2000:6000, 2000:6000] = (255, 128, 0)
    Image.fromarray(pixels).save(stream, "PNG")
    assert read_quietly(stream.getvalue()).shape == (8000, 8000, 3)
    (tmp_path / "large.png").write_bytes(stream.getvalue())
    arguments = ["--paths", "1", "--iterations", "5", "--revisions", "0"]
    assert cli.main([str(tmp_path / "large.png"), "-o", str(tmp_path / "out.svg"), *arguments]) == 0
    assert "8000x8000 px, reduced to 512x512 px" in capsys.readouterr().err
    assert read_svg(tmp_path / "out.svg").size == (8000, 8000)
