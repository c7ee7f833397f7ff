# SPDX-License-Identifier: Apache-2.0
"""Strokes are fitted to their ink before anything is decided on them: places and widths, with their shades kept."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from support.found import find_strokes
from support.line_art import BLACK, arc, curve, drawing, line

from livecl import Drawing, Options, Rasterizer, render
from livecl.geometry.bezier import evaluate
from livecl.layering.context import Context
from livecl.layering.strokes.fitting import fitted_to_ink

SIZE = (64, 64)
#: Lines that are 5 px wide.
LINES = {
    "straight": line((10, 20), (54, 43)),
    "bent": curve((10, 40), (22, 8), (42, 56), (54, 20)),
    "circle": arc(32, 32, 20),
}


def _sampled(layer: Drawing) -> np.ndarray:
    """Return points (n, 2) of the centre line, twenty a pixel."""
    cubics = layer.cubics[: -1 if layer.strokes.is_open[0] else None]
    return np.concatenate([evaluate(cubic, np.linspace(0, 1, 1500)) for cubic in cubics])


def _off(found: Drawing, true: Drawing) -> float:
    """Return the largest distance, px, from points of one centre line to the other."""
    return float(cKDTree(_sampled(true)).query(_sampled(found))[0].max())


@pytest.mark.parametrize("strength", [1.0, 0.5])
@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize(("shift", "wide"), [((0.3, -0.3), 1.0), ((0.0, 0.0), 1.15), ((-0.3, 0.3), 0.85)])
def test_lines_move_to_their_ink(name: str, strength: float, shift: tuple[float, float], wide: float) -> None:
    true = drawing((BLACK, 5, [LINES[name]]), size=SIZE)
    start = true.replace(points=true.points + shift, strokes=true.strokes.with_widths([5 * wide]))
    rasterizer = Rasterizer(SIZE)
    ink = strength * np.asarray(rasterizer.coverages(true)[0], dtype=np.float64)

    found = fitted_to_ink(rasterizer, start, ink, np.array([strength]), np.ones(SIZE))

    assert _off(found, true) < 0.1
    assert found.strokes.widths[0] == pytest.approx(5, rel=0.02)
    np.testing.assert_array_equal(found.colors, start.colors)
    assert found.background is not None and start.background is not None
    np.testing.assert_array_equal(found.background, start.background)


def test_ink_beneath_another_ink_does_not_count() -> None:
    true = drawing((BLACK, 5, [LINES["straight"]]), size=SIZE)
    rasterizer = Rasterizer(SIZE)
    ink = np.asarray(rasterizer.coverages(true)[0], dtype=np.float64)
    seen = np.ones(SIZE)
    seen[:, 24:40] = 0

    found = fitted_to_ink(rasterizer, true, np.where(seen > 0, ink, 0), np.ones(1), seen)

    assert _off(found, true) < 0.1
    assert found.strokes.widths[0] == pytest.approx(5, rel=0.02)


def test_strokes_of_a_picture_are_compared_after_the_fit() -> None:
    """Untrained lines, as they are weighed against shapes: without the fit, this curve is off by up to .24 px."""
    true = drawing((BLACK, 5, [LINES["bent"]]), size=SIZE)
    context = Context(Rasterizer(SIZE), render(true), Options(strokes="only"))

    found = find_strokes(context, np.ones(3))

    assert found.num_layers == 1
    assert _off(found, true) < 0.1
    assert found.strokes.widths[0] == pytest.approx(5, rel=0.02)
