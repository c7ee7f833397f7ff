# SPDX-License-Identifier: Apache-2.0
"""Choosing and opening devices, and building the kernels on them: the messages when either fails."""

from __future__ import annotations

import importlib.metadata
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyopencl as cl
import pytest

import livecl
from livecl import DeviceError, KernelBuildError
from livecl.opencl import device as device_module
from livecl.opencl import program
from livecl.opencl.device import DeviceInfo, choose_device, list_devices, open_device

ROOT = Path(__file__).resolve().parents[2]

FOUND = [
    DeviceInfo(0, "cpu-haswell", "Portable Computing Language", "OpenCL 3.0 PoCL 6.0", "CPU"),
    DeviceInfo(1, "Radeon Pro", "AMD Accelerated Parallel Processing", "OpenCL 2.1", "GPU"),
    DeviceInfo(2, "Radeon RX", "AMD Accelerated Parallel Processing", "OpenCL 2.1", "GPU"),
]


@pytest.fixture
def three_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_module, "list_devices", lambda: FOUND)
    monkeypatch.delenv("LIVECL_DEVICE", raising=False)


@pytest.mark.usefixtures("three_devices")
@pytest.mark.parametrize(
    ("spec", "index"),
    [
        (None, 0),
        (0, 0),
        (2, 2),
        ("1", 1),
        (" 2 ", 2),
        ("haswell", 0),
        ("HASWELL", 0),
        ("portable", 0),
        ("radeon pro", 1),
        ("RX", 2),
    ],
)
def test_a_device_is_chosen_by_index_or_by_part_of_a_name(spec: int | str | None, index: int) -> None:
    assert choose_device(spec) == index


@pytest.mark.usefixtures("three_devices")
@pytest.mark.parametrize(
    ("spec", "problem"),
    [
        (3, "names no device"),
        (-1, "names no device"),
        ("7", "names no device"),
        ("geforce", "names no device"),
        ("--1", "names no device"),
        ("²", "names no device"),
        ("radeon", "names several devices"),
        ("AMD", "names several devices"),
    ],
)
def test_what_names_none_or_several_gets_a_list_of_the_devices(spec: int | str, problem: str) -> None:
    with pytest.raises(DeviceError) as caught:
        choose_device(spec)
    message = str(caught.value)
    assert message.startswith(f"device '{spec}' {problem}") and "\n" not in message
    for info in FOUND:
        assert f"[{info.index}] {info.name}" in message


@pytest.mark.usefixtures("three_devices")
def test_the_environment_variable_names_the_device_where_the_caller_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIVECL_DEVICE", "radeon rx")
    assert choose_device() == 2 and choose_device("haswell") == 0 and choose_device(0) == 0
    monkeypatch.setenv("LIVECL_DEVICE", "1")
    assert choose_device() == 1
    monkeypatch.setenv("LIVECL_DEVICE", "")
    assert choose_device() == 0
    monkeypatch.setenv("LIVECL_DEVICE", "geforce")
    with pytest.raises(DeviceError, match=r"^LIVECL_DEVICE 'geforce' names no device; .*haswell"):
        choose_device()


def test_without_devices_the_error_says_how_to_get_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_platforms() -> list[Any]:
        raise cl.LogicError("clGetPlatformIDs failed: PLATFORM_NOT_FOUND_KHR")

    monkeypatch.setattr(device_module.cl, "get_platforms", no_platforms)
    assert list_devices() == []
    for spec in (None, 0, "pocl"):
        with pytest.raises(DeviceError, match=r"no OpenCL device found; 'pip install pyopencl\[pocl\]'") as caught:
            choose_device(spec)
        assert "\n" not in str(caught.value)


POCL = "Portable Computing Language"
PLATFORMS = [
    SimpleNamespace(name="Vendor's OpenCL", version="OpenCL 2.1"),
    SimpleNamespace(name=POCL, version="OpenCL 3.0 PoCL 3.1+debian  Linux"),
    SimpleNamespace(name="Another's", version="OpenCL 3.0"),
    SimpleNamespace(name=POCL, version="OpenCL 3.0 PoCL 3.0-rc2  Linux"),
    SimpleNamespace(name=POCL, version="OpenCL 3.0 PoCL 6.0  Linux"),
]


def test_pocl_comes_first_and_pip_s_before_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.metadata.version", {"pocl-binary-distribution": "3.0"}.__getitem__)
    assert device_module._in_order(PLATFORMS) == [PLATFORMS[index] for index in (3, 1, 4, 0, 2)]

    def not_there(package: str) -> str:
        raise importlib.metadata.PackageNotFoundError(package)

    monkeypatch.setattr("importlib.metadata.version", not_there)
    assert device_module._in_order(PLATFORMS) == [PLATFORMS[index] for index in (1, 3, 4, 0, 2)]


def test_of_the_pocls_here_pip_s_is_the_default() -> None:
    versions = [info.version for info in list_devices() if info.platform == POCL]
    if len(versions) < 2:
        pytest.skip("one PoCL at most is here")
    assert f" PoCL {importlib.metadata.version('pocl-binary-distribution')}" in versions[0]


def test_devices_are_listed_with_the_index_that_chooses_them(device: int) -> None:
    infos = list_devices()
    assert [info.index for info in infos] == list(range(len(infos)))
    info = infos[device]
    opened = open_device(device)
    assert opened.info == info and opened.device.name.strip() == info.name
    assert info.version.startswith("OpenCL ") and info.kind in ("CPU", "GPU", "accelerator", "device")
    assert str(info).startswith(f"[{device}] {info.name} ({info.kind}; ")
    assert opened.is_cpu == (info.kind == "CPU")


def test_a_device_is_opened_once(device: int) -> None:
    assert open_device(device) is open_device(str(device))


def test_a_device_that_does_not_open_is_named(monkeypatch: pytest.MonkeyPatch, device: int) -> None:
    def refuse(devices: list[Any]) -> None:
        raise cl.RuntimeError("clCreateContext failed: OUT_OF_HOST_MEMORY")

    monkeypatch.setattr(device_module, "_opened", {})
    monkeypatch.setattr(device_module.cl, "Context", refuse)
    name = re.escape(list_devices()[device].name)
    with pytest.raises(DeviceError, match=f"^cannot open .*{name}.*OUT_OF_HOST_MEMORY"):
        open_device(device)


FORKING = """
import os, sys
import numpy as np
import livecl
from livecl.opencl.device import open_device

device = int(sys.argv[1])
if sys.argv[2] == "used":
    livecl.Rasterizer((8, 8), device=device)
child = os.fork()
if child == 0:
    try:
        livecl.Rasterizer((8, 8), device=device)
        print("opened", flush=True)
    except livecl.DeviceError as error:
        print(f"DeviceError: {error}", flush=True)
    os._exit(0)
os.waitpid(child, 0)
if sys.argv[2] == "used":
    open_device(device)
    print("the parent goes on", flush=True)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
def test_a_forked_process_is_refused_what_would_hang(device: int) -> None:
    def lines(how: str) -> list[str]:
        command = [sys.executable, "-c", FORKING, str(device), how]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        finished = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment, check=True)
        return finished.stdout.splitlines()

    error, parent = lines("used")
    assert error.startswith("DeviceError: OpenCL was used before this process was forked") and "spawn" in error
    assert parent == "the parent goes on"
    # A process that has not used a device may fork, and its children open devices of their own.
    if open_device(device).is_cpu:
        assert lines("unused") == ["opened"]


def test_marks_in_the_program_name_file_and_line_of_all_that_follows() -> None:
    name, number, seen = "", 0, set()
    for line in program.program_source().split("\n"):
        mark = re.fullmatch(r'#line (\d+) "([^"]+)"', line)
        if mark:
            number, name = int(mark[1]), mark[2]
            original = (program.kernel_dir() / name).read_text(encoding="utf-8").split("\n")
            continue
        if line != (original[number - 1] if number <= len(original) else ""):
            assert line == "" and original[number - 1].startswith("#include"), f"{name}:{number}"
        seen.add((name, number))
        number += 1
    # Nothing is left out but the includes, in whose place there are the files.
    for path in program.kernel_dir().iterdir():
        if path.suffix in (".cl", ".h"):
            text = path.read_text(encoding="utf-8").split("\n")
            missing = [k for k, line in enumerate(text, start=1) if (path.name, k) not in seen and line]
            assert all(text[k - 1].lstrip().startswith("#include") for k in missing), f"{path.name}: {missing}"


def test_includes_are_put_in_once() -> None:
    source = program.program_source()
    assert "#include" not in re.sub(r"//.*", "", source)
    for name in [*program.SOURCES, "common.h"]:
        assert source.count(f'#line 1 "{name}"') == 1


def test_parameters_are_those_of_the_built_kernels(device: int) -> None:
    built = program.build_program(open_device(device), np.dtype(np.float32), 3)
    parameters = program.kernel_parameters()
    assert {kernel.function_name: kernel.num_args for kernel in built.all_kernels()} == {
        name: len(names) for name, names in parameters.items()
    }
    assert parameters["flatten_forward"] and all(len(set(names)) == len(names) for names in parameters.values())


def test_a_program_is_built_once_for_each_kind(device: int) -> None:
    opened = open_device(device)
    first = program.build_program(opened, np.dtype(np.float32), 3)
    assert program.build_program(opened, np.dtype(np.float32), 3) is first
    assert program.build_program(opened, np.dtype(np.float32), 4) is not first


def test_a_syntax_error_is_told_with_file_options_and_log(monkeypatch: pytest.MonkeyPatch, device: int) -> None:
    source = program.program_source().replace('#line 1 "coverage.cl"', '#line 1 "coverage.cl"\nreal spoiled( {', 1)
    monkeypatch.setattr(program, "_built", {})
    monkeypatch.setattr(program, "program_source", lambda: source)
    with pytest.raises(KernelBuildError) as caught:
        livecl.Rasterizer((8, 8), device=device)
    message = str(caught.value)
    first = message.splitlines()[0]
    assert "-DREAL=float" in first and "-DCHANNELS=3" in first and list_devices()[device].name in first
    assert "coverage.cl:1" in message and "error" in message.lower()
    assert not program._built, "what failed is not kept"


def test_missing_sources_are_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(program, "__file__", str(tmp_path / "package" / "program.py"))
    with pytest.raises(KernelBuildError, match=r"^the kernel sources are missing beside .*; reinstall livecl$"):
        program.kernel_dir()


@pytest.mark.parametrize("spec", ["no such device", 99])
def test_everything_that_takes_a_device_refuses_an_unknown_one(spec: int | str) -> None:
    drawing = livecl.Drawing(points=np.zeros((0, 3, 2)), colors=np.zeros((0, 4)), size=(4, 4))
    for call in (
        lambda: livecl.Rasterizer((4, 4), device=spec),
        lambda: livecl.render(drawing, device=spec),
        lambda: livecl.vectorize(np.ones((4, 4, 3)), 1, device=spec),
    ):
        with pytest.raises(
            DeviceError, match=f"^device '{spec}' names no device; .*{re.escape(str(list_devices()[0]))}"
        ):
            call()
