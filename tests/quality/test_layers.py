# SPDX-License-Identifier: Apache-2.0
"""Measures of layers, on drawings whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from support import drawings, shapes
from support.drawings import polygon, rectangle

from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.layering.contributions import layer_alphas, visible_shares
from livecl.layering.neighbors import flat_labels
from livecl.quality.layers import (
    LayerMeasures,
    measure_layers,
    nearly_opaque,
    num_parameters,
    region_shares,
    self_crossing,
)
from livecl.rendering.single import render

SIZE = (12, 16)
RED, BLUE, WHITE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0)
BOW_TIE = [(0, 0), (8, 8), (8, 0), (0, 8)]


def drawn(*layers: tuple[shapes.Path, ArrayLike], background: ArrayLike | None = (1.0, 1.0, 1.0)) -> Drawing:
    return drawings.build([([path], color) for path, color in layers], SIZE, background)


def opacity(color: tuple[float, ...], alpha: float) -> tuple[float, ...]:
    return (*color[:3], alpha)


def test_num_parameters() -> None:
    assert num_parameters(drawn((rectangle(1, 1, 5, 5), RED), (rectangle(1, 1, 5, 5), RED))) == 2 * (4 * 6 + 4)


def test_region_shares() -> None:
    target = np.ones((*SIZE, 3))
    target[:, :8] = 0
    drawing = drawn(
        (rectangle(0, 0, 8, 12), RED),  # below the next: its rows 2 to 11
        (rectangle(0, 0, 10, 2), RED),  # 8 of 10 columns
        (rectangle(12, 4, 16, 8), opacity(RED, 0.5)),  # visible nowhere: one half is not more than it
    )
    shares = visible_shares(layer_alphas(drawing))
    assert region_shares(shares, flat_labels(target)) == pytest.approx([1, 0.8, 0])


def test_nearly_opaque() -> None:
    drawing = drawn(*((rectangle(0, 0, 4, 4), opacity(RED, alpha)) for alpha in (1, 254 / 255, 0.91, 0.9, 0.4, 0)))
    assert nearly_opaque(drawing).tolist() == [False, True, True, False, False, False]


def test_measure_layers() -> None:
    drawing = drawn(
        (rectangle(1, 1, 7, 11), RED),
        (rectangle(9, 1, 15, 11), RED),
        (rectangle(9, 1, 15, 6), opacity(RED, 0.95)),  # hardly changes anything, could be part of the one below
        (polygon(np.array(BOW_TIE) / 2 + 2), BLUE),  # two regions, within the first layer
    )
    measures = measure_layers(drawing, render(drawing))
    assert measures == LayerMeasures(
        layers=4, in_one_region=3, self_crossing=1, needless=1, mergeable=1, nearly_opaque=1
    )


def test_measure_layers_without_layers_or_background() -> None:
    nothing = LayerMeasures(layers=0, in_one_region=0, self_crossing=0, needless=0, mergeable=0, nearly_opaque=0)
    assert measure_layers(empty_drawing(SIZE), np.zeros((*SIZE, 3))) == nothing
    white = drawn((rectangle(2, 2, 9, 9), WHITE), background=None)
    assert measure_layers(white, np.ones((*SIZE, 3))).needless == 1
    assert measure_layers(white, render(white)).needless == 0
    with pytest.raises(ValueError, match="target: shape"):
        measure_layers(white.replace(background=(0, 0, 0)), np.ones((*SIZE, 4)))


def test_self_crossing_names_layers() -> None:
    tie = polygon(BOW_TIE)
    drawing = drawings.build(
        [
            ([rectangle(0, 0, 4, 4)], RED),
            ([rectangle(0, 0, 9, 9), tie], RED),
            ([rectangle(0, 0, 9, 9), rectangle(6, 6, 12, 12)], RED),  # subpaths may cross each other
            ([tie], RED),
        ],
        SIZE,
    )
    assert self_crossing(drawing).tolist() == [False, True, False, True]
    assert self_crossing(empty_drawing(SIZE)).tolist() == []
