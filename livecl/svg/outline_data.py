# SPDX-License-Identifier: Apache-2.0
"""Write outlines as path data, with the short forms of horizontal, vertical and smooth segments."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.geometry import cyclic
from livecl.svg.servers import format_decimal

IntArray = NDArray[np.integer]

#: Most decimals of a coordinate, to which the reader rounds: float64 does not hold more for the largest coordinates.
MAX_PRECISION = 9
#: Shortest line, as a share of the largest coordinate: a reader could take a shorter one for the end of a subpath.
SHORTEST = 4e-6


def rounded_points(points: FloatArray, following: IntArray, drawn: NDArray[np.bool_], precision: int) -> FloatArray:
    """Return the control points as read back from the written data.

    Coordinates have `precision` decimals; the handles of straight segments, which are not written, are at their thirds;
    handles that differ from their neighbour's reflection by rounding only are that reflection.

    Parameters
    ----------
    points : (M, 3, 2) float64
        Segments (anchor, handle, handle), px.
    following : (M,) int
        Index of the segment after each.
    drawn : (M,) bool
        Segments that are drawn: all but the last rows of open subpaths.
    precision : int
        Decimals.
    """
    unit = 10.0**-precision
    points = np.round(points, precision) + 0.0  # turns -0 into 0
    if not len(points):
        return points
    straight = straight_segments(points, points[following, 0], precision) & drawn
    reflected = np.round(2 * points[following, 0] - points[:, 2], precision) + 0.0
    near = (np.abs(points[following, 1] - reflected) <= 1.01 * unit).all(axis=1) & ~straight & ~straight[following]
    near &= (points[:, 2] != points[following, 0]).any(axis=1) & drawn & drawn[following]
    handles = points[:, 1].copy()
    points[following[near], 1] = reflected[near]
    turned = straight_segments(points, points[following, 0], precision) & ~straight  # made lines by the reflection
    points[turned, 1] = handles[turned]
    two_lines = straight[following] & (following[following] == np.arange(len(points)))  # readers drop them
    straight &= ~two_lines
    start, end = points[straight, 0], points[following[straight], 0]
    points[straight, 1] = np.round(start + (end - start) / 3, MAX_PRECISION) + 0.0
    points[straight, 2] = np.round(end - (end - start) / 3, MAX_PRECISION) + 0.0
    return points


def straight_segments(points: FloatArray, ends: FloatArray, precision: int) -> NDArray[np.bool_]:
    """Return which segments (m, 3, 2), ending at (m, 2), are lines with handles at thirds, up to rounding: (m,)."""
    unit, chord = 10.0**-precision, ends - points[:, 0]
    off = np.abs(points[:, 1:] - points[:, :1] - chord[:, None] * (np.array([[1.0], [2.0]]) / 3)).max(axis=(1, 2))
    scale = np.maximum(np.abs(points[:, 0]).max(axis=1), 1.0)
    return np.asarray((off <= 1.01 * unit) & (np.abs(chord).max(axis=1) > np.maximum(unit / 2, SHORTEST * scale)))


def format_outline(points: FloatArray, precision: int, is_open: bool = False, cubics: bool = False) -> str:
    """Return path data of one subpath (m, 3, 2) from :func:`rounded_points`.

    Coordinates are relative, which is a fifth shorter, unless the subpath is so long or so far away that a reader that
    adds them up in float64 could be off by half of the last decimal to which it rounds. The closing line is not
    written. With `cubics` all segments are cubics.
    """
    drift = 2 * (len(points) + 1) * np.spacing(np.abs(points).max())
    relative = bool(drift < 0.5 * 10**-MAX_PRECISION)
    ends = cyclic.following(points[:, 0])
    rows = np.concatenate([points, ends[:, None]], axis=1)[: -1 if is_open else None]
    straight = straight_segments(rows[:, :3], rows[:, 3], precision) & (not cubics)
    if (
        not is_open and straight.all() and len(points) < 3
    ):  # encloses nothing: a reader would drop it if written as lines
        straight[:] = False
    units = np.rint(rows * 10**precision).astype(np.int64)
    written = [_Command("M", units[0, 0].tolist())]
    for k, (segment, line) in enumerate(zip(units, straight.tolist(), strict=True)):
        if line and not is_open and k == len(units) - 1:
            break  # Z draws it
        base = segment[0] if relative else np.zeros(2, np.int64)
        letter, numbers = _line(segment, base) if line else ("C", (segment[1:] - base).reshape(-1).tolist())
        before = units[k - 1]
        after_cubic = k > 0 and not straight[k - 1]
        if not (line or cubics) and after_cubic and (2 * segment[0] - before[2] == segment[1]).all():
            letter, numbers = "S", numbers[2:]
        written.append(_Command(letter.lower() if relative else letter, numbers))
    return _command_text(written, precision) + ("" if is_open else "Z")


class _Command(NamedTuple):
    """A letter and its numbers, in units of the last decimal."""

    letter: str
    numbers: list[int]


def _line(segment: IntArray, base: IntArray) -> tuple[str, list[int]]:
    x, y = (segment[3] - base).tolist()
    if segment[3, 1] == segment[0, 1]:
        return "H", [x]
    return ("V", [y]) if segment[3, 0] == segment[0, 0] else ("L", [x, y])


def _command_text(commands: list[_Command], precision: int) -> str:
    """Return commands as text; repeated letters are left out."""
    parts: list[str] = []
    last = ""
    for letter, numbers in commands:
        texts = [format_decimal(number, precision) for number in numbers]
        if letter == last:
            texts = [parts[-1], *texts]
        spaced = [
            number if number[0] == "-" or (number[0] == "." and "." in before) else " " + number
            for before, number in itertools.pairwise(texts)
        ]
        if letter == last:
            parts += spaced
        else:
            parts += [letter, texts[0], *spaced]
        last = letter
    return "".join(parts)
