# SPDX-License-Identifier: Apache-2.0
"""The command ``livecl-sequence``: vectorize consecutive pictures, each drawing started from the preceding one."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import livecl
from livecl.cli.animations import add_output_arguments, check_output, write_drawings
from livecl.cli.common import (
    BadInputError,
    Parser,
    add_method_arguments,
    check_device,
    inform,
    method,
    read_input,
    run,
    whole,
)
from livecl.cli.progress import PictureProgress
from livecl.image.source import SUFFIXES
from livecl.run.sequences import vectorize_sequence

COMMAND = "livecl-sequence"
DESCRIPTION = """\
Vectorize consecutive pictures: each drawing starts from the one before, so layers keep their identity.
"""
EPILOG = """\
examples:
  livecl-sequence frames/*.png --paths 4 -o out.svg
  livecl-sequence frames --refine-iterations 100 -o drawings

exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    return run(COMMAND, work, argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = Parser(prog=COMMAND, description=DESCRIPTION, epilog=EPILOG)
    parser.add_argument(
        "frames", nargs="+", type=Path, metavar="FRAMES", help="pictures of one size, in order, or folders of them"
    )
    add_output_arguments(parser)
    add_method_arguments(parser)
    parser.add_argument(
        "--refine-iterations",
        type=whole(1),
        metavar="N",
        help="iterations for each picture but the first (default: twice those of a stage)",
    )
    parser.add_argument(
        "--add-paths",
        type=whole(0),
        default=1,
        metavar="N",
        help="paths added for a picture that needs more (default: 1)",
    )
    return parser


def work(argv: Sequence[str] | None) -> None:
    """Read, vectorize, write."""
    arguments = build_parser().parse_args(argv)
    paths = [path for given in arguments.frames for path in pictures_of(given)]
    check_output(arguments.output, paths)
    check_device(arguments)
    images = [read_input(livecl.read_image, path) for path in paths]
    for path, image in zip(paths, images, strict=True):
        if image.shape[:2] != images[0].shape[:2]:
            raise BadInputError(f"{path}: is of {image.shape[:2]} px, wanted {images[0].shape[:2]} as {paths[0]}")
    options, schedule = method(arguments)
    with PictureProgress(len(images), quiet=arguments.quiet) as progress:
        result = vectorize_sequence(
            progress.counted(images),
            paths=arguments.paths,
            schedule=schedule,
            options=options,
            refine_iterations=arguments.refine_iterations,
            add_paths=arguments.add_paths,
            device=arguments.device,
            seed=arguments.seed,
        )
    write_drawings(arguments.output, result.drawings, arguments)
    inform(
        f"{arguments.output}: {len(paths)} drawings of {result.drawings[0].num_layers} layers, "
        f"MSE {max(result.mse):.3g} at most, {sum(result.seconds):.1f} s",
        arguments,
    )


def pictures_of(path: Path) -> list[Path]:
    """Return the pictures of a folder, by name, or the file itself."""
    if not path.is_dir():
        return [path]
    pictures = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES)
    if not pictures:
        raise BadInputError(f"{path}: holds no pictures")
    return pictures
