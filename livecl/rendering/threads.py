# SPDX-License-Identifier: Apache-2.0
"""Per-thread state of a rasterizer: buffers, kernels, and the drawing rendered last."""

from __future__ import annotations

import dataclasses
import threading
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from livecl.drawing.drawing import WANTED_DRAWING, Drawing
from livecl.errors import check_type
from livecl.opencl.device import OpenDevice
from livecl.opencl.launcher import Launcher
from livecl.rendering.pipeline import Pipeline
from livecl.rendering.stacks import Stack
from livecl.rendering.strokes import Filled
from livecl.rendering.tiling import Grid


def channels_of(drawing: Drawing) -> int:
    """Return the number of channels of a drawing's image: 3, or 4 without a background.

    Raises TypeError if it is no drawing.
    """
    check_type("drawing", drawing, Drawing, WANTED_DRAWING)
    return 4 if drawing.background is None else 3


class Workspace(threading.local):
    """The pipelines of a canvas, created on first use, separately for each thread.

    Parameters
    ----------
    opened : OpenDevice
        The device, which all threads share.
    grid : Grid
        Strips and tiles of the canvas.
    dtype : float32 or float64
        Number type of the kernels.
    tolerance, max_tiles
        As :class:`livecl.rendering.pipeline.Pipeline` takes them.
    """

    def __init__(self, opened: OpenDevice, grid: Grid, dtype: np.dtype[Any], tolerance: float, max_tiles: int) -> None:
        self._opened, self._grid, self._dtype = opened, grid, dtype
        self._tolerance, self._max_tiles = tolerance, max_tiles
        self._pipelines: dict[tuple[int, bool, bool], tuple[int, Pipeline]] = {}
        self.rendered: tuple[Filled, ArrayLike | None] | None = None

    def pipeline(self, channels: int, fills: bool = False, count: int = 1) -> Pipeline:
        """Return the pipeline for a number of channels, for drawings with gradient fills or without.

        For batches, only the pipeline of the last number of drawings, `count`, is kept.
        """
        kind = channels, fills, count > 1
        last, pipeline = self._pipelines.get(kind, (0, None))
        if pipeline is None or last != count:
            launcher = Launcher(self._opened, self._dtype, channels, fills)
            grid = dataclasses.replace(self._grid, count=count)
            pipeline = Pipeline(launcher, grid, self._tolerance, self._max_tiles)
            self._pipelines[kind] = count, pipeline
        return pipeline

    def loaded(self, drawing: Drawing, stack: Stack | None = None) -> Pipeline:
        """Return the drawing's pipeline after loading the drawing, or that of a stack."""
        count = 1 if stack is None else stack.count
        pipeline = self.pipeline(channels_of(drawing), drawing.fills.any_gradients, count)
        pipeline.load(drawing, stack if count > 1 else None)
        return pipeline

    def forget(self) -> None:
        """Release all buffers of this thread."""
        self._pipelines.clear()
