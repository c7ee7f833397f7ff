#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Vectorize what lies between digits in the latents of a variational autoencoder.

Written into the folder: vae.npz, the trained model; vae-strip.png, the model's pictures from one digit to another
with the drawings below them; vae-grid.png, the drawings between four digits, each row a sequence.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from animations.inputs import (
    BadInputError,
    Parser,
    add_method_arguments,
    check_device,
    method,
    read_input,
    run,
    say,
    whole,
)
from animations.outputs import GAP, GAP_LEVEL, side_by_side
from skimage.transform import resize
from tqdm import tqdm

from livecl.digit_strokes import draw_digits
from livecl.digits import SIDE, Digits, read_mnist
from livecl.frames import render_frames
from livecl.image import save_image
from livecl.sequences import vectorize_sequence
from livecl.vae import Vae, interpolate_latents, latent_grid
from livecl.vae_training import train_vae

#: Side of the pictures that are vectorized, px: four times a digit's.
ENLARGED = 4 * SIDE
#: Digits drawn where there is no MNIST.
DRAWN = 4000
#: Pictures of a step of the training.
BATCH = 128
#: Paths of the first drawing of a sequence, where the user does not say.
PATHS = 5
#: What the digits at the ends of the strip and in the corners of the grid show.
ENDS, CORNERS = (3, 8), (0, 6, 7, 2)
EPILOG = """\
examples:
  vae_interpolation.py -o figures
  vae_interpolation.py -o figures --mnist mnist --epochs 10
  vae_interpolation.py -o figures --model figures/vae.npz --frames 5

exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    return run(work, argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = Parser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="DIR", help="folder of what is written")
    parser.add_argument("--mnist", type=Path, metavar="DIR", help="folder with MNIST's files (default: drawn digits)")
    parser.add_argument("--model", type=Path, metavar="FILE", help="a model trained before, instead of training one")
    parser.add_argument("--epochs", type=whole(1), default=20, metavar="N", help="rounds of training (default: 20)")
    parser.add_argument("--frames", type=whole(2), default=9, metavar="N", help="pictures of the strip (default: 9)")
    parser.add_argument("--grid", type=whole(2), default=5, metavar="N", help="rows and columns (default: 5)")
    parser.add_argument(
        "--add-paths", type=whole(0), default=1, metavar="N", help="for pictures that need more (default: 1)"
    )
    add_method_arguments(parser)
    parser.set_defaults(paths=PATHS)
    return parser


def work(argv: Sequence[str] | None) -> None:
    """Train or load, interpolate, vectorize, write."""
    arguments = build_parser().parse_args(argv)
    check_device(arguments)
    digits = (
        draw_digits(DRAWN, seed=arguments.seed) if arguments.mnist is None else read_input(read_mnist, arguments.mnist)
    )
    model = None if arguments.model is None else read_input(Vae.load, arguments.model)
    if model is not None and model.size != (SIDE, SIDE):
        raise BadInputError(f"{arguments.model}: a model of pictures of {model.size} px, wanted {(SIDE, SIDE)}")
    ends, corners = pictures_of(digits, ENDS), pictures_of(digits, CORNERS)
    try:
        arguments.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{arguments.output}: cannot make the folder: {error.strerror or error}") from error
    if model is None:
        model = train(digits, arguments)
        model.save(arguments.output / "vae.npz")

    frames = enlarged(interpolate_latents(model, *ends, arguments.frames))
    drawn = vectorized(frames, "strip", arguments)
    save_image(arguments.output / "vae-strip.png", stacked([side_by_side(frames), side_by_side(drawn)]))

    grid = latent_grid(model, corners, arguments.grid, arguments.grid)
    rows = [vectorized(enlarged(row), f"row {index}", arguments) for index, row in enumerate(grid, 1)]
    save_image(arguments.output / "vae-grid.png", stacked([side_by_side(row) for row in rows]))


def pictures_of(digits: Digits, wanted: Sequence[int]) -> np.ndarray:
    """Return the first picture of each of some digits, (N, 28, 28)."""
    for digit in wanted:
        if digit not in digits.labels:
            raise BadInputError(f"there is no {digit} among the digits")
    return np.stack([digits.images[np.argmax(digits.labels == digit)] for digit in wanted])


def train(digits: Digits, arguments: argparse.Namespace) -> Vae:
    """Train a model on the digits."""
    steps = -(-arguments.epochs * len(digits) // BATCH)
    start = time.perf_counter()
    with tqdm(total=steps, desc="training", disable=True if arguments.quiet else None, leave=False) as bar:
        training = train_vae(
            digits.images, steps=steps, batch=BATCH, seed=arguments.seed, callback=lambda *_: bar.update()
        )
    seconds, nats = time.perf_counter() - start, training.losses[-1].sum()
    say(f"training: {len(digits)} digits, {steps} steps, {nats:.1f} nats a picture, {seconds:.1f} s", arguments)
    return training.model


def enlarged(pictures: np.ndarray) -> list[np.ndarray]:
    """Return grey pictures (N, 28, 28) as N of (112, 112, 3), by cubic splines, which may overshoot and are clipped."""
    large = [resize(picture, (ENLARGED, ENLARGED), order=3, mode="edge") for picture in pictures]
    return [np.repeat(np.clip(picture, 0, 1)[..., None], 3, axis=2).astype(np.float32) for picture in large]


def vectorized(pictures: Sequence[np.ndarray], name: str, arguments: argparse.Namespace) -> list[np.ndarray]:
    """Return the renders of the drawings of a sequence of pictures."""
    options, schedule = method(arguments)
    with tqdm(pictures, desc=name, disable=True if arguments.quiet else None, leave=False) as bar:
        result = vectorize_sequence(
            bar,
            paths=arguments.paths,
            schedule=schedule,
            options=options,
            add_paths=arguments.add_paths,
            device=arguments.device,
            seed=arguments.seed,
        )
    say(
        f"{name}: {len(pictures)} drawings of {result.drawings[0].num_layers} layers, MSE {np.mean(result.mse):.1e} "
        f"(mean), {sum(result.seconds):.1f} s",
        arguments,
    )
    return list(render_frames(result.drawings, device=arguments.device))


def stacked(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Return rows (H, W, 3) below each other, with a grey line between each and the next."""
    line = np.full((GAP, rows[0].shape[1], 3), GAP_LEVEL, np.float32)
    return np.concatenate([part for row in rows for part in (line, row)][1:])


if __name__ == "__main__":
    sys.exit(main())
