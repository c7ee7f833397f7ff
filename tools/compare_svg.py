#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compare how SVG files are read with how resvg shows them.

Each file is read, rendered, and compared with resvg's picture of the file itself, in premultiplied RGBA. Renderers
differ where outlines cross pixels, so the squared difference is given per pixel of outline (`edge`), and the largest
difference (`flat`, in levels of 255) where no outline is within a pixel. Files worst first, those read without a
warning before the others; then how many differ.
"""

import argparse
import dataclasses
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import livecl
from livecl.drawing.drawing import Drawing
from livecl.errors import SvgError
from livecl.geometry import bezier
from livecl.rendering.rasterizer import render

#: Squared difference at a pixel that an outline crosses, for a step from 0 to 1. resvg and skia sample coverage on a
#: grid of 4 x 4 a pixel, so an edge lies up to an eighth of a pixel from its place; where edges lie anywhere, the mean
#: square is a third of that.
EDGE = 0.125**2
#: Largest difference elsewhere, levels of 255: both round a colour, and resvg each blending.
FLAT = 2.5
#: Largest side compared, px.
MAX_SIDE = 2048

FloatArray = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Comparison:
    """A file: what was read, what was not, and the difference from resvg's picture."""

    path: Path
    layers: int = 0
    warning: str = ""
    mse: float = 0.0
    edge: float = 0.0
    flat: float = 0.0

    @property
    def differs(self) -> bool:
        """Whether the pictures differ by more than antialiasing and rounding."""
        return self.edge > EDGE or self.flat > FLAT


def outline_pixels(drawing: Drawing) -> NDArray[np.bool_]:
    """Return the pixels that outlines pass through, sampled at steps of at most a quarter of a pixel: (H, W)."""
    height, width = drawing.size
    mask = np.zeros((height, width), dtype=bool)
    for cubic in drawing.cubics:
        length = np.abs(np.diff(cubic, axis=0)).sum()
        x, y = bezier.evaluate(cubic, np.linspace(0, 1, 2 + int(min(4 * length, 1e5)))).T
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        mask[y[inside].astype(int), x[inside].astype(int)] = True
    return mask


def shown_by_resvg(text: str) -> FloatArray:
    """Return resvg's picture of an SVG in premultiplied RGBA: (H, W, 4)."""
    import resvg_py

    return premultiplied(livecl.read_image(bytes(resvg_py.svg_to_bytes(svg_string=text, dpi=96))))


def premultiplied(image: NDArray[Any]) -> FloatArray:
    """Return RGB or straight RGBA as premultiplied RGBA."""
    image = np.asarray(image, dtype=np.float64)
    alpha = image[..., 3:] if image.shape[2] == 4 else np.ones_like(image[..., :1])
    return np.concatenate([image[..., :3] * alpha, alpha], axis=2)


def rendered(drawing: Drawing) -> FloatArray:
    """Return our picture of a drawing in premultiplied RGBA: (H, W, 4)."""
    image = np.asarray(render(drawing), dtype=np.float64)
    return image if image.shape[2] == 4 else premultiplied(image)


def differences(drawing: Drawing, picture: FloatArray) -> tuple[float, float, float]:
    """Return the mean squared difference, that per pixel of outline, and the largest away from outlines in levels.

    A canvas of a fractional size is rounded up here and rounded there: what both show is compared.
    """
    height, width = np.minimum(drawing.size, picture.shape[:2])
    if np.abs(np.subtract(drawing.size, picture.shape[:2])).max() > 1:
        raise ValueError(f"sizes {drawing.size} and {picture.shape[:2]}")
    image, picture = rendered(drawing)[:height, :width], picture[:height, :width]
    squares = np.square(image - picture).mean(axis=2)
    crossed = outline_pixels(drawing)[:height, :width]
    near = ndimage.binary_dilation(crossed, np.ones((3, 3)))
    edge = float(squares[near].sum() / max(1, crossed.sum()))
    return float(squares.mean()), edge, float(255 * np.abs(image - picture)[~near].max(initial=0))


def compare(path: Path) -> Comparison:
    """Read and compare a file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            drawing = livecl.read_svg(path)
        except SvgError as error:
            return Comparison(path=path, warning=f"refused: {str(error).removeprefix(f'{path}: ')}")
    warning = "; ".join(str(item.message).partition("paths: ")[2] for item in caught)
    facts = {"path": path, "layers": drawing.num_layers}
    if max(drawing.size) > MAX_SIDE:
        return Comparison(**facts, warning="not compared: too large")
    try:
        picture = shown_by_resvg(path.read_text(encoding="utf-8"))
        mse, edge, flat = differences(drawing, picture)
    except (ValueError, UnicodeDecodeError) as error:
        return Comparison(**facts, warning=f"not compared: {error}")
    return Comparison(**facts, warning=warning, mse=mse, edge=edge, flat=flat)


def files(folders: Iterable[Path], every: int) -> list[Path]:
    """Return each `every`-th SVG file of the folders, links left out."""
    found = [
        path
        for folder in folders
        for path in ([folder] if folder.is_file() else sorted(folder.rglob("*.svg")))
        if path.is_file() and not path.is_symlink()
    ]
    return found[::every]


def main() -> int:
    """Print the table; return 1 if a file differs without a warning."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="SVG files, or folders of them")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only each N-th file")
    parser.add_argument("--rows", type=int, default=20, metavar="N", help="rows of the table")
    arguments = parser.parse_args()
    found = [compare(path) for path in files(arguments.folders, arguments.every)]
    found.sort(key=lambda item: (bool(item.warning), -item.edge, -item.flat))
    print("| file | layers | MSE | edge | flat | not read |\n|---|--:|--:|--:|--:|---|")
    for item in found[: arguments.rows]:
        facts = f"{item.layers} | {item.mse:.2g} | {item.edge:.2g} | {item.flat:.1f} | {item.warning[:200]}"
        print(f"| {item.path} | {facts} |")
    plain = [item for item in found if not item.warning]
    differing = [item for item in plain if item.differs]
    refused = sum(item.warning.startswith("refused") for item in found)
    apart = sum(item.warning.startswith("not compared") for item in found)
    print(
        f"\n{len(found)} files: {len(plain)} read in full, {len(differing)} of them shown otherwise; "
        f"{len(found) - len(plain) - refused - apart} with a warning, {refused} refused, {apart} not compared."
    )
    if plain:
        print(f"Read in full: median MSE {np.median([item.mse for item in plain]):.2g}, ", end="")
        print(f"edge {np.median([item.edge for item in plain]):.2g}, worst {max(item.edge for item in plain):.2g}.")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
