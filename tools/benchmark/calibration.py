# SPDX-License-Identifier: Apache-2.0
"""What the machine can do at this moment: how fast it multiplies and adds, and how fast it copies.

Both are measured with kernels of the same kind as the program's, on all cores of the OpenCL device, and the median of
some repeats is taken, not the best: where other programs take their share of the machine, they take it from what is
measured too.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pyopencl as cl

from livecl.opencl.device import OpenDevice
from livecl.opencl.program import compile_source

#: Sums of which none waits for another. Two leave the units idle most of the time, as the program's own kernels do;
#: eight keep them busy: the peak, from which the floor is reckoned.
REFERENCE_SUMS, PEAK_SUMS = 2, 8
#: Sizes of buffers that are copied, bytes: from what a core's own cache holds to what no cache holds.
COPY_BYTES = (1 << 18, 1 << 21, 1 << 24, 1 << 27)
_REPEATS = 9
_ROUNDS = 4096
#: Work-items for each compute unit, on a CPU and elsewhere; work-items in a group.
_ITEMS, _LOCAL = {True: 128, False: 1024}, {True: 1, False: 32}
_LANES, _VECTOR_BYTES, _BLOCK = 8, 32, 2048


def _source() -> str:
    """Return the kernels: chains of a*b+c, as the program writes it; a copy of 64 KiB a work-item."""
    kernels = []
    for sums in (REFERENCE_SUMS, PEAK_SUMS):
        names = [f"s{i}" for i in range(sums)]
        kernels.append(
            f"__kernel void multiply_add_{sums}(int rounds, __global const float *factors, __global float8 *out)\n"
            "{\n"
            "    float8 a = factors[0], b = factors[1];\n"
            f"    float8 {', '.join(f'{name} = {i}' for i, name in enumerate(names))};\n"
            f"    for (int i = 0; i < rounds; i++) {{ {' '.join(f'{name} = {name} * a + b;' for name in names)} }}\n"
            f"    out[get_global_id(0)] = {' + '.join(names)};\n"
            "}\n"
        )
    kernels.append(
        "__kernel void copy(int rounds, __global const float8 *from, __global float8 *to)\n"
        "{\n"
        f"    int begin = get_global_id(0) * {_BLOCK};\n"
        "    for (int round = 0; round < rounds; round++)\n"
        f"        for (int i = begin; i < begin + {_BLOCK}; i++) to[i] = from[i] + round;\n"
        "}\n"
    )
    return "".join(kernels)


class MultiplyAdd:
    """Measures the rate of a*b+c on vectors of eight floats, on all cores.

    Parameters
    ----------
    opened : OpenDevice
        The device.
    sums : int
        `REFERENCE_SUMS` or `PEAK_SUMS`.
    """

    def __init__(self, opened: OpenDevice, sums: int) -> None:
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        factors = cl.Buffer(opened.context, flags, hostbuf=np.array([0.5, 0.25], np.float32))
        self._num_items = _ITEMS[opened.is_cpu] * opened.device.max_compute_units
        out = cl.Buffer(opened.context, cl.mem_flags.WRITE_ONLY, self._num_items * _VECTOR_BYTES)
        self._opened = opened
        self._kernel = cl.Kernel(_program(opened), f"multiply_add_{sums}")
        self._kernel.set_args(np.int32(_ROUNDS), factors, out)
        self._buffers = factors, out  # kernels do not keep their arguments alive
        self._operations = 2 * sums * _LANES * _ROUNDS * self._num_items
        self.once()  # the first launch may still compile

    def once(self) -> float:
        """Return the rate of one launch of about a millisecond, GFLOP/s."""
        return 1e-9 * self._operations / _seconds(self._opened, self._kernel, self._num_items)

    def rate(self) -> float:
        """Return the median rate of three launches, GFLOP/s."""
        return float(np.median([self.once() for _ in range(3)]))


@functools.cache
def _program(opened: OpenDevice) -> Any:
    return compile_source(opened, _source())


def _seconds(opened: OpenDevice, kernel: Any, num_items: int) -> float:
    """Time of a launch by the device's clock."""
    local = _LOCAL[opened.is_cpu]
    return _event_seconds(cl.enqueue_nd_range_kernel(opened.queue, kernel, (num_items,), (local,)))


def _event_seconds(event: Any) -> float:
    event.wait()
    return 1e-9 * float(event.profile.end - event.profile.start)


def copy_rate(opened: OpenDevice, num_bytes: int) -> float:
    """Return the rate of copying a buffer, GB/s, reads and writes counted; in rounds, where one would be too short.

    On a CPU a kernel copies, on all cores; elsewhere the driver does.
    """
    source, target = (cl.Buffer(opened.context, cl.mem_flags.READ_WRITE, num_bytes) for _ in range(2))
    cl.enqueue_copy(opened.queue, source, np.ones(num_bytes // 4, np.float32))
    kernel = cl.Kernel(_program(opened), "copy")
    rounds = max(1, COPY_BYTES[-2] // num_bytes) if opened.is_cpu else 1
    kernel.set_args(np.int32(rounds), source, target)

    def once() -> float:
        if opened.is_cpu:
            return _seconds(opened, kernel, num_bytes // (_BLOCK * _VECTOR_BYTES))
        return _event_seconds(cl.enqueue_copy(opened.queue, target, source))

    seconds = [once() for _ in range(1 + _REPEATS)]
    for buffer in (source, target):
        buffer.release()
    return 1e-9 * 2 * num_bytes * rounds / float(np.median(seconds[1:]))


def calibrate(opened: OpenDevice) -> dict[str, Any]:
    """Return the rates at this moment: GFLOP/s of the reference kernel and at the peak, GB/s of copies by size.

    The two kernels take turns, so that what else runs on the machine disturbs both alike.
    """
    reference, peak = MultiplyAdd(opened, REFERENCE_SUMS), MultiplyAdd(opened, PEAK_SUMS)
    rates = np.median([(reference.once(), peak.once()) for _ in range(4 * _REPEATS)], axis=0)
    return {
        "reference_gflops": float(rates[0]),
        "peak_gflops": float(rates[1]),
        "copy_gigabytes": {str(size): copy_rate(opened, size) for size in COPY_BYTES},
    }
