#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An optimizer from SciPy on the rasterizer's gradients: L-BFGS with bounds, in double precision.

Coverage is exact and its gradient is derived, without noise of samples, so that line searches work. The numbers of
lines that curves are flattened into are held fixed meanwhile (`pieces`): a change would make the picture jump, which no
gradient sees. Writes the SVG to the folder given, or to a new one; takes some seconds.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import scipy.optimize

import livecl
from livecl.drawing.drawing import Drawing
from livecl.svg import quantize

FOLDER = Path(__file__).resolve().parent


def refined(drawing: Drawing, image: np.ndarray, iterations: int) -> tuple[Drawing, scipy.optimize.OptimizeResult]:
    """Optimize control points and colours by L-BFGS; return the drawing and SciPy's result."""
    rasterizer = livecl.Rasterizer(drawing.size, dtype=np.float64)
    pieces, count = rasterizer.pieces(drawing), drawing.points.size

    def drawing_of(numbers: np.ndarray) -> Drawing:
        return drawing.replace(points=numbers[:count].reshape(-1, 3, 2), colors=numbers[count:].reshape(-1, 4))

    def loss_and_gradient(numbers: np.ndarray) -> tuple[float, np.ndarray]:
        error = rasterizer.forward(drawing_of(numbers), pieces) - image
        gradients = rasterizer.backward(2 * error / error.size)
        return float(np.mean(error * error)), np.concatenate([gradients.points.ravel(), gradients.colors.ravel()])

    start = np.concatenate([drawing.points.ravel(), drawing.colors.ravel()])
    bounds = [(None, None)] * count + [(0, 1)] * drawing.colors.size
    found = scipy.optimize.minimize(
        loss_and_gradient, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": iterations}
    )
    return drawing_of(found.x), found


def main(output: Path) -> None:
    """Start from a short run, and go on with SciPy."""
    image = livecl.read_image(FOLDER / "face.png")
    start = livecl.vectorize(
        image,
        schedule=(1, 1, 1, 1, 1, 1),
        options=livecl.Options(iterations=4, revisions=0, placement="region", simplify=False),
    )
    drawing, found = refined(start.drawing, image, iterations=60)
    quantize(drawing).save_svg(output / "face.svg")
    print(f"MSE {start.mse:.2g} -> {found.fun:.2g} in {found.nfev} evaluations: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
