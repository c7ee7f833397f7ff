#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Render the sample pictures of this folder from their sources, ``sources/*.svg``."""

from pathlib import Path

import resvg_py

FOLDER = Path(__file__).resolve().parent


def main() -> None:
    """Write a PNG beside this script for each source, at its own size."""
    for source in sorted((FOLDER / "sources").glob("*.svg")):
        target = FOLDER / f"{source.stem}.png"
        target.write_bytes(bytes(resvg_py.svg_to_bytes(svg_string=source.read_text(encoding="utf-8"))))
        print(target)


if __name__ == "__main__":
    main()
