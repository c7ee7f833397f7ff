# SPDX-License-Identifier: Apache-2.0
"""Exceptions for failures other than wrong arguments.

Wrong arguments raise :class:`ValueError` or :class:`TypeError`; the classes here are for files, devices and compilers.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class LiveclError(Exception):
    """Base class of the errors that livecl raises."""


class DeviceError(LiveclError):
    """No OpenCL device fits the request, or the device failed; the message lists the devices found."""


class CheckpointError(LiveclError):
    """A checkpoint cannot be read, or belongs to another run; no file has been changed."""


class DeviceMemoryError(DeviceError, MemoryError):
    """The device is out of memory; less work may succeed."""


class KernelBuildError(LiveclError):
    """An OpenCL kernel did not compile; the message carries options, device and the compiler's first error.

    Parameters
    ----------
    message : str
        One line.
    log : str
        The compiler's complete log.
    """

    def __init__(self, message: str, log: str = "") -> None:
        super().__init__(message)
        self.log = log

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return type(self), (str(self), self.log)


class SvgError(LiveclError):
    """An SVG cannot be read as filled and stroked paths."""


class ImageError(LiveclError):
    """A picture cannot be read or is of a kind that cannot be vectorized."""


def readable(text: str) -> str:
    """Return text as one line for a message: runs of control and other invisible characters become a space."""
    return " ".join("".join(character if character.isprintable() else " " for character in text).split())


#: Largest number of names listed in a hint.
MAX_LISTED = 12


def name_hint(name: str, known: Iterable[str]) -> str:
    """Return a hint for an unknown name: the nearest known name, or the first known names."""
    known = list(known)
    if near := difflib.get_close_matches(name, known, n=1, cutoff=0.5):
        return f"did you mean {near[0]!r}?"
    more = ", ..." if len(known) > MAX_LISTED else ""
    return f"wanted one of {', '.join(known[:MAX_LISTED])}{more}"


def check_type(name: str, value: object, kind: type, wanted: str) -> None:
    """Raise TypeError, naming the argument, for a value of another type."""
    if not isinstance(value, kind):
        raise TypeError(f"{name}: got {type(value).__name__}, wanted {wanted}")
