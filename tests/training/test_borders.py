# SPDX-License-Identifier: Apache-2.0
"""A fill and the stroke around it are trained as one outline: its gradient is the sum of theirs."""

from __future__ import annotations

import numpy as np
from support.line_art import polygon

from livecl import Options, Rasterizer, render, vectorize
from livecl.drawing import Drawing, Strokes
from livecl.drawing.borders import border_pairs
from livecl.training.borders import Borders
from livecl.training.state import State
from livecl.training.step import untangle_outlines

SIZE = (40, 40)


def _bordered(*corners: tuple[float, float], width: float = 4.0) -> Drawing:
    rows = polygon(*corners)[0]
    return Drawing.from_outlines(
        [[rows], [rows]],
        [[0.9, 0.6, 0.2, 1], [0.1, 0.2, 0.5, 1]],
        SIZE,
        strokes=Strokes(widths=[0, width], joins=1, is_open=np.zeros(2, bool)),
    )


TRUE = _bordered((10.3, 8.2), (30.7, 12.1), (26.4, 31.8), (8.6, 27.3))


def test_gradient_agrees_with_central_differences() -> None:
    """Both layers move with a shared point: relative 1e-6 in double, the pieces held fixed."""
    drawing = _bordered((11.1, 9.4), (29.2, 11.3), (27.1, 30.2), (9.5, 26.1))
    rasterizer = Rasterizer(SIZE, dtype=np.float64)
    pieces = rasterizer.pieces(drawing)
    target = render(TRUE).astype(np.float64)
    borders = Borders.of(drawing, np.zeros(2, bool))

    def loss(points: np.ndarray) -> float:
        borders.restore(points)
        return float(np.square(rasterizer.forward(drawing.replace(points=points), pieces=pieces) - target).sum())

    image, pullback = rasterizer.vjp(drawing, pieces=pieces)
    found = pullback(2 * (image - target)).points
    borders.gather(found)

    assert not found[4:].any()
    step = 1e-5
    for index in np.ndindex(4, 3, 2):
        ahead, behind = drawing.points.copy(), drawing.points.copy()
        ahead[index] += step
        behind[index] -= step
        slope = (loss(ahead) - loss(behind)) / (2 * step)
        np.testing.assert_allclose(found[index], slope, rtol=1e-6, atol=1e-6 * np.abs(found).max())


def test_training_finds_outline_and_width_and_keeps_the_pair() -> None:
    start = _bordered((11.1, 9.4), (29.2, 11.3), (27.1, 30.2), (9.5, 26.1), width=3.0)

    result = vectorize(render(TRUE), start=start, options=Options(iterations=150, revisions=0, simplify=False))

    assert border_pairs(result.drawing).tolist() == [[0, 1]]
    np.testing.assert_allclose(result.drawing.points[:4, 0], TRUE.points[:4, 0], atol=0.15)
    np.testing.assert_allclose(result.drawing.strokes.widths, [0, 4], atol=0.1)


def test_loops_of_an_outline_with_a_stroke_stay_in_both() -> None:
    drawing = _bordered((5, 5), (20, 20), (20, 5), (5, 24))
    state = State.start(drawing, Options(), 0)
    untangle_outlines(state, lambda drawing: 0.0)
    assert np.array_equal(state.drawing.points, drawing.points)


def test_a_pair_of_which_one_layer_is_locked_comes_apart() -> None:
    start = _bordered((11.1, 9.4), (29.2, 11.3), (27.1, 30.2), (9.5, 26.1))

    for locked in (0, 1):
        holds = np.arange(2) == locked
        assert len(Borders.of(start, holds).fills) == 0
        result = vectorize(render(TRUE), start=start, lock=[locked], options=Options(iterations=20, revisions=0))
        own = slice(4 * locked, 4 * locked + 4)
        np.testing.assert_allclose(result.drawing.points[own], start.points[own], atol=1e-8)  # rounded to 9 decimals
