# SPDX-License-Identifier: Apache-2.0
"""`Finisher`: scale a run's drawings to the picture's own canvas, group and cut their layers."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import scaled
from livecl.drawing.borders import border_pairs, paired_rows
from livecl.drawing.drawing import Drawing
from livecl.editing.cutout import cut_out
from livecl.image.background import TRAIN, WHITE, target_over
from livecl.image.errors import mse
from livecl.image.resizing import working_size
from livecl.layering.groups import GROUPING_SIDE, grouped
from livecl.rendering.rasterizer import Rasterizer
from livecl.rendering.single import render
from livecl.run.result import Result, Stage
from livecl.svg.outline_data import MAX_PRECISION
from livecl.svg.writer import primitives, quantize

#: Decimals to which a run rounds coordinates, and at which it measures errors.
VECTORIZED_PRECISION = 3


@dataclasses.dataclass(frozen=True, eq=False)
class Finisher:
    """Finishes the drawings of one picture."""

    target: NDArray[np.float32]  # (h, w, 3) or (h, w, 4), the image at the working size, straight
    size: tuple[int, int]  # height and width of the picture, px
    start: Drawing | None  # drawing to start from, on the picture's canvas
    lock: Sequence[int]  # layers of `start` that are not changed
    precision: int  # decimals kept of coordinates, px of the picture
    device: int | str | None  # OpenCL device

    def finished(self, result: Result, *, groups: bool, trap: float | None) -> Result:
        """Return a result on the picture's canvas, with errors measured again for drawings that differ from the run's.

        With `groups`, the last drawing is grouped by containment. With a `trap`, px of the picture, its layers are cut
        to overlap by that much; None leaves them whole.
        """
        *earlier, last = [self._enlarged(stage) for stage in result.stages]
        drawing = last.drawing
        if groups and (self.start is None or not self.start.num_layers):
            coarse = working_size(self.size, GROUPING_SIDE)
            drawing = grouped(drawing, Rasterizer(coarse, self.device).coverages(scaled(drawing, coarse)))
        if trap is not None:
            drawing = quantize(cut_out(drawing, trap), self.precision)
        stages = [*earlier, dataclasses.replace(last, drawing=drawing)]
        over_white = result.options.background == TRAIN
        if self.precision < VECTORIZED_PRECISION:
            stages = [self._measured(stage, over_white) for stage in stages]
        elif trap is not None:
            stages[-1] = self._measured(stages[-1], over_white)
        return self._with_stages(result, stages)

    def salvaged(self, result: Result) -> Result:
        """Return a result on the picture's canvas, without the device, which may have failed."""
        return self._with_stages(result, [self._enlarged(stage) for stage in result.stages])

    def _with_stages(self, result: Result, stages: Sequence[Stage]) -> Result:
        drawing, error = stages[-1].drawing, stages[-1].mse
        size = (self.target.shape[0], self.target.shape[1])
        return dataclasses.replace(result, drawing=drawing, mse=error, stages=tuple(stages), working_size=size)

    def _enlarged(self, stage: Stage) -> Stage:
        drawing = enlarged_drawing(stage.drawing, self.size, self.start, self.lock)
        return dataclasses.replace(stage, drawing=quantize(drawing, self.precision))

    def _measured(self, stage: Stage, over_white: bool) -> Stage:
        """Return a stage with the error of its drawing at the working size."""
        drawing, size = stage.drawing, (self.target.shape[0], self.target.shape[1])
        ground = WHITE if over_white else drawing.background
        error = mse(render(scaled(drawing, size), self.device), target_over(self.target, ground))
        return dataclasses.replace(stage, mse=error)


def enlarged_drawing(drawing: Drawing, size: tuple[int, int], start: Drawing | None, lock: Sequence[int]) -> Drawing:
    """Return a drawing on the picture's canvas, with the locked layers' points taken from `start`.

    Points scaled down, rounded and scaled up again would differ from these.
    """
    enlarged = scaled(drawing, size)
    if enlarged is drawing:
        return enlarged
    points = enlarged.points.copy()
    factors = np.array(size[::-1]) / drawing.size[::-1]
    for layer, shape in primitives(drawing, MAX_PRECISION).items():  # as the factors of x and y differ slightly
        larger = shape.scaled(factors)
        own = slice(*drawing.segment_offsets[layer : layer + 2])
        if larger is not None and larger.points.shape == points[own].shape:
            points[own] = larger.points
    fill_rows, stroke_rows = paired_rows(drawing, border_pairs(drawing))
    points[stroke_rows] = points[fill_rows]
    if start is None:
        return enlarged.replace(points=points)
    smaller = quantize(scaled(start, drawing.size))
    for layer in lock:
        own = slice(*smaller.segment_offsets[layer : layer + 2])
        for first, end in itertools.pairwise(drawing.segment_offsets):
            if np.array_equal(drawing.points[first:end], smaller.points[own]):
                points[first:end] = start.points[own]
    return enlarged.replace(points=points)
