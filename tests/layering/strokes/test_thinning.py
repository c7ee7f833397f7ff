# SPDX-License-Identifier: Apache-2.0
"""Thin layers of coloured drawings become strokes where a centre line and a width are fewer numbers."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import SIZE, Subpath, arc, curve, drawing, line, match
from support.shapes import build, circle, rectangle

from livecl import Drawing, Options, Rasterizer, render, vectorize
from livecl.drawing.assembly import concatenate
from livecl.geometry.outlines import circle as circle_of
from livecl.layering.context import Context
from livecl.layering.strokes.thinning import thinned, worth

RED, BROWN, BLUE = (0.6, 0.1, 0.1), (0.4, 0.25, 0.1), (0.1, 0.3, 0.8)
MOUTH, RING = arc(80, 85, 34, 0.08, 0.42), arc(80, 25, 12)
BROW = curve((45, 48), (50, 40), (60, 40), (68, 44))


def _face() -> Drawing:
    """A yellow disc with two eyes, and, as strokes, a mouth, a brow and a ring."""
    discs = [(80, 80, 60), (58, 62, 9), (102, 62, 9)]
    fills = Drawing.from_outlines(
        [[circle_of((x, y), radius, 4)] for x, y, radius in discs],
        [(1, 0.8, 0.2, 1), (0.2, 0.15, 0.1, 1), (0.2, 0.15, 0.1, 1)],
        SIZE,
    )
    return concatenate(fills, drawing((RED, 6, [MOUTH]), (BROWN, 5, [BROW]), (BLUE, 5, [RING])))


def test_lines_of_a_coloured_drawing_become_strokes() -> None:
    true = _face()
    image = render(true)

    filled = vectorize(image, options=Options(background="#ffffff"))
    result = vectorize(image, options=Options(strokes="auto", background="#ffffff"))

    stroked = result.drawing.strokes.widths > 0
    assert stroked.sum() == 3
    np.testing.assert_allclose(sorted(result.drawing.strokes.widths[stroked]), [5, 5, 6], atol=0.1)
    assert match(result.drawing.layer_subset(stroked), true.layer_subset([3, 4, 5])).distance < 0.15
    assert result.drawing.num_segments < filled.drawing.num_segments
    assert result.mse < filled.mse
    assert not filled.drawing.strokes.any


def _thinned(layer: Drawing, free: bool = True) -> Drawing:
    return thinned(Context(Rasterizer(layer.size), render(layer), Options()), layer, np.array([free]))


@pytest.mark.parametrize(
    "shape",
    [circle((30, 30), 20), rectangle(10, 10, 50, 40), rectangle(27.2, 26.1, 33.4, 31.8)],
    ids=["disc", "rectangle", "dot"],
)
def test_compact_layers_stay(shape: np.ndarray) -> None:
    layer = build([([shape], (0.2, 0.4, 0.1, 1))], (60, 60))

    assert _thinned(layer) is layer


def _banana() -> Drawing:
    """A thin crescent with ends in points: no pen draws it."""
    outer = [[(8, 12), (14, 52), (46, 52)], [(52, 12), (44, 40), (16, 40)]]
    return build([([np.array(outer, float)], (0.9, 0.7, 0.1, 1))], (60, 60))


def test_layers_of_uneven_width_stay() -> None:
    layer = _banana()

    assert _thinned(layer) is layer


def _ring() -> Drawing:
    outlines = [circle((30, 30), 20, 4), circle((30, 30), 16, 4)[::-1]]
    inner = circle((30, 30), 16, 4)
    reversed_rows = np.stack([inner[:, 0], np.roll(inner, 1, axis=0)[:, 2], np.roll(inner, 1, axis=0)[:, 1]], axis=1)
    return build([([outlines[0], reversed_rows[::-1]], (0.1, 0.1, 0.5, 0.8))], (60, 60))


def test_rings_become_circles_with_their_names_and_colours() -> None:
    ring = _ring().replace(names=["halo"], stages=[3])

    result = _thinned(ring)

    assert result.strokes.widths[0] == pytest.approx(4, abs=0.2)
    assert not result.strokes.is_open.any()
    assert result.num_segments == 4
    assert result.names == ("halo",) and result.stages.tolist() == [3]
    np.testing.assert_array_equal(result.colors, ring.colors)
    assert worth(ring, result) > 0
    assert _thinned(ring, free=False) is ring


def test_a_drawing_is_worth_nothing_in_place_of_itself() -> None:
    straight: Subpath = line((20, 30), (140, 120))
    assert worth(drawing((RED, 4, [straight])), drawing((RED, 4, [straight]))) == 0
    # two numbers of a point more
    bent = line((20, 30), (80, 40), (140, 120))
    assert worth(drawing((RED, 4, [bent])), drawing((RED, 4, [straight]))) == pytest.approx(2 / 12 / (3 * 160 * 160))
