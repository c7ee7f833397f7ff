# SPDX-License-Identifier: Apache-2.0
"""Saved strokes look in other renderers as they were optimized, with every cap and join."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support import chromium

import livecl
from livecl.drawing import Drawing, Strokes
from livecl.geometry.strokes import CAPS, JOINS
from livecl.svg import quantize

SIZE = (96, 100)
#: Mean squared differences measured, the largest of all caps and joins: antialiasing, and caps at ends of tight bends,
#: which look along the curve there and along its first line here. Filled outlines of the same strokes differ by up to
#: 6e-5 (cairo), 1.1e-4 (resvg) and 2.3e-4 (Chromium).
NOISE = {"resvg": 1.7e-4, "cairo": 1.4e-4, "chromium": 1.9e-4}


def _drawing(cap: int, join: int) -> Drawing:
    """Return strokes over one another: bent lines, a triangle and curves, thin and wide, opaque and translucent."""
    rng = np.random.default_rng(10 * cap + join)
    outlines, opened = [], []
    for kind in range(6):
        corners = rng.uniform(15, 80, (3, 2))
        steps = np.roll(corners, -1, axis=0) - corners
        rows = np.stack([corners, corners + steps / 3, corners + 2 * steps / 3], axis=1)
        if kind % 3 == 2:
            rows[:, 1:] += rng.normal(0, 8, (3, 2, 2))
        outlines.append([rows])
        opened.append(kind % 2 == 0)
    pens = Strokes(
        widths=[1.3, 4, 7, 9, 2.5, 5], caps=cap, joins=join, miter_limits=4, is_open=np.array(opened, dtype=bool)
    )
    colors = np.column_stack([rng.uniform(size=(6, 3)), [1, 0.7, 1, 0.5, 1, 0.8]])
    return quantize(Drawing.from_outlines(outlines, colors, SIZE, strokes=pens))


def _resvg(path: Path) -> NDArray[np.float32]:
    resvg_py = pytest.importorskip("resvg_py")
    return livecl.read_image(bytes(resvg_py.svg_to_bytes(svg_string=path.read_text(encoding="utf-8"))))[..., :3]


def _cairo(path: Path) -> NDArray[np.float32]:
    cairosvg = pytest.importorskip("cairosvg", exc_type=OSError)
    return livecl.read_image(io.BytesIO(cairosvg.svg2png(url=str(path))))[..., :3]


def _chromium(path: Path) -> NDArray[np.float32]:
    return chromium.screenshot(path, SIZE)


@pytest.mark.parametrize("join", range(len(JOINS)), ids=JOINS)
@pytest.mark.parametrize("cap", range(len(CAPS)), ids=CAPS)
@pytest.mark.parametrize("shown", [_resvg, _cairo, pytest.param(_chromium, marks=pytest.mark.full)])
def test_saved_strokes_look_as_optimized(
    shown: Callable[[Path], NDArray[np.float32]], cap: int, join: int, tmp_path: Path
) -> None:
    drawing = _drawing(cap, join)
    drawing.save_svg(tmp_path / "strokes.svg")

    picture = shown(tmp_path / "strokes.svg")

    def difference(other: Drawing) -> float:
        return float(np.mean((picture - livecl.render(other)) ** 2))

    assert difference(drawing) <= NOISE[shown.__name__[1:]]
    pens = drawing.strokes
    for caps, joins in (((pens.caps + 1) % len(CAPS), pens.joins), (pens.caps, (pens.joins + 1) % len(JOINS))):
        wrong = Strokes(widths=pens.widths, caps=caps, joins=joins, miter_limits=4, is_open=pens.is_open)
        assert difference(drawing.replace(strokes=wrong)) > difference(drawing)
