# SPDX-License-Identifier: Apache-2.0
"""Devices that fail in the middle, have no room, or are used by several threads or processes at a time."""

from __future__ import annotations

import contextlib
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from support.device_work import everything, opencl_error, with_checkout
from support.drawings import CASES

import livecl
from livecl import DeviceError, DeviceMemoryError, KernelBuildError, Rasterizer
from livecl.cli import command as cli
from livecl.image.reading import save_image
from livecl.opencl import device as device_module
from livecl.opencl import launcher, program
from livecl.opencl.caches import pocl_cache
from livecl.opencl.device import open_device

HOLES = CASES["holes"]()


@contextlib.contextmanager
def failing_launch(monkeypatch: pytest.MonkeyPatch, number: int, error: BaseException) -> Iterator[list[int]]:
    """Have launch `number` from now on raise an error; the list counts the launches."""
    launches = [0]
    launch = cl.enqueue_nd_range_kernel

    def fail(*arguments: Any) -> Any:
        launches[0] += 1
        if launches[0] == number:
            raise error
        return launch(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(launcher.cl, "enqueue_nd_range_kernel", fail)
        yield launches


def num_launches(monkeypatch: pytest.MonkeyPatch, rasterizer: Rasterizer) -> int:
    with failing_launch(monkeypatch, 0, RuntimeError()) as launches:
        everything(rasterizer, HOLES)
    return launches[0]


@pytest.mark.parametrize("routine", ["enqueue_nd_range_kernel", "enqueue_copy"])
def test_a_device_that_is_lost_is_an_error_from_then_on(
    routine: str, monkeypatch: pytest.MonkeyPatch, device: int
) -> None:
    monkeypatch.setattr(device_module, "_opened", {})  # so that no other test sees a lost device
    rasterizer = Rasterizer(HOLES.drawing.size, device=device)
    expected = everything(rasterizer, HOLES)

    def lose(*_: Any, **__: Any) -> None:
        raise opencl_error(cl.LogicError, cl.status_code.INVALID_COMMAND_QUEUE)

    with monkeypatch.context() as patch:
        patch.setattr(cl, routine, lose)
        with pytest.raises(DeviceError, match=r" failed: .*INVALID_COMMAND_QUEUE") as caught:
            rasterizer.forward(HOLES.drawing)
    name = livecl.list_devices()[device].name
    assert str(caught.value).startswith(name) and "\n" not in str(caught.value)
    assert not isinstance(caught.value, MemoryError)
    calls: list[Callable[[], object]] = [
        lambda: rasterizer.forward(HOLES.drawing),
        lambda: rasterizer.coverages(HOLES.drawing),
        lambda: rasterizer.upload(np.ones(HOLES.drawing.size)),
        lambda: rasterizer.distance_weight(HOLES.drawing),
        lambda: rasterizer.loss_and_gradients(HOLES.drawing, np.ones((*HOLES.drawing.size, 3)), np.ones((1, 1))),
    ]
    for call in calls:
        with pytest.raises(DeviceError, match=r"INVALID_COMMAND_QUEUE; it was given up: make a new Rasterizer$"):
            call()
    assert everything(Rasterizer(HOLES.drawing.size, device=device), HOLES) == expected, "it is opened anew"


def test_a_device_that_is_lost_while_a_loss_is_waited_for_is_an_error(
    monkeypatch: pytest.MonkeyPatch, device: int
) -> None:
    monkeypatch.setattr(device_module, "_opened", {})
    rasterizer = Rasterizer(HOLES.drawing.size, device=device)
    target = rasterizer.upload(np.ones((*HOLES.drawing.size, 3)))
    finish = rasterizer.begin_loss(HOLES.drawing, target, rasterizer.upload(np.ones(HOLES.drawing.size)))

    def lose(*_: Any, **__: Any) -> None:
        raise opencl_error(cl.RuntimeError, cl.status_code.OUT_OF_RESOURCES)

    monkeypatch.setattr(cl, "enqueue_copy", lose)
    with pytest.raises(DeviceMemoryError, match="OUT_OF_RESOURCES"):
        finish()


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (cl.MemoryError, "MEM_OBJECT_ALLOCATION_FAILURE"),
        (cl.RuntimeError, "OUT_OF_HOST_MEMORY"),
        (cl.RuntimeError, "OUT_OF_RESOURCES"),
    ],
)
def test_a_lack_of_memory_is_told_and_less_work_succeeds(
    kind: type[cl.Error], name: str, monkeypatch: pytest.MonkeyPatch, device: int
) -> None:
    rasterizer = Rasterizer(HOLES.drawing.size, device=device)
    expected = everything(rasterizer, HOLES)
    told = rf" is out of memory \(.*{name}.*--size.*fewer paths"
    for number in range(1, 1 + num_launches(monkeypatch, rasterizer)):
        error = opencl_error(kind, getattr(cl.status_code, name))
        with failing_launch(monkeypatch, number, error), pytest.raises(DeviceMemoryError, match=told) as caught:
            everything(rasterizer, HOLES)
        assert isinstance(caught.value, MemoryError) and "\n" not in str(caught.value)
        assert everything(rasterizer, HOLES) == expected, f"after launch {number}"


def test_an_interruption_at_any_launch_leaves_nothing_half_done(monkeypatch: pytest.MonkeyPatch, device: int) -> None:
    rasterizer = Rasterizer(HOLES.drawing.size, device=device)
    expected = everything(rasterizer, HOLES)
    for number in range(1, 1 + num_launches(monkeypatch, rasterizer)):
        with failing_launch(monkeypatch, number, KeyboardInterrupt()), pytest.raises(KeyboardInterrupt):
            everything(rasterizer, HOLES)
        assert everything(rasterizer, HOLES) == expected, f"after launch {number}"


def test_what_is_larger_than_the_device_allows_is_told_with_its_size(
    monkeypatch: pytest.MonkeyPatch, device: int
) -> None:
    rasterizer = Rasterizer((64, 64), device=device)
    drawing = livecl.Drawing(points=np.full((1, 3, 2), 8.0), colors=np.ones((1, 4)), size=(64, 64))
    monkeypatch.setattr(open_device(device), "max_bytes", 40_000)
    with pytest.raises(
        DeviceMemoryError, match=r" has no room for 0\.0492 MB \(image; at most 0\.04 MB in one piece\); .*--size"
    ):
        rasterizer.forward(drawing)
    with pytest.raises(DeviceMemoryError, match=r"0\.0492 MB"):
        rasterizer.upload(np.ones((64, 64, 3)))
    monkeypatch.undo()
    assert rasterizer.forward(drawing).shape == (64, 64, 3)


def test_a_build_that_fails_is_one_line_and_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = program.program_source().replace('#line 1 "coverage.cl"', '#line 1 "coverage.cl"\nreal spoiled( {', 1)
    monkeypatch.setattr(program, "_built", {})
    monkeypatch.setattr(program, "program_source", lambda: source)
    save_image(tmp_path / "in.png", np.full((16, 16, 3), 0.3))
    assert cli.main([str(tmp_path / "in.png"), "-o", str(tmp_path / "out.svg"), "-q"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("livecl: error: building with -DREAL=float ")
    assert "coverage.cl:1:" in line and "error:" in line and len(line) < 600
    assert not (tmp_path / "out.svg").exists()
    with pytest.raises(KernelBuildError) as caught:
        Rasterizer((8, 8))
    assert " ".join(str(caught.value).split()) in line and caught.value.log.count("\n") > 3
    copy = caught.value.__reduce__()
    assert copy[0] is KernelBuildError and copy[1] == (str(caught.value), caught.value.log)


def test_a_program_without_some_kernel_says_which_cache_to_delete(monkeypatch: pytest.MonkeyPatch, device: int) -> None:
    # What PoCL makes of a damaged program is one without kernels; the process cannot go on with it.
    parameters = program.kernel_parameters()
    monkeypatch.setattr(program, "_built", {})
    monkeypatch.setattr(program, "kernel_parameters", lambda: {**parameters, "a_missing_one": ()})
    told = f"left out a_missing_one: the compiler's cache is broken; delete the folder {pocl_cache()}"
    with pytest.raises(KernelBuildError, match=re.escape(told)):
        Rasterizer((8, 8), device=device)


def test_a_device_that_fails_in_a_run_is_one_line_and_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(device_module, "_opened", {})
    save_image(tmp_path / "in.png", np.full((16, 16, 3), 0.3))
    error = opencl_error(cl.RuntimeError, cl.status_code.INVALID_COMMAND_QUEUE)
    with failing_launch(monkeypatch, 5, error):
        assert cli.main([str(tmp_path / "in.png"), "-o", str(tmp_path / "out.svg"), "-q"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("livecl: error: ") and "INVALID_COMMAND_QUEUE" in line
    assert not (tmp_path / "out.svg").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="PoCL from pip is for Linux")
@pytest.mark.parametrize("command", [["--list-devices"], ["in.png", "-o", "out.svg"]])
def test_without_a_device_the_command_line_says_how_to_get_one(command: list[str], tmp_path: Path) -> None:
    if {info.platform for info in livecl.list_devices()} != {"Portable Computing Language"}:
        pytest.skip("there are other devices than PoCL's")
    save_image(tmp_path / "in.png", np.full((16, 16, 3), 0.3))
    done = subprocess.run(
        [sys.executable, "-m", "livecl", *command],
        cwd=tmp_path,
        env=with_checkout(POCL_DEVICES="none"),
        capture_output=True,
        text=True,
        timeout=60,
    )
    (line,) = done.stderr.splitlines()
    assert line.startswith("livecl: error: no OpenCL device found; 'pip install pyopencl[pocl]' brings one ")
    assert done.returncode == 2
