#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A photograph: many paths, few iterations, and a film of how the drawing came to be.

The picture is scikit-image's astronaut, at 128 px. Writes SVG and GIF to the folder given, or to a new one; takes some
seconds.
"""

import sys
import tempfile
from pathlib import Path

import skimage.data

import livecl
from livecl.image.reading import as_image
from livecl.image.resizing import reduced
from livecl.views.course import Course

SIZE = 128


def main(output: Path) -> None:
    """Vectorize the photograph into files of `output`."""
    image = reduced(as_image(skimage.data.astronaut()), (SIZE, SIZE))
    course = Course(every=10)
    options = livecl.Options(iterations=60, revisions=0)
    result = livecl.vectorize(image, paths=31, schedule="exp", options=options, on_step=course)
    result.save_svg(output / "photograph.svg")
    course.save_gif(output / "photograph.gif", result=result)
    for stage in result.stages:
        print(f"{stage.paths:3} paths, MSE {stage.mse:.4f}")
    print(output)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
