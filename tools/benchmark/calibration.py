# SPDX-License-Identifier: Apache-2.0
"""Measure the machine's present rate of multiplications and additions, beside each measurement of a case.

The kernel is similar to the program's, on all cores of the OpenCL device, and the median of some launches is used, not
the best, so that load from other programs affects it as it affects the measurement.
"""

from __future__ import annotations

import dataclasses
import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmark.package import compiled

#: The rate for which times are stated, GFLOP/s: that of the kernel with PoCL from pip on two quiet cores of the machine
#: for which the goals were set.
REFERENCE_GFLOPS = 60.0
#: Two independent sums leave the units idle most of the time, as the program's own kernels do.
SOURCE = """
__kernel void multiply_add(int rounds, __global const float *factors, __global float8 *out)
{
    float8 a = factors[0], b = factors[1], s0 = 0, s1 = 1;
    for (int i = 0; i < rounds; i++) { s0 = s0 * a + b; s1 = s1 * a + b; }
    out[get_global_id(0)] = s0 + s1;
}
"""
SUMS, LANES, ROUNDS = 2, 8, 4096
#: Work-items for each compute unit, on a CPU and elsewhere; work-items in a group.
ITEMS, LOCAL = {True: 128, False: 1024}, {True: 1, False: 32}
#: Time of all repeats, seconds, and the least and largest number of repeats.
SECONDS, MIN_SAMPLES, MAX_SAMPLES = 2.0, 3, 1000
#: Seconds between two measurements of the machine's rate.
BLOCK = 0.03


class MultiplyAdd:
    """Measures the rate of a*b+c on vectors of eight floats.

    Parameters
    ----------
    opened : OpenDevice
        The device.
    """

    def __init__(self, opened: Any) -> None:
        import pyopencl as cl

        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        self._items = ITEMS[opened.is_cpu] * opened.device.max_compute_units
        self._buffers = (
            cl.Buffer(opened.context, flags, hostbuf=np.array([0.5, 0.25], np.float32)),
            cl.Buffer(opened.context, cl.mem_flags.WRITE_ONLY, self._items * LANES * 4),
        )
        kernel = cl.Kernel(compiled(opened, SOURCE), "multiply_add")
        kernel.set_args(np.int32(ROUNDS), *self._buffers)
        sizes = (self._items,), (LOCAL[opened.is_cpu],)
        self._launch = lambda: cl.enqueue_nd_range_kernel(opened.queue, kernel, *sizes)
        self.once()  # the first launch may still compile

    def once(self) -> float:
        """Return the rate of one launch of about a millisecond, GFLOP/s."""
        event = self._launch()
        event.wait()
        return 2 * SUMS * LANES * ROUNDS * self._items / float(event.profile.end - event.profile.start)

    def rate(self) -> float:
        """Return the median rate of three launches, GFLOP/s."""
        return float(np.median([self.once() for _ in range(3)]))


@dataclasses.dataclass
class Repeats:
    """Seconds of each repeat, of processors too, and the machine's reference rate then, GFLOP/s."""

    seconds: list[float] = dataclasses.field(default_factory=list)
    processor: list[float] = dataclasses.field(default_factory=list)
    rates: list[float] = dataclasses.field(default_factory=list)

    def summary(self) -> dict[str, Any]:
        """Return number, median and minimum, ms; medians at the reference rate and of processor time; of the rate."""
        seconds, rates = np.array(self.seconds), np.array(self.rates)
        return {
            "repeats": len(seconds),
            "median_ms": 1e3 * float(np.median(seconds)),
            "minimum_ms": 1e3 * float(seconds.min()),
            "scaled_ms": 1e3 * float(np.median(seconds * rates)) / REFERENCE_GFLOPS,
            "processor_ms": 1e3 * float(np.median(self.processor)),
            "gflops": float(np.median(rates)),
        }


def processor_seconds() -> float:
    """Return the time of processors that this process has used, its threads and ended subprocesses included, s."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def repeated(work: Callable[[], float | None], rate: Callable[[], float], repeats: int | None = None) -> Repeats:
    """Measure repeats of something.

    The machine's rate is measured before and after each block of repeats, as load may change: a repeat counts with the
    mean of the two.

    Parameters
    ----------
    work : callable
        The work to measure; it may return its seconds itself.
    rate : callable
        Returns the machine's present rate, GFLOP/s.
    repeats : int or None
        Number of repeats; None for as many as fit into `SECONDS`.
    """
    found = Repeats()
    start = time.perf_counter()
    before, in_block, block_start = rate(), 0, start
    while len(found.seconds) < (MAX_SAMPLES if repeats is None else repeats):
        if repeats is None and len(found.seconds) >= MIN_SAMPLES and time.perf_counter() - start > SECONDS:
            break
        begin, used = time.perf_counter(), processor_seconds()
        own = work()
        found.seconds.append(time.perf_counter() - begin if own is None else own)
        found.processor.append(processor_seconds() - used)
        in_block += 1
        if time.perf_counter() - block_start > BLOCK:
            after = rate()
            found.rates += [(before + after) / 2] * in_block
            before, in_block, block_start = after, 0, time.perf_counter()
    found.rates += [(before + rate()) / 2] * in_block
    return found
