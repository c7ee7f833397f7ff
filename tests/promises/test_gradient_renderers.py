# SPDX-License-Identifier: Apache-2.0
"""Saved gradients look in other renderers as they were optimized: stops interpolated straight, with opacities."""

from __future__ import annotations

import io
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support import chromium
from support.shapes import blob

import livecl
from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills
from livecl.svg import format_svg, quantize, read_svg

SIZE = (96, 100)
#: Mean squared difference that renderers' antialiasing of solid fills makes, too.
RESVG, CAIRO = 3e-5, 1e-5
#: Chromium and Inkscape round more or less from version to version: bounds are multiples of what solid fills differ by
#: there, and a level of 255 for the colours within a gradient.
NOISE, LEVEL = 1.5, 1 / 255


def _drawing(seed: int) -> Drawing:
    """Return blobs over one another; two thirds have gradients of two to four stops, transparent, opaque, and steps."""
    rng = np.random.default_rng(seed)
    kinds = np.tile([LINEAR, RADIAL, SOLID], 3)
    counts = np.where(kinds == SOLID, 0, rng.integers(2, 5, 9))
    positions = [np.sort(rng.uniform(size=count)) for count in counts]
    if counts[0] > 2:
        positions[0][1] = positions[0][2]
    colors = rng.uniform(size=(counts.sum(), 4))
    colors[rng.random(len(colors)) < 0.3, 3] = 1
    fills = Fills(
        kinds=kinds,
        geometry=rng.uniform(5, 90, (9, 3, 2)),
        stop_offsets=np.concatenate([[0], np.cumsum(counts)]),
        stop_positions=np.concatenate(positions),
        stop_colors=colors,
    )
    outlines = [[blob(100 * seed + k, rng.uniform(20, 80, 2), 30)] for k in range(9)]
    return quantize(Drawing.from_outlines(outlines, rng.uniform(size=(9, 4)), SIZE, fills=fills))


def _read(png: bytes) -> NDArray[np.float32]:
    return livecl.read_image(png)[..., :3]


def _resvg(path: Path) -> NDArray[np.float32]:
    resvg_py = pytest.importorskip("resvg_py")
    return _read(bytes(resvg_py.svg_to_bytes(svg_string=path.read_text(encoding="utf-8"))))


def _cairo(path: Path) -> NDArray[np.float32]:
    cairosvg = pytest.importorskip("cairosvg", exc_type=OSError)
    return livecl.read_image(io.BytesIO(cairosvg.svg2png(url=str(path))))[..., :3]


def _chromium(path: Path) -> NDArray[np.float32]:
    return chromium.screenshot(path, SIZE)


def _inkscape(path: Path) -> NDArray[np.float32]:
    if (program := shutil.which("inkscape")) is None:
        pytest.skip("Inkscape is not installed")
    png = path.with_suffix(".png")
    command = [program, "--export-type=png", f"--export-filename={png}", str(path)]
    subprocess.run(command, capture_output=True, timeout=120, check=True)
    return _read(png.read_bytes())


def _error(render: Callable[[Path], NDArray[np.float32]], drawing: Drawing, folder: Path) -> float:
    path = folder / "drawing.svg"
    svg, image = format_svg(drawing), livecl.render(drawing)
    path.write_text(svg, encoding="utf-8")
    np.testing.assert_array_equal(livecl.render(read_svg(path)), image)
    return float(np.mean(np.square(render(path) - image, dtype=np.float64)))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("render", "bound"), [(_resvg, RESVG), (_cairo, CAIRO)], ids=["resvg", "cairo"])
def test_saved_is_what_was_optimized(
    render: Callable[[Path], NDArray[np.float32]], bound: float, seed: int, tmp_path: Path
) -> None:
    assert _error(render, _drawing(seed), tmp_path) < bound


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("render", [_chromium, _inkscape], ids=["chromium", "inkscape"])
def test_gradients_differ_no_more_than_solid_fills(
    render: Callable[[Path], NDArray[np.float32]], seed: int, tmp_path: Path
) -> None:
    drawing = _drawing(seed)
    solid = quantize(drawing.replace(fills=None, colors=np.clip(drawing.colors, 0.2, 0.8)))
    assert _error(render, drawing, tmp_path) < NOISE * _error(render, solid, tmp_path) + LEVEL**2
