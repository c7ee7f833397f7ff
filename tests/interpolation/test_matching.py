# SPDX-License-Identifier: Apache-2.0
"""Layers that belong together, and a paint order for both drawings."""

from __future__ import annotations

import numpy as np
import pytest
from support.drawings import BLUE, GREEN, RED, build, rectangle
from support.shapes import circle

from livecl.drawing.assembly import empty_drawing
from livecl.drawing.canvas import layer_boxes
from livecl.interpolation.matching import Pair, layer_differences, match_layers

SIZE = (100, 100)
HEAD, LEFT, RIGHT, MOUTH = (
    ([circle((50, 50), 40)], RED),
    ([circle((35, 40), 5)], BLUE),
    ([circle((65, 40), 5)], BLUE),
    (
        [rectangle(35, 62, 65, 72)],
        GREEN,
    ),
)


def ranks(pairs: list[Pair], side: int) -> list[int]:
    """Return the layers of one drawing, in the order of the pairs."""
    return [layer for pair in pairs if (layer := pair[side]) is not None]


def test_boxes() -> None:
    drawing = build([([rectangle(10, 20, 30, 50), rectangle(40, 5, 44, 9)], RED), LEFT], SIZE)
    np.testing.assert_allclose(layer_boxes(drawing)[0], (10, 5, 44, 50))
    assert layer_boxes(empty_drawing(SIZE)).shape == (0, 4)


def test_differences() -> None:
    a, b = build([([rectangle(10, 10, 30, 30)], RED)], SIZE), build([([rectangle(20, 10, 60, 30)], RED)], SIZE)
    # The middle shifts by 0.2 of the canvas, and the width grows by 0.2.
    assert layer_differences(a, b)[0, 0] == pytest.approx(0.08)
    assert layer_differences(a, a)[0, 0] == 0


def test_order() -> None:
    a, b = build([HEAD, LEFT, MOUTH], SIZE), build([MOUTH, HEAD, LEFT], SIZE)
    assert match_layers(a, b) == [(0, 0), (1, 1), (2, 2)]


def test_order_pads_where_layers_differ_least() -> None:
    a, b = build([HEAD, MOUTH], SIZE), build([HEAD, LEFT, RIGHT, MOUTH], SIZE)
    assert match_layers(a, b) == [(0, 0), (None, 1), (None, 2), (1, 3)]
    assert match_layers(b, a) == [(0, 0), (1, None), (2, None), (3, 1)]


def test_order_of_the_like_takes_the_lowest() -> None:
    a, b = build([LEFT], SIZE), build([LEFT, LEFT, LEFT], SIZE)
    assert match_layers(a, b) == [(0, 0), (None, 1), (None, 2)]


def test_nearest() -> None:
    a, b = build([HEAD, LEFT, RIGHT, MOUTH], SIZE), build([HEAD, MOUTH, RIGHT, LEFT], SIZE)
    assert sorted(match_layers(a, b, "nearest")) == [(0, 0), (1, 3), (2, 2), (3, 1)]


def test_nearest_leaves_what_differs_too_much() -> None:
    a, b = build([([rectangle(0, 0, 10, 10)], RED)], SIZE), build([([rectangle(80, 80, 95, 95)], BLUE)], SIZE)
    assert sorted(match_layers(a, b, "nearest"), key=str) == [(0, None), (None, 0)]


def test_nearest_keeps_both_paint_orders() -> None:
    # The eye lies above the head in one and below it in the other: no order of pairs suits both.
    a, b = build([HEAD, LEFT, MOUTH], SIZE), build([LEFT, HEAD, MOUTH], SIZE)
    pairs = match_layers(a, b, "nearest")
    assert (0, 1) in pairs
    assert (1, None) in pairs
    assert (None, 0) in pairs
    assert ranks(pairs, 0) == [0, 1, 2]
    assert ranks(pairs, 1) == [0, 1, 2]


def test_nearest_orders_many() -> None:
    rng = np.random.default_rng(4)
    layers = [([circle(rng.uniform(20, 80, 2), rng.uniform(5, 30))], (*rng.uniform(size=3), 1.0)) for _ in range(20)]
    a, b = build(layers, SIZE), build([layers[i] for i in rng.permutation(20)], SIZE)
    pairs = match_layers(a, b, "nearest")
    for side, drawing in enumerate((a, b)):
        order = ranks(pairs, side)
        assert sorted(order) == list(range(20))
        boxes = layer_boxes(drawing)
        for place, lower in enumerate(order):
            for upper in order[place + 1 :]:
                apart = np.any(boxes[lower, :2] > boxes[upper, 2:]) or np.any(boxes[upper, :2] > boxes[lower, 2:])
                assert lower < upper or apart


@pytest.mark.parametrize("match", ["order", "nearest"])
def test_empty_drawings(match: str) -> None:
    none, one = empty_drawing(SIZE), build([HEAD], SIZE)
    assert match_layers(none, none, match) == []
    assert match_layers(none, one, match) == [(None, 0)]
    assert match_layers(one, none, match) == [(0, None)]


def test_unknown_match() -> None:
    none = empty_drawing(SIZE)
    with pytest.raises(ValueError, match="match: got 'best', wanted 'order' or 'nearest'"):
        match_layers(none, none, "best")
