#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The rasterizer alone, with a loss of one's own in NumPy: pictures are compared blurred, less and less so.

A drawing that was moved aside finds back: where shapes do not overlap their counterparts at once, a blurred difference
still tells the direction. The loss has to return its value and dL/dimage, and the rasterizer takes that on to control
points and colours. Writes SVGs before and after to the folder given, or to a new one; takes some seconds.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy import ndimage

import livecl
from livecl.training.adam import Adam

FOLDER = Path(__file__).resolve().parent
SHIFT = (6.0, -5.0)
STEPS, RATE, BLUR = 120, 0.8, 6.0


def blurred_loss(image: np.ndarray, target: np.ndarray, blur: float) -> tuple[float, np.ndarray]:
    """Mean squared difference of blurred pictures (H, W, 3), and its gradient.

    L = mean (G e)^2 with e = image - target and a Gaussian blur G, so dL/dimage = 2/n G^T G e. The blur is symmetric,
    and takes pixels outside for 0: G^T = G.
    """

    def filtered(pixels: np.ndarray) -> np.ndarray:
        return ndimage.gaussian_filter(pixels, (blur, blur, 0), mode="constant")

    error = filtered(image - target)
    return float(np.mean(error * error)), 2 / error.size * filtered(error)


def main(output: Path) -> None:
    """Move a drawing aside, and fit it to its picture again."""
    target = livecl.read_image(FOLDER / "face.png")
    options = livecl.Options(iterations=60, revisions=0)
    drawing = livecl.vectorize(target, schedule=(1, 1, 1, 1, 1, 1), options=options).drawing
    drawing = drawing.replace(points=drawing.points + SHIFT)
    drawing.save_svg(output / "before.svg")

    rasterizer = livecl.Rasterizer(drawing.size)
    adam = Adam.start(drawing.points.shape)
    before = np.mean((rasterizer.forward(drawing) - target) ** 2)
    for step in range(STEPS):
        left = 1 - step / STEPS
        _, d_image = blurred_loss(rasterizer.forward(drawing), target, BLUR * left)
        gradients = rasterizer.backward(d_image)
        drawing = drawing.replace(points=drawing.points + adam.step(gradients.points, RATE * left))
    drawing.save_svg(output / "after.svg")
    after = np.mean((rasterizer.forward(drawing) - target) ** 2)
    print(f"MSE {before:.2g} -> {after:.2g}: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
