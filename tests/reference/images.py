# SPDX-License-Identifier: Apache-2.0
"""Render: coverage of every layer, then their paints one over the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from reference.composite import composite_forward
from reference.coverage import coverage
from reference.fill import layer_paints
from reference.flatten import flatten


def layer_coverages(drawing: Drawing, pieces: ArrayLike) -> NDArray[np.float64]:
    """Return the coverage of every layer: (N, H, W)."""
    layers = [coverage(outlines, drawing.size) for outlines in flatten(drawing, pieces)]
    return np.array(layers).reshape(drawing.num_layers, *drawing.size)


def render(drawing: Drawing, pieces: ArrayLike) -> NDArray[np.float64]:
    """Return the image: (H, W, 3), or premultiplied (H, W, 4) where there is no background."""
    colors = layer_paints(drawing) if drawing.fills.any_gradients else drawing.colors
    return composite_forward(layer_coverages(drawing, pieces), colors, drawing.background)[0]
