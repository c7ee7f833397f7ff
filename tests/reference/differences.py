# SPDX-License-Identifier: Apache-2.0
"""Derivatives by differences, of functions with several values at once.

`by_small_steps` is for control points. The central difference D(h) of a function with one-sided derivatives is their
mean, up to an error that is even in h where the function is smooth and begins with h where it has a kink at the point
itself, as coverage has for an edge on a pixel border. 2 D(h / 2) - D(h) removes that first term, so one formula serves
both. With h = 1e-5 px the error for a smooth function is about 1e-10 of its third derivative, and rounding gives
about 1e-13 (300 pixels of error 1e-14) / 1e-5 = 1e-8: both well below the 1e-6 that is tested.

`of_quadratic` is for colours, in which a quadratic loss of the image is quadratic: any three points give its derivative
exactly, so they can lie inside [0, 1] also for an opacity of 0 or 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

STEP = 1e-5


def by_small_steps(
    function: Callable[[FloatArray], FloatArray],
    x: FloatArray,
    entries: Sequence[int] | None = None,
    step: float = STEP,
) -> FloatArray:
    """Return the derivatives of function(x) (K,) by the given flat entries of x, or by all: (K, entries)."""

    def difference(entry: int, h: float) -> FloatArray:
        delta = np.zeros_like(x)
        delta.flat[entry] = h
        return (function(x + delta) - function(x - delta)) / (2 * h)

    columns = [
        2 * difference(entry, step / 2) - difference(entry, step)
        for entry in (range(x.size) if entries is None else entries)
    ]
    return np.stack(columns, axis=1)


def of_quadratic(
    function: Callable[[FloatArray], FloatArray], x: FloatArray, entries: Sequence[int] | None = None
) -> FloatArray:
    """Return the derivatives of function(x) (K,), a quadratic in each entry of x in [0, 1]: (K, entries)."""
    columns = []
    for entry in range(x.size) if entries is None else entries:
        value = x.flat[entry]
        step = 0.25 if value < 0.5 else -0.25
        samples = []
        for steps in range(3):
            moved = x.copy()
            moved.flat[entry] = value + steps * step
            samples.append(function(moved))
        columns.append((-3 * samples[0] + 4 * samples[1] - samples[2]) / (2 * step))
    return np.stack(columns, axis=1)
