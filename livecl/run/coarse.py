# SPDX-License-Identifier: Apache-2.0
"""Coarse to fine: a picture placed by regions is drawn on as many pixels as its paths need, then polished on all."""

from __future__ import annotations

import dataclasses
import math
import time

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.editing.polish import polished
from livecl.image.background import TRAIN, WHITE, target_over
from livecl.image.resizing import reduced, working_size
from livecl.interruption import interruptible
from livecl.layering.context import Context
from livecl.rendering.rasterizer import Rasterizer
from livecl.run.beginning import Beginning
from livecl.run.control import Stopped
from livecl.run.finishing import enlarged_drawing
from livecl.run.progress import Progress
from livecl.run.result import Result
from livecl.svg import quantize

#: Fewest pixels that a run begins on: 240 x 240. Numbers of a drawing are priced for pictures of that size and more.
LEAST_PIXELS = 57600
#: Least factor by which fewer pixels are worth the steps on all of them that follow.
LEAST_REDUCTION = 2.0


def coarse_size(progress: Progress, size: tuple[int, int]) -> tuple[int, int]:
    """Return the height and width, px, on which a run that begins so draws a picture of a size.

    `Options.pixels_per_path` for each path that it may add. A run from a drawing, and one that is not placed by
    regions, is on all pixels from its beginning.
    """
    options = progress.state.options
    if options.placement != "region" or progress.start_drawing is not None or not options.pixels_per_path:
        return size
    wanted = max(LEAST_PIXELS, options.pixels_per_path * sum(progress.schedule))
    if size[0] * size[1] < LEAST_REDUCTION * wanted:
        return size
    return working_size(size, round(math.sqrt(wanted)))


def coarsened(
    image: NDArray[np.float32], beginning: Beginning, progress: Progress
) -> tuple[NDArray[np.float32], Progress]:
    """Return the pixels that a run begins on, and its progress before the first stage there."""
    size = coarse_size(progress, (image.shape[0], image.shape[1]))
    if size == progress.state.drawing.size:
        return image, progress
    smaller = reduced(image, size)
    return smaller, dataclasses.replace(beginning, options=progress.state.options).progress(smaller)


def enlarged(result: Result, size: tuple[int, int]) -> Result:
    """Return a result with its drawings on a canvas of another size, its errors as they were measured."""
    stages = [dataclasses.replace(stage, drawing=_on(stage.drawing, size)) for stage in result.stages]
    return dataclasses.replace(result, drawing=stages[-1].drawing, stages=tuple(stages))


def refined(result: Result, image: NDArray[np.float32], device: int | str | None) -> Result:
    """Return a result on all pixels of a picture (H, W, C): the last drawing polished, all errors measured there.

    A run that has been stopped, or is stopped meanwhile, is not polished.
    """
    size, begin = (image.shape[0], image.shape[1]), time.perf_counter()
    result = enlarged(result, size)
    ground = WHITE if result.options.background == TRAIN else result.drawing.background
    context = Context(Rasterizer(size, device), target_over(image, ground), result.options)
    drawing, stopped = result.drawing, result.stopped
    if stopped is None:
        try:
            found = quantize(polished(context, drawing, np.ones(drawing.num_layers, bool)))
            drawing = found if context.visible_mse(found) < context.visible_mse(drawing) else drawing
        except Stopped as stop:
            stopped = stop.reason
    with interruptible(None):
        stages = [dataclasses.replace(stage, mse=context.mse(stage.drawing)) for stage in result.stages[:-1]]
        error = context.mse(drawing)
    seconds = time.perf_counter() - begin
    last = result.stages[-1]
    stages.append(dataclasses.replace(last, drawing=drawing, mse=error, seconds=last.seconds + seconds))
    return dataclasses.replace(
        result,
        drawing=drawing,
        mse=error,
        stages=tuple(stages),
        seconds=result.seconds + seconds,
        stopped=stopped,
    )


def _on(drawing: Drawing, size: tuple[int, int]) -> Drawing:
    return quantize(enlarged_drawing(drawing, size, None, ()))
