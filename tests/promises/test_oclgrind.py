# SPDX-License-Identifier: Apache-2.0
"""All kernels in Oclgrind, which simulates a device and notices invalid accesses, races and wrong calls of OpenCL.

Its exit code is 0 whatever it finds, so what it prints is read: anything that is not known to be harmless is a failure.
Its search for uninitialized values crashes on `coverage_forward` (Oclgrind 21.10); the last test stands in for it.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from support.device_work import everything
from support.drawings import ALL_CASES

from livecl import Rasterizer
from livecl.opencl.device import OpenDevice
from livecl.opencl.program import kernel_parameters

TESTS = Path(__file__).resolve().parents[1]
OCLGRIND = ["oclgrind", "--check-api", "--data-races"]
#: What pyopencl asks each device for, whether it knows it or not.
HARMLESS = re.compile(
    r"Oclgrind - OpenCL runtime error detected\n\tFunction: clGetDeviceInfo\n\tError:    CL_INVALID_VALUE\n"
    r"\tFor argument 'param_name'\n"
)
#: A drawing for each branch of the kernels; of 20x20 px, as the simulation takes seconds for each.
CASES = [
    "holes",
    "rgba",
    "winding 2",
    "opposite windings",
    "across the canvas's borders",
    "outside and around",
    "hidden below opaque",
    "zero-length lines",
    "1x1",
    "1x41",
    "41x1",
    "border: doubled, cutting pixels in half",
    "border: whole canvas, not a multiple of 8",
]

needs_oclgrind = pytest.mark.skipif(shutil.which("oclgrind") is None, reason="Oclgrind is not installed")


def simulate(*arguments: str) -> tuple[list[str], list[str]]:
    """Run Python in Oclgrind; return what the program printed itself, and what Oclgrind had to say."""
    variables = {**os.environ, "PYTHONPATH": f"{TESTS.parent}{os.pathsep}{TESTS}"}
    variables.pop("LIVECL_DEVICE", None)
    done = subprocess.run(
        [*OCLGRIND, sys.executable, *arguments],
        env=variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    lines = [line for line in HARMLESS.sub("", done.stdout).splitlines() if line.strip()]
    printed = [line for line in lines if line.startswith("printed: ")]
    return printed, [line for line in lines if line not in printed]


@needs_oclgrind
@pytest.mark.full
@pytest.mark.parametrize("name", CASES)
def test_kernels_make_no_invalid_access_and_no_race(name: str) -> None:
    printed, found = simulate(str(TESTS / "support" / "device_work.py"), name)
    assert not found, "\n".join(found)
    assert printed[-1].split()[2:] == sorted(kernel_parameters()), "each kernel was launched"
    # Two number types, two sizes of work-groups, in one go and in bands.
    assert len(printed) - 1 == 8 and all(line.startswith(f"printed: {name} on Oclgrind") for line in printed[:-1])


SPOILED = """
from support import device_work
from livecl.opencl import program

source = program.program_source()
assert {right!r} in source
program.program_source = lambda: source.replace({right!r}, {wrong!r})
device_work.main(["1x1"])
"""


@needs_oclgrind
@pytest.mark.full
@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("pieces_out[k - 1] = ", "pieces_out[k + 100000] = ", "Invalid write of size "),
        ("lines[segment] = ", "lines[0] = ", "Write-write data race at global memory address"),
    ],
)
def test_a_spoiled_kernel_is_noticed(right: str, wrong: str, told: str) -> None:
    _, found = simulate("-c", SPOILED.format(right=right, wrong=wrong))
    assert any(told in line for line in found), "\n".join(found)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("max_tiles", [1 << 17, 1], ids=["at-once", "in-bands"])
def test_what_a_new_buffer_holds_makes_no_difference(
    name: str, max_tiles: int, monkeypatch: pytest.MonkeyPatch, device: int
) -> None:
    """Kernels read nothing that was not written: buffers begin as zeros, and as bytes that are no number."""
    make_buffer = OpenDevice.buffer

    def digest(byte: int) -> str:
        def filled(opened: OpenDevice, label: str, size: int, content: Any = None) -> Any:
            buffer = make_buffer(opened, label, size, content)
            if content is None:
                cl.enqueue_copy(opened.queue, buffer, np.full(buffer.size, byte, np.uint8))
            return buffer

        with monkeypatch.context() as patch:
            patch.setattr(OpenDevice, "buffer", filled)
            return everything(Rasterizer(case.drawing.size, device=device, max_tiles=max_tiles), case)

    case = ALL_CASES[name]()
    assert digest(0x00) == digest(0xFF)


@pytest.mark.parametrize("name", ["holes", "rgba", "33x50"])
def test_work_groups_of_gpus_give_the_same_bytes(name: str, monkeypatch: pytest.MonkeyPatch, device: int) -> None:
    case = ALL_CASES[name]()
    expected = everything(Rasterizer(case.drawing.size, device=device), case)
    rasterizer = Rasterizer(case.drawing.size, device=device)
    monkeypatch.setitem(vars(rasterizer.device), "is_cpu", not rasterizer.device.is_cpu)
    assert everything(rasterizer, case) == expected
