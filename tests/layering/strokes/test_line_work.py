# SPDX-License-Identifier: Apache-2.0
"""Strokes of flat pictures are taken where they are cheaper than shapes, which are placed beside them."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import BLACK, DRAWINGS, arc, drawing, line, match
from support.outlined_drawings import DRAWINGS as OUTLINED

from livecl import Drawing, Options, Rasterizer, Result, render, vectorize
from livecl.drawing import Strokes
from livecl.drawing.assembly import scaled
from livecl.geometry.strokes import BUTT, ROUND
from livecl.layering.context import Context
from livecl.layering.strokes.ends import REACH, lengthened, with_best_ends, with_flat_ends
from livecl.layering.strokes.thinning import worth


def _found(true: Drawing, strokes: str) -> Result:
    return vectorize(render(true), paths="auto", options=Options(strokes=strokes))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["button", "sign", "plate"])
def test_strokes_are_never_dearer_than_shapes(name: str) -> None:
    plain, found = (_found(OUTLINED[name], strokes) for strokes in ("off", "auto"))

    assert found.mse - plain.mse < max(worth(plain.drawing, found.drawing), 0.05 * plain.mse)
    assert found.drawing.strokes.any


@pytest.mark.parametrize(("name", "nodes"), [("star", 1.0), ("house", 1.0), ("letter", 1.0)])
def test_line_art_is_drawn_by_centre_lines_with_its_own_ends(name: str, nodes: float) -> None:
    true = DRAWINGS[name]
    plain, found = (_found(true, strokes) for strokes in ("off", "auto"))

    result = match(found.drawing, true)
    assert found.drawing.strokes.widths.all()
    assert result.distance < 0.2
    assert result.nodes <= nodes
    assert found.mse - plain.mse < worth(plain.drawing, found.drawing)


def _line(cap: int, reach: float) -> Drawing:
    rows = np.array([[[20, 30], [30, 30], [50, 30]], [[60 + reach, 30]] * 3], dtype=float)
    rows[0] -= [[reach, 0]] * 3
    pen = Strokes(widths=[8], caps=cap, is_open=np.array([True]))
    return Drawing.from_outlines([[rows]], [0, 0, 0, 1], (60, 80), strokes=pen)


@pytest.mark.parametrize("cap", [BUTT, ROUND])
def test_caps_are_those_of_the_ink(cap: int) -> None:
    true, other = _line(cap, 0.0), _line(BUTT + ROUND - cap, np.pi if cap == ROUND else -np.pi)
    context = Context(Rasterizer(true.size), render(true), Options())

    found = with_best_ends(context, other)

    assert found.strokes.caps.tolist() == [cap]
    assert context.visible_mse(found) < context.visible_mse(other)
    assert with_best_ends(context, true) is true


def test_ends_on_other_lines_stay() -> None:
    stem = np.array([[[10, 20], [20, 20], [30, 20]], [[40, 20]] * 3], dtype=float)
    bar = np.array([[[40, 5], [40, 15], [40, 25]], [[40, 35]] * 3], dtype=float)

    longer, _ = lengthened([stem, bar], np.array([True, True]), 4.0, 2.0)

    np.testing.assert_allclose(longer[0, 0], (8, 20))
    np.testing.assert_array_equal(longer[-1], stem[-1])


@pytest.mark.parametrize("cap", [BUTT, ROUND])
def test_ends_are_where_their_ink_ends(cap: int) -> None:
    true, short = _line(cap, 0.0), _line(cap, -2.5)
    lines = [short.points[rows] for rows in short.subpaths()]
    coverage = np.asarray(Rasterizer(true.size).coverages(true)[0], dtype=np.float64)

    (rows,) = with_flat_ends(lines, np.array([True]), 8.0, coverage)

    flat = 8 * REACH[cap]
    np.testing.assert_allclose(rows[[0, -1], 0], [(20 - flat, 30), (60 + flat, 30)], atol=0.15)


def _sampled(drawing: Drawing, samples: int) -> np.ndarray:
    """Return a drawing as a renderer shows it that samples pixels `samples` x `samples` times."""
    height, width = drawing.size
    fine = np.asarray(render(scaled(drawing, (samples * height, samples * width))))[..., :3] > 0.5
    return fine.reshape(height, samples, width, samples, 3).mean(axis=(1, 3)).astype(np.float32)


def _head() -> Drawing:
    """An arrow in a ring, as of an icon: wide lines, round caps and joins."""
    return drawing((BLACK, 14, [arc(80, 80, 66), line((80, 50), (50, 80), (80, 110)), line((110, 80), (50, 80))]))


@pytest.mark.parametrize("samples", [4, pytest.param(2, marks=pytest.mark.slow)])
def test_lines_of_a_renderer_that_samples_pixels_are_strokes(samples: int) -> None:
    """A free outline follows the steps of such a renderer, at less error: these show nothing that anybody drew."""
    true = _head()

    found = vectorize(_sampled(true, samples), options=Options(strokes="auto", background="#ffffff")).drawing

    assert found.strokes.widths.all()
    result = match(found, true)
    assert result.distance < 0.3
    assert result.width < 0.05
    assert result.nodes <= 1.3
