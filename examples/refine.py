#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Refine a traced logo: outlines as a plain tracer finds them, on whole pixels, moved to where they are by the picture.

The tracer is scikit-image's `find_contours` on each colour of the logo, with corners thinned out: it knows pixels as
inside or outside, and so loses what anti-aliased edges say. All points are then trained on the picture at once. Writes
both drawings to the folder given, or to a new one; takes some seconds.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from skimage.measure import approximate_polygon, find_contours

import livecl
from livecl.training.adam import Adam

FOLDER = Path(__file__).resolve().parent
COLORS, COARSE = 5, 1.2
STEPS, RATE = 150, 0.3


def outlines_of(mask: np.ndarray) -> list[np.ndarray]:
    """Return the borders of a mask as closed runs of cubics: smooth where thinned-out points turn little."""
    outlines = []
    for contour in find_contours(np.pad(mask, 1).astype(float), 0.5):
        anchors = approximate_polygon(contour, COARSE)[:-1, ::-1] - 0.5  # (x, y); the padding, and pixel centres
        if len(anchors) < 3:
            continue
        before, after = anchors - np.roll(anchors, 1, axis=0), np.roll(anchors, -1, axis=0) - anchors
        turn = np.abs(np.angle((after @ [1, 1j]) / (before @ [1, 1j])))[:, None]
        along = np.where(turn < 0.8, (before + after) / 2, 0)  # tangents of a Catmull-Rom spline, none at corners
        ends, goes = np.roll(anchors, -1, axis=0), np.roll(along, -1, axis=0)
        outlines.append(np.stack([anchors, anchors + along / 3, ends - goes / 3], axis=1))
    return outlines


def traced(image: np.ndarray) -> livecl.Drawing:
    """Return a layer for each of the most frequent colours, the largest first."""
    colors, counts = np.unique((image * 255).round().reshape(-1, 3), axis=0, return_counts=True)
    colors = colors[np.argsort(-counts)[:COLORS]] / 255
    nearest = np.argmin(np.linalg.norm(image[:, :, None] - colors, axis=3), axis=2)
    layers = [outlines_of(nearest == index) for index in range(1, COLORS)]
    return livecl.Drawing.from_outlines(
        layers, np.column_stack([colors[1:], np.ones(COLORS - 1)]), nearest.shape, colors[0]
    )


def main(output: Path) -> None:
    """Trace the logo and refine the outlines, into files of `output`."""
    image = livecl.read_image(FOLDER / "logo.png")[:, :, :3]
    drawing = traced(image)
    drawing.save_svg(output / "traced.svg")

    rasterizer = livecl.Rasterizer(drawing.size)
    points, colors = Adam.start(drawing.points.shape), Adam.start(drawing.colors.shape)
    before = np.mean((rasterizer.forward(drawing) - image) ** 2)
    for step in range(STEPS):
        left = 1 - step / STEPS
        rendered, pullback = rasterizer.vjp(drawing)
        gradients = pullback(2 / image.size * (rendered - image))
        drawing = drawing.replace(
            points=drawing.points + points.step(gradients.points, RATE * left),
            colors=np.clip(drawing.colors + colors.step(gradients.colors, 0.01 * left), 0, 1),
        )
    after = np.mean((rasterizer.forward(drawing) - image) ** 2)
    drawing.save_svg(output / "refined.svg")
    print(f"MSE {before:.2g} -> {after:.2g}: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
