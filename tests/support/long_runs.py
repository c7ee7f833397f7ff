# SPDX-License-Identifier: Apache-2.0
"""Long runs in a process of their own: `python tests/long_runs.py KIND COUNT` prints memory and time as they go on.

A line of JSON after each tenth: how much was done, the resident memory in bytes, and the processor time that it took.
"""

from __future__ import annotations

import gc
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import livecl
from livecl import Drawing, Options, Rasterizer
from livecl.drawing.assembly import empty_drawing
from livecl.run.progress import Progress
from livecl.run.run import Run
from support.runs import SMALL, three_shapes


def resident_memory() -> int:
    """Return the resident memory of this process, bytes."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024
    raise RuntimeError("/proc/self/status has no VmRSS")


def steps() -> Callable[[], object]:
    """Return an iteration of a run: distance weight, Xing loss, loops cut out; 48x48 px, four paths."""
    target = three_shapes(48)
    options = Options(iterations=10**9, loss="udf", xing_weight=0.01)
    run_ = Run(target, Progress.start(empty_drawing((48, 48), (1, 1, 1)), options, (4,), 0))
    assert run_.begin()
    return run_.step


def calls() -> Callable[[], object]:
    """Return a whole run of a small picture, with a revision, and its SVG."""
    options = Options(iterations=5, revisions=1)
    return lambda: livecl.vectorize(SMALL, 2, options=options).svg


def rasterizers() -> Callable[[], object]:
    """Return the making of a rasterizer, its use for one gradient, and its end."""
    drawing = livecl.vectorize(SMALL, 2, options=Options(iterations=5, revisions=0)).drawing
    sizes = [(24, 24), (40, 56), (64, 48)]
    used = 0

    def one() -> float:
        nonlocal used
        used += 1
        size = sizes[used % len(sizes)]
        on_canvas: Drawing = drawing.replace(size=size, background=None if used % 2 else (1.0, 1.0, 1.0))
        rasterizer = Rasterizer(size)
        image = rasterizer.forward(on_canvas)
        return rasterizer.loss_and_gradients(on_canvas, image, rasterizer.distance_weight(on_canvas))[0]

    return one


KINDS = {"steps": steps, "calls": calls, "rasterizers": rasterizers}


def main(kind: str, count: int) -> None:
    """Do it `count` times."""
    once = KINDS[kind]()
    for tenth in range(1, 11):
        begin = time.process_time()
        for _ in range(count // 10):
            once()
        seconds = time.process_time() - begin
        gc.collect()  # what only waits for the collector is not a leak
        row = {"done": tenth * (count // 10), "memory": resident_memory(), "seconds": seconds}
        print(json.dumps(row), flush=True)  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
