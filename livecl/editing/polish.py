# SPDX-License-Identifier: Apache-2.0
"""Short training of edited outlines that keeps their lines, smooth joins and shapes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.editing.constraints import Constraints
from livecl.layering.context import Context
from livecl.training.adam import Adam, settling

#: Steps, Adam's step at first, px, and share of it left at the end.
STEPS, RATE, LEFT = 60, 0.12, 0.1
#: Share of the largest gradient under which the picture does not decide on a coordinate: it stays as it is.
DECIDED = 2e-3


def polished(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> Drawing:
    """Return a drawing with the points of the layers that are `free`, (N,), trained under their constraints."""
    constraints = Constraints(drawing, free)
    rasterizer = context.rasterizer
    target, ones = rasterizer.upload(context.target), rasterizer.upload(np.ones(context.target.shape[:2]))
    coordinates, best = constraints.start, (np.inf, drawing.points)
    adam, still = Adam.start(coordinates.shape), np.zeros(coordinates.shape, bool)
    pieces = rasterizer.pieces(drawing)
    for step in range(STEPS + 1):
        context.check()
        points = constraints.points(coordinates)
        moved = drawing.moved(points, drawing.colors, drawing.background)
        loss, gradients = rasterizer.loss_and_gradients(moved, target, ones, pieces)
        if loss < best[0]:
            best = loss, points
        if not np.isfinite(gradients.points).all():
            break
        slopes = constraints.gradient(coordinates, gradients.points)
        if step == 0:
            still = np.abs(slopes) <= DECIDED * np.abs(slopes).max(initial=0.0)
        slopes[still] = 0
        coordinates = coordinates + adam.step(slopes, RATE * settling(step / STEPS, LEFT))
    return drawing.replace(points=best[1])
