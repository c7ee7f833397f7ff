# SPDX-License-Identifier: Apache-2.0
"""Checks of the arguments of a `Drawing`: errors name the argument, and no value is converted silently."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from livecl.arrays import FloatArray, Int32Array
from livecl.errors import readable

#: Largest canvas side accepted, px.
MAX_SIDE = 32768
#: Longest name kept, characters.
MAX_NAME = 120


def checked_size(size: Any) -> tuple[int, int]:
    """Return (height, width), px."""
    try:
        height, width = size
        if int(height) != height or int(width) != width:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        got = reprlib.repr(size)
        raise ValueError(f"size: got {got}, wanted (height, width) as two whole numbers of pixels") from None
    if not (1 <= height <= MAX_SIDE and 1 <= width <= MAX_SIDE):
        raise ValueError(f"size: got {reprlib.repr(size)}, wanted sides of 1 to {MAX_SIDE} px")
    return int(height), int(width)


def checked_floats(name: str, value: Any, shape: tuple[int, ...] | None, low: float, high: float) -> FloatArray:
    """Return an array of a shape (-1: any number; None: any shape), with numbers within [low, high]."""
    try:
        given = np.asarray(value)
    except ValueError:  # rows of different lengths
        given = np.array(None)
    if given.dtype.kind not in "biuf":
        raise ValueError(f"{name}: got {reprlib.repr(value)}, wanted an array of numbers")
    array = np.array(given, dtype=np.float64)
    if shape is not None:
        wanted = "(" + ", ".join("any" if n < 0 else str(n) for n in shape) + ("," if len(shape) == 1 else "") + ")"
        if array.ndim != len(shape) or any(n not in (-1, m) for n, m in zip(shape, array.shape, strict=True)):
            raise ValueError(f"{name}: shape {array.shape}, wanted {wanted}")
    if not np.all((array >= low) & (array <= high)):
        raise ValueError(f"{name}: all numbers must be finite and within [{low:g}, {high:g}]")
    return array


def checked_names(names: Sequence[str], num_layers: int) -> tuple[str, ...]:
    """Return one clean name for each layer."""
    listed = isinstance(names, Collection) and not isinstance(names, str)
    if not listed or not all(isinstance(name, str) for name in names) or len(names) != num_layers:
        raise ValueError(f"names: got {reprlib.repr(names)}, wanted {num_layers} texts, one for each layer")
    return tuple(clean_name(name) for name in names)


def checked_groups(groups: Sequence[Sequence[str]], num_layers: int) -> tuple[tuple[str, ...], ...]:
    """Return the clean names of the groups around each layer, the outermost first; empty ones are left out."""
    listed = isinstance(groups, Collection) and not isinstance(groups, str) and len(groups) == num_layers
    if not listed or not all(
        isinstance(path, Collection) and not isinstance(path, str) and all(isinstance(name, str) for name in path)
        for path in groups
    ):
        got = reprlib.repr(groups)
        raise ValueError(f"groups: got {got}, wanted {num_layers} lists of names, one for each layer")
    return tuple(tuple(name for name in map(clean_name, path) if name) for path in groups)


def checked_offsets(name: str, value: Any, count: int | None, end: int) -> Int32Array:
    """Return offsets that rise from 0 to `end`; of `count` items, where that is given."""
    array = checked_integers(name, value)
    if array.ndim != 1 or not len(array) or (count is not None and len(array) != count + 1):
        raise ValueError(
            f"{name}: shape {array.shape}, wanted {'one offset more than items' if count is None else (count + 1,)}"
        )
    if array[0] != 0 or array[-1] != end or np.any(np.diff(array) < 1):
        raise ValueError(f"{name}: offsets must rise from 0 to {end} with at least one item each")
    return array


def checked_integers(name: str, value: Any) -> Int32Array:
    """Return whole numbers as they are; a cast by itself would cut off fractions, and high bits."""
    array = checked_floats(name, value, None, float(np.iinfo(np.int32).min), float(np.iinfo(np.int32).max))
    if np.any(array != np.rint(array)):
        raise ValueError(f"{name}: got {reprlib.repr(value)}, wanted whole numbers")
    return array.astype(np.int32)


def clean_name(text: str) -> str:
    """Return a name on one line of at most 120 characters; runs of spaces and invisible characters become a space."""
    return readable(text[: 4 * MAX_NAME])[:MAX_NAME].rstrip()


def python_number(value: Any) -> Any:
    """Return a number of NumPy's as Python's own, and anything else as it is."""
    return value.item() if isinstance(value, np.generic) else value


def check_whole(name: str, value: Any, least: int) -> None:
    """Raise ValueError unless a value is an int, and no bool, of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ValueError(f"{name}: got {reprlib.repr(value)}, wanted a whole number of at least {least}")


def check_number(name: str, value: float, least: float, most: float = math.inf) -> None:
    """Raise ValueError unless a number is finite, at least `least` and at most `most`."""
    if not (math.isfinite(value) and least <= value <= most):
        limit = "" if most == math.inf else f" and at most {most:g}"
        raise ValueError(f"{name}: got {value!r}, wanted a finite number of at least {least:g}{limit}")
