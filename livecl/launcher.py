# SPDX-License-Identifier: Apache-2.0
"""Buffers by name and kernel launches on one device, with as little host work for each launch as OpenCL allows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyopencl as cl
from numpy.typing import NDArray

from livecl.device import OpenDevice
from livecl.errors import DeviceError
from livecl.program import build_kernels

#: Work-items in a work-group. A CPU runs a group's items one after the other, and private arrays count for each of them.
LOCAL_SIZE_CPU, LOCAL_SIZE_GPU = 1, 32


class Launcher:
    """Calls kernels of one build: ``launcher(name, num_items, argument, ...)``.

    An argument is a buffer's name, a buffer, a NumPy scalar, or an array of four int32 (an ``int4``). Arguments that are
    the same as in the call before are not set again: setting them is most of a launch's cost.

    Parameters
    ----------
    opened : OpenDevice
        The device, its context and queue.
    dtype : float32 or float64
        Number type of the kernels.
    channels : int
        Channels of the image, 3 or 4.
    """

    def __init__(self, opened: OpenDevice, dtype: np.dtype[Any], channels: int) -> None:
        self.channels = channels
        self._dtype = dtype
        self._opened = opened
        self._kernels = build_kernels(opened, dtype, channels)
        self._local_size = LOCAL_SIZE_CPU if opened.is_cpu else LOCAL_SIZE_GPU
        self._buffers: dict[str, Any] = {}
        self._arguments: dict[str, list[Any]] = {name: [] for name in self._kernels}
        self._written: dict[str, NDArray[Any]] = {}

    def reserve(self, name: str, num_bytes: int) -> Any:
        """Return the buffer of that name, made anew (half as large again) if it is smaller than asked for.

        Raises
        ------
        DeviceError
            If the device has no room for it.
        """
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < num_bytes:
            size = max(64, num_bytes if buffer is None else num_bytes * 3 // 2)
            try:
                buffer = cl.Buffer(self._opened.context, cl.mem_flags.READ_WRITE, size)
            except cl.Error as error:
                raise DeviceError(f"{self._opened.info} has no room for {size} bytes ({name}): {error}") from error
            self._buffers[name] = buffer
        return buffer

    def write(self, name: str, values: NDArray[Any]) -> None:
        """Copy an array into the buffer of that name, without waiting."""
        buffer = self.reserve(name, values.nbytes)
        if values.nbytes:
            self._written[name] = values = np.ascontiguousarray(values)  # must live until the copy is done
            cl.enqueue_copy(self._opened.queue, buffer, values, is_blocking=False)

    def read(self, name: str, count: int) -> NDArray[Any]:
        """Wait for all launches, and return the first `count` numbers of a buffer."""
        values = np.empty(count, self._dtype)
        cl.enqueue_copy(self._opened.queue, values, self._buffers[name])
        return values

    def __call__(self, name: str, num_items: int, *arguments: Any) -> None:
        """Launch a kernel on `num_items` work-items, padded to whole work-groups."""
        if num_items == 0:
            return
        kernel, last = self._kernels[name], self._arguments[name]
        for index, argument in enumerate(arguments):
            value = self._buffers[argument] if isinstance(argument, str) else argument
            if index < len(last) and _same(last[index], value):
                continue
            kernel.set_arg(index, value)
            last[index:] = [value, *last[index + 1 :]]
        local = self._local_size
        cl.enqueue_nd_range_kernel(self._opened.queue, kernel, (-(-num_items // local) * local,), (local,))


def _same(a: Any, b: Any) -> bool:
    if a is b:
        return True
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and bool((a == b).all())
    return isinstance(a, np.generic) and isinstance(b, np.generic) and a == b
