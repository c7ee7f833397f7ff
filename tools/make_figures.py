#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Make the figures of the README, the tutorial, the method, the options and interpolation: docs/figures/NAME.png.

Needs the extra `plots`. All of them take a few minutes.
"""

import argparse
from pathlib import Path

from figures import blending, method, options, tutorial

FIGURES = {**blending.FIGURES, **method.FIGURES, **tutorial.FIGURES, **options.FIGURES}
FOLDER = Path(__file__).resolve().parent.parent / "docs" / "figures"


def main() -> None:
    """Make the figures named, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"figures to make (all): {', '.join(FIGURES)}")
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, metavar="DIR", help="folder (docs/figures)")
    arguments = parser.parse_args()
    if unknown := set(arguments.names) - set(FIGURES):
        parser.error(f"no figure {', '.join(sorted(unknown))}; there are {', '.join(FIGURES)}")
    arguments.output.mkdir(parents=True, exist_ok=True)
    for name in arguments.names or FIGURES:
        file = arguments.output / f"{name}.png"
        FIGURES[name](file)
        print(f"{file}: {file.stat().st_size} bytes", flush=True)


if __name__ == "__main__":
    main()
