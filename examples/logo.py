#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A logo: few flat colours, one path each, refined until the error is low enough.

Writes the SVG, a page to look through it (``logo.html``) and its stages side by side to the folder given, or to a new
one; takes some seconds.
"""

import sys
import tempfile
from pathlib import Path

import livecl
from livecl.views.report.page import write_report
from livecl.views.sheet import save_sheet

FOLDER = Path(__file__).resolve().parent


def main(output: Path) -> None:
    """Vectorize the logo into files of `output`."""
    image = livecl.read_image(FOLDER / "logo.png")
    # Flat colours are opaque; no further stage begins once the error is that of rounding to 8 bits or so.
    options = livecl.Options(iterations=60, opacity="opaque", target_mse=2e-5)
    result = livecl.vectorize(image, paths=12, options=options)
    result.save_svg(output / "logo.svg")
    save_sheet(output / "stages.png", image, result)
    write_report(output / "logo.html", image, result, name="logo.png")
    print(f"{result.drawing.num_layers} paths, MSE {result.mse:.2g}, {len(result.svg)} bytes: {output}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="livecl-")))
