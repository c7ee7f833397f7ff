# SPDX-License-Identifier: Apache-2.0
"""Processors newer than PoCL's compiler: substitute the name of a processor that it knows.

PoCL asks LLVM for the name of the host's processor. An LLVM that is older than the processor answers "generic", which
its own compiler then refuses ("unknown target CPU 'generic'"): LLVM 14, which is part of PoCL from pip, does not know
Zen 5. PoCL has no option for the name, so it is replaced in PoCL's record of the device: in the one field that points
to the string "generic". Memory is read through /proc/self/mem, which refuses invalid addresses, and nothing is written
unless exactly one field fits.
"""

from __future__ import annotations

import ctypes
import logging
import os
import re
import struct
from pathlib import Path
from typing import Any

#: LLVM's name of an unknown processor.
UNKNOWN = b"generic"
#: Names of the x86-64 levels that LLVM has known since version 12, with flags (as Linux spells them) that each needs
#: beyond the one before: psABI for x86-64, "micro-architecture levels".
LEVELS = (
    ("x86-64", ()),
    ("x86-64-v2", ("ssse3", "sse4_1", "sse4_2", "popcnt", "cx16")),
    ("x86-64-v3", ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe")),
)
#: Bytes of PoCL's record of a device that are searched: in PoCL 3.0 the name is at byte 640, near the record's end.
RECORD_BYTES = 1024

_log = logging.getLogger(__name__)


def is_unknown_processor(message: str) -> bool:
    """Whether a compiler's message says that it does not know the host's processor."""
    return f"unknown target CPU '{UNKNOWN.decode()}'" in message


def level_of(flags: frozenset[str]) -> str:
    """Return the highest x86-64 level whose flags a processor has."""
    name = LEVELS[0][0]
    for level, needed in LEVELS:
        if not flags.issuperset(needed):
            break
        name = level
    return name


def name_processor(device: Any) -> bool:
    """Replace the processor's unknown name in PoCL's record of a pyopencl.Device by one known to LLVM.

    Return whether it was found and replaced: False on other systems than Linux on x86-64.
    """
    try:
        flags = _flags(Path("/proc/cpuinfo").read_text(encoding="utf-8"))
        with Path("/proc/self/mem").open("rb", buffering=0) as memory:
            fields = _fields_with(UNKNOWN, memory.fileno(), device.int_ptr)
    except OSError:
        return False
    if len(fields) != 1 or "lm" not in flags:
        return False
    name = level_of(flags)
    libc = ctypes.CDLL(None)
    libc.strdup.restype = ctypes.c_void_p  # from malloc, as PoCL's own name is: PoCL frees it
    ctypes.c_void_p.from_address(fields[0]).value = libc.strdup(name.encode())
    _log.info("PoCL's compiler does not know this processor: kernels are built for %s", name)
    return True


def _flags(cpuinfo: str) -> frozenset[str]:
    """Return the flags of the first processor in the text of /proc/cpuinfo."""
    found = re.search(r"^flags\s*:(.*)$", cpuinfo, re.MULTILINE)
    return frozenset(found[1].split() if found else ())


def _fields_with(text: bytes, memory: int, start: int) -> list[int]:
    """Return the addresses of the words from `start` on that point to a text, reading the file `memory`."""
    record = os.pread(memory, RECORD_BYTES, start)
    found = []
    for offset in range(0, len(record) - 7, 8):
        (pointer,) = struct.unpack_from("<Q", record, offset)
        try:
            if 0 < pointer < 1 << 47 and os.pread(memory, len(text) + 1, pointer) == text + b"\0":
                found.append(start + offset)
        except OSError:
            continue
    return found
