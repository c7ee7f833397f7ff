# SPDX-License-Identifier: Apache-2.0
"""Runs that start from stroked layers train their centre lines and widths, and keep what they are."""

from __future__ import annotations

import numpy as np
import pytest

import livecl
import livecl.svg
from livecl.drawing import Drawing, Strokes

SIZE = (64, 64)


def _wave(height: float, middle: float) -> np.ndarray:
    """An open subpath of three straight segments; the last row is its end."""
    x = np.linspace(10, 54, 4)
    anchors = np.stack([x, middle + height * np.sin(x / 8)], axis=1)
    steps = np.concatenate([np.diff(anchors, axis=0), np.zeros((1, 2))])
    return np.stack([anchors, anchors + steps / 3, anchors + 2 * steps / 3], axis=1)


def _drawing() -> Drawing:
    return Drawing.from_outlines(
        [[_wave(8, 20)], [_wave(-6, 44)]],
        [[0.1, 0.2, 0.7, 1], [0.8, 0.3, 0.1, 1]],
        SIZE,
        strokes=Strokes(widths=[5, 3], caps=1, joins=1, is_open=np.array([True, True])),
    )


def _moved(drawing: Drawing) -> Drawing:
    change = np.random.default_rng(0).normal(0, 2, drawing.points.shape)
    return drawing.replace(points=drawing.points + change, strokes=drawing.strokes.with_widths([3, 4]))


@pytest.fixture(scope="module")
def result() -> livecl.Result:
    drawing = _drawing()
    options = livecl.Options(iterations=200, revisions=0)
    return livecl.vectorize(livecl.render(drawing), start=_moved(drawing), options=options)


def test_widths_and_lines_are_found(result: livecl.Result) -> None:
    np.testing.assert_allclose(result.drawing.strokes.widths, [5, 3], atol=0.1)
    before = np.mean((livecl.render(_moved(_drawing())) - livecl.render(_drawing())) ** 2)
    assert result.mse < before / 100


def test_strokes_stay_strokes(result: livecl.Result) -> None:
    strokes = result.drawing.strokes

    assert strokes.is_open.all()
    assert strokes.caps.tolist() == [1, 1]
    assert (
        livecl.read_svg(livecl.svg.format_svg(result.drawing).encode()).strokes.widths.tolist()
        == strokes.widths.tolist()
    )


def test_locked_strokes_stay_as_they_are() -> None:
    drawing = _drawing()
    start = livecl.svg.quantize(_moved(drawing))

    found = livecl.vectorize(
        livecl.render(drawing), start=start, lock=[0], options=livecl.Options(iterations=20, revisions=0)
    ).drawing

    assert found.strokes.widths[0] == 3
    np.testing.assert_array_equal(found.points[:4], start.points[:4])
    assert found.strokes.widths[1] != 4
