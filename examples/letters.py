#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Letters that morph: one pen stroke becomes L, I, V and U in turn, pulled by a blurred loss alone.

Nobody says which point goes where: the stroke follows the picture of the next letter, seen blurred, less and less so.
All letters are sought at a time, as a batch; each starts from the letter before. Writes the letters and what lies
between them, in a row, to the folder given, or to a new one; takes some seconds.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from custom_loss import blurred_loss

import livecl
from livecl.drawing import Strokes
from livecl.drawing.assembly import concatenate, empty_drawing, stretched
from livecl.training.adam import Adam

SIZE, WIDTH, SEGMENTS = 64, 6.0, 10
STEPS, RATE, BLUR, FRAMES = 160, 0.7, 9.0, 4
#: Corners of each letter, the way a pen goes.
LETTERS = {
    "L": [(20, 10), (20, 54), (46, 54)],
    "I": [(32, 10), (32, 54)],
    "V": [(14, 10), (32, 54), (50, 10)],
    "U": [(16, 10), (16, 44), (24, 54), (40, 54), (48, 44), (48, 10)],
}


def letter(corners: list[tuple[float, float]]) -> livecl.Drawing:
    """Return the stroke through corners, as SEGMENTS cubics of equal lengths."""
    places = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    steps = np.linspace(0, places[-1], 3 * SEGMENTS + 1)
    points = np.stack([np.interp(steps, places, np.array(corners, float)[:, axis]) for axis in (0, 1)], axis=1)
    rows = np.concatenate([points[:-1].reshape(-1, 3, 2), np.repeat(points[None, -1:], 3, axis=1)])
    pen = Strokes(widths=[WIDTH], caps=1, joins=1, is_open=np.array([True]))
    return livecl.Drawing.from_outlines([[rows]], (0.1, 0.2, 0.5, 1), (SIZE, SIZE), strokes=pen)


def main(output: Path) -> None:
    """Morph the letters into a file of `output`."""
    ends = [letter(corners) for corners in LETTERS.values()]
    rasterizer = livecl.Rasterizer((SIZE, SIZE))
    targets = rasterizer.forward_all(ends[1:] + ends[:1])  # each letter becomes the next one
    drawings = list(ends)
    adam = Adam.start((len(drawings), *drawings[0].points.shape))
    before = np.mean((rasterizer.forward_all(drawings) - targets) ** 2)
    rows = [list(drawings)]
    for step in range(STEPS):
        left = 1 - step / STEPS
        images, pullback = rasterizer.vjp_all(drawings)
        d_images = [
            blurred_loss(image, target, BLUR * left + 0.5)[1] for image, target in zip(images, targets, strict=True)
        ]
        moves = adam.step(np.stack([gradients.points for gradients in pullback(d_images)]), RATE * left)
        drawings = [
            drawing.replace(points=drawing.points + move) for drawing, move in zip(drawings, moves, strict=True)
        ]
        if (step + 1) % (STEPS // FRAMES) == 0:
            rows.append(drawings)
    after = np.mean((rasterizer.forward_all(drawings) - targets) ** 2)

    size = (SIZE * len(ends), SIZE * len(rows))
    sheet = empty_drawing(size)
    for column, frames in enumerate(rows):
        for row, drawing in enumerate(frames):
            sheet = concatenate(sheet, stretched(drawing, 1, size, (SIZE * column, SIZE * row)))
    sheet.save_svg(output / "letters.svg")
    print(f"MSE {before:.2g} -> {after:.2g}: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
