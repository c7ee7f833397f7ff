# SPDX-License-Identifier: Apache-2.0
"""Fit strokes to their ink: a short training of centre lines and widths, before strokes and shapes are compared.

A line found on a skeleton is off by some tenths of a pixel, and by more at corners and junctions. What it misses then
says little of what a trained one misses: on icons looked into, sums of squares of 280 to 700, of about .2 to 4 after
the fit (docs/notes/quality.md).
"""

from __future__ import annotations

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.drawing import Drawing
from livecl.rendering.rasterizer import Rasterizer
from livecl.training.adam import Adam, settling
from livecl.training.step import MIN_WIDTH, PIECES_PERIOD
from livecl.training.ties import Ties

#: Steps of the fit, their first length, px, and the share of it that is left at the end.
STEPS, RATE, SETTLE = 60, 0.5, 0.1


def fitted_to_ink(
    rasterizer: Rasterizer, strokes: Drawing, coverage: FloatArray, strengths: FloatArray, seen: FloatArray
) -> Drawing:
    """Return the strokes of one ink, moved to where they cover it best.

    Parameters
    ----------
    rasterizer : Rasterizer
        Of the canvas's size.
    strokes : Drawing
        The strokes, K layers.
    coverage : (H, W) float
        Coverage of the ink.
    strengths : (K,) float
        Coverage of the ink in the middle of each layer's lines.
    seen : (H, W) float
        Weight of each pixel: less where another ink lies above.
    """
    shades = np.column_stack([np.repeat(strengths[:, None], 3, axis=1), np.ones(len(strengths))])
    drawing = strokes.replace(colors=shades, background=np.zeros(3))
    target, weight = rasterizer.upload(np.repeat(coverage[..., None], 3, axis=2)), rasterizer.upload(seen)
    points, widths = Adam.start(drawing.points.shape), Adam.start((drawing.num_layers, 1))
    pieces, ties = rasterizer.pieces(drawing), Ties.of(drawing)
    for step in range(STEPS):
        interruption.check()
        if step % PIECES_PERIOD == 0:
            pieces = np.maximum(pieces, rasterizer.pieces(drawing))
        _, gradients = rasterizer.loss_and_gradients(drawing, target, weight, pieces)
        assert gradients.widths is not None
        rate = RATE * settling(step / STEPS, SETTLE)
        ties.gather(gradients.points)
        moved = drawing.points + points.step(gradients.points, rate)
        ties.restore(moved)
        wide = np.maximum(drawing.strokes.widths + widths.step(gradients.widths[:, None], rate)[:, 0], MIN_WIDTH)
        drawing = drawing.moved(moved, drawing.colors, drawing.background, None, drawing.strokes.moved(wide))
    return drawing.replace(colors=strokes.colors, background=strokes.background)
