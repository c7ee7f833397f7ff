# SPDX-License-Identifier: Apache-2.0
"""Find, expand and build the kernel sources."""

from __future__ import annotations

import functools
import pathlib
import re
from typing import Any

import numpy as np
import pyopencl as cl

from livecl.device import OpenDevice
from livecl.errors import KernelBuildError
from livecl.tiling import LANES

#: Sources of the program, in the order of the pipeline.
SOURCES = ("flatten.cl", "coverage.cl", "composite.cl", "reduce.cl", "distance.cl", "joint.cl")
_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"[ \t]*$', re.MULTILINE)
_built: dict[tuple[Any, ...], Any] = {}


def kernel_dir() -> pathlib.Path:
    """Return the folder of the kernel sources: in the installed package, or at the top of a checkout."""
    package = pathlib.Path(__file__).resolve().parent
    for folder in (package / "kernels", package.parent / "kernels"):
        if (folder / "common.h").is_file():
            return folder
    raise KernelBuildError(f"the kernel sources are missing beside {package}; reinstall livecl")


def _expand(name: str, seen: set[str]) -> str:
    """Return a source with its includes put in place, each once, marked so that compilers name file and line."""
    seen.add(name)
    text = (kernel_dir() / name).read_text(encoding="utf-8")

    def include(match: re.Match[str]) -> str:
        line = text.count("\n", 0, match.start()) + 2
        inner = "" if match[1] in seen else _expand(match[1], seen)
        return f'{inner}\n#line {line} "{name}"'

    return f'#line 1 "{name}"\n' + _INCLUDE.sub(include, text)


def program_source() -> str:
    """Return the source of the whole program."""
    seen: set[str] = set()
    return "\n".join(_expand(name, seen) for name in SOURCES)


@functools.cache
def kernel_parameters() -> dict[str, tuple[str, ...]]:
    """Return the names of each kernel's parameters, in order, as the sources spell them."""
    found = {}
    for name, parameters in re.findall(r"__kernel\s+void\s+(\w+)\s*\(([^)]*)\)", program_source()):
        found[name] = tuple(re.findall(r"(\w+)\s*(?:,|$)", parameters.strip()))
    return found


def build_options(dtype: np.dtype[Any], channels: int) -> list[str]:
    """Return the compiler options for a number type and a number of image channels."""
    real, mask, epsilon = {
        "float32": ("float", "int", "FLT_EPSILON"),
        "float64": ("double", "long", "DBL_EPSILON"),
    }[dtype.name]
    lanes = LANES[dtype.name]
    return [
        f"-DREAL={real}",
        f"-DMASK={mask}",
        f"-DLANES={lanes}",
        f"-DREAL_EPSILON={epsilon}",
        f"-DCHANNELS={channels}",
    ]


def build_program(opened: OpenDevice, dtype: np.dtype[Any], channels: int) -> Any:
    """Build the program, once for each device, number type and number of channels.

    Raises
    ------
    KernelBuildError
        If the compiler refuses; the message carries options and log.
    """
    key = (opened.info.index, dtype.name, channels)
    if key not in _built:
        options = build_options(dtype, channels)
        try:
            _built[key] = cl.Program(opened.context, program_source()).build(options)
        except cl.Error as error:
            raise KernelBuildError(f"building with {' '.join(options)} on {opened.info} failed:\n{error}") from error
    return _built[key]
