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
from livecl.layering.pruning import needed_layers

SIZE = (40, 40)
#: Edges lie in the middle of pixels: two of them make their rims darker than one.
SQUARE = drawings.rectangle(4.5, 4.5, 20.5, 20.5)
RED = (1.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("other", "left"),
    [(SQUARE, {0.5: 1, 2: 1, 20: 2}), (drawings.rectangle(24.5, 4.5, 32.5, 12.5), {0.5: 1, 2: 2, 20: 2})],
    ids=["hidden", "seen"],
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
