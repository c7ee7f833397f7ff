# SPDX-License-Identifier: Apache-2.0
"""Shape words: what a person calls an outline, at any angle, and "shape" for what has no such word."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings, shapes

from livecl.drawing import Drawing, Strokes
from livecl.drawing.shape_words import SHAPE_WORDS, shape_words

RED = (1, 0, 0, 1)


def word(*outline: NDArray[np.float64]) -> str:
    return shape_words(drawings.build([(list(outline), RED)], (200, 200)))[0]


def turned(outline: NDArray[np.float64], degrees: float, stretch: float = 1.0) -> NDArray[np.float64]:
    """An outline stretched in x and turned about the canvas's centre."""
    angle = np.radians(degrees)
    matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag([stretch, 1])
    return (outline - 100) @ matrix.T + 100


@pytest.mark.parametrize("degrees", [0, 20, 90, 133])
def test_words_at_any_angle(degrees: float) -> None:
    circle, square = shapes.circle((100, 100), 40), drawings.rectangle(70, 70, 130, 130)
    assert word(turned(circle, degrees)) == "circle"
    assert word(turned(circle, degrees, 1.6)) == "oval"
    assert word(turned(square, degrees)) == "square"
    assert word(turned(square, degrees, 1.6)) == "rectangle"
    assert word(turned(drawings.rectangle(40, 92, 160, 108), degrees)) == "bar"
    assert word(turned(drawings.polygon([(60, 130), (140, 130), (90, 60)]), degrees)) == "triangle"


def test_holes() -> None:
    circle, hole = shapes.circle((100, 100), 40), drawings.reverse(shapes.circle((104, 100), 25))
    box, opening = drawings.rectangle(50, 60, 150, 140), drawings.reverse(drawings.rectangle(60, 70, 140, 130))
    assert word(circle, hole) == "ring"
    assert word(box, opening) == "frame"
    assert word(box, hole) == word(circle, opening) == "shape"
    assert word(circle, drawings.reverse(shapes.circle((104, 100), 2))) == "circle"  # hardly a hole
    assert word(shapes.circle((40, 40), 20), shapes.circle((150, 150), 20)) == "shape"  # two parts


def test_other_words() -> None:
    assert word(shapes.circle((100, 100), 2)) == "dot"
    star = [
        (100 + (60 if k % 2 else 22) * np.cos(k * np.pi / 5), 100 + (60 if k % 2 else 22) * np.sin(k * np.pi / 5))
        for k in range(10)
    ]
    assert word(drawings.polygon(star)) == "shape"
    assert word(drawings.polygon([(50, 50), (150, 50), (150, 80), (80, 80), (80, 150), (50, 150)])) == "shape"
    assert word(np.tile((7.0, 6.0), (4, 3, 1))) == "shape"  # without area
    line = drawings.build([([shapes.circle((100, 100), 40)], RED)], (200, 200))
    assert shape_words(line.replace(strokes=Strokes(widths=[3], is_open=[False]))) == ["line"]


def test_any_outline_has_a_word() -> None:
    rng = np.random.default_rng(0)
    layers = [
        ([rng.normal(100, 40, (rng.integers(1, 6), 3, 2)) for _ in range(rng.integers(1, 4))], RED) for _ in range(60)
    ]
    drawing = drawings.build(layers, (200, 200))
    assert set(shape_words(drawing)) <= set(SHAPE_WORDS)
    assert shape_words(Drawing.from_outlines([], np.zeros((0, 4)), (9, 9))) == []
