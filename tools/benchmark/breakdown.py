# SPDX-License-Identifier: Apache-2.0
"""Breakdown of an iteration's time: on the device by kernel, on the host by step.

The steps are timed from outside the package, by wrapping the functions named in `HOST_STEPS` while an iteration is
measured. A step's time excludes the steps it calls. Wrapping takes time as well: `overhead_ms` is its cost.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

#: Host steps: label, module, function. Functions that a checkout lacks are left out; their time counts as `other`.
HOST_STEPS = (
    ("pieces", "livecl.training.step", "choose_pieces"),
    ("pieces", "livecl.training.objective", "Objective._distance_pieces"),
    ("Xing", "livecl.training.objective", "Objective._xing"),
    ("Adam", "livecl.training.step", "move"),
    ("upload", "livecl.rendering.device_drawing", "Scene.load"),
    ("layout", "livecl.rendering.device_drawing", "Scene.flatten"),
    ("upload", "livecl.opencl.launcher", "Launcher.write"),
    ("launch", "livecl.opencl.launcher", "Launcher.__call__"),
    ("launch", "livecl.opencl.launcher", "Launcher.set"),
    ("launch", "livecl.opencl.launcher", "Launcher.reserve"),
    ("wait and read", "livecl.opencl.launcher", "Launcher.read"),
)
#: Parts of a whole run, likewise; merging and pruning while a stage is closed are part of that.
RUN_PARTS = (
    ("placement", "livecl.run.phases", "place_paths"),
    ("iterations", "livecl.run.run", "Run.step"),
    ("merging", "livecl.run.outcome", "merge_neighbors"),
    ("pruning", "livecl.run.outcome", "needed_layers"),
    ("choice", "livecl.run.phases", "least_useful"),
)
#: Outputs of a run: label, and the function that writes it.
OUTPUTS: tuple[tuple[str, Callable[..., Any]], ...] = (
    ("saving", lambda views, image, result, course, path: result.save_svg(path / "a.svg")),
    ("report", lambda views, image, result, course, path: views.write_report(path / "a.html", image, result)),
    ("sheet", lambda views, image, result, course, path: views.save_sheet(path / "a.png", image, result)),
    ("GIF", lambda views, image, result, course, path: course.save_gif(path / "a.gif", result=result)),
)
#: The rest of an iteration, or of a run.
OTHER = "other"
#: Number of iterations of which each breakdown is the median.
ITERATIONS = 40


class Clock:
    """Own time of nested steps, seconds by label."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._inner = [0.0]  # time of the steps called by each step under way

    def timed(self, label: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function, with its own time counted under the label."""

        @functools.wraps(function)
        def wrapper(*arguments: Any, **keywords: Any) -> Any:
            in_revision = type(getattr(arguments[0], "phase", None)).__name__ == "Revise" if arguments else False
            self._inner.append(0.0)
            start = time.perf_counter()
            try:
                return function(*arguments, **keywords)
            finally:
                whole = time.perf_counter() - start
                self.seconds[f"{label} of revisions" if in_revision else label] += whole - self._inner.pop()
                self._inner[-1] += whole

        return wrapper


@contextlib.contextmanager
def wrapped(clock: Clock, steps: tuple[tuple[str, str, str], ...] = HOST_STEPS) -> Iterator[list[str]]:
    """Context manager: wrap the steps' functions; yields the names of missing ones."""
    undo: list[tuple[Any, str, Any]] = []
    missing = []
    for label, module, path in steps:
        *outer, name = path.split(".")
        try:
            owner: Any = functools.reduce(getattr, outer, importlib.import_module(module))
            function = getattr(owner, name)
        except (ImportError, AttributeError):
            missing.append(f"{module}.{path}")
            continue
        undo.append((owner, name, function))
        setattr(owner, name, clock.timed(label, function))
    try:
        yield missing
    finally:
        for owner, name, function in undo:
            setattr(owner, name, function)


def host_steps(step: Callable[[], object], iterations: int = ITERATIONS) -> dict[str, Any]:
    """Return the median ms of each host step in an iteration, the wrapping's cost, and the functions not found."""
    plain = _median_ms([_seconds(step) for _ in range(iterations)])
    whole, by_label = [], defaultdict(list)
    clock = Clock()
    with wrapped(clock) as missing:
        labels = dict.fromkeys(label for label, module, path in HOST_STEPS if f"{module}.{path}" not in missing)
        for _ in range(iterations):
            clock.seconds.clear()
            whole.append(_seconds(step))
            for label in labels:
                by_label[label].append(clock.seconds[label])
            by_label[OTHER].append(whole[-1] - sum(clock.seconds.values()))
    return {
        "ms": {label: _median_ms(seconds) for label, seconds in by_label.items()},
        "overhead_ms": _median_ms(whole) - plain,
        "missing": missing,
    }


def kernels(step: Callable[[], object], iterations: int = ITERATIONS) -> dict[str, Any]:
    """Return the median ms of each kernel in an iteration by the device's clock, and its launches."""
    launchers = set()

    def find(launch: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(launch)
        def wrapper(launcher: Any, *arguments: Any, **keywords: Any) -> Any:
            launchers.add(launcher)
            if launcher.trace is None:
                launcher.trace = []
            return launch(launcher, *arguments, **keywords)

        return wrapper

    from livecl.opencl.launcher import Launcher

    launch = Launcher.__call__
    by_name: defaultdict[str, list[float]] = defaultdict(list)
    launches: defaultdict[str, int] = defaultdict(int)
    Launcher.__call__ = find(launch)  # type: ignore[method-assign]
    try:
        for _ in range(iterations):
            step()
            seconds: defaultdict[str, float] = defaultdict(float)
            for launcher in launchers:
                for name, event in launcher.trace:
                    event.wait()
                    seconds[name] += 1e-9 * (event.profile.end - event.profile.start)
                    launches[name] += 1
                launcher.trace = []
            for name, total in seconds.items():
                by_name[name].append(total)
    finally:
        Launcher.__call__ = launch  # type: ignore[method-assign]
        for launcher in launchers:
            launcher.trace = None
    return {
        "ms": {name: _median_ms(seconds) for name, seconds in by_name.items()},
        "launches": {name: round(count / iterations, 2) for name, count in launches.items()},
    }


def _seconds(step: Callable[[], object]) -> float:
    start = time.perf_counter()
    step()
    return time.perf_counter() - start


def _median_ms(seconds: list[float]) -> float:
    return 1e3 * float(np.median(seconds))
