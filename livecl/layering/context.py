# SPDX-License-Identifier: Apache-2.0
"""`Context`: the picture wanted, the rasterizer and the options, as layering needs them."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.image.errors import mse, visible_mse
from livecl.layering.regions import TargetPartitions
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer

if TYPE_CHECKING:
    from livecl.layering.drift import Changes


@dataclasses.dataclass(eq=False)
class Context:
    """Surroundings of a decision about layers."""

    rasterizer: Rasterizer  # one of the canvas's size
    target: NDArray[Any]  # (H, W, 3), or (H, W, 4) premultiplied where drawings have no background: the picture wanted
    options: Options  # parameters of the method

    @functools.cached_property
    def partitions(self) -> TargetPartitions:
        """Partitions of the target, made when they are first asked for."""
        return TargetPartitions(self.target, self.options.prune * 3 * self.target[..., 0].size)

    @functools.cached_property
    def changes(self) -> Changes:
        """Changes of the target's colour from pixel to pixel, found when they are first asked for."""
        from livecl.layering.drift import Changes  # loads SciPy

        return Changes.of(np.asarray(self.target, dtype=np.float64))

    def mse(self, drawing: Drawing) -> float:
        """Return the mean squared error of a drawing over pixels and channels, as reported."""
        return mse(self.rasterizer.forward(drawing), self.target)

    def visible_mse(self, drawing: Drawing) -> float:
        """Return the visible mean squared error of a drawing, which all decisions compare.

        Over a background it is the mean squared error.
        """
        return visible_mse(self.rasterizer.forward(drawing), self.target)
