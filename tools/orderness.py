#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compare how well drawings of two pictures can be interpolated: those of our method, and of a DiffVG-style baseline.

Rows, from the top: the default method, without holes; the same with the nearest layers matched; the paper's method; the
baseline with a random seed for each picture, and with one seed for both. Layers are matched by order but in the second.

Printed for each: MSE at the ends; stray, how far areas of layers in between are from lying between those at the ends,
sum over layers, as a share of the sum of areas; self-crossing layers, at the ends and in between; px by which control
points move; difference of the fills of matched layers, mean over red, green, blue. What is said of layers in between is
a mean over the drawings; all are means over --repeats pairs of seeds.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from animations.inputs import BadInputError, Parser, check_device, read_picture, run, whole
from animations.outputs import check_output, side_by_side

import livecl
from livecl.geometry import bezier
from livecl.image.reading import save_image
from livecl.interpolation.blending import correspond, interpolate
from livecl.layering.metrics import self_crossing
from livecl.views.frames import render_frames

NO_HOLES = functools.partial(livecl.Options, holes=False)
#: Name, preset, whether all paths come in one stage, matching, whether both pictures have the same seed.
ROWS = (
    ("default", NO_HOLES, False, "order", True),
    ("default, nearest", NO_HOLES, False, "nearest", True),
    ("paper", livecl.Options.paper, False, "order", True),
    ("DiffVG-style, random seeds", livecl.Options.diffvg, True, "order", False),
    ("DiffVG-style, one seed", livecl.Options.diffvg, True, "order", True),
)
HEAD = "| method | MSE | stray | crossing, ends | crossing, between | moved px | fill differs |"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    return run(work, argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("a", type=Path, metavar="A", help="a picture, or an SVG that is rendered to one")
    parser.add_argument("b", type=Path, metavar="B", help="a picture of the same size")
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="OUT.png", help="the figure")
    parser.add_argument("--paths", type=whole(1), default=8, metavar="N", help="paths of each drawing (default: 8)")
    parser.add_argument("--frames", type=whole(3), default=7, metavar="N", help="drawings in a row (default: 7)")
    parser.add_argument("--repeats", type=whole(1), default=3, metavar="N", help="pairs of seeds (default: 3)")
    parser.add_argument("--scale", type=float, default=0.5, metavar="X", help="of the figure (default: 0.5)")
    parser.add_argument("--device", metavar="D", help="OpenCL device: its index or a part of its name")
    return parser


def work(argv: Sequence[str] | None) -> None:
    """Vectorize, interpolate, measure, draw."""
    arguments = build_parser().parse_args(argv)
    check_output(arguments.output, [arguments.a, arguments.b])
    check_device(arguments)
    images = [read_picture(path, arguments.device) for path in (arguments.a, arguments.b)]
    if images[0].shape != images[1].shape:
        raise BadInputError(f"{arguments.b}: has shape {images[1].shape}, wanted {images[0].shape} as {arguments.a}")
    places = np.linspace(0, 1, arguments.frames).tolist()
    rows = []
    print(HEAD)
    print("|---" + "|--:" * 6 + "|")
    for name, preset, at_once, match, same_seed in ROWS:
        measures = []
        for repeat in range(arguments.repeats):
            seeds = (repeat, repeat if same_seed else repeat + arguments.repeats)
            ends = [
                livecl.vectorize(
                    image,
                    paths=arguments.paths,
                    schedule=str(arguments.paths) if at_once else None,
                    options=preset(),
                    device=arguments.device,
                    seed=seed,
                )
                for image, seed in zip(images, seeds, strict=True)
            ]
            a, b = (end.drawing for end in ends)
            drawings = interpolate(a, b, places, match=match)
            measures.append([np.mean([end.mse for end in ends]), *measure(*correspond(a, b, match=match), drawings)])
            if repeat == 0:
                rows.append(side_by_side(list(render_frames(drawings, arguments.scale, arguments.device))))
        mse, stray, at_ends, between, moved, fill = np.mean(measures, axis=0)
        print(f"| {name} | {mse:.2g} | {stray:.1%} | {at_ends:.1f} | {between:.1f} | {moved:.1f} | {fill:.2f} |")
    save_image(arguments.output, np.concatenate(rows))


def measure(start: livecl.Drawing, end: livecl.Drawing, drawings: Sequence[livecl.Drawing]) -> tuple[float, ...]:
    """Return stray, self-crossing layers at the ends and in between, movement in px, and difference of fills."""
    areas = np.array([layer_areas(drawing) for drawing in drawings])
    t = np.linspace(0, 1, len(drawings))[:, None]
    expected = (1 - t) * areas[0] + t * areas[-1]
    stray = np.abs(areas - expected)[1:-1].sum() / expected[1:-1].sum()
    crossing = [self_crossing(drawing).sum() for drawing in drawings]
    moved = np.linalg.norm(end.points - start.points, axis=-1).mean()
    fill = np.abs(end.colors - start.colors)[:, :3].mean()
    return float(stray), (crossing[0] + crossing[-1]) / 2, float(np.mean(crossing[1:-1])), float(moved), float(fill)


def layer_areas(drawing: livecl.Drawing) -> np.ndarray:
    """Return the area that each layer's outline winds around, holes taken away: (N,), px^2."""
    cubics = drawing.cubics
    return np.array([abs(bezier.signed_area(cubics[i:j])) for i, j in itertools.pairwise(drawing.segment_offsets)])


if __name__ == "__main__":
    sys.exit(main())
