# SPDX-License-Identifier: Apache-2.0
"""Processors that PoCL's compiler does not know: which level they have, and how they get its name."""

from __future__ import annotations

import ctypes
import types

import numpy as np
import pyopencl as cl
import pytest

from livecl.opencl import processor, program
from livecl.opencl.device import open_device

V2 = "lm ssse3 sse4_1 sse4_2 popcnt cx16"
V3 = f"{V2} avx avx2 bmi1 bmi2 f16c fma movbe"
MESSAGE = "error: unknown target CPU 'generic'"


@pytest.mark.parametrize(
    ("flags", "level"),
    [("lm", "x86-64"), (V2, "x86-64-v2"), (V3, "x86-64-v3"), (V3.replace("sse4_2 ", ""), "x86-64")],
)
def test_level_follows_flags(flags, level):
    assert processor.level_of(frozenset(flags.split())) == level


def test_flags_are_those_of_the_first_processor():
    text = "processor\t: 0\nflags\t\t: lm avx\n\nprocessor\t: 1\nflags\t\t: other\n"
    assert processor._flags(text) == {"lm", "avx"}
    assert processor._flags("no such line") == frozenset()


class Record(ctypes.Structure):
    _fields_ = (
        ("dispatch", ctypes.c_void_p),
        ("text", ctypes.c_char_p),
        ("name", ctypes.c_char_p),
        ("rest", ctypes.c_char * processor.RECORD_BYTES),
    )


def record(name: bytes) -> Record:
    # a word that points nowhere, a text that only begins like the name, and the name
    return Record(dispatch=8, text=b"generic device", name=name, rest=b"")


def linux_on_x86() -> bool:
    try:
        return "lm" in processor._flags(processor.Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    except OSError:
        return False


@pytest.mark.skipif(not linux_on_x86(), reason="names are replaced on Linux on x86-64 only")
def test_only_the_unknown_name_is_replaced():
    unknown, known = record(b"generic"), record(b"znver3")
    assert processor.name_processor(types.SimpleNamespace(int_ptr=ctypes.addressof(unknown)))
    assert unknown.name.startswith(b"x86-64")
    assert unknown.text == b"generic device" and unknown.dispatch == 8
    assert not processor.name_processor(types.SimpleNamespace(int_ptr=ctypes.addressof(known)))
    assert known.name == b"znver3"


def test_no_name_without_proc(monkeypatch):
    monkeypatch.setattr(processor, "Path", lambda _: types.SimpleNamespace(read_text=failing))
    assert not processor.name_processor(types.SimpleNamespace(int_ptr=0))


def failing(**_):
    raise FileNotFoundError


def test_compiled_again_once_it_has_a_name(device, monkeypatch):
    opened = open_device(device)
    built, named = [], []

    def build(source_program, options):
        built.append(options)
        if not named:
            raise cl.RuntimeError(MESSAGE)
        return "built"

    monkeypatch.setattr(program.cl, "Program", lambda *_: types.SimpleNamespace(build=lambda o: build(None, o)))
    monkeypatch.setattr(program, "name_processor", lambda d: named.append(d) or True)
    options = program.build_options(np.dtype(np.float32), 3)
    assert program.compile_source(opened, "source", options) == "built"
    assert built == [options, options] and named == [opened.device]


@pytest.mark.parametrize(("message", "is_named"), [(MESSAGE, False), ("error: expected expression", True)])
def test_other_failures_are_raised(device, monkeypatch, message, is_named):
    def build(options):
        raise cl.RuntimeError(message)

    monkeypatch.setattr(program.cl, "Program", lambda *_: types.SimpleNamespace(build=build))
    monkeypatch.setattr(program, "name_processor", lambda _: is_named)
    with pytest.raises(cl.RuntimeError, match="error:"):
        program.compile_source(open_device(device), "source")
