#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compare drawings of transparent pictures, laid over three backgrounds, with the same pictures vectorized on white.

Without files, pictures with soft alpha are drawn. Errors are those of resvg's picture of the SVG; `on white` is that of
the picture composited on white and vectorized as any opaque one, `opaque` the same with opaque paths only.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
import resvg_py
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter

import livecl
from livecl.image.reading import over_background, read_image
from livecl.layering.metrics import mse

SIDE, CHECK = 240, 8
WHITE, BLACK = np.ones(3), np.zeros(3)

FloatArray = NDArray[np.floating]


def main(argv: Sequence[str] | None = None) -> int:
    """Print a row for each picture and number of paths."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="*", type=Path, metavar="PICTURE", help="files with alpha")
    parser.add_argument("--paths", type=int, nargs="+", default=[8, 16], metavar="N", help="paths (default: 8 16)")
    arguments = parser.parse_args(argv)
    print("| picture | paths | over white | black | checkerboard | on white | opaque |")
    print("|---" + "|--:" * 6 + "|")
    files = ((file.stem, read_image(file)) for file in arguments.pictures)
    for name, picture in files if arguments.pictures else drawn():
        flat, checks = over_background(picture, WHITE), checkerboard(picture.shape[:2])
        for paths in arguments.paths:
            shown = resvg_picture(livecl.vectorize(picture, paths))
            errors = [mse(over(shown, ground), over(picture, ground)) for ground in (WHITE, BLACK, checks)]
            for opacity in ("snap", "opaque"):
                shown = resvg_picture(livecl.vectorize(flat, paths, options=livecl.Options(opacity=opacity)))
                errors.append(mse(over(shown, WHITE), flat))
            print(f"| {name} | {paths} | " + " | ".join(f"{error:.2g}" for error in errors) + " |", flush=True)
    return 0


def resvg_picture(result: livecl.Result) -> FloatArray:
    """Return resvg's picture of a result's SVG: (H, W, 4), straight."""
    with Image.open(io.BytesIO(bytes(resvg_py.svg_to_bytes(svg_string=result.svg)))) as image:
        return np.asarray(image.convert("RGBA"), dtype=np.float64) / 255


def over(picture: FloatArray, ground: FloatArray) -> FloatArray:
    """Return a straight picture over a colour, (3,), or an opaque picture, (H, W, 3)."""
    rgb, alpha = picture[..., :3].astype(np.float64), picture[..., 3:].astype(np.float64)
    return alpha * rgb + (1 - alpha) * ground


def checkerboard(size: tuple[int, ...]) -> FloatArray:
    """Return two greys in squares: (H, W, 3)."""
    odd = (np.indices(size) // CHECK).sum(axis=0) % 2
    return np.where(odd, 0.8, 0.4)[..., None] * WHITE


def drawn() -> Iterator[tuple[str, FloatArray]]:
    """Yield names and pictures with soft alpha, straight RGBA of 8 bits."""
    square, moon = box(45, 40, 195, 165), disc(120, 120, 52)
    yield (
        "edges",
        stack((blurred(disc(90, 100, 60), 1.5), "#d9331f", 1.0), (blurred(disc(150, 150, 55), 2), "#1a59cc", 0.6)),
    )
    yield (
        "blurred",
        stack((blurred(disc(95, 100, 60), 10), "#d93326", 1.0), (blurred(disc(150, 150, 45), 6), "#1a59cc", 0.8)),
    )
    shadow = blurred(np.roll(square, (24, 12), axis=(0, 1)), 14)
    yield "shadow", stack((shadow, "#000000", 0.6), (square, "#f2b326", 1.0), (disc(120, 102, 36), "#bf2633", 1.0))
    letter = np.maximum.reduce([box(60, 40, 90, 200), box(60, 40, 190, 70), box(60, 105, 165, 135)])
    yield "letter", stack((blurred(letter, 5), "#1a7359", 1.0))
    yield (
        "glow",
        stack((blurred(moon, 22), "#ffd94d", 0.9), (moon, "#fff2bf", 1.0), (disc(138, 105, 14), "#e69933", 1.0)),
    )


def stack(*layers: tuple[FloatArray, str, float]) -> FloatArray:
    """Return layers of coverage, colour and opacity, bottom first: (SIDE, SIDE, 4), straight."""
    image = np.zeros((SIDE, SIDE, 4))
    for coverage, color, opacity in layers:
        paint = np.array([*bytes.fromhex(color[1:]), 255]) / 255
        image += (opacity * coverage)[..., None] * (paint - image)
    image[..., :3] /= np.maximum(image[..., 3:], 1e-6)
    return (np.rint(255 * np.clip(image, 0, 1)) / 255).astype(np.float32)


def disc(x: float, y: float, radius: float) -> FloatArray:
    """Return the coverage of a disc, its edge a pixel wide."""
    rows, columns = np.indices((SIDE, SIDE)) + 0.5
    return np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0, 1)


def box(x_0: int, y_0: int, x_1: int, y_1: int) -> FloatArray:
    """Return the coverage of a rectangle."""
    coverage = np.zeros((SIDE, SIDE))
    coverage[y_0:y_1, x_0:x_1] = 1
    return coverage


def blurred(coverage: FloatArray, sigma: float) -> FloatArray:
    """Return a coverage blurred by a Gaussian."""
    return np.asarray(gaussian_filter(coverage, sigma))


if __name__ == "__main__":
    sys.exit(main())
