#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A sketch of sixteen strokes: ink laid where the edges of a picture are, under a blurred loss.

Ink and edges are compared blurred, less and less so: a stroke feels edges that it does not touch yet, and ends on them.
Strokes begin on the strongest edges that none is near. Writes the SVG to the folder given, or to a new one; takes some
seconds.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from custom_loss import blurred_loss
from scipy import ndimage

import livecl
from livecl.drawing import Strokes
from livecl.training.adam import Adam

FOLDER = Path(__file__).resolve().parent
STROKES, STEPS, RATE, BLUR = 16, 250, 1.2, 5.0
WIDTH, CURVES = 3.0, 4


def ink_of_edges(image: np.ndarray) -> np.ndarray:
    """Return paper (H, W, 3) with ink where the picture's colours change, darker where they change more."""
    smooth = ndimage.gaussian_filter(image, (1.5, 1.5, 0))
    change = np.sqrt(sum(ndimage.sobel(smooth, axis) ** 2 for axis in (0, 1)).sum(axis=2))
    ink = np.clip(1.5 * np.sqrt(change / change.max()) - 0.3, 0, 1)
    return np.repeat(1 - ink[:, :, None], 3, axis=2)


def first_strokes(target: np.ndarray) -> livecl.Drawing:
    """Return strokes along the strongest edges, each a curve of CURVES cubics, as a layer of its own."""
    ink = 1 - target[:, :, 0]
    left = ndimage.gaussian_filter(ink, 2)
    y, x = np.indices(ink.shape)
    reach = ink.sum() / WIDTH / STROKES / 2  # px, of a stroke
    lines = []
    for _ in range(STROKES):
        row, column = np.unravel_index(np.argmax(left), left.shape)
        near = np.hypot(x - column, y - row) < reach / 4
        weights, places = (ink * near)[near], np.stack([x, y], axis=2)[near] + 0.5
        middle = np.average(places, axis=0, weights=weights)
        along = np.linalg.svd(np.sqrt(weights)[:, None] * (places - middle), full_matrices=False)[2][0]
        steps = np.linspace(-0.5, 0.5, 3 * CURVES + 1) * reach
        points = np.array([column, row]) + 0.5 + steps[:, None] * along
        lines.append(np.concatenate([points[:-1].reshape(-1, 3, 2), np.repeat(points[None, -1:], 3, axis=1)]))
        left = left * (1 - np.exp(-(((x - column) ** 2 + (y - row) ** 2) / (2 * (reach / 2) ** 2))))
    pen = Strokes(widths=np.full(STROKES, WIDTH), caps=1, joins=1, is_open=np.ones(STROKES, bool))
    return livecl.Drawing.from_outlines([[line] for line in lines], (0.1, 0.1, 0.15, 1), ink.shape, strokes=pen)


def main(output: Path) -> None:
    """Sketch the face into a file of `output`."""
    target = ink_of_edges(livecl.read_image(FOLDER / "face.png"))
    drawing = first_strokes(target)
    rasterizer = livecl.Rasterizer(drawing.size)
    points, widths = Adam.start(drawing.points.shape), Adam.start(drawing.strokes.widths.shape)
    before = np.mean((rasterizer.forward(drawing) - target) ** 2)
    for step in range(STEPS):
        left = 1 - step / STEPS
        image, pullback = rasterizer.vjp(drawing)
        gradients = pullback(blurred_loss(image, target, BLUR * left + 0.5)[1])
        drawing = drawing.replace(
            points=drawing.points + points.step(gradients.points, RATE * left),
            strokes=drawing.strokes.with_widths(
                np.clip(drawing.strokes.widths + widths.step(gradients.widths, 0.1 * left), 1.5, 6)
            ),
        )
    after = np.mean((rasterizer.forward(drawing) - target) ** 2)
    drawing.save_svg(output / "sketch.svg")
    print(f"MSE {before:.2g} -> {after:.2g}: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
