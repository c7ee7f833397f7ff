# SPDX-License-Identifier: Apache-2.0
"""Independent renderers show the saved SVG as the program's own render does."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings, shapes

import livecl
from livecl import Drawing, Options
from livecl.image.reading import over_background
from livecl.svg import quantize

ROOT = Path(__file__).resolve().parents[2]
#: Mean squared difference from exact coverage that the renderers' own antialiasing makes (resvg 1.2e-5, cairo 3.8e-6 on
#: five overlapping translucent paths), with room for pictures of more edges; and the mean difference in levels of 255.
RESVG, CAIRO, LEVELS = 3e-5, 1e-5, 0.5


def _resvg(drawing: Drawing) -> NDArray[np.float32]:
    import resvg_py

    return livecl.read_image(bytes(resvg_py.svg_to_bytes(svg_string=drawing._repr_svg_())))[..., :3]


def _cairo(drawing: Drawing) -> NDArray[np.float32]:
    cairosvg = pytest.importorskip("cairosvg", exc_type=OSError)
    return livecl.read_image(io.BytesIO(cairosvg.svg2png(bytestring=drawing._repr_svg_().encode())))[..., :3]


def _check(drawing: Drawing) -> None:
    own = livecl.render(drawing)
    for picture, bound in ((_resvg(drawing), RESVG), (_cairo(drawing), CAIRO)):
        assert np.mean(np.square(picture - own, dtype=np.float64)) < bound
        assert 255 * np.mean(np.abs(picture - own)) < LEVELS


def test_translucent_overlaps_and_a_hole() -> None:
    ring = [shapes.circle((120, 110), 70), drawings.reverse(shapes.circle((126, 118), 35))]
    layers = [
        (ring, (0.1, 0.4, 0.8, 1.0)),
        ([shapes.circle((80, 150), 55)], (0.9, 0.3, 0.1, 128 / 255)),
        ([drawings.rectangle(20.5, 30.25, 150, 60)], (0.2, 0.7, 0.3, 1.0)),
    ]
    _check(quantize(drawings.build(layers, (240, 240))))


@pytest.mark.parametrize("name", ["face", "logo", "letter", "badge"])
def test_vectorized_samples(name: str) -> None:
    image = livecl.read_image(ROOT / "examples" / f"{name}.png")
    _check(livecl.vectorize(image, paths=5, options=Options(iterations=40)).drawing)


@pytest.mark.parametrize("name", ["1f436", "1f614", "1f646"])
def test_vectorized_faces(name: str, data_dir: Path) -> None:
    image = over_background(livecl.read_image(data_dir / "emoji" / f"{name}.png"), (1, 1, 1))
    _check(livecl.vectorize(image, paths=5, options=Options(iterations=40)).drawing)
