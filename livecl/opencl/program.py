# SPDX-License-Identifier: Apache-2.0
"""Find, expand and build the kernel sources."""

from __future__ import annotations

import functools
import logging
import pathlib
import re
import sqlite3
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyopencl as cl

from livecl import interruption
from livecl.errors import KernelBuildError
from livecl.opencl.caches import pocl_cache, pyopencl_cache
from livecl.opencl.device import OpenDevice
from livecl.opencl.processor import is_unknown_processor, name_processor

#: Sources of the program, in the order of the pipeline.
SOURCES = ("flatten.cl", "coverage.cl", "composite.cl", "reduce.cl", "distance.cl", "joint.cl")
#: Rows of a strip: the lanes of a vector of 32 bytes, the widest that PoCL from pip compiles correctly.
LANES = {"float32": 8, "float64": 4}
_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"[ \t]*$', re.MULTILINE)
_built: dict[tuple[Any, ...], Any] = {}
#: Compilers and pyopencl's cache are used by one thread at a time.
_building = threading.Lock()
_log = logging.getLogger(__name__)


def kernel_dir() -> pathlib.Path:
    """Return the folder of the kernel sources: in the installed package, or at the top of a checkout."""
    package = pathlib.Path(__file__).resolve().parents[1]
    for folder in (package / "kernels", package.parent / "kernels"):
        if (folder / "common.h").is_file():
            return folder
    raise KernelBuildError(f"the kernel sources are missing beside {package}; reinstall livecl")


def _expand(name: str, seen: set[str]) -> str:
    """Return a source with its includes expanded, each once, and #line directives for compiler messages."""
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
    """Return the names of each kernel's parameters, in order, parsed from the sources."""
    found = {}
    for name, parameters in re.findall(r"\b(?:__)?kernel\s+void\s+(\w+)\s*\(([^)]*)\)", program_source()):
        found[name] = tuple(re.findall(r"(\w+)\s*(?:,|$)", parameters.strip()))
    return found


def build_options(dtype: np.dtype[Any], channels: int, fills: bool = False) -> list[str]:
    """Return the compiler options for a number type, a number of image channels, and with gradient fills or without."""
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
        *(["-DFILLS=1"] if fills else []),
    ]


def build_program(opened: OpenDevice, dtype: np.dtype[Any], channels: int, fills: bool = False) -> Any:
    """Build the program, once for each device, number type and number of channels, with gradient fills or without.

    Raises KernelBuildError if compilation fails; the message has options, device and the first error, its `log` all of
    them.
    """
    key = (opened, dtype.name, channels, fills)
    if key not in _built:
        interruption.apart(functools.partial(_build, key, dtype))
    return _built[key]


def _build(key: tuple[OpenDevice, str, int, bool], dtype: np.dtype[Any]) -> None:
    """Build the program of a key of `_built`, unless another thread has."""
    opened, _, channels, fills = key
    with _building:
        if key not in _built:
            options = build_options(dtype, channels, fills)
            what = f"building with {' '.join(options)} on {opened.info}"
            try:
                built = compile_source(opened, program_source(), options)
            except cl.Error as error:
                log = str(error)
                raise KernelBuildError(f"{what} failed: {_first_error(log)}", log) from error
            if missing := kernel_parameters().keys() - set(built.kernel_names.split(";")):
                raise KernelBuildError(
                    f"{what} left out {min(missing)}: the compiler's cache is broken; delete the folder {pocl_cache()}"
                )
            _built[key] = built


def compile_source(opened: OpenDevice, source: str, options: Sequence[str] = ()) -> Any:
    """Compile a source; if PoCL's compiler does not know the processor, again with the name of a known one."""
    with pyopencl_cache():
        try:
            return cl.Program(opened.context, source).build(list(options))
        except cl.Error as error:
            if not (is_unknown_processor(str(error)) and name_processor(opened.device)):
                raise
            return cl.Program(opened.context, source).build(list(options))


def _first_error(log: str) -> str:
    """Return the first error of a compiler's log, or the log's first line."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    return next((line for line in lines if re.search(r"\berror\b\s*:", line, re.IGNORECASE)), lines[0] if lines else "")


def make_kernel(program: Any, name: str) -> Any:
    """Return a new kernel object of a built program."""
    with _building:
        try:
            with pyopencl_cache():
                return cl.Kernel(program, name)
        except sqlite3.Error as error:
            _log.warning("pyopencl's cache is broken (%s): it gets a temporary folder", error)
            with pyopencl_cache(broken=error):
                return cl.Kernel(program, name)
