#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Five hundred strokes painted onto a photograph: centre lines, widths and colours by Adam.

The picture is scikit-image's astronaut, at 128 px. Strokes begin at random places, in the picture's colours there.
Writes the SVG to the folder given, or to a new one; takes some seconds.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import skimage.data

import livecl
from livecl.drawing import Strokes
from livecl.image.reading import as_image
from livecl.image.resizing import reduced
from livecl.training.adam import Adam

SIZE, STROKES, STEPS = 128, 500, 60
WIDTHS = (1.0, 9.0)


def random_strokes(image: np.ndarray, rng: np.random.Generator) -> livecl.Drawing:
    """Return curves at random places, the wider ones beneath."""
    starts = rng.uniform(0, SIZE, (STROKES, 2))
    steps = rng.normal(0, 5, (STROKES, 3, 2))
    points = starts[:, None] + np.concatenate([np.zeros((STROKES, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    rows, columns = np.clip(points[:, 1:3].mean(axis=1)[:, ::-1].astype(int), 0, SIZE - 1).T
    ends = np.repeat(points[:, 3:], 3, axis=1)
    return livecl.Drawing.from_outlines(
        [[np.stack([curve, end])] for curve, end in zip(points[:, :3], ends, strict=True)],
        np.column_stack([image[rows, columns], np.full(STROKES, 0.9)]),
        (SIZE, SIZE),
        strokes=Strokes(widths=np.linspace(*WIDTHS[::-1], STROKES), caps=1, joins=1, is_open=np.ones(STROKES, bool)),
    )


def main(output: Path) -> None:
    """Paint the photograph into a file of `output`."""
    image = reduced(as_image(skimage.data.astronaut()), (SIZE, SIZE))
    drawing = random_strokes(image, np.random.default_rng(0))
    rasterizer = livecl.Rasterizer(drawing.size)
    points, colors, widths = (
        Adam.start(array.shape) for array in (drawing.points, drawing.colors, drawing.strokes.widths)
    )
    weight = np.full((SIZE, SIZE), 1 / image.size)
    before = np.mean((rasterizer.forward(drawing) - image) ** 2)
    for _ in range(STEPS):
        _, gradients = rasterizer.loss_and_gradients(drawing, image, weight)
        drawing = drawing.replace(
            points=drawing.points + points.step(gradients.points, 0.6),
            colors=np.clip(drawing.colors + colors.step(gradients.colors, 0.02), 0, 1),
            strokes=drawing.strokes.with_widths(
                np.clip(drawing.strokes.widths + widths.step(gradients.widths, 0.15), *WIDTHS)
            ),
        )
    after = np.mean((rasterizer.forward(drawing) - image) ** 2)
    drawing.save_svg(output / "strokes.svg")
    print(f"MSE {before:.2g} -> {after:.2g}: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
