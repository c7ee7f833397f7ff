# SPDX-License-Identifier: Apache-2.0
"""Which layers do least for the picture: those that a revision takes out and places anew, and those worth nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import Drawing
from livecl.metrics import layer_alphas, removal_changes
from livecl.rasterizer import Rasterizer
from livecl.transparency import mse_seen


def needed_layers(
    drawing: Drawing, rasterizer: Rasterizer, target: NDArray[Any], least: float, free: NDArray[np.bool_]
) -> Drawing:
    """Return the drawing without layers of opacity 0, and without those that lower the error by less than `least`.

    Only layers that are `free`, (N,) bool, are left out.

    They are taken away one by one, the least useful first, as two that hide each other are not both needless; and again
    as long as there are any, as what mended a layer may be needless without it.
    """
    shown = ~free | (drawing.colors[:, 3] > 0)
    drawing, free = drawing.layer_subset(shown), free[shown]
    if least <= 0 or not drawing.num_layers:
        return drawing
    error = mse_seen(rasterizer.forward(drawing), target)
    while True:
        changes = np.where(free, removal_changes(drawing, layer_alphas(drawing, rasterizer), target, seen=True), np.inf)
        kept = np.ones(len(changes), bool)
        for layer in np.argsort(changes, kind="stable")[: int(np.sum(changes < least))]:
            kept[layer] = False
            without = mse_seen(rasterizer.forward(drawing.layer_subset(kept)), target)
            if without - error < least:
                error = without
            else:
                kept[layer] = True
        if kept.all():
            return drawing
        drawing, free = drawing.layer_subset(kept), free[kept]


def least_useful(drawing: Drawing, rasterizer: Rasterizer, target: NDArray[Any]) -> NDArray[np.intp]:
    """Return the layers in the order of what the picture loses without them, the least first: (N,)."""
    changes = removal_changes(drawing, layer_alphas(drawing, rasterizer), target, seen=True)
    return np.argsort(changes, kind="stable")
