# SPDX-License-Identifier: Apache-2.0
"""The arguments of the command line: their names, kinds and help."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import NoReturn, get_args, get_type_hints

from livecl import __version__
from livecl.schedule import DEFAULT_PATHS

DESCRIPTION = "Turn a picture into a layered SVG of few closed Bézier paths."
EPILOG = """\
examples:
  livecl face.png -o face.svg --schedule 1,1,1,1,1,1 --stages stages --json face.json
  livecl photo.jpg -o photo.svg --paths 64

exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
An existing output file is replaced only when the new one is complete.
"""


class BadInputError(Exception):
    """What is asked for cannot be done; the message is one line for the user."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        raise BadInputError(f"{message} (see --help)")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    from livecl.options import PRESETS, Options

    parser = _Parser(
        prog="livecl",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    choices = {name: get_args(hint) for name, hint in get_type_hints(Options).items()}
    add("input", metavar="IN", nargs="?", help="the picture: PNG, JPEG or another file that Pillow reads")
    add("-o", "--output", metavar="OUT.svg", help="the SVG to write; required, unless devices are listed")
    add(
        "--paths",
        type=_paths,
        metavar="N",
        help=f"number of paths, at most, or auto: as many as gain enough (default: {DEFAULT_PATHS})",
    )
    add("--target-mse", type=_weight, metavar="X", help="begin no further stage once the error is that low")
    add("--schedule", metavar="LIST", help="paths that each stage adds, as 1,1,2, or exp: 1, 2, 4 ... 32, 32 ...")
    add(
        "--preset",
        choices=tuple(PRESETS),
        default="default",
        help="default: what measures best; paper: exactly the published text; released: the authors' program; diffvg: "
        "the paper's comparison, random paths in one stage; the options below change single points of it",
    )
    add("--iterations", type=_whole(1), metavar="N", help="iterations of each stage")
    add("--segments", type=_whole(1), metavar="N", help="cubic segments of each path")
    add("--max-segments", type=_whole(1), metavar="N", help="most segments of a path that is fitted to a region")
    add("--loss", choices=choices["loss"], help="pixel loss weighted near the outlines, or plain mean squared error")
    add("--xing-weight", type=_weight, metavar="X", help="weight of the loss against self-crossing")
    add(
        "--placement",
        choices=choices["placement"],
        help="where new paths start: on the regions that matter most, on the largest components of the error (the "
        "paper's rule), or anywhere (then as circles, unless --shape says otherwise)",
    )
    add("--shape", choices=choices["shape"], help="what new paths start as")
    add("--revisions", type=_whole(0), metavar="N", help="rounds at the end that place the least useful paths anew")
    add("--background", type=_background, metavar="COLOR", help="white, #rrggbb, or train to learn it")
    add("--seed", type=_whole(0), default=0, metavar="N", help="seed of all random choices (default: 0)")
    add("--device", metavar="D", help="OpenCL device: its index or a part of its name (default: $LIVECL_DEVICE)")
    add("--threads", type=_whole(1), metavar="N", help="processor cores that PoCL may use (default: all)")
    add("--list-devices", action="store_true", help="list the OpenCL devices and exit")
    add("--stages", metavar="DIR", help="also write the drawing after each stage: DIR/stage-1.svg ...")
    add("--json", metavar="FILE", help="also write size, options, error and seconds as JSON")
    add("-q", "--quiet", action="store_true", help="show no progress and no summary")
    add("--version", action="version", version=f"livecl {__version__}")
    return parser


def _whole(least: int) -> Callable[[str], int]:
    def convert(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted a whole number of at least {least}")
        return value

    return convert


def _paths(text: str) -> int | str:
    return text if text == "auto" else _whole(1)(text)


def _weight(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise argparse.ArgumentTypeError(f"got {text!r}, wanted a number of at least 0")
    return value


def _background(text: str) -> str:
    from livecl.background import check_background

    try:
        check_background(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("background: ")) from error
    return text
