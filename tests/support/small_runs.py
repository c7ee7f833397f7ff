# SPDX-License-Identifier: Apache-2.0
"""Small runs of every kind, and the digests of the SVGs they make: `python tests/small_runs.py [NAME ...]` prints them.

A process of its own can be given other surroundings (threads, hash seed, locale, folder); the bytes must not change.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import locale
import sys
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

import livecl
from livecl import Options, vectorize, vectorize_sequence
from livecl.svg import format_svg
from support.runs import SMALL, three_shapes

#: Few iterations, and all the rest that a run does: revisions, merging, pruning.
SHORT = Options(placement="region", iterations=12, revisions=2)


def glass() -> NDArray[np.float64]:
    """Return two translucent discs on nothing, straight RGBA."""
    rows, columns = np.indices((24, 24)) + 0.5
    image = np.zeros((24, 24, 4))
    image[np.hypot(columns - 9, rows - 12) < 7] = (0.9, 0.2, 0.1, 0.5)
    image[np.hypot(columns - 15, rows - 12) < 6] = (0.1, 0.3, 0.9, 0.8)
    return image


def ring() -> NDArray[np.float64]:
    """Return a ring over two colours."""
    rows, columns = np.indices((28, 28)) + 0.5
    image = np.ones((28, 28, 3))
    image[:, 14:] = (0.9, 0.9, 0.4)
    far = np.hypot(columns - 14, rows - 14)
    image[(far < 11) & (far > 5)] = (0.2, 0.1, 0.6)
    return image


def busy_picture(side: int) -> NDArray[np.float64]:
    """Return a picture of many regions with borders of thousands of pixels, for which BLAS uses its threads."""
    rows, columns = (np.indices((side, side)) + 0.5) / side
    waves = np.sin(9 * columns + 4 * np.sin(5 * rows)) + np.cos(7 * rows - 3 * np.cos(6 * columns))
    steps = np.floor(3 * (waves + 2)) / 12
    return np.stack([steps, 1 - steps, np.floor(4 * columns) / 4], axis=2)


def _default() -> list[str]:
    return [vectorize(SMALL, schedule=[1, 2], options=SHORT).svg]


def _paper() -> list[str]:
    return [vectorize(SMALL, schedule=[1, 2], options=Options.paper(iterations=12), seed=1).svg]


def _random() -> list[str]:
    return [vectorize(SMALL, schedule=[3], options=Options.diffvg(iterations=12), seed=2).svg]


def _alpha() -> list[str]:
    return [vectorize(glass(), 2, options=SHORT).svg]


def _holes() -> list[str]:
    svg = vectorize(ring(), 3, options=SHORT).svg
    assert svg.count("M") > svg.count("<path"), "no layer has a hole"
    return [svg]


def _start_and_lock() -> list[str]:
    start = vectorize(SMALL, 2, options=SHORT).drawing
    moved = three_shapes(24, shift=1.0)
    return [vectorize(moved, 1, options=SHORT, start=start, lock=[0]).svg]


def _sequence() -> list[str]:
    frames = [three_shapes(24, shift) for shift in (0.0, 1.0, 2.0)]
    return [format_svg(drawing) for drawing in vectorize_sequence(frames, paths=3, options=SHORT).drawings]


def _file() -> list[str]:
    # Through an encoded picture, as the command line reads it, and a canvas larger than the working copy.
    recipe = livecl.Recipe(paths=2, options=dataclasses.replace(SHORT, revisions=0), size=24)
    return [recipe.svg(recipe.vectorize(three_shapes(48)).drawing)]


def _busy() -> list[str]:
    return [vectorize(busy_picture(300), 12, options=Options(placement="region", iterations=3, revisions=1)).svg]


RUNS: dict[str, Callable[[], list[str]]] = {
    "default": _default,
    "paper": _paper,
    "random": _random,
    "alpha": _alpha,
    "holes": _holes,
    "start and lock": _start_and_lock,
    "sequence": _sequence,
    "reduced": _file,
}
#: Takes some seconds.
BUSY: dict[str, Callable[[], list[str]]] = {"busy": _busy}


def digests(names: Sequence[str] = tuple(RUNS)) -> dict[str, str]:
    """Do the runs of these names; return a digest of the SVGs of each."""
    made = {name: {**RUNS, **BUSY}[name]() for name in names}
    return {name: hashlib.sha256("\0".join(svgs).encode()).hexdigest() for name, svgs in made.items()}


if __name__ == "__main__":
    locale.setlocale(locale.LC_ALL, "")  # which Python itself does for LC_CTYPE only
    print(json.dumps(digests(sys.argv[1:] or tuple(RUNS))))  # noqa: T201
