# SPDX-License-Identifier: Apache-2.0
"""Repeated measurements and what is told of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

#: Repeats are made until this many seconds are over, within these numbers.
SECONDS, FEWEST, MOST = 2.0, 5, 400


def repeated(work: Callable[[], object], repeats: int | None = None) -> list[float]:
    """Return the seconds of each of `repeats` calls, or, for None, of as many as fit `SECONDS`."""
    seconds: list[float] = []
    start = time.perf_counter()
    while len(seconds) < (MOST if repeats is None else repeats):
        if repeats is None and len(seconds) >= FEWEST and time.perf_counter() - start > SECONDS:
            break
        before = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - before)
    return seconds


def summary(seconds: Sequence[float]) -> dict[str, Any]:
    """Return number, median, minimum and mean, in ms."""
    return {
        "repeats": len(seconds),
        "median_ms": 1e3 * float(np.median(seconds)),
        "minimum_ms": 1e3 * min(seconds),
        "mean_ms": 1e3 * float(np.mean(seconds)),
    }
