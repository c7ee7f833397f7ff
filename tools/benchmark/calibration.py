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

#: The multiply-add rate that times are stated for, GFLOP/s.
REFERENCE_GFLOPS = 60.0
#: Bytes that are copied: more than any cache holds, once read and once written.
COPY_BYTES = 1 << 27
_REPEATS = 9
_ITEMS, _ROUNDS = 256, 4096

# Eight sums, none waiting for another: enough to keep two units busy that each take four cycles for a multiply-add.
# a*b+c, as the program writes it. Work-items of the copy move 64 KiB each.
_SOURCE = """
__kernel void multiply_add(int rounds, __global const float *factors, __global float8 *out)
{
    float8 a = factors[0], b = factors[1];
    float8 s0 = 0, s1 = 1, s2 = 2, s3 = 3, s4 = 4, s5 = 5, s6 = 6, s7 = 7;
    for (int i = 0; i < rounds; i++) {
        s0 = s0 * a + b; s1 = s1 * a + b; s2 = s2 * a + b; s3 = s3 * a + b;
        s4 = s4 * a + b; s5 = s5 * a + b; s6 = s6 * a + b; s7 = s7 * a + b;
    }
    out[get_global_id(0)] = ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7));
}

#define BLOCK 2048
__kernel void copy(__global const float8 *from, __global float8 *to)
{
    int begin = get_global_id(0) * BLOCK;
    for (int i = begin; i < begin + BLOCK; i++) to[i] = from[i];
}
"""
_VECTOR_BYTES, _BLOCK = 32, 2048
#: Multiply-adds of a work-item and round: sums x lanes; each is two operations.
_OPERATIONS = 2 * 8 * 8


@functools.cache
def _program(context: Any) -> Any:
    return cl.Program(context, _SOURCE).build()


def _median_seconds(opened: OpenDevice, kernel: Any, num_items: int) -> float:
    """Median time of a launch by the device's clock, the first one left out: it may still compile."""
    local = (1,) if opened.is_cpu else (32,)
    seconds = []
    for _ in range(1 + _REPEATS):
        event = cl.enqueue_nd_range_kernel(opened.queue, kernel, (num_items,), local)
        event.wait()
        seconds.append(1e-9 * (event.profile.end - event.profile.start))
    return float(np.median(seconds[1:]))


def multiply_add_rate(opened: OpenDevice) -> float:
    """Return the rate of a*b+c on vectors of eight floats, GFLOP/s."""
    flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
    factors = cl.Buffer(opened.context, flags, hostbuf=np.array([0.5, 0.25], np.float32))
    out = cl.Buffer(opened.context, cl.mem_flags.WRITE_ONLY, _ITEMS * _VECTOR_BYTES)
    kernel = cl.Kernel(_program(opened.context), "multiply_add")
    kernel.set_args(np.int32(_ROUNDS), factors, out)
    return 1e-9 * _OPERATIONS * _ROUNDS * _ITEMS / _median_seconds(opened, kernel, _ITEMS)


def copy_rate(opened: OpenDevice, num_bytes: int = COPY_BYTES) -> float:
    """Return the rate of copying a buffer that no cache holds, GB/s, reads and writes counted."""
    flags = cl.mem_flags.READ_WRITE
    source, target = (cl.Buffer(opened.context, flags, num_bytes) for _ in range(2))
    cl.enqueue_copy(opened.queue, source, np.ones(num_bytes // 4, np.float32))
    kernel = cl.Kernel(_program(opened.context), "copy")
    kernel.set_args(source, target)
    seconds = _median_seconds(opened, kernel, num_bytes // (_BLOCK * _VECTOR_BYTES))
    for buffer in (source, target):
        buffer.release()
    return 1e-9 * 2 * num_bytes / seconds
