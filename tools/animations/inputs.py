# SPDX-License-Identifier: Apache-2.0
"""Arguments, and drawings from SVGs and pictures."""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from tqdm import tqdm

import livecl
from livecl.opencl.device import choose_device
from livecl.options import PRESETS
from livecl.schedule import DEFAULT_PATHS
from livecl.views.frames import render_frames

#: Exit codes, beside 0.
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


class BadInputError(Exception):
    """What is asked for cannot be done; the message is one line for the user."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        """Raise what `run` reports."""
        raise BadInputError(f"{message} (see --help)")


def whole(least: int) -> Callable[[str], int]:
    """Return a converter of arguments to whole numbers."""

    def convert(text: str) -> int:
        if not text.isascii() or not text.isdigit() or int(text) < least:
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted a whole number of at least {least}")
        return int(text)

    return convert


def number(least: float) -> Callable[[str], float]:
    """Return a converter of arguments to numbers."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value >= least):
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted a number of at least {least:g}")
        return value

    return convert


def add_method_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that say how pictures are vectorized."""
    group = parser.add_argument_group("how pictures are vectorized")
    group.add_argument(
        "--paths", type=whole(1), default=DEFAULT_PATHS, metavar="N", help=f"paths, at most (default: {DEFAULT_PATHS})"
    )
    group.add_argument("--iterations", type=whole(1), metavar="N", help="iterations of each stage")
    group.add_argument("--preset", choices=tuple(PRESETS), default="default", help="as of the command livecl")
    group.add_argument("--seed", type=whole(0), default=0, metavar="N", help="seed of all random choices (default: 0)")
    parser.add_argument("--device", metavar="D", help="OpenCL device: its index or a part of its name")
    parser.add_argument("-q", "--quiet", action="store_true", help="show no progress and no summary")


def method(arguments: argparse.Namespace) -> tuple[livecl.Options, str | None]:
    """Return the options of the method that the arguments name, and its schedule."""
    changes = {} if arguments.iterations is None else {"iterations": arguments.iterations}
    return PRESETS[arguments.preset](**changes), str(arguments.paths) if arguments.preset == "diffvg" else None


def is_svg(path: Path) -> bool:
    """Return whether a file is read as an SVG; all others are pictures."""
    return path.suffix.lower() == ".svg"


def read_picture(path: Path, device: str | None) -> np.ndarray:
    """Read a picture, or render an SVG at its own size: (H, W, 3 or 4), straight."""
    if not is_svg(path):
        return read_input(livecl.read_image, path)
    drawing = read_input(livecl.read_svg, path)
    return next(render_frames([drawing], device=device))


def read_drawing(path: Path, arguments: argparse.Namespace) -> livecl.Drawing:
    """Read an SVG, or vectorize a picture, each thing in it as a layer of its own."""
    if is_svg(path):
        return read_input(livecl.read_svg, path)
    image = read_input(livecl.read_image, path)
    options, schedule = method(arguments)
    options = dataclasses.replace(options, holes=False)  # a hole shows what lies below: two things in one layer
    with tqdm(desc=path.name, unit="it", disable=True if arguments.quiet else None, leave=False) as bar:
        result = livecl.vectorize(
            image,
            paths=arguments.paths,
            schedule=schedule,
            options=options,
            device=arguments.device,
            seed=arguments.seed,
            on_step=lambda _: bool(bar.update(1) and False),
        )
    say(f"{path}: {result.drawing.num_layers} paths, MSE {result.mse:.3g}, {result.seconds:.1f} s", arguments)
    return result.drawing


def check_device(arguments: argparse.Namespace) -> None:
    """Refuse a device that there is not."""
    if arguments.device is not None:
        read_input(choose_device, arguments.device)


def read_input(read: Callable[[Any], Any], source: Any) -> Any:
    """Read what the user has named; what is wrong with it is bad input."""
    try:
        return read(source)
    except livecl.LiveclError as error:
        raise BadInputError(str(error)) from error


def say(message: str, arguments: argparse.Namespace) -> None:
    """Tell the user, unless told to be quiet."""
    if not arguments.quiet:
        print(message, file=sys.stderr)


def run(work: Callable[[Sequence[str] | None], None], argv: Sequence[str] | None) -> int:
    """Do a tool's work and return its exit code; what goes wrong is told in one line."""
    try:
        work(argv)
    except BadInputError as error:
        code, message = BAD_INPUT, str(error)
    except KeyboardInterrupt:
        code, message = INTERRUPTED, "interrupted"
    except (livecl.LiveclError, OSError, MemoryError) as error:
        code, message = FAILED, str(error) or type(error).__name__
    else:
        return 0
    print(f"{Path(sys.argv[0]).stem}: error: {' '.join(message.split())}", file=sys.stderr)
    return code
