# SPDX-License-Identifier: Apache-2.0
"""Kernel launches on one device, with arguments by name and little host work for each launch."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyopencl as cl
from numpy.typing import NDArray

from livecl.opencl.device import OpenDevice
from livecl.opencl.program import build_program, kernel_parameters, make_kernel

#: Work-items in a work-group. A CPU runs them one after the other and needs private arrays for each: so one, except for
#: kernels of many small work-items without such arrays.
LOCAL_SIZE_CPU, LOCAL_SIZE_GPU = 1, 32
LOCAL_SIZES_CPU = {"coverage_backward": 16}


@dataclasses.dataclass(frozen=True)
class _BoundKernel:
    """A kernel object: work-items of its groups, names of its arguments, and the values set last."""

    kernel: Any
    local_size: int
    keys: list[str]
    arguments: list[Any]


class Launcher:
    """Buffers, structs and scalars under the names of the kernels' parameters, and the kernels of one build.

    A name may belong to a scope, ``scope_name``: a kernel launched with that scope takes it before the plain one.
    Arguments that have not changed since the last launch are not set again: that is most of a launch's cost.

    Parameters
    ----------
    opened : OpenDevice
        The device, its context and queue.
    dtype : float32 or float64
        Number type of the kernels, `real`.
    channels : int
        Channels of the image, 3 or 4.
    fills : bool
        Whether kernels support gradient fills; others are faster.
    """

    def __init__(self, opened: OpenDevice, dtype: np.dtype[Any], channels: int, fills: bool = False) -> None:
        self.dtype = dtype
        self._opened = opened
        self._program = build_program(opened, dtype, channels, fills)
        self._bound: dict[tuple[str, str], _BoundKernel] = {}
        self._values: dict[str, Any] = {}
        self._given: dict[str, Any] = {}
        self._written: dict[str, NDArray[Any]] = {}
        #: If a list, each launch appends the kernel's name and its event, for profiling.
        self.trace: list[tuple[str, Any]] | None = None

    def reserve(self, sizes: Mapping[str, int]) -> None:
        """Allocate buffers: a buffer that is too small is replaced by one half as large again as requested.

        Parameters
        ----------
        sizes : mapping from str to int
            Bytes of each buffer, by name, of all that are needed together.

        Raises
        ------
        DeviceMemoryError
            If the device has no room for one of them, or for all; none is allocated then.
        """
        self._opened.require_room(sizes)
        for name, num_bytes in sizes.items():
            self._reserve(name, num_bytes)

    def _reserve(self, name: str, num_bytes: int) -> Any:
        buffer = self._values.get(name)
        if buffer is None or buffer.size < num_bytes:
            size = max(64, num_bytes if buffer is None else min(num_bytes * 3 // 2, self._opened.max_bytes))
            buffer = self._values[name] = self._opened.buffer(name, size)
        return buffer

    def buffer(self, name: str) -> Any:
        """Return a buffer by name."""
        return self._values[name]

    def set(self, **values: Any) -> None:
        """Set scalars (int, or float for `real`), structs (as arrays), and buffers allocated elsewhere."""
        for name, value in values.items():
            last = self._given.get(name)
            if last is value or (isinstance(value, (int, float)) and last == value and type(last) is type(value)):
                continue
            self._given[name] = value
            if isinstance(value, float):
                value = self.dtype.type(value)
            elif isinstance(value, int):  # bool too
                value = np.int32(value)
            self._values[name] = value

    def write(self, name: str, values: NDArray[Any]) -> None:
        """Copy an array into a buffer, without waiting.

        If the device is the processor, into a new buffer: allocating one takes 2 us, a copy command 10 to 40.
        """
        if not values.nbytes:
            self._reserve(name, 0)
        elif self._opened.is_cpu:
            self._values[name] = self._opened.buffer(name, values.nbytes, np.ascontiguousarray(values))
        else:
            self._written[name] = values = np.ascontiguousarray(values)  # kept alive until the copy is done
            cl.enqueue_copy(self._opened.queue, self._reserve(name, values.nbytes), values, is_blocking=False)

    def write_reals(self, name: str, *parts: NDArray[Any]) -> None:
        """Copy flat arrays, concatenated, into a buffer, without waiting."""
        self.write(name, np.concatenate(parts).astype(self.dtype))

    def read(self, name: str, shape: int | tuple[int, ...]) -> NDArray[Any]:
        """Wait for all launches, and return the first numbers of a buffer as an array of a shape."""
        values = np.empty(shape, self.dtype)
        cl.enqueue_copy(self._opened.queue, values, self._values[name])
        return values

    def __call__(self, name: str, num_items: int, scope: str = "") -> None:
        """Launch a kernel on `num_items` work-items, padded to whole work-groups."""
        if num_items == 0:
            return
        bound = self._bound.get((name, scope)) or self._bind(name, scope)
        kernel, arguments, values = bound.kernel, bound.arguments, self._values
        for index, key in enumerate(bound.keys):
            value = values[key]
            if value is not arguments[index]:
                kernel.set_arg(index, value)
                arguments[index] = value
        local = bound.local_size
        event = cl.enqueue_nd_range_kernel(self._opened.queue, kernel, (-(-num_items // local) * local,), (local,))
        if self.trace is not None:
            self.trace.append((name, event))

    def _bind(self, name: str, scope: str) -> _BoundKernel:
        """Create the kernel object for a scope: objects hold their arguments, so each scope has its own."""
        scoped = [(parameter, f"{scope}_{parameter}") for parameter in kernel_parameters()[name]]
        keys = [key if key in self._values else parameter for parameter, key in scoped]
        local_size = LOCAL_SIZES_CPU.get(name, LOCAL_SIZE_CPU) if self._opened.is_cpu else LOCAL_SIZE_GPU
        kernel = make_kernel(self._program, name)
        bound = _BoundKernel(kernel, local_size, keys, [None] * len(keys))
        self._bound[name, scope] = bound
        return bound
