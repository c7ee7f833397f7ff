# SPDX-License-Identifier: Apache-2.0
"""Work that uses every kernel, as a digest of its bytes: what tests of devices in trouble compare.

As a program it prints the digest of each case that is named, in both number types where the device has them.
"""

from __future__ import annotations

import hashlib
import logging
import sys

import numpy as np
from drawings import ALL_CASES, Case

from livecl import Rasterizer
from livecl.pipeline import DistanceWeight


def everything(rasterizer: Rasterizer, case: Case) -> str:
    """Return a digest of all that a rasterizer can be asked for: image, coverages, distance weight, gradients."""
    drawing, pieces = case.drawing, case.pieces
    image = rasterizer.forward(drawing, pieces)
    gradients = [rasterizer.backward(np.linspace(-1, 1, image.size).reshape(image.shape))]
    weighted = rasterizer.distance_weight(drawing, 6.0, pieces)
    parts = [image, rasterizer.coverages(drawing, pieces), weighted]
    for weight in (np.ones(image.shape[:2]), DistanceWeight(6.0, pieces)):
        loss, gradient = rasterizer.loss_and_gradients(drawing, np.full_like(image, 0.5), weight, pieces)
        parts.append(np.array(loss))
        gradients.append(gradient)
    for gradient in gradients:
        parts += [gradient.points, gradient.colors]
    return hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in parts)).hexdigest()


def main(names: list[str]) -> None:
    """Print the digests of cases; of the bands of strips too, in which large drawings are worked on."""
    logging.basicConfig(format="%(levelname)s: %(message)s")
    for name in names:
        case = ALL_CASES[name]()
        for dtype in (np.float32, np.float64):
            for max_tiles in (1 << 17, 1):
                rasterizer = Rasterizer(case.drawing.size, dtype=dtype, max_tiles=max_tiles)
                print(name, dtype.__name__, max_tiles, everything(rasterizer, case), flush=True)  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1:])
