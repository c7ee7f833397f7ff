# SPDX-License-Identifier: Apache-2.0
"""Gradients of filled and stroked layers over each other, of all kinds of paint, along random directions."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor

from livecl.drawing import Drawing, Fills, Strokes
from livecl.drawing.fills import concatenate_fills

SIZE, LAYERS = (64, 64), 6


def _scene(seed: int) -> Drawing:
    """Return layers of random curves: every second is stroked, with random caps and joins, some of them open."""
    rng = np.random.default_rng(seed)
    ends = [np.column_stack([rng.uniform(size=(2, 3)), rng.uniform(0.3, 1, 2)]) for _ in range(LAYERS)]
    fills = [
        Fills.solid(1),
        Fills.linear(*rng.uniform(0, 64, (2, 2)), ends[1]),
        Fills.radial(*rng.uniform(10, 50, (3, 2)), ends[2]),
        Fills.solid(1),
        Fills.linear(*rng.uniform(0, 64, (2, 2)), ends[4]),
        Fills.radial(*rng.uniform(10, 50, (3, 2)), ends[5]),
    ]
    return Drawing.from_outlines(
        [[rng.uniform(5, 59, (3, 3, 2))] for _ in range(LAYERS)],
        np.column_stack([rng.uniform(size=(LAYERS, 3)), rng.uniform(0.3, 1, LAYERS)]),
        SIZE,
        fills=concatenate_fills(fills),
        strokes=Strokes(
            widths=[0, *rng.uniform(1.2, 9, 1), 0, *rng.uniform(1.2, 9, 1), 0, *rng.uniform(1.2, 9, 1)],
            caps=rng.integers(0, 3, LAYERS),
            joins=rng.integers(0, 3, LAYERS),
            is_open=np.array([False, True, False, False, False, True]),
        ),
    )


@pytest.mark.parametrize("seed", range(6))
def test_products_are_central_differences(rasterizer_for: RasterizerFor, seed: int) -> None:
    """u^T (J v) by differences is (u^T J) v by the gradients of points, widths, colours and stops."""
    drawing, rng, step = _scene(seed), np.random.default_rng(seed + 100), 1e-6
    rasterizer = rasterizer_for(SIZE, np.float64)
    pieces = rasterizer.pieces(drawing)
    image, pullback = rasterizer.vjp(drawing, pieces)
    u = rng.normal(size=image.shape)
    gradients = pullback(u)
    assert gradients.widths is not None
    assert gradients.fills is not None
    d_points = rng.normal(size=drawing.points.shape)
    d_widths = rng.normal(size=LAYERS) * (drawing.strokes.widths > 0)
    d_colors = rng.normal(size=drawing.colors.shape) * (drawing.fills.kinds == 0)[:, None]
    d_stops = rng.normal(size=drawing.fills.stop_colors.shape)

    def moved(by: float) -> float:
        fills = drawing.fills.moved(
            drawing.fills.geometry, drawing.fills.stop_positions, drawing.fills.stop_colors + by * d_stops
        )
        strokes = drawing.strokes.moved(drawing.strokes.widths + by * d_widths)
        points, colors = drawing.points + by * d_points, drawing.colors + by * d_colors
        changed = drawing.moved(points, colors, drawing.background, fills, strokes)
        return float((rasterizer.forward(changed, pieces) * u).sum())

    product = (gradients.points * d_points).sum() + (gradients.widths * d_widths).sum()
    product += (gradients.colors * d_colors).sum() + (gradients.fills.stop_colors * d_stops).sum()

    assert (moved(step) - moved(-step)) / (2 * step) == pytest.approx(product, rel=1e-6)
