# SPDX-License-Identifier: Apache-2.0
"""`Context`: target, rasterizer and options, as layering needs them."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.drawing import Drawing
from livecl.image.errors import mse, visible_error, visible_mse
from livecl.layering.regions import TargetPartitions
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer

if TYPE_CHECKING:
    from livecl.layering.drift import Changes


@dataclasses.dataclass(eq=False)
class Context:
    """Context of decisions about layers: rasterizer, target, options."""

    rasterizer: Rasterizer  # of the canvas's size
    target: NDArray[Any]  # target image (H, W, 3), or (H, W, 4) premultiplied where drawings have no background
    options: Options  # parameters of the method

    @functools.cached_property
    def partitions(self) -> TargetPartitions:
        """Partitions of the target, computed on first use."""
        return TargetPartitions(self.target, self.options.prune * 3 * self.target[..., 0].size)

    @functools.cached_property
    def changes(self) -> Changes:
        """Colour changes of the target from pixel to pixel, computed on first use."""
        from livecl.layering.drift import Changes  # loads SciPy

        return Changes.of(np.asarray(self.target, dtype=np.float64))

    @property
    def edge_offset(self) -> float:
        """Distance, px, that the target's edges may lie off, 0 if that is not known; see `layering.slack`."""
        return 0.0

    @functools.cached_property
    def slack(self) -> NDArray[np.float64]:
        """Errors (H, W, C) that the target's edges are uncertain by."""
        from livecl.layering.slack import edge_slack  # loads SciPy

        return edge_slack(np.asarray(self.target, dtype=np.float64), self.edge_offset)

    def priced_error(self, drawing: Drawing) -> float:
        """Return the sum of squared visible errors of a drawing, beyond what the target's edges are uncertain by.

        Numbers are weighed against it where two descriptions of the same edges compete, as a line and its outline.
        """
        error = np.asarray(self.rasterizer.forward(drawing), dtype=np.float64) - self.target
        beyond = np.sign(error) * np.maximum(np.abs(error) - self.slack, 0.0)
        return float(np.square(visible_error(beyond)).sum())

    def mse(self, drawing: Drawing) -> float:
        """Return the mean squared error of a drawing over pixels and channels, as reported."""
        interruption.check()
        return mse(self.rasterizer.forward(drawing), self.target)

    def visible_mse(self, drawing: Drawing) -> float:
        """Return the visible mean squared error of a drawing, by which all decisions are made.

        Over a background it equals the mean squared error.
        """
        interruption.check()
        return visible_mse(self.rasterizer.forward(drawing), self.target)
