# SPDX-License-Identifier: Apache-2.0
"""Pruning: remove layers that contribute too little, and rank layers by contribution for a revision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.drawing import Drawing
from livecl.layering.context import Context
from livecl.layering.contributions import VISIBLE_SHARE, layer_alphas, removal_changes, visible_shares

#: Share of visible pixels below which a layer counts as hidden.
HIDDEN_SHARE = 0.01
#: Hidden layers are pruned below this multiple of `prune`: they only mend the rims of the layers above. With 10, 40
#: faces have 260 instead of 264 layers at an error of .000532 instead of .000531 (docs/notes/quality.md).
HIDDEN_FACTOR = 10


def needed_layers(context: Context, drawing: Drawing, least: float, free: NDArray[np.bool_]) -> Drawing:
    """Remove layers of opacity 0, and layers that lower the mean squared error by less than `least`.

    Hidden layers must lower it by more (`HIDDEN_FACTOR`). Only `free` layers, (N,) bool, are removed. They are removed
    one by one, the least useful first, as of two that hide each other only one is needless; and repeatedly, as a layer
    that corrected another may become needless without it.
    """
    shown = ~free | (drawing.colors[:, 3] > 0)
    drawing, free = drawing.layer_subset(shown), free[shown]
    if least <= 0 or not drawing.num_layers:
        return drawing
    error = context.visible_mse(drawing)
    while True:
        interruption.check()
        alphas = layer_alphas(drawing, context.rasterizer)
        changes = np.where(free, removal_changes(drawing, alphas, context.target, seen=True), np.inf)
        wanted = np.where(_hidden(alphas), HIDDEN_FACTOR * least, least)
        kept = np.ones(len(changes), bool)
        for layer in np.argsort(changes - wanted, kind="stable")[: int(np.sum(changes < wanted))]:
            interruption.check()
            kept[layer] = False
            without = context.visible_mse(drawing.layer_subset(kept))
            if without - error < wanted[layer]:
                error = without
            else:
                kept[layer] = True
        if kept.all():
            return drawing
        drawing, free = drawing.layer_subset(kept), free[kept]


def _hidden(alphas: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which layers of alphas (N, H, W) are all but covered by those above; no translucent ones: (N,)."""
    shown, covered = _visible_pixels(visible_shares(alphas)), _visible_pixels(alphas)
    return np.asarray(shown < HIDDEN_SHARE * covered)


def _visible_pixels(shares: NDArray[Any]) -> NDArray[np.int64]:
    """Return in how many pixels each of shares (N, H, W) is visible: (N,)."""
    counts = np.zeros(len(shares), np.int64)
    for layer, share in enumerate(shares):
        interruption.check()
        counts[layer] = np.count_nonzero(share > VISIBLE_SHARE)
    return counts


def least_useful(context: Context, drawing: Drawing) -> NDArray[np.intp]:
    """Return the indices of the layers by the rise of the error without them, smallest first: (N,)."""
    changes = removal_changes(drawing, layer_alphas(drawing, context.rasterizer), context.target, seen=True)
    return np.argsort(changes, kind="stable")
