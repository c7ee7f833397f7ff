# SPDX-License-Identifier: Apache-2.0
"""OpenCL devices: list, choose, describe and open them, and translate their errors."""

from __future__ import annotations

import dataclasses
import functools
import importlib.metadata
import os
import re
import threading
from collections.abc import Mapping
from typing import Any

import pyopencl as cl
from numpy.typing import NDArray

from livecl.errors import DeviceError, DeviceMemoryError
from livecl.opencl.caches import prepare_pocl_cache

#: Environment variable with the default device.
DEVICE_VARIABLE = "LIVECL_DEVICE"
#: Name of PoCL's platform, and the pip package that contains PoCL.
POCL, POCL_PACKAGE = "Portable Computing Language", "pocl-binary-distribution"
#: OpenCL errors of insufficient memory.
_OUT_OF_MEMORY = {
    cl.status_code.MEM_OBJECT_ALLOCATION_FAILURE,
    cl.status_code.OUT_OF_HOST_MEMORY,
    cl.status_code.OUT_OF_RESOURCES,
    cl.status_code.INVALID_BUFFER_SIZE,
}


@dataclasses.dataclass(frozen=True)
class DeviceInfo:
    """Description of an OpenCL device; it is selected by `index`, or by a part of `name` or `platform`."""

    index: int
    name: str
    platform: str
    version: str
    kind: str

    def __str__(self) -> str:
        return f"[{self.index}] {self.name} ({self.kind}; {self.platform}, {self.version})"


@dataclasses.dataclass(eq=False)
class OpenDevice:
    """A device with this process's context and in-order queue."""

    info: DeviceInfo
    device: Any
    context: Any
    queue: Any
    process: int  # id of the process that opened it; no other may use it
    max_bytes: int  # largest size of a buffer
    memory_bytes: int  # size of its memory
    failure: str | None = None  # error after which it must not be used

    @functools.cached_property
    def is_cpu(self) -> bool:
        """Whether kernels run on the host's processor."""
        return bool(self.device.type & cl.device_type.CPU)

    def require_usable(self) -> None:
        """Raise DeviceError if calls of OpenCL would hang or fail."""
        if self.process != os.getpid():
            raise DeviceError(_FORKED)
        if self.failure is not None:
            raise DeviceError(f"{self.failure}; it was given up: make a new Rasterizer")

    def require_room(self, sizes: Mapping[str, int]) -> None:
        """Raise DeviceMemoryError if buffers of these sizes, bytes by name, do not fit into memory together."""
        for name, size in sizes.items():
            if size > self.max_bytes:
                raise DeviceMemoryError(self._no_room(name, size, f"at most {_amount(self.max_bytes)} in one piece"))
        if (total := sum(sizes.values())) > self.memory_bytes:
            raise DeviceMemoryError(self._no_room(", ".join(sizes), total, f"it has {_amount(self.memory_bytes)}"))

    def buffer(self, name: str, size: int, content: NDArray[Any] | None = None) -> Any:
        """Return a new buffer.

        Raises DeviceMemoryError if the device has no room for it.
        """
        self.require_room({name: size})
        flags: int = cl.mem_flags.READ_WRITE
        if content is not None:
            flags |= cl.mem_flags.COPY_HOST_PTR
        elif self.is_cpu:  # PoCL allocates now; otherwise at the first launch, which crashes without memory
            flags |= cl.mem_flags.ALLOC_HOST_PTR
        try:
            return cl.Buffer(self.context, flags, size, hostbuf=content)
        except cl.Error as error:
            if error.code not in _OUT_OF_MEMORY:
                raise
            raise DeviceMemoryError(self._no_room(name, size, str(error))) from error

    def _no_room(self, name: str, size: int, why: str) -> str:
        return f"{self.info.name} has no room for {_amount(size)} ({name}; {why}); {_LESS}"

    def error(self, error: cl.Error) -> DeviceError:
        """Translate an OpenCL error into one line; unless memory ran out, the device is marked as failed."""
        what = " ".join(str(error).split())
        if error.code in _OUT_OF_MEMORY:
            return DeviceMemoryError(f"{self.info.name} is out of memory ({what}); {_LESS}")
        self.failure = f"{self.info.name} failed: {what}"
        return DeviceError(self.failure)


#: Remedy for lack of memory.
_LESS = "less is needed at a smaller size (--size) or with fewer paths"
_FORKED = "OpenCL was used before this process was forked, and would hang; start workers with the 'spawn' method"

_opened: dict[int, OpenDevice] = {}
_opening = threading.Lock()


def _amount(num_bytes: int) -> str:
    return f"{num_bytes / 1e9:.3g} GB" if num_bytes >= 1e9 else f"{num_bytes / 1e6:.3g} MB"


def _devices() -> list[Any]:
    """Return all devices of all platforms; PoCL's first, as pip installs it, and pip's before others."""
    try:
        platforms = cl.get_platforms()
    except cl.Error:  # the loader reports "no platform" as an error
        return []
    if any(platform.name == POCL for platform in platforms):
        prepare_pocl_cache()
    found: list[Any] = []
    for platform in _in_order(platforms):
        try:
            found += platform.get_devices()
        except cl.Error:  # a platform without devices
            continue
    return found


def _in_order(platforms: list[Any]) -> list[Any]:
    """Sort platforms: PoCL's first, and among several the one of the version installed by pip."""
    ours = ""
    if sum(platform.name == POCL for platform in platforms) > 1:
        try:
            ours = f" PoCL {importlib.metadata.version(POCL_PACKAGE)}"
        except importlib.metadata.PackageNotFoundError:
            ours = ""
    return sorted(platforms, key=lambda platform: (platform.name != POCL, ours not in platform.version))


def _describe(index: int, device: Any) -> DeviceInfo:
    kinds = {cl.device_type.CPU: "CPU", cl.device_type.GPU: "GPU", cl.device_type.ACCELERATOR: "accelerator"}
    kind = next((word for bit, word in kinds.items() if device.type & bit), "device")
    platform = device.platform
    return DeviceInfo(index, device.name.strip(), platform.name.strip(), platform.version.strip(), kind)


def list_devices() -> list[DeviceInfo]:
    """Return the OpenCL devices of this machine, in the order of their indices."""
    return [_describe(index, device) for index, device in enumerate(_devices())]


def choose_device(spec: int | str | None = None) -> int:
    """Return the index of the device selected by `spec`.

    Parameters
    ----------
    spec : int, str or None
        Index, or part of the device's or platform's name (any case). None takes the environment variable
        ``LIVECL_DEVICE``, and without it the first device.

    Raises
    ------
    DeviceError
        If there is no device, or `spec` names none or several; the message lists the devices.
    """
    infos = list_devices()
    if not infos:
        raise DeviceError(
            "no OpenCL device found; 'pip install pyopencl[pocl]' brings one that runs on the CPU (Linux x86-64), "
            "elsewhere a driver must be installed"
        )
    source = "device"
    if spec is None:
        spec, source = os.environ.get(DEVICE_VARIABLE) or 0, DEVICE_VARIABLE
    text = str(spec).strip()
    if re.fullmatch(r"-?[0-9]+", text):
        matching = [info for info in infos if info.index == int(text)]
    else:
        matching = [info for info in infos if text.lower() in f"{info.name}\n{info.platform}".lower()]
    if len(matching) != 1:
        problem = "names no device" if not matching else "names several devices"
        choices = "; ".join(map(str, infos))
        raise DeviceError(f"{source} {text!r} {problem}; choose by index or by part of the name: {choices}")
    return matching[0].index


def open_device(spec: int | str | None = None) -> OpenDevice:
    """Return the context and queue of a device, which the process shares.

    Raises DeviceError if the device cannot be chosen or opened, or was opened before this process was forked: OpenCL
    calls would never return.
    """
    if any(opened.process != os.getpid() for opened in _opened.values()):
        raise DeviceError(_FORKED)
    with _opening:
        index = choose_device(spec)
        if index not in _opened or _opened[index].failure is not None:
            _opened[index] = _open(index)
        return _opened[index]


def _open(index: int) -> OpenDevice:
    device = _devices()[index]
    info = _describe(index, device)
    try:
        context = cl.Context([device])
        queue = cl.CommandQueue(context, device, properties=cl.command_queue_properties.PROFILING_ENABLE)
    except cl.Error as error:
        raise DeviceError(f"cannot open {info}: {error}") from error
    return OpenDevice(info, device, context, queue, os.getpid(), device.max_mem_alloc_size, device.global_mem_size)
