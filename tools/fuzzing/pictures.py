# SPDX-License-Identifier: Apache-2.0
"""Picture files of every supported kind, changed bytewise: each is read as an array, or refused in one line."""

from __future__ import annotations

import functools
import io
import random

import numpy as np
from PIL import Image, ImageCms
from support.picture_files import encoded, png16, png_chunk, tiff

from fuzzing.kind import CHOSEN, EVEN, Kind, one_line
from fuzzing.mutation import mutated
from livecl.errors import ImageError
from livecl.image.reading import read_image

#: Height and width of the pictures before they are changed.
SIZE = (9, 12)


@functools.cache
def seeds() -> dict[str, bytes]:
    """Return intact files by kind."""
    rng = np.random.default_rng(0)
    deep = rng.integers(0, 65536, (*SIZE, 4), dtype=np.uint16)
    levels = (deep >> 8).astype(np.uint8)
    rgb, rgba, grey = Image.fromarray(levels[..., :3]), Image.fromarray(levels), Image.fromarray(levels[..., 0])
    palette, bits, cmyk = rgb.quantize(16), grey.convert("1"), rgb.convert("CMYK")
    more = [rgb.rotate(180), rgb.convert("L").convert("RGB")]
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("XYZ")).tobytes()
    exif = Image.Exif()
    exif[0x0112] = 6
    gamma = png_chunk(b"gAMA", (100_000).to_bytes(4, "big"))
    return {
        "png": encoded(rgb, exif=exif, icc_profile=profile),
        "png alpha": encoded(rgba),
        "png grey": encoded(grey, transparency=7),
        "png grey and alpha": encoded(rgba.convert("LA")),
        "png palette": encoded(palette, transparency=bytes(range(16))),
        "png bits": encoded(bits),
        "png 16": png16(deep[..., :3], gamma),
        "png 16 alpha": png16(deep),
        "png 16 grey": png16(deep[..., :1], png_chunk(b"tRNS", b"\1\2")),
        "png 16 grey and alpha": png16(deep[..., :2]),
        "png animated": encoded(rgb, save_all=True, append_images=more),
        "jpeg": encoded(rgb, "JPEG", exif=exif, icc_profile=profile),
        "jpeg progressive": encoded(rgb, "JPEG", progressive=True, subsampling=2),
        "jpeg grey": encoded(grey, "JPEG"),
        "jpeg cmyk": encoded(cmyk, "JPEG"),
        "gif": encoded(palette, "GIF", transparency=3),
        "gif animated": encoded(rgb, "GIF", save_all=True, append_images=more, duration=50),
        "webp": encoded(rgba, "WEBP", exif=exif),
        "webp lossless": encoded(rgb, "WEBP", lossless=True),
        "webp animated": encoded(rgb, "WEBP", save_all=True, append_images=more),
        "tiff": encoded(rgb, "TIFF", exif=exif),
        "tiff lzw": encoded(rgba, "TIFF", compression="tiff_lzw"),
        "tiff jpeg": encoded(rgb, "TIFF", compression="jpeg"),
        "tiff fax": encoded(bits, "TIFF", compression="group4"),
        "tiff cmyk": encoded(cmyk, "TIFF"),
        "tiff palette": encoded(palette, "TIFF", compression="packbits"),
        "tiff lab": encoded(rgb.convert("YCbCr"), "TIFF"),
        "tiff pages": encoded(rgb, "TIFF", save_all=True, append_images=more),
        "tiff 16": tiff(deep[..., :3], photometric="rgb", compression="zlib", predictor=True),
        "tiff 16 alpha": tiff(deep, photometric="rgb", extrasamples=["assocalpha"]),
        "tiff 16 grey": tiff(deep[..., 0], photometric="miniswhite"),
        "tiff float": tiff(levels[..., :3] / np.float32(255), photometric="rgb", planarconfig="contig"),
        "tiff planes": tiff(np.moveaxis(deep[..., :3], -1, 0).copy(), photometric="rgb", planarconfig="separate"),
        "bmp": encoded(rgb, "BMP"),
        "ico": encoded(rgba.resize((16, 16)), "ICO"),
        "ppm": encoded(rgb, "PPM"),
        "ppm 16": b"P6 12 9 65535\n" + deep[..., :3].astype(">u2").tobytes(),
        "pgm 16": b"P5 12 9 65535\n" + deep[..., 0].astype(">u2").tobytes(),
        "pbm text": b"P1\n12 9\n" + b"10 " * 108,
        "pfm": b"Pf\n12 9\n-1.0\n" + (levels[..., 0] / np.float32(255)).tobytes(),
        "tga": encoded(rgba, "TGA", compression="tga_rle"),
        "pcx": encoded(palette, "PCX"),
        "sgi": encoded(rgb, "SGI"),
        "dds": encoded(rgba, "DDS"),
        "jpeg 2000": encoded(rgb, "JPEG2000"),
        "icns": encoded(rgba.resize((16, 16)), "ICNS"),
        "qoi": encoded(rgba, "QOI"),
        "avif": encoded(rgb, "AVIF"),
        "xbm": encoded(bits, "XBM"),
        "msp": encoded(bits, "MSP"),
        "mpo": encoded(rgb, "MPO", save_all=True, append_images=more),
    }


def make(rng: random.Random) -> bytes:
    """Return a file that was changed; one in a hundred is whole."""
    files = list(seeds().values())
    data = rng.choice(files)
    return data if rng.random() < 0.01 else mutated(rng, data, files)


def check(data: bytes) -> str:
    """Read it: an array as promised, or an error of one line."""
    try:
        image = read_image(io.BytesIO(data))
    except ImageError as error:
        one_line(error)
        return "refused"
    assert image.dtype == np.float32 and image.ndim == 3 and image.shape[2] in (3, 4), (image.dtype, image.shape)
    assert image.size and image.flags.c_contiguous
    assert np.isfinite(image).all() and image.min() >= 0 and image.max() <= 1, (image.min(), image.max())
    return "read"


KIND = Kind(cases=CHOSEN.map(make), others=EVEN.map(make), check=check, suffix=".picture", seconds=60.0, megabytes=4000)
