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

from livecl.device import OpenDevice

#: The multiply-add rate that times are stated for, GFLOP/s: what the kernel with `REFERENCE_SUMS` gives on two quiet cores
#: with PoCL from pip (59; a core that waits for each sum does no more than this).
REFERENCE_GFLOPS = 60.0
#: Sums of which none waits for another. Two leave the units idle most of the time, as the program's own kernels do; eight
#: keep them busy: the peak, from which the floor is reckoned.
REFERENCE_SUMS, PEAK_SUMS = 2, 8
#: Bytes that are copied: more than any cache holds, once read and once written.
COPY_BYTES = 1 << 27
_REPEATS = 9
_ITEMS, _ROUNDS = 256, 4096
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
        "__kernel void copy(__global const float8 *from, __global float8 *to)\n"
        "{\n"
        f"    int begin = get_global_id(0) * {_BLOCK};\n"
        f"    for (int i = begin; i < begin + {_BLOCK}; i++) to[i] = from[i];\n"
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
        out = cl.Buffer(opened.context, cl.mem_flags.WRITE_ONLY, _ITEMS * _VECTOR_BYTES)
        self._opened = opened
        self._kernel = cl.Kernel(_program(opened.context), f"multiply_add_{sums}")
        self._kernel.set_args(np.int32(_ROUNDS), factors, out)
        self._operations = 2 * sums * _LANES * _ROUNDS * _ITEMS
        self.once()  # the first launch may still compile

    def once(self) -> float:
        """Return the rate of one launch of about a millisecond, GFLOP/s."""
        return 1e-9 * self._operations / _seconds(self._opened, self._kernel, _ITEMS)

    def rate(self) -> float:
        """Return the median rate of three launches, GFLOP/s."""
        return float(np.median([self.once() for _ in range(3)]))


@functools.cache
def _program(context: Any) -> Any:
    return cl.Program(context, _source()).build()


def _seconds(opened: OpenDevice, kernel: Any, num_items: int) -> float:
    """Time of a launch by the device's clock."""
    event = cl.enqueue_nd_range_kernel(opened.queue, kernel, (num_items,), (1,) if opened.is_cpu else (32,))
    event.wait()
    return 1e-9 * float(event.profile.end - event.profile.start)


def copy_rate(opened: OpenDevice, num_bytes: int = COPY_BYTES) -> float:
    """Return the rate of copying a buffer that no cache holds, GB/s, reads and writes counted."""
    flags = cl.mem_flags.READ_WRITE
    source, target = (cl.Buffer(opened.context, flags, num_bytes) for _ in range(2))
    cl.enqueue_copy(opened.queue, source, np.ones(num_bytes // 4, np.float32))
    kernel = cl.Kernel(_program(opened.context), "copy")
    kernel.set_args(source, target)
    num_items = num_bytes // (_BLOCK * _VECTOR_BYTES)
    seconds = [_seconds(opened, kernel, num_items) for _ in range(1 + _REPEATS)]
    for buffer in (source, target):
        buffer.release()
    return 1e-9 * 2 * num_bytes / float(np.median(seconds[1:]))


def calibrate(opened: OpenDevice) -> dict[str, float]:
    """Return the machine's rates at this moment: GFLOP/s of the reference kernel and at the peak, GB/s of a copy.

    The two kernels take turns, so that what else runs on the machine disturbs both alike.
    """
    reference, peak = MultiplyAdd(opened, REFERENCE_SUMS), MultiplyAdd(opened, PEAK_SUMS)
    rates = np.median([(reference.once(), peak.once()) for _ in range(4 * _REPEATS)], axis=0)
    return {
        "reference_gflops": float(rates[0]),
        "peak_gflops": float(rates[1]),
        "copy_gigabytes": copy_rate(opened),
    }
