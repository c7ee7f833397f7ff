#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Vectorize what lies between digits in the latents of a variational autoencoder.

Written into the folder: vae.npz, the trained model; vae-loss.csv, its loss curve, and vae-loss.png with matplotlib;
vae-strip.png, the model's pictures from one digit to another with the drawings below them, vae-strip.svg, the drawings
animated, and vae-strip/, each by itself; vae-grid.png, the drawings between four digits, with the model's pictures in
the corners, and vae-grid/, each drawing by itself.
"""

from __future__ import annotations

import argparse
import dataclasses
import io
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from tqdm import tqdm

import livecl
from livecl.cli.animations import GAP, GAP_LEVEL, side_by_side
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
from livecl.files import write_atomically
from livecl.image.reading import save_image
from livecl.run.sequences import SequenceResult, vectorize_sequence
from livecl.svg.animated import save_animated_svg
from livecl.vae.drawn_digits import draw_digits
from livecl.vae.enlarging import enlarge
from livecl.vae.mnist import SIDE, Digits, read_mnist
from livecl.vae.model import Vae, interpolate_latents, latent_grid
from livecl.vae.training import Training, train_vae
from livecl.views.frames import render_frames

#: Digits drawn where there is no MNIST, and how many of a set, its last ones, are not trained on: the ends of the
#: strip and the corners of the grid are among them.
DRAWN, HELD_OUT = 10000, 500
#: Paths of the first drawing of a sequence, where the user does not say.
PATHS = 5
#: Frame of pictures among drawings: px, and colour.
FRAME, FRAME_COLOR = 2, (0.1, 0.75, 0.2)
#: Steps whose mean is one point of the loss curve.
WINDOW = 25
EPILOG = """\
examples:
  vae_interpolation.py -o figures
  vae_interpolation.py -o figures --mnist mnist --steps 5000
  vae_interpolation.py -o figures --model figures/vae.npz --ends 72 --frames 5

exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    return run("vae_interpolation", work, argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = Parser(description=__doc__, epilog=EPILOG)
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="DIR", help="output folder")
    parser.add_argument("--mnist", type=Path, metavar="DIR", help="folder with MNIST's files (default: drawn digits)")
    parser.add_argument("--model", type=Path, metavar="FILE", help="a model trained before, instead of training one")
    parser.add_argument("--steps", type=whole(1), default=3000, metavar="N", help="of the training (default: 3000)")
    parser.add_argument("--size", type=whole(SIDE), default=112, metavar="PX", help="side of a drawing (default: 112)")
    parser.add_argument("--frames", type=whole(2), default=9, metavar="N", help="pictures of the strip (default: 9)")
    parser.add_argument("--ends", type=digits_of(2), default="38", metavar="AB", help="its digits (default: 38)")
    parser.add_argument("--grid", type=whole(2), default=5, metavar="N", help="rows and columns (default: 5)")
    parser.add_argument("--corners", type=digits_of(4), default="5638", metavar="ABCD", help="its digits, row by row")
    parser.add_argument(
        "--add-paths", type=whole(0), default=1, metavar="N", help="for pictures that need more (default: 1)"
    )
    add_method_arguments(parser)
    parser.set_defaults(paths=PATHS)
    return parser


def digits_of(count: int) -> Callable[[str], str]:
    """Return a converter of arguments to strings of `count` digits."""

    def convert(text: str) -> str:
        if len(text) != count or not text.isascii() or not text.isdigit():
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted {count} digits one after the other")
        return text

    return convert


def work(argv: Sequence[str] | None) -> None:
    """Train or load, interpolate, vectorize, write."""
    arguments = build_parser().parse_args(argv)
    check_device(arguments)
    known, held_out = read_digits(arguments)
    model = None if arguments.model is None else read_input(Vae.load, arguments.model)
    if model is not None and model.size != (SIDE, SIDE):
        raise BadInputError(f"{arguments.model}: a model of pictures of {model.size} px, wanted {(SIDE, SIDE)}")
    ends, corners = pictures_of(held_out, arguments.ends), pictures_of(held_out, arguments.corners)
    try:
        arguments.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{arguments.output}: cannot make the folder: {error.strerror or error}") from error
    if model is None:
        training = train(known, arguments)
        model = training.model
        model.save(arguments.output / "vae.npz")
        write_curve(training, arguments)
    decoded = model.decode(model.encode(held_out.images)[0])
    error = np.square(decoded - held_out.images).mean()
    inform(f"{len(held_out)} digits not trained on: MSE {error:.2e} of the model's pictures", arguments)
    make_strip(enlarged(interpolate_latents(model, *ends, arguments.frames), arguments.size), arguments)
    grid = latent_grid(model, corners, arguments.grid, arguments.grid)
    make_grid([enlarged(row, arguments.size) for row in grid], arguments)


def read_digits(arguments: argparse.Namespace) -> tuple[Digits, Digits]:
    """Return the digits to train on, and those held out."""
    if arguments.mnist is None:
        digits = draw_digits(DRAWN, seed=arguments.seed)
    else:
        digits = read_input(read_mnist, arguments.mnist)
        if len(digits) <= HELD_OUT:
            raise BadInputError(f"{arguments.mnist}: {len(digits)} digits, wanted more than the {HELD_OUT} held out")
    return (
        Digits(digits.images[:-HELD_OUT], digits.labels[:-HELD_OUT]),
        Digits(digits.images[-HELD_OUT:], digits.labels[-HELD_OUT:]),
    )


def pictures_of(digits: Digits, wanted: str) -> np.ndarray:
    """Return the first picture of each of some digits, (N, 28, 28)."""
    places = []
    for digit in map(int, wanted):
        if digit not in digits.labels:
            raise BadInputError(f"there is no {digit} among the digits held out")
        places.append(np.argmax(digits.labels == digit))
    return digits.images[places]


def train(digits: Digits, arguments: argparse.Namespace) -> Training:
    """Train a model on the digits."""
    start, steps = time.perf_counter(), arguments.steps
    with tqdm(total=steps, desc="training", disable=True if arguments.quiet else None, leave=False) as bar:
        training = train_vae(digits.images, steps=steps, seed=arguments.seed, callback=lambda *_: bar.update())
    seconds, nats = time.perf_counter() - start, training.losses[-100:].sum(axis=1).mean()
    inform(f"training: {len(digits)} digits, {steps} steps, {nats:.1f} nats a picture, {seconds:.1f} s", arguments)
    return training


def write_curve(training: Training, arguments: argparse.Namespace) -> None:
    """Write the loss curve as a table, and as a picture where matplotlib is installed."""
    rows = [f"{step},{pixels:.6g},{latents:.6g}\n" for step, (pixels, latents) in enumerate(training.losses)]
    write_atomically(arguments.output / "vae-loss.csv", "".join(["step,cross_entropy,divergence\n", *rows]))
    try:
        plot_training(training.losses, arguments.output / "vae-loss.png")
    except ImportError:
        inform("no plot of the loss without matplotlib: pip install 'livecl[plots]'", arguments)


def plot_training(losses: np.ndarray, file: Path) -> None:
    """Draw cross-entropy and divergence (steps, 2), nats a picture, as PNG; ImportError without matplotlib."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 3), layout="constrained")
    axes = figure.subplots()
    window = min(WINDOW, len(losses))
    whole = len(losses) // window * window
    means = losses[:whole].reshape(-1, window, 2).mean(axis=1)
    steps = (np.arange(len(means)) + 0.5) * window
    for index, label in enumerate(("cross-entropy", "divergence")):
        axes.plot(steps, means[:, index], label=label)
    axes.set(xlabel="step", ylabel="nats a picture", yscale="log")
    axes.grid(visible=True, which="both", alpha=0.25)
    axes.legend()
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=100)
    write_atomically(file, png.getvalue())


def enlarged(pictures: np.ndarray, size: int) -> list[np.ndarray]:
    """Return grey pictures (N, 28, 28) as N of (size, size, 3)."""
    return [np.repeat(picture[..., None], 3, axis=2).astype(np.float32) for picture in enlarge(pictures, size)]


def make_strip(pictures: Sequence[np.ndarray], arguments: argparse.Namespace) -> None:
    """Vectorize the pictures from one digit to another, and write them."""
    result = vectorized(pictures, "strip", arguments)
    write_drawings(arguments.output / "vae-strip", {f"{n:02}": each for n, each in enumerate(result.drawings, 1)})
    save_animated_svg(arguments.output / "vae-strip.svg", result.drawings, hold=0.5)
    rendered = list(render_frames(result.drawings, device=arguments.device))
    save_image(arguments.output / "vae-strip.png", stacked([side_by_side(pictures), side_by_side(rendered)]))


def make_grid(pictures: Sequence[Sequence[np.ndarray]], arguments: argparse.Namespace) -> None:
    """Vectorize the pictures between four digits, the first column and from each of its drawings a row; write them."""
    column = vectorized([row[0] for row in pictures], "first column", arguments)
    rows = []
    for n, (row, start) in enumerate(zip(pictures, column.drawings, strict=True), 1):
        result = vectorized(row, f"row {n}", arguments, start)
        write_drawings(
            arguments.output / "vae-grid", {f"{n:02}-{m:02}": each for m, each in enumerate(result.drawings, 1)}
        )
        rows.append(list(render_frames(result.drawings, device=arguments.device)))
    for n, m in ((0, 0), (0, -1), (-1, 0), (-1, -1)):
        rows[n][m] = framed(pictures[n][m])
    save_image(arguments.output / "vae-grid.png", stacked([side_by_side(row) for row in rows]))


def vectorized(
    pictures: Sequence[np.ndarray], name: str, arguments: argparse.Namespace, start: livecl.Drawing | None = None
) -> SequenceResult:
    """Return the drawings of a sequence of pictures.

    Outlines keep their loops: a 3 becomes an 8 by touching itself, and the loop is its hole.
    """
    options, schedule = method(arguments)
    options = dataclasses.replace(options, background="#000000", untangle=False)
    with tqdm(pictures, desc=name, disable=True if arguments.quiet else None, leave=False) as bar:
        result = vectorize_sequence(
            bar,
            paths=arguments.paths if start is None else None,
            schedule=schedule if start is None else None,
            options=options,
            add_paths=arguments.add_paths,
            device=arguments.device,
            seed=arguments.seed,
            start=start,
        )
    inform(
        f"{name}: {len(pictures)} drawings of {result.drawings[0].num_layers} layers, MSE {np.mean(result.mse):.1e} "
        f"(mean), {sum(result.seconds):.1f} s",
        arguments,
    )
    return result


def write_drawings(folder: Path, drawings: dict[str, livecl.Drawing]) -> None:
    """Write drawings by their names."""
    folder.mkdir(exist_ok=True)
    for name, drawing in drawings.items():
        drawing.save_svg(folder / f"{name}.svg")


def framed(picture: np.ndarray) -> np.ndarray:
    """Return a picture with a frame of its outermost pixels."""
    result = np.empty_like(picture)
    result[:] = FRAME_COLOR
    inside = slice(FRAME, -FRAME)
    result[inside, inside] = picture[inside, inside]
    return result


def stacked(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Return rows (H, W, 3) below each other, with a grey line between each and the next."""
    line = np.full((GAP, rows[0].shape[1], 3), GAP_LEVEL, np.float32)
    return np.concatenate([part for row in rows for part in (line, row)][1:])


if __name__ == "__main__":
    sys.exit(main())
