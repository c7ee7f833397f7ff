# SPDX-License-Identifier: Apache-2.0
"""Guard of methods that use a device: translate OpenCL errors, drop buffers after a failure."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Concatenate, ParamSpec, Protocol, TypeVar

import pyopencl as cl

from livecl.opencl.device import OpenDevice


class DeviceUser(Protocol):
    """Object with guarded methods."""

    @property
    def device(self) -> OpenDevice:
        """The device that it uses."""

    def forget(self) -> None:
        """Drop all buffers on the device."""


User = TypeVar("User", bound=DeviceUser)
Arguments = ParamSpec("Arguments")
Value = TypeVar("Value")


def on_device(method: Callable[Concatenate[User, Arguments], Value]) -> Callable[Concatenate[User, Arguments], Value]:
    """Decorator: raise DeviceError if OpenCL fails, or would hang; one check for all launches of a method.

    If the method raises any exception, the buffers on the device are dropped, so that the next call starts afresh.
    """

    @functools.wraps(method)
    def checked(user: User, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Value:
        user.device.require_usable()
        try:
            return method(user, *args, **kwargs)
        except BaseException as error:
            user.forget()
            if isinstance(error, cl.Error):
                raise user.device.error(error) from error
            raise

    return checked
