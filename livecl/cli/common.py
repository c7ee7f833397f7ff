# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the commands: parser, types of arguments, refusal of bad input in one line, exit codes."""

from __future__ import annotations

import argparse
import dataclasses
import difflib
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import livecl
from livecl.cli.messages import complain, say
from livecl.options import PRESETS
from livecl.schedule import DEFAULT_PATHS

#: Exit codes, beside 0: failed while working, bad arguments or input, interrupted by Ctrl-C.
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130

T = TypeVar("T")


class BadInputError(ValueError):
    """Bad input; the message is one line for the user."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text; options are not abbreviated.

    Attributes
    ----------
    settings : dict
        The arguments that a file of options may set, by key.
    """

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
        self.settings: dict[str, argparse.Action] = {}

    def error(self, message: str) -> NoReturn:
        """Raise BadInputError, in place of ending the process; it names the option nearest to an unknown one."""
        unknown = re.match(r"unrecognized arguments: (--[^ =]+)", message)
        known = [name for name in self._option_string_actions if name.startswith("--")]
        if unknown and (near := difflib.get_close_matches(unknown[1], known, n=1)):
            message += f"; did you mean {near[0]}?"
        raise BadInputError(f"{message} (see --help)")


def path_text(text: str) -> str:
    """Return the text of a path; an empty one, as of an unset variable, would be the current folder."""
    if not text:
        raise argparse.ArgumentTypeError("got '', wanted a path")
    return text


def whole(least: int) -> Callable[[str], int]:
    """Return a converter of text to whole numbers of at least `least`."""

    def convert(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted a whole number of at least {least}")
        return value

    return convert


def number(least: float, unit: str = "") -> Callable[[str], float]:
    """Return a converter of text to finite numbers of at least `least`."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value >= least):
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted a number{unit} of at least {least:g}")
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
    """Return the options of the method and the schedule."""
    changes = {} if arguments.iterations is None else {"iterations": arguments.iterations}
    schedule = str(arguments.paths) if arguments.preset == "diffvg" else None
    return livecl.Options.preset(arguments.preset, **changes), schedule


def read_drawing(path: Path, arguments: argparse.Namespace) -> livecl.Drawing:
    """Read an SVG, or vectorize a picture with one layer for each thing in it."""
    from livecl.cli.progress import RunProgress

    if path.suffix.lower() == ".svg":
        return read_input(livecl.read_svg, path)
    image = read_input(livecl.read_image, path)
    options, schedule = method(arguments)
    options = dataclasses.replace(options, holes=False)  # through a hole the layer below shows: two shapes in one layer
    with RunProgress(quiet=arguments.quiet) as progress:
        result = livecl.vectorize(
            image,
            paths=arguments.paths,
            schedule=schedule,
            options=options,
            device=arguments.device,
            seed=arguments.seed,
            on_step=progress,
        )
    inform(f"{path}: {result.drawing.num_layers} paths, MSE {result.mse:.3g}, {result.seconds:.1f} s", arguments)
    return result.drawing


def check_device(arguments: argparse.Namespace) -> None:
    """Raise BadInputError for a device that does not exist."""
    from livecl.opencl.device import choose_device

    if arguments.device is not None:
        read_input(choose_device, arguments.device)


def read_input(read: Callable[[Any], T], source: Any) -> T:
    """Read an input; its errors are bad input."""
    try:
        return read(source)
    except livecl.LiveclError as error:
        raise BadInputError(str(error)) from error


def inform(message: str, arguments: argparse.Namespace) -> None:
    """Show a message, unless `arguments.quiet`."""
    if not arguments.quiet:
        say(message)


def run(command: str, work: Callable[[Sequence[str] | None], None], argv: Sequence[str] | None) -> int:
    """Run a command's work and return its exit code; errors are shown in one line."""
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
    complain(message, command)
    return code
