# SPDX-License-Identifier: Apache-2.0
"""The time limit that a floor means on a machine.

It is what remains if every operation were done at the rate of vector multiply-adds and every byte at the rate of a
copy, both at once, and neither Python, launches nor waiting took any time. No program reaches it: a walk along an
outline is not a stream of vector multiply-adds. It says how much is left to gain, in the same way for all cases.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

#: The multiply-add rate that times are stated for, GFLOP/s: what the reference kernel of calibration.py gives with PoCL
#: from pip on two quiet cores of the machine that the goals were set on.
REFERENCE_GFLOPS = 60.0


@dataclasses.dataclass(frozen=True)
class Floor:
    """Operations and bytes that some iterations cannot do without.

    Attributes
    ----------
    operations, bytes : float
        Of all iterations.
    iteration_bytes : float
        Bytes of the largest iteration, which decide what cache they may stay in.
    """

    operations: float
    bytes: float
    iteration_bytes: float

    def limit_ms(self, machine: Mapping[str, Any]) -> float:
        """Return the least time on the reference machine, ms.

        That is a machine with the reference rate of `REFERENCE_GFLOPS` and, in proportion, the peak of the calibrated
        one. Bytes move at the rate of a copy of the same size, as measured.

        Parameters
        ----------
        machine : mapping
            The rates, as `calibration.calibrate` returns them.
        """
        peak = machine["peak_gflops"] * REFERENCE_GFLOPS / machine["reference_gflops"]
        rates = sorted((int(size), rate) for size, rate in machine["copy_gigabytes"].items())
        copy = next((rate for size, rate in rates if 2 * size >= self.iteration_bytes), rates[-1][1])
        return 1e3 * max(self.operations / (1e9 * peak), self.bytes / (1e9 * copy))

    def __add__(self, other: Floor) -> Floor:
        return Floor(
            self.operations + other.operations,
            self.bytes + other.bytes,
            max(self.iteration_bytes, other.iteration_bytes),
        )

    def times(self, count: int) -> Floor:
        """Return the floor of `count` such iterations."""
        return Floor(count * self.operations, count * self.bytes, self.iteration_bytes)
