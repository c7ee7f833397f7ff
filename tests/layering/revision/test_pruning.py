# SPDX-License-Identifier: Apache-2.0
"""Which layers are dropped at the end: those that do little for the picture, and hidden ones sooner than others."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from support import drawings

from livecl import Options
from livecl.image.errors import mse
from livecl.layering.context import Context
from livecl.layering.revision.pruning import needed_layers

SIZE = (40, 40)
#: Edges lie in the middle of pixels: two of them make their rims darker than one.
SQUARE = drawings.rectangle(4.5, 4.5, 20.5, 20.5)
RED = (1.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("other", "left"),
    [
        (SQUARE, {0.5: 1, 2: 1, 20: 2}),
        (drawings.rectangle(24.5, 4.5, 32.5, 12.5), {0.5: 1, 2: 2, 20: 2}),
        (drawings.rectangle(24, 4, 27, 7), {0.5: 1, 2: 2, 20: 2}),  # small is not hidden
    ],
    ids=["hidden", "seen", "small"],
)
def test_hidden_layers_must_be_worth_more(
    rasterizer_for: RasterizerFor, other: np.ndarray, left: dict[float, int]
) -> None:
    # `left`: number of layers kept, where the gain of the lower one is this multiple of the threshold of others.
    drawing = drawings.build([([other], RED), ([SQUARE], RED)], SIZE)
    rasterizer = rasterizer_for(SIZE, np.float32)
    target = rasterizer.forward(drawing)
    worth = mse(rasterizer.forward(drawing.layer_subset([1])), target)
    context = Context(rasterizer, target, Options())
    for factor, wanted in left.items():
        free, held = np.ones(2, bool), np.zeros(2, bool)
        assert needed_layers(context, drawing, worth / factor, free).num_layers == wanted
        assert needed_layers(context, drawing, worth / factor, held).num_layers == 2


def test_layers_that_cannot_be_seen_go_unless_they_are_held(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.build([([SQUARE], (1.0, 0.0, 0.0, 0.0)), ([SQUARE], RED)], SIZE)
    rasterizer = rasterizer_for(SIZE, np.float32)
    context = Context(rasterizer, rasterizer.forward(drawing), Options())
    assert needed_layers(context, drawing, 0.0, np.array([True, True])).num_layers == 1
    assert needed_layers(context, drawing, 0.0, np.array([False, True])).num_layers == 2


def test_what_mended_a_layer_that_goes_is_needless_too(rasterizer_for: RasterizerFor) -> None:
    # A black square, hidden by a white one on white: without the black one, the white one is not seen.
    rasterizer = rasterizer_for(SIZE, np.float32)
    black, white = (0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0)
    inner, outer = drawings.rectangle(8, 8, 20, 20), drawings.rectangle(4, 4, 24, 24)
    drawing = drawings.build([([inner], black), ([outer], white)], SIZE)
    context = Context(rasterizer, np.ones((*SIZE, 3), np.float32), Options())
    assert needed_layers(context, drawing, 1e-6, np.ones(2, bool)).num_layers == 0
    assert needed_layers(context, drawing, 1e-6, np.array([False, True])).num_layers == 2


def test_of_two_layers_that_hide_each_other_one_stays(rasterizer_for: RasterizerFor) -> None:
    # Each by itself is needless. The error that is left without the first is what the second is judged against.
    rasterizer = rasterizer_for(SIZE, np.float32)
    drawing = drawings.build([([drawings.rectangle(4, 4, 24, 24)], RED)] * 2, SIZE)
    context = Context(rasterizer, rasterizer.forward(drawing), Options())
    assert needed_layers(context, drawing, 1e-6, np.ones(2, bool)).num_layers == 1


def test_each_layer_is_judged_by_its_own_worth_and_not_by_the_sum(rasterizer_for: RasterizerFor) -> None:
    # Two equal squares, each worth 0.6 of the threshold: both go, though both together are worth 1.2 of it.
    rasterizer = rasterizer_for(SIZE, np.float32)
    squares = [([drawings.rectangle(x, 4, x + 8, 12)], RED) for x in (4, 20)]
    drawing = drawings.build(squares, SIZE)
    context = Context(rasterizer, rasterizer.forward(drawing), Options())
    worth = context.mse(drawing.layer_subset([0]))
    assert needed_layers(context, drawing, worth / 0.6, np.ones(2, bool)).num_layers == 0
    assert needed_layers(context, drawing, worth / 1.2, np.ones(2, bool)).num_layers == 2
