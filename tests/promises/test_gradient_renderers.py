# SPDX-License-Identifier: Apache-2.0
"""Saved gradients look in other renderers as they were optimized: stops interpolated straight, with opacities."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from support.shapes import blob

import livecl
from livecl.drawing import Drawing, Fills
from livecl.svg import format_svg, quantize, read_svg

#: Mean squared difference that renderers' antialiasing of solid fills makes, too.
RESVG, CAIRO = 3e-5, 1e-5


def _drawing() -> Drawing:
    rng = np.random.default_rng(1)
    kinds = np.tile([1, 2, 0], 3)
    fills = Fills(
        kinds=kinds,
        geometry=rng.uniform(5, 90, (9, 3, 2)),
        stop_offsets=np.concatenate([[0], np.cumsum(np.where(kinds > 0, 3, 0))]),
        stop_positions=np.tile([0, 0.4, 1], 6),
        stop_colors=rng.uniform(size=(18, 4)),
    )
    outlines = [[blob(k, rng.uniform(20, 80, 2), 30)] for k in range(9)]
    return quantize(Drawing.from_outlines(outlines, rng.uniform(size=(9, 4)), (96, 100), fills=fills))


def _picture(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")) / 255.0


def test_resvg_and_cairo_show_what_is_rendered() -> None:
    resvg_py, cairosvg = pytest.importorskip("resvg_py"), pytest.importorskip("cairosvg")
    drawing = _drawing()
    svg, image = format_svg(drawing), livecl.render(drawing)
    np.testing.assert_array_equal(livecl.render(read_svg(svg.encode())), image)
    assert np.mean((_picture(bytes(resvg_py.svg_to_bytes(svg_string=svg))) - image) ** 2) < RESVG
    assert np.mean((_picture(cairosvg.svg2png(svg.encode())) - image) ** 2) < CAIRO
