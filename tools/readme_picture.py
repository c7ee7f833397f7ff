#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Make the README's picture, ``docs/face.png``: a sample beside its drawing after each stage, as resvg shows it."""

import sys
from pathlib import Path

import numpy as np
import resvg_py

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import livecl
from livecl.image.reading import save_image
from livecl.svg import format_svg

ROOT = Path(__file__).resolve().parent.parent
SCHEDULE = (1, 1, 1, 1, 1, 1)
#: Pixels averaged into one, both ways: the size that fits beside text.
SHRINK = 2


def main() -> None:
    """Vectorize the face and save the row of pictures."""
    target = livecl.read_image(ROOT / "examples" / "face.png")
    result = livecl.vectorize(target, schedule=SCHEDULE)
    stages = [livecl.read_image(bytes(resvg_py.svg_to_bytes(format_svg(stage.drawing)))) for stage in result.stages]
    row = np.concatenate([target, *stages], axis=1)
    height, width = (side // SHRINK for side in row.shape[:2])
    save_image(ROOT / "docs" / "face.png", row.reshape(height, SHRINK, width, SHRINK, 3).mean(axis=(1, 3)))
    print(f"MSE {result.mse:.3g}, {result.seconds:.1f} s")


if __name__ == "__main__":
    main()
