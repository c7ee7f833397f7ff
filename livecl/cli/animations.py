# SPDX-License-Identifier: Apache-2.0
"""Write consecutive drawings as frames or an animation, by the suffix of the output."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import livecl
from livecl.cli.common import BadInputError, number
from livecl.image.reading import save_image
from livecl.svg.animated import save_animated_svg
from livecl.views.films import save_gif
from livecl.views.frames import MIN_GIF_FRAME, render_frames

FORMATS = "OUT.svg: animated; OUT.gif; OUT.png: side by side; a folder: numbered SVGs"
#: Gap between pictures side by side: px, and grey level.
GAP, GAP_LEVEL = 2, 0.8


def add_output_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the output."""
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="OUT", help=FORMATS)
    group = parser.add_argument_group("output")
    group.add_argument(
        "--seconds",
        type=number(MIN_GIF_FRAME),
        default=2.0,
        metavar="S",
        help="time from the first drawing to the last (default: 2)",
    )
    group.add_argument(
        "--hold",
        type=number(0),
        default=0.5,
        metavar="S",
        help="time that the first and the last drawing stay (default: 0.5)",
    )
    group.add_argument(
        "--one-way", action="store_true", help="restart from the first drawing at the end, instead of playing backwards"
    )
    group.add_argument("--scale", type=number(0.01), default=1.0, metavar="X", help="size of PNG and GIF (default: 1)")


def check_output(output: Path, inputs: Sequence[Path]) -> None:
    """Refuse an output that cannot be written, has an unknown format, or would replace an input."""
    for path in inputs:
        if output.exists() and path.exists() and output.samefile(path):
            raise BadInputError(f"{output}: is an input and would be overwritten")
    suffix = output.suffix.lower()
    if output.is_dir() or not suffix:
        if output.exists() and not output.is_dir():
            raise BadInputError(f"{output}: is a file, wanted a folder for the SVGs, or a name that ends in .svg ...")
    elif suffix not in (".svg", ".gif", ".png"):
        raise BadInputError(f"{output}: the format {suffix} is not known; wanted {FORMATS}")
    folder = output if output.is_dir() else output.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInputError(f"{output}: cannot write into {folder}: {error.strerror or error}") from error


def write_drawings(output: Path, drawings: Sequence[livecl.Drawing], arguments: argparse.Namespace) -> None:
    """Write drawings of one structure in the format that the output's name says."""
    suffix = "" if output.is_dir() else output.suffix.lower()
    steps = max(1, len(drawings) - 1)
    if suffix == ".svg":
        save_animated_svg(
            output, drawings, seconds=arguments.seconds, hold=arguments.hold, bounce=not arguments.one_way
        )
    elif suffix == ".gif":
        save_gif(
            output,
            drawings,
            seconds_per_frame=max(MIN_GIF_FRAME, arguments.seconds / steps),
            hold=arguments.hold,
            bounce=not arguments.one_way,
            scale=arguments.scale,
            device=arguments.device,
        )
    elif suffix == ".png":
        save_image(output, side_by_side(list(render_frames(drawings, arguments.scale, arguments.device))))
    else:
        output.mkdir(exist_ok=True)
        digits = max(2, len(str(len(drawings))))
        for index, drawing in enumerate(drawings, 1):
            drawing.save_svg(output / f"frame-{index:0{digits}}.svg")


def side_by_side(pictures: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    """Return pictures (H, W, 3) in a row, with a grey line between each and the next."""
    line = np.full((pictures[0].shape[0], GAP, 3), GAP_LEVEL, np.float32)
    return np.concatenate([part for picture in pictures for part in (line, picture)][1:], axis=1)
