# SPDX-License-Identifier: Apache-2.0
"""OpenCL devices: list, choose, describe, open."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import re
from collections.abc import Iterator
from typing import Any

import pyopencl as cl

from livecl.errors import DeviceError

#: Environment variable that names the device to use where the caller names none.
DEVICE_VARIABLE = "LIVECL_DEVICE"


@dataclasses.dataclass(frozen=True)
class DeviceInfo:
    """What is known about an OpenCL device; `index` chooses it, and so does a part of its `name` or `platform`."""

    index: int
    name: str
    platform: str
    version: str
    kind: str

    def __str__(self) -> str:
        return f"[{self.index}] {self.name} ({self.kind}; {self.platform}, {self.version})"


@dataclasses.dataclass(frozen=True)
class OpenDevice:
    """A device with the context and the in-order queue that this process uses it by."""

    info: DeviceInfo
    device: Any
    context: Any
    queue: Any
    process: int

    @property
    def is_cpu(self) -> bool:
        """Whether kernels run on the host's processor."""
        return bool(self.device.type & cl.device_type.CPU)


_opened: dict[int, OpenDevice] = {}


def _devices() -> list[Any]:
    """All devices of all platforms, PoCL's first: it is the default that pip installs."""
    try:
        platforms = cl.get_platforms()
    except cl.Error:  # the loader reports "no platform" as an error
        return []
    platforms.sort(key=lambda platform: platform.name != "Portable Computing Language")
    found: list[Any] = []
    for platform in platforms:
        try:
            found += platform.get_devices()
        except cl.Error:  # a platform without devices
            continue
    return found


def _describe(index: int, device: Any) -> DeviceInfo:
    kinds = {cl.device_type.CPU: "CPU", cl.device_type.GPU: "GPU", cl.device_type.ACCELERATOR: "accelerator"}
    kind = next((word for bit, word in kinds.items() if device.type & bit), "device")
    platform = device.platform
    return DeviceInfo(index, device.name.strip(), platform.name.strip(), platform.version.strip(), kind)


def list_devices() -> list[DeviceInfo]:
    """Return the OpenCL devices of this machine, in the order of their indices."""
    return [_describe(index, device) for index, device in enumerate(_devices())]


def _choices(infos: list[DeviceInfo]) -> str:
    return "; ".join(map(str, infos))


def choose_device(spec: int | str | None = None) -> int:
    """Return the index of the device that `spec` names.

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
            "no OpenCL device found; 'pip install pyopencl[pocl]' brings one that runs on the CPU (Linux x86-64), and "
            "PoCL needs a home folder it can write to (or XDG_CACHE_HOME, a folder for caches)"
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
        raise DeviceError(f"{source} {text!r} {problem}; choose by index or by part of the name: {_choices(infos)}")
    return matching[0].index


def open_device(spec: int | str | None = None) -> OpenDevice:
    """Return the context and queue of a device, shared by all that use it in this process.

    Raises
    ------
    DeviceError
        If the device cannot be chosen or opened, or was opened before this process was forked off: OpenCL calls would
        never return then.
    """
    if any(opened.process != os.getpid() for opened in _opened.values()):
        raise DeviceError(
            "OpenCL was used before this process was forked, and would hang; start workers with the 'spawn' method"
        )
    index = choose_device(spec)
    if index not in _opened:
        device = _devices()[index]
        try:
            context = cl.Context([device])
            queue = cl.CommandQueue(context, device, properties=cl.command_queue_properties.PROFILING_ENABLE)
        except cl.Error as error:
            raise DeviceError(f"cannot open {_describe(index, device)}: {error}") from error
        _opened[index] = OpenDevice(_describe(index, device), device, context, queue, os.getpid())
    return _opened[index]


@contextlib.contextmanager
def failures_of(info: DeviceInfo | str) -> Iterator[None]:
    """Raise what OpenCL raises within as a DeviceError: the device failed, or was lost, while it worked."""
    try:
        yield
    except cl.Error as error:
        raise DeviceError(f"{info} failed while it worked: {error}") from error
