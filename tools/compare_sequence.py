#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compare a sequence, in which each drawing starts from the one before, with as many independent runs.

The pictures are digits drawn by a pen, one turning into another. Printed for each pair of digits: seconds and
mean error of both ways, and how far control points move from one drawing to the next, mean over points and pictures;
those of independent runs after layers (by order) and outlines are made to correspond as `livecl.interpolate` does.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from animations.inputs import Parser, add_method_arguments, check_device, method, run, whole
from animations.outputs import side_by_side
from animations.strokes import DIGITS, draw_frames

import livecl
from livecl.image.reading import save_image
from livecl.interpolation.blending import correspond
from livecl.run.sequences import vectorize_sequence
from livecl.views.frames import render_frames

HEAD = "| digits | seconds, sequence | alone | ratio | MSE, sequence | alone | moved px, sequence | alone |"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    return run(work, argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("digits", nargs="+", choices=[a + b for a in DIGITS for b in DIGITS if a != b], metavar="AB")
    parser.add_argument("--frames", type=whole(2), default=9, metavar="N", help="pictures of each (default: 9)")
    parser.add_argument("--side", type=whole(16), default=64, metavar="PX", help="their sides (default: 64)")
    parser.add_argument("--refine-iterations", type=whole(1), metavar="N", help="for each picture but the first")
    parser.add_argument("--add-paths", type=whole(0), default=1, metavar="N", help="for pictures that need more")
    parser.add_argument("-o", "--output", type=Path, metavar="OUT.png", help="the pictures, and both ways below them")
    add_method_arguments(parser)
    return parser


def work(argv: Sequence[str] | None) -> None:
    """Run both ways on each pair of digits; print the table, and draw the rows."""
    arguments = build_parser().parse_args(argv)
    check_device(arguments)
    options, schedule = method(arguments)
    same = {
        "paths": arguments.paths,
        "schedule": schedule,
        "options": options,
        "device": arguments.device,
        "seed": arguments.seed,
    }
    print(HEAD)
    print("|---" + "|--:" * 7 + "|")
    rows = []
    for first, last in arguments.digits:
        images = draw_frames(first, last, arguments.frames, arguments.side)
        sequence = vectorize_sequence(
            images, refine_iterations=arguments.refine_iterations, add_paths=arguments.add_paths, **same
        )
        alone = [livecl.vectorize(image, **same) for image in images]
        drawings = [result.drawing for result in alone]
        seconds, seconds_alone = sum(sequence.seconds), sum(result.seconds for result in alone)
        print(
            f"| {first} to {last} | {seconds:.2f} | {seconds_alone:.2f} | {seconds / seconds_alone:.2f} "
            f"| {np.mean(sequence.mse):.2e} | {np.mean([result.mse for result in alone]):.2e} "
            f"| {movement(sequence.drawings):.2f} | {movement(drawings):.2f} |"
        )
        rows += [
            side_by_side(row) for row in (images, list(render_frames(sequence.drawings)), list(render_frames(drawings)))
        ]
    if arguments.output is not None:
        save_image(arguments.output, np.concatenate(rows))


def movement(drawings: Sequence[livecl.Drawing]) -> float:
    """Return how far control points move from drawing to drawing, mean over points and steps, px."""
    distances = []
    for a, b in itertools.pairwise(drawings):
        if not np.array_equal(a.subpath_offsets, b.subpath_offsets):
            a, b = correspond(a, b)
        distances.append(np.linalg.norm(b.points - a.points, axis=-1).mean())
    return float(np.mean(distances))


if __name__ == "__main__":
    sys.exit(main())
