# SPDX-License-Identifier: Apache-2.0
"""Command-line arguments: names, types and help; those that an options file may set."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import Any

from livecl.cli.common import Parser, number, path_text, whole
from livecl.cli.config import read_config
from livecl.cli.method import add_method
from livecl.cli.outputs import OUTPUTS
from livecl.editing.cutout import DEFAULT_TRAP
from livecl.image.resizing import DEFAULT_SIZE, LEAST_SIZE
from livecl.options import PRESET_PATHS, PRESETS
from livecl.run.recipe import GROUP_KINDS, LAYER_STYLES
from livecl.schedule import MAX_DEFAULT_PATHS
from livecl.svg import LayerStyle
from livecl.version import __version__

#: How layers lie: whole shapes over each other, or cut by those above.
ARRANGEMENTS = ("stacked", "cutout")
DESCRIPTION = "Turn a picture, or many, into layered SVGs of few closed Bézier paths."
EPILOG = """\
examples:
  livecl face.png -o face.svg --schedule 1,1,1,1,1,1 --stages stages --json face.json
  livecl photo.jpg -o photo.svg --preset photo
  livecl logo.png -o - --paths 12 --precision 1 | inkscape --pipe
  livecl icons/ more/*.png -o svgs --preset icon        a folder of SVGs, and summary.csv
  livecl photos -o svgs --scheduler tcp://10.0.0.5:8786  on the machines of a Dask cluster
  livecl --preset draft --show-options > mine.toml; livecl in.png -o out.svg --config mine.toml

environment: LIVECL_DEVICE chooses the OpenCL device as --device does.
exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted (Ctrl-C), 143 terminated.
An existing output file is replaced only when the new one is complete.
"""


def parse_arguments(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the arguments; those not on the command line come from the file of ``--config``.

    Raises ValueError if they are not usable.
    """
    parser = build_parser()
    command = ("livecl", *(sys.argv[1:] if argv is None else argv))
    parser.set_defaults(command=command)
    given = parser.parse_intermixed_args(argv)
    if given.config is None:
        return given
    words = []
    for key, value in read_config(given.config, parser.settings).items():
        if key in ("paths", "schedule") and (given.paths is not None or given.schedule is not None):
            continue  # one of the two on the command line stands for both
        words += _words(given.config, parser.settings[key], value)
    try:
        configured = parser.parse_intermixed_args(words)
    except ValueError as error:
        raise ValueError(f"{given.config}: {str(error).removesuffix(' (see --help)')}") from error
    del configured.inputs
    return parser.parse_intermixed_args(argv, configured)


def build_parser() -> Parser:
    """Return the parser of the command line."""
    parser = Parser(
        prog="livecl",
        usage="livecl IN -o OUT.svg [options]\n       livecl IN... -o FOLDER [options]",
        description=DESCRIPTION,
        epilog=EPILOG,
        add_help=False,
    )
    _add_files(parser.add_argument_group("files").add_argument)
    drawing = parser.add_argument_group("drawing")
    method = parser.add_argument_group("method", "Each option overrides one value of the preset.")
    running = parser.add_argument_group("running")
    _add_drawing(_setting(parser, drawing))
    add_method(_setting(parser, method))
    _add_running(_setting(parser, running))
    _add_checkpoint(running.add_argument)
    running.add_argument(
        "--config",
        metavar="FILE.toml",
        type=path_text,
        help="read options from a file; those of the command line override them",
    )
    running.add_argument("-q", "--quiet", action="store_true", help="show no progress, no warnings and no summary")
    running.add_argument("-v", "--verbose", action="store_true", help="also report each stage")
    information = parser.add_argument_group("information").add_argument
    information("-h", "--help", action="help", help="show this and exit")
    information("--version", action="version", version=f"livecl {__version__}", help="show the version and exit")
    information("--list-devices", action="store_true", help="list the OpenCL devices and exit")
    information("--show-options", action="store_true", help="print the options in effect as a --config file, and exit")
    return parser


Adder = Callable[..., argparse.Action]


def _setting(parser: Parser, group: Any) -> Adder:
    """Return a group's `add_argument` that also registers the argument for files of options."""

    def add(*names: str, **arguments: Any) -> argparse.Action:
        action: argparse.Action = group.add_argument(*names, **arguments)
        parser.settings[action.dest] = action
        return action

    return add


def _add_files(add: Adder) -> None:
    add(
        "inputs",
        metavar="IN",
        nargs="*",
        type=path_text,
        help="pictures: PNG, JPEG or other files that Pillow reads, folders of them, patterns, or - for standard input",
    )
    add(
        "-o",
        "--output",
        metavar="OUT",
        type=path_text,
        help="the SVG to write, - for standard output; of several pictures or a folder, the folder for the SVGs",
    )
    add(
        "--start",
        metavar="FILE.svg",
        type=path_text,
        help="start from a drawing: refine it, then add --paths paths, if given",
    )
    add(
        "--lock",
        action="append",
        metavar="LAYER",
        help="keep a layer of --start unchanged, named by its number (from 0), label or colour; may be repeated",
    )
    add(
        "--masks",
        metavar="DIR|LABELS",
        type=path_text,
        help="masks of the things in the picture: a folder of pictures, white inside, or one picture with a value or "
        "colour for each; each mask becomes a group, with --paths paths at most (default: as many as gain enough)",
    )
    for output in OUTPUTS:
        add(f"--{output.name}", metavar=output.metavar, type=path_text, help=output.help)
    add(
        "--frame-step",
        type=whole(1),
        default=10,
        metavar="N",
        help="iterations between two frames of --gif and --mp4 (default: 10)",
    )


def _add_drawing(add: Adder) -> None:
    counts = ", ".join(f"{name} {paths}" for name, paths in PRESET_PATHS.items())
    add(
        "--preset",
        choices=tuple(PRESETS),
        default="default",
        help="default: lowest error; icon, clipart, photo: for such pictures; draft: a quick look; paper: exactly the "
        "published text; released: the authors' program; diffvg: the paper's baseline, random paths in one stage",
    )
    add(
        "--paths",
        type=_paths,
        metavar="N",
        help="paths at most, or auto: as many as gain enough "
        f"(default: auto, to {MAX_DEFAULT_PATHS} where the picture is not flat; {counts})",
    )
    add("--schedule", metavar="LIST", help="paths added by each stage, as 1,1,2, or exp for 1, 2, 4 ... 32, 32 ...")
    add(
        "--size",
        type=_size,
        default=DEFAULT_SIZE,
        metavar="N",
        help="reduce larger pictures to the area of N x N px, or full; the SVG keeps the picture's own "
        f"coordinates (default: {DEFAULT_SIZE})",
    )
    add("--precision", type=int, choices=range(10), default=3, metavar="N", help="decimals of coordinates (default: 3)")
    add(
        "--layers",
        type=_layers,
        default=LAYER_STYLES[0],
        metavar="HOW",
        help="inkscape: layers named and grouped as Inkscape shows them, or plain SVG; stacked: whole shapes that "
        "overlap, or cutout: each cut by those above, for cutters and print; one of either kind, as plain,cutout "
        "(default: inkscape,stacked)",
    )
    add(
        "--trap",
        type=number(0, " of pixels"),
        default=DEFAULT_TRAP,
        metavar="PX",
        help=f"how far cut layers extend below those above them (default: {DEFAULT_TRAP:g})",
    )
    add(
        "--groups",
        choices=GROUP_KINDS,
        default=GROUP_KINDS[0],
        help="group layers by thing (a layer and those inside it), by the stage that added them, or not at all "
        "(default: thing)",
    )
    add(
        "--swatches",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="write each colour as an Inkscape swatch: editing it recolours all layers that use it; programs that do "
        "not support gradients may not show it",
    )
    add("--seed", type=whole(0), default=0, metavar="N", help="seed of all random choices (default: 0)")


def _add_running(add: Adder) -> None:
    add("--device", metavar="D", help="OpenCL device: its index or a part of its name (default: $LIVECL_DEVICE)")
    add(
        "--threads",
        type=whole(1),
        metavar="N",
        help="processor cores that PoCL may use (default: all, and one in each worker process)",
    )
    add("--workers", type=whole(1), metavar="N", help="worker processes for several pictures (default: one per core)")
    add(
        "--scheduler",
        metavar="ADDRESS",
        help="vectorize several pictures on the workers of a Dask cluster; local: a cluster on this machine",
    )
    add(
        "--time-limit",
        type=number(0, " of seconds"),
        metavar="SECONDS",
        help="longest time for a picture; the run then ends with the best drawing so far",
    )
    add(
        "--redo",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="vectorize pictures of a folder anew that are already done (default: skip them)",
    )


def _add_checkpoint(add: Adder) -> None:
    add(
        "--checkpoint",
        metavar="FILE",
        type=path_text,
        help="file in which a run of more than a few seconds saves its state, for --resume (default: "
        "OUT.svg.checkpoint; deleted when all outputs are written)",
    )
    add("--no-checkpoint", dest="checkpoint", action="store_false", help="save no checkpoints")
    add(
        "--checkpoint-period",
        type=number(0, " of seconds"),
        metavar="SECONDS",
        help="least time between two checkpoints (default: 5, or a hundred times the time of writing one if longer)",
    )
    add("--resume", action="store_true", help="continue from the checkpoint of the same command, if there is one")


def _paths(text: str) -> int | str:
    return text if text == "auto" else whole(1)(text)


def _size(text: str) -> int:
    """Return the side that pictures are reduced to: a whole number that is not too small, 0 for none."""
    if text in ("full", "0"):
        return 0
    try:
        return whole(LEAST_SIZE)(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, or full") from None


def _layers(text: str) -> str:
    """Return how layers are written, as given, if it is one of a style and one of an arrangement at most."""
    words = [word.strip() for word in text.split(",")]
    if not set(words) <= {*LAYER_STYLES, *ARRANGEMENTS} or max(map(len, _split(words))) > 1:
        raise argparse.ArgumentTypeError(
            f"got {text!r}, wanted {' or '.join(LAYER_STYLES)}, {' or '.join(ARRANGEMENTS)}, or both, as plain,cutout"
        )
    return ",".join(words)


def layers_of(text: str) -> tuple[LayerStyle, bool]:
    """Return the style of layers, and whether they are cut out, from the text of ``--layers``."""
    styles, arrangements = _split(text.split(","))
    return ("plain" if "plain" in styles else "inkscape"), "cutout" in arrangements


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    return [word for word in words if word in LAYER_STYLES], [word for word in words if word in ARRANGEMENTS]


def _words(file: str, action: argparse.Action, value: Any) -> list[str]:
    """Return the words of the command line that are equivalent to a value in a file."""
    option = action.option_strings[0]
    if isinstance(action, argparse.BooleanOptionalAction):
        if not isinstance(value, bool):
            raise ValueError(f"{file}: {action.dest}: got {value!r}, wanted true or false")
        return [option if value else action.option_strings[1]]
    if isinstance(value, bool):
        raise ValueError(f"{file}: {action.dest}: got {str(value).lower()}, wanted a number or text")
    return [f"{option}={','.join(map(str, value)) if isinstance(value, list) else value}"]
