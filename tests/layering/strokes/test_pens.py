# SPDX-License-Identifier: Apache-2.0
"""Shade and width of thin lines are chosen together: their product is known well, each of them is not."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import drawing, line

from livecl import Drawing, Options, Rasterizer, render, vectorize
from livecl.layering.context import Context
from livecl.layering.strokes.pens import with_best_shades

SIZE = (64, 64)


def _lines(ink: float, width: float) -> Drawing:
    """Two lines of a width, px, in a grey whose contrast with the white ground is `ink`."""
    shade = 1 - ink
    lines = [line((8, 12.3), (56, 30.1)), line((10.4, 56), (50.2, 38))]
    return drawing(((shade, shade, shade), width, lines), size=SIZE)


def _chosen(found: Drawing, true: Drawing) -> Drawing:
    return with_best_shades(Context(Rasterizer(SIZE), render(true), Options()), found)


@pytest.mark.parametrize("share", [0.75, 1.25])
def test_a_line_of_one_pixel_has_its_own_shade_and_width(share: float) -> None:
    true, found = _lines(0.8, 1.0), _lines(0.8 * share, 1 / share)

    chosen = _chosen(found, true)

    assert chosen.strokes.widths[0] == pytest.approx(1, rel=0.03)
    np.testing.assert_allclose(1 - chosen.colors[0, :3], 0.8, rtol=0.03)
    np.testing.assert_array_equal(chosen.points, found.points)


def test_what_is_right_or_wide_stays() -> None:
    true = _lines(0.8, 1.0)
    assert _chosen(true, true) is true
    wide = _lines(0.5, 5.0)
    assert _chosen(wide, _lines(0.8, 4.0)) is wide


def test_a_run_chooses_shades_of_thin_lines() -> None:
    """Training alone leaves them near those of the first lines: here 8 % too wide and too pale."""
    true = _lines(0.8, 1.0)

    found = vectorize(render(true), options=Options(strokes="auto", background="#ffffff", iterations=30)).drawing

    assert found.strokes.widths.all()
    np.testing.assert_allclose(found.strokes.widths, 1, rtol=0.05)
    np.testing.assert_allclose(1 - found.colors[:, :3], 0.8, rtol=0.05)
