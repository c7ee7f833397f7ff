# SPDX-License-Identifier: Apache-2.0
"""Train edited outlines briefly, keeping their lines, smooth joins, shapes and borders."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.borders import border_pairs, paired_rows
from livecl.drawing.drawing import Drawing
from livecl.editing.constraints import Constraints
from livecl.layering.context import Context
from livecl.training.adam import Adam, settling
from livecl.training.borders import Borders
from livecl.training.step import MIN_WIDTH

#: Steps; Adam's first step, px, and the share of it left at the end.
STEPS, RATE, LEFT = 60, 0.12, 0.1
#: Share of the largest gradient below which a coordinate is undetermined by the picture, and stays.
DECIDED = 2e-3


def polished(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> Drawing:
    """Train the points of the layers that are `free`, (N,), under their constraints.

    Strokes around free fills follow them, and their widths are trained; other strokes stay as they are.
    """
    pairs = border_pairs(drawing)
    pairs = pairs[free[pairs[:, 0]]]
    borders, pens = Borders(*paired_rows(drawing, pairs)), pairs[:, 1]
    constraints = Constraints(drawing, free)
    rasterizer = context.rasterizer
    target, ones = rasterizer.upload(context.target), rasterizer.upload(np.ones(context.target.shape[:2]))
    coordinates, widths = constraints.start, drawing.strokes.widths.copy()
    best = np.inf, drawing.points, widths
    adam, still = Adam.start(coordinates.shape), np.zeros(coordinates.shape, bool)
    pen_adam = Adam.start(pens.shape)
    pieces = rasterizer.pieces(drawing)
    for step in range(STEPS + 1):
        interruption.check()
        points = constraints.points(coordinates)
        borders.restore(points)
        strokes = drawing.strokes.moved(widths)
        moved = drawing.moved(points, drawing.colors, drawing.background, strokes=strokes)
        loss, gradients = rasterizer.loss_and_gradients(moved, target, ones, pieces)
        if loss < best[0]:
            best = loss, points, widths
        if not np.isfinite(gradients.points).all():
            break
        borders.gather(gradients.points)
        slopes = constraints.gradient(coordinates, gradients.points)
        if step == 0:
            still = np.abs(slopes) <= DECIDED * np.abs(slopes).max(initial=0.0)
        slopes[still] = 0
        rate = RATE * settling(step / STEPS, LEFT)
        coordinates = coordinates + adam.step(slopes, rate)
        if len(pens) and gradients.widths is not None:
            widths = widths.copy()
            widths[pens] = np.maximum(widths[pens] + pen_adam.step(gradients.widths[pens], rate), MIN_WIDTH)
    return drawing.replace(points=best[1], strokes=drawing.strokes.with_widths(best[2]))
