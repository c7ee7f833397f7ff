# SPDX-License-Identifier: Apache-2.0
"""Devices that are used by several threads or processes at a time, or by one that has little memory."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from support.device_work import everything, with_checkout
from support.drawings import CASES

from livecl import Rasterizer

HOLES = CASES["holes"]()


LITTLE_MEMORY = """
import re, resource, sys
import numpy as np
import livecl

def drawing(side):
    return livecl.Drawing(points=np.full((1, 3, 2), side / 2), colors=np.ones((1, 4)), size=(side, side))

small, large = livecl.Rasterizer((40, 40)), livecl.Rasterizer((4000, 4000))
expected = small.forward(drawing(40))
used = 1024 * int(re.search(r"VmSize:\\s+(\\d+)", open("/proc/self/status").read())[1])
resource.setrlimit(resource.RLIMIT_AS, (used + 120_000_000,) * 2)
try:
    large.forward(drawing(4000))  # its image takes 192 MB
except MemoryError as error:
    print(type(error).__name__, error)
print("goes on", np.array_equal(small.forward(drawing(40)), expected))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of memory is Linux's")
def test_a_process_without_memory_gets_an_error_not_a_crash() -> None:
    # PoCL finds memory for a buffer when it is first used, unless told otherwise, and crashes if there is none.
    done = subprocess.run(
        [sys.executable, "-c", LITTLE_MEMORY], env=with_checkout(), capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    told, after = done.stdout.splitlines()
    assert told.startswith("DeviceMemoryError ") and "has no room for 192 MB (image;" in told
    assert after == "goes on True"


KEPT = """
import os, sys
import numpy as np
import livecl

device = int(sys.argv[1])
drawing = livecl.Drawing(points=np.full((1, 3, 2), 4.0), colors=np.ones((1, 4)), size=(8, 8))
rasterizer = livecl.Rasterizer((8, 8), device=device)
image = rasterizer.forward(drawing)
child = os.fork()
if child == 0:
    for call in (lambda: rasterizer.forward(drawing), lambda: rasterizer.upload(image)):
        try:
            call()
        except livecl.DeviceError as error:
            print(f"DeviceError: {error}", flush=True)
    sys.exit(3)
print("ended", os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), np.array_equal(rasterizer.forward(drawing), image))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
def test_a_rasterizer_made_before_a_fork_refuses_in_the_child(device: int) -> None:
    command = [sys.executable, "-c", KEPT, str(device)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=with_checkout(), check=True)
    *refused, ended = done.stdout.splitlines()
    assert len(refused) == 2 and all(line.startswith("DeviceError: OpenCL was used before this") for line in refused)
    assert ended == "ended 3 True", "the child ends by itself, and the parent goes on"


@pytest.mark.parametrize("shared", [True, False], ids=["one-rasterizer", "a-rasterizer-each"])
def test_threads_get_the_same_bytes_as_one_alone(shared: bool, device: int) -> None:
    cases = [CASES[name]() for name in ("translucent", "rgba", "holes")]
    size = max(case.drawing.size for case in cases)
    cases = [type(case)(drawing=case.drawing.replace(size=size), pieces=case.pieces) for case in cases]
    rasterizer = Rasterizer(size, device=device)
    expected = [everything(rasterizer, case) for case in cases]
    found: list[list[str]] = []
    start = threading.Barrier(4)

    def work() -> None:
        own = rasterizer if shared else Rasterizer(size, device=device)
        start.wait(60)
        found.extend([everything(own, case) for case in cases] for _ in range(5))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    assert found == [expected] * 20


def test_threads_differentiate_what_they_rendered_themselves(device: int) -> None:
    rasterizer = Rasterizer(HOLES.drawing.size, device=device)
    rasterizer.forward(HOLES.drawing)
    caught: list[BaseException] = []

    def differentiate() -> None:
        try:
            rasterizer.backward(np.ones((*HOLES.drawing.size, 3)))
        except RuntimeError as error:
            caught.append(error)

    thread = threading.Thread(target=differentiate)
    thread.start()
    thread.join(60)
    assert [str(error) for error in caught] == ["backward needs a drawing: call forward first"]


WORK = """
from support.device_work import everything, opencl_error
from support.drawings import CASES
from livecl import Rasterizer

case = CASES["holes"]()
print(everything(Rasterizer(case.drawing.size), case))
"""


def run_at_once(count: int, cache: Path) -> list[str]:
    """Run that many processes at once on one cache, and return what they print."""
    command = [sys.executable, "-c", WORK]
    processes = [
        subprocess.Popen(
            command,
            env=with_checkout(XDG_CACHE_HOME=str(cache)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(count)
    ]
    ended = [(process.communicate(timeout=300), process.returncode) for process in processes]
    assert all(code == 0 and not stderr for (_, stderr), code in ended), ended
    return [stdout for (stdout, _), _ in ended]


@pytest.mark.parametrize("count", [2, pytest.param(8, marks=pytest.mark.full)])
@pytest.mark.slow
def test_processes_that_build_into_one_empty_cache_all_succeed(count: int, tmp_path: Path) -> None:
    together = run_at_once(count, tmp_path / "caches")
    (alone,) = run_at_once(1, tmp_path / "caches")
    assert together == [alone] * count
