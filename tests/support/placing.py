# SPDX-License-Identifier: Apache-2.0
"""Placement of paths on a drawing, as tests call it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl import Drawing, Options
from livecl.drawing.assembly import empty_drawing
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas
from livecl.layering.placement import Placement, place_paths

if TYPE_CHECKING:
    from livecl import Rasterizer

FloatArray = NDArray[np.float64]
RasterizerFor = Callable[[tuple[int, int], type], "Rasterizer"]


class Placer:
    """Places paths on a drawing, and renders, on one device."""

    def __init__(self, rasterizer_for: RasterizerFor) -> None:
        self._rasterizer_for = rasterizer_for

    def __call__(self, target: FloatArray, count: int, options: Options, seed: int = 0) -> Drawing:
        """Return the new layers on a blank canvas, bottom first."""
        placement = self.on(empty_drawing(target.shape[:2]), target, count, options, seed)
        return placement.drawing.layer_subset(placement.order)

    def on(self, drawing: Drawing, target: FloatArray, count: int, options: Options, seed: int = 0) -> Placement:
        """Return the new layers for a drawing, and their order."""
        rng = np.random.default_rng(seed)
        rasterizer = self._rasterizer_for(drawing.size, np.float32)
        return place_paths(Context(rasterizer, target, options), drawing, count, rng)

    def alphas(self, drawing: Drawing) -> FloatArray:
        """Return the alpha of each layer: (N, H, W)."""
        return layer_alphas(drawing, self._rasterizer_for(drawing.size, np.float32)).astype(np.float64)

    def error(self, target: FloatArray, drawing: Drawing) -> float:
        """Return the squared error of a drawing, summed over pixels and channels."""
        image = self._rasterizer_for(drawing.size, np.float32).forward(drawing).astype(np.float64)
        return float(np.square(target - image).sum())
