# SPDX-License-Identifier: Apache-2.0
"""Timing of the cases, once they are known to be right."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import livecl
from benchmark import breakdown
from benchmark.calibration import REFERENCE_SUMS, MultiplyAdd
from benchmark.cases import Case
from benchmark.limit import REFERENCE_GFLOPS
from benchmark.machine import peak_megabytes
from benchmark.repeats import repeated
from benchmark.scene_file import load_scene
from benchmark.startup import process_seconds
from livecl import Result
from livecl.opencl.device import OpenDevice
from livecl.options import Options
from livecl.run.loop import run
from livecl.run.stages import Step, Vectorizer

Image = NDArray[np.float32]
Answer = dict[str, Any]

#: Seconds of iterations before the measurement, one at least.
WARM_UP = 0.1
#: Seconds that a breakdown may take, and the fewest iterations it is made from.
BREAKDOWN_SECONDS, FEWEST = 1.0, 1
#: Repeats of whole runs and of processes.
RUNS, PROCESSES = 3, 5
#: What places paths, as in `breakdown.HOST_STEPS`.
PLACEMENT = ("placement", "livecl.run.stages", "place_paths")
#: Mean squared errors whose time is told, and the iterations between two looks at the error.
ERRORS, LOOK = (2e-2, 1e-2, 5e-3), 10


@dataclasses.dataclass(frozen=True)
class Machine:
    """The device that is measured, and what it was chosen by."""

    opened: OpenDevice
    device: str | None

    @functools.cached_property
    def rate(self) -> Callable[[], float]:
        """Function that returns the reference rate at this moment, GFLOP/s."""
        return MultiplyAdd(self.opened, REFERENCE_SUMS).rate


def measure_step(case: Case, image: Image, scene: Path, machine: Machine, repeats: int | None) -> Answer:
    """Time iterations from a scene on, then break them down; placement; memory."""
    vectorizer = Vectorizer(image, load_scene(scene), machine.device)

    def step() -> None:
        vectorizer.step()

    start = time.perf_counter()
    while time.perf_counter() - start < WARM_UP:
        step()
    found = repeated(step, machine.rate, repeats)
    iterations = int(np.clip(BREAKDOWN_SECONDS / np.median(found.seconds), FEWEST, breakdown.ITERATIONS))
    iterations = min(iterations, repeats or iterations)
    answer: Answer = {
        "time": found.summary(),
        "host": breakdown.host_steps(step, iterations),
        "kernels": breakdown.kernels(step, iterations),
    }
    if case.picture != "covers":
        answer |= _placement(vectorizer, scene)
    return {**answer, "memory_mb": peak_megabytes()}


def _placement(vectorizer: Vectorizer, scene: Path) -> Answer:
    """Time of placing the paths of the last stage once more, ms: what each stage does once."""
    clock, seconds = breakdown.Clock(), []
    with breakdown.wrapped(clock, (PLACEMENT,)) as missing:
        if missing:
            return {}
        for _ in range(4):
            vectorizer.state = load_scene(scene)
            vectorizer.state.iteration = 0  # as if the stage began
            run(vectorizer, on_step=lambda step: True)
            seconds.append(clock.seconds.pop(PLACEMENT[0]))
    paths = vectorizer.state.schedule[vectorizer.state.stage]
    median = 1e3 * float(np.median(seconds[1:]))  # the first call imports what it needs
    return {"placement": {"paths": paths, "first_ms": 1e3 * seconds[0], "median_ms": median}}


def course(
    case: Case, image: Image, device: int | str | None, on_step: Callable[[Step], bool | None] | None = None
) -> Result:
    """Run the case's schedule with the paper's settings."""
    return livecl.vectorize(image, schedule=case.schedule, options=Options.paper(), device=device, on_step=on_step)


def measure_course(case: Case, image: Image, machine: Machine, repeats: int | None) -> Answer:
    """Time whole runs: the seconds of optimization, without compilation; and the time to given errors."""
    first = course(case, image, machine.device)  # imports what it needs
    found = repeated(lambda: course(case, image, machine.device).seconds, machine.rate, repeats or RUNS)
    return {
        "time": found.summary(),
        "first_ms": 1e3 * first.seconds,
        "stages": [{"paths": stage.paths, "mse": stage.mse, "seconds": stage.seconds} for stage in first.stages],
        "to_error": times_to_errors(case, image, machine),
        "memory_mb": peak_megabytes(),
    }


def times_to_errors(case: Case, image: Image, machine: Machine) -> dict[str, dict[str, float] | None]:
    """Return the time of optimization until the error was down to each bound, None where it never was.

    In ms as measured, and at the reference rate. Looking at the error costs a render, and at the machine's rate a few
    launches; the clock stands still meanwhile.
    """
    reached: dict[str, dict[str, float] | None] = dict.fromkeys(f"{bound:g}" for bound in ERRORS)
    moments: list[tuple[float, float]] = []  # when the clock stood still, and until when
    rates: list[float] = []

    def look(step: Step) -> None:
        if step.iteration % LOOK:
            return
        now = time.perf_counter()
        error = step.mse
        rates.append(machine.rate())
        for bound in reached:
            if reached[bound] is None and error <= float(bound):
                measured = 1e3 * (now - sum(end - begin for begin, end in moments))
                reached[bound] = {"ms": measured, "gflops": float(np.mean(rates))}
        moments.append((now, time.perf_counter()))

    start = time.perf_counter()
    start += course(case, image, machine.device, look).compile_seconds
    for found in filter(None, reached.values()):
        found["ms"] -= 1e3 * start
        found["scaled_ms"] = found["ms"] * found.pop("gflops") / REFERENCE_GFLOPS
    return reached


def measure_process(case: Case, root: Path, machine: Machine, repeats: int | None) -> Answer:
    """Time processes: the command line to its first iteration, or an import."""
    found = repeated(lambda: process_seconds(case, root, machine.device), machine.rate, repeats or PROCESSES)
    return {"time": found.summary()}
