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

from benchmark import breakdown
from benchmark.calibration import REFERENCE_SUMS, MultiplyAdd
from benchmark.cases import Case
from benchmark.machine import peak_megabytes
from benchmark.repeats import repeated
from benchmark.startup import process_seconds
from livecl.device import OpenDevice
from livecl.options import Options
from livecl.placement import place_paths
from livecl.state import State
from livecl.vectorizer import Result, Step, Vectorizer, vectorize

Image = NDArray[np.float32]
Answer = dict[str, Any]

#: Iterations before the measurement.
WARM_UP = 3
#: Seconds that a breakdown may take, and the fewest iterations it is made from.
BREAKDOWN_SECONDS, FEWEST = 1.0, 3
#: Repeats of whole runs and of processes.
RUNS, PROCESSES = 3, 5
#: Mean squared errors whose time is told, and the iterations between two looks at the error.
ERRORS, LOOK = (1e-2, 3e-3, 1e-3), 5


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
    vectorizer = Vectorizer(image, State.load(scene), machine.device)

    def step() -> None:
        vectorizer.step()

    for _ in range(WARM_UP):
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
        answer["placement"] = _placement(vectorizer)
    return {**answer, "memory_mb": peak_megabytes()}


def _placement(vectorizer: Vectorizer) -> Answer:
    """Time of placing the paths of the last stage once more, ms: what each stage does once."""
    state = vectorizer.state
    image = vectorizer.rasterizer.forward(state.drawing)
    seconds = []
    for _ in range(4):
        start = time.perf_counter()
        place_paths(vectorizer.target, image, state.schedule[-1], state.options, np.random.default_rng(0))
        seconds.append(time.perf_counter() - start)
    # The first call imports what it needs.
    return {"paths": state.schedule[-1], "first_ms": 1e3 * seconds[0], "median_ms": 1e3 * float(np.median(seconds[1:]))}


def course(
    case: Case, image: Image, device: int | str | None, on_step: Callable[[Step], bool | None] | None = None
) -> Result:
    """Run the case's schedule with the paper's settings."""
    return vectorize(image, schedule=case.schedule, options=Options.paper(), device=device, on_step=on_step)


def measure_course(case: Case, image: Image, machine: Machine, repeats: int | None) -> Answer:
    """Time whole runs: the seconds of optimization, without compilation; and the time to given errors."""
    first = course(case, image, machine.device)  # imports what it needs
    found = repeated(lambda: course(case, image, machine.device).seconds, machine.rate, repeats or RUNS)
    return {
        "time": found.summary(),
        "first_ms": 1e3 * first.seconds,
        "stages": [{"paths": stage.paths, "mse": stage.mse, "seconds": stage.seconds} for stage in first.stages],
        "seconds_to_error": seconds_to_errors(case, image, machine.device),
        "memory_mb": peak_megabytes(),
    }


def seconds_to_errors(case: Case, image: Image, device: int | str | None) -> dict[str, float | None]:
    """Return the seconds of optimization until the error was down to each bound; None where it never was.

    Looking at the error costs a render; the clock stands still meanwhile.
    """
    reached: dict[float, float | None] = dict.fromkeys(ERRORS)
    looking = 0.0

    def look(step: Step) -> None:
        nonlocal looking
        if step.iteration % LOOK:
            return
        now = time.perf_counter()
        error = step.mse
        for bound in ERRORS:
            if reached[bound] is None and error <= bound:
                reached[bound] = now - looking
        looking += time.perf_counter() - now

    start = time.perf_counter()
    start += course(case, image, device, look).compile_seconds
    return {f"{bound:g}": None if moment is None else moment - start for bound, moment in reached.items()}


def measure_process(case: Case, root: Path, machine: Machine, repeats: int | None) -> Answer:
    """Time processes: the command line to its first iteration, or an import."""
    found = repeated(lambda: process_seconds(case, root, machine.device), machine.rate, repeats or PROCESSES)
    return {"time": found.summary()}
