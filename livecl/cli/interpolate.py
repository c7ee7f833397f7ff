# SPDX-License-Identifier: Apache-2.0
"""The command ``livecl-interpolate``: drawings between two SVGs, or between two pictures, vectorized first."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import numpy as np

import livecl
from livecl.cli.animations import add_output_arguments, check_output, write_drawings
from livecl.cli.common import (
    BadInputError,
    Parser,
    add_method_arguments,
    check_device,
    inform,
    read_drawing,
    run,
    whole,
)
from livecl.interpolation.blending import Lone, fit_canvas
from livecl.interpolation.matching import Match

COMMAND = "livecl-interpolate"
DESCRIPTION = """\
Interpolate between two drawings: SVGs, or pictures that are vectorized first.

Control points and colours of matched layers are interpolated linearly. B is scaled to the canvas of A where they
differ; where only one has a background, both get it.
"""
EPILOG = """\
examples:
  livecl-interpolate a.svg b.svg --frames 9 -o strip.png
  livecl-interpolate face.png portrait.png --match nearest -o face.svg

exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    return run(COMMAND, work, argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = Parser(prog=COMMAND, description=DESCRIPTION, epilog=EPILOG)
    parser.add_argument("a", type=Path, metavar="A", help="first drawing: an SVG, or a picture")
    parser.add_argument("b", type=Path, metavar="B", help="last drawing")
    parser.add_argument(
        "--frames", type=whole(2), default=9, metavar="N", help="drawings, A and B included (default: 9)"
    )
    parser.add_argument(
        "--match",
        choices=get_args(Match),
        default="order",
        help="match layers by their place in paint order (default), or the most similar ones",
    )
    parser.add_argument(
        "--lone",
        choices=get_args(Lone),
        default="fade",
        help="how a layer without a match appears and disappears: by its opacity (default), or by its size",
    )
    add_output_arguments(parser)
    add_method_arguments(parser)
    return parser


def work(argv: Sequence[str] | None) -> None:
    """Read, interpolate, write."""
    arguments = build_parser().parse_args(argv)
    check_output(arguments.output, [arguments.a, arguments.b])
    check_device(arguments)
    a, b = (read_drawing(path, arguments) for path in (arguments.a, arguments.b))
    if b.size != a.size:
        b = fit_canvas(b, a.size)
    if a.background is None and b.background is not None:
        inform(f"{arguments.a} has no background, and gets that of {arguments.b}", arguments)
        a = a.replace(background=b.background)
    elif b.background is None and a.background is not None:
        inform(f"{arguments.b} has no background, and gets that of {arguments.a}", arguments)
        b = b.replace(background=a.background)
    try:
        places = np.linspace(0, 1, arguments.frames).tolist()
        drawings = livecl.interpolate(a, b, places, match=arguments.match, lone=arguments.lone)
    except ValueError as error:
        raise BadInputError(str(error)) from error
    write_drawings(arguments.output, drawings, arguments)
    inform(f"{arguments.output}: {len(drawings)} drawings of {drawings[0].num_layers} layers", arguments)
