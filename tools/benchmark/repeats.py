# SPDX-License-Identifier: Apache-2.0
"""Repeated measurements, each with the machine's rate at that moment, and what is told of them."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmark.limit import REFERENCE_GFLOPS

#: Repeats are made until this many seconds are over, within these numbers.
SECONDS, FEWEST, MOST = 2.0, 3, 1000
#: Seconds between two looks at the machine's rate.
BLOCK = 0.03


@dataclasses.dataclass
class Repeats:
    """Seconds of each repeat, and the machine's reference rate then, GFLOP/s."""

    seconds: list[float] = dataclasses.field(default_factory=list)
    rates: list[float] = dataclasses.field(default_factory=list)

    def summary(self) -> dict[str, Any]:
        """Return number, median, minimum and mean, ms; the median at the reference rate; the median rate."""
        seconds, rates = np.array(self.seconds), np.array(self.rates)
        return {
            "repeats": len(seconds),
            "median_ms": 1e3 * float(np.median(seconds)),
            "minimum_ms": 1e3 * float(seconds.min()),
            "mean_ms": 1e3 * float(seconds.mean()),
            "scaled_ms": 1e3 * float(np.median(seconds * rates)) / REFERENCE_GFLOPS,
            "gflops": float(np.median(rates)),
        }


def repeated(work: Callable[[], float | None], rate: Callable[[], float], repeats: int | None = None) -> Repeats:
    """Measure repeats of something.

    The machine's rate is looked at before and after each block of repeats, as another program may come or go: a repeat
    counts with the mean of the two.

    Parameters
    ----------
    work : callable
        What is measured; it may return its seconds itself.
    rate : callable
        Returns the machine's rate at this moment, GFLOP/s.
    repeats : int or None
        How many; None for as many as fit `SECONDS`.
    """
    found = Repeats()
    start = time.perf_counter()
    before, in_block, block_start = rate(), 0, start
    while len(found.seconds) < (MOST if repeats is None else repeats):
        if repeats is None and len(found.seconds) >= FEWEST and time.perf_counter() - start > SECONDS:
            break
        begin = time.perf_counter()
        own = work()
        found.seconds.append(time.perf_counter() - begin if own is None else own)
        in_block += 1
        if time.perf_counter() - block_start > BLOCK:
            after = rate()
            found.rates += [(before + after) / 2] * in_block
            before, in_block, block_start = after, 0, time.perf_counter()
    found.rates += [(before + rate()) / 2] * in_block
    return found
