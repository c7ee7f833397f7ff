# SPDX-License-Identifier: Apache-2.0
"""The errors that livecl raises for what lies outside the caller's arguments.

Wrong arguments raise :class:`ValueError` or :class:`TypeError`; the classes here are for files, devices and compilers.
"""


class LiveclError(Exception):
    """Base class of the errors that livecl raises."""


class DeviceError(LiveclError):
    """No OpenCL device fits the request, or the device failed; the message lists what was found."""


class KernelBuildError(LiveclError):
    """An OpenCL kernel did not compile; the message carries file, options and compiler log."""


class SvgError(LiveclError):
    """An SVG cannot be read as closed filled paths."""


class ImageError(LiveclError):
    """A picture cannot be read or is of a kind that cannot be vectorized."""


def readable(text: str) -> str:
    """Return text for a message: on one line, each run of what cannot be seen, as control characters, a space."""
    return " ".join("".join(character if character.isprintable() else " " for character in text).split())
