# SPDX-License-Identifier: Apache-2.0
"""Worker process of the benchmark: make a scene, check a case, or time it.

A separate process has its own memory, and measures the package of another checkout by the same code.
"""

from __future__ import annotations

import inspect
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmark.cases import CASES, Case
from benchmark.package import name_processor, training, use_checkout

Answer = dict[str, Any]
#: Seconds of iterations before the measurement, one at least.
WARM_UP = 0.1
#: Seconds that a breakdown may take.
BREAKDOWN_SECONDS = 1.0
#: Repeats of short processes. A process does one whole run, as further ones would profit from caches of the first.
PROCESSES = 5


class Worker:
    """Answers the requests about a case.

    Parameters
    ----------
    root, folder : str
        The checkout whose package is measured; the folder of scenes.
    case : str
        Name of the case; empty for the machine.
    device, photo : str or None
        OpenCL device; file of the photograph.
    repeats : int or None
        Number of measurements; None for as many as fit.
    judged : bool
        Whether whole runs must end below the case's error; those of another checkout need not.
    """

    def __init__(self, root: str, folder: str, case: str, **settings: Any) -> None:
        self.root, self.folder = Path(root), Path(folder)
        self.case = CASES.get(case) or Case(name="", kind="import")
        self.device, self.photo, self.repeats = (settings[name] for name in ("device", "photo", "repeats"))
        self.mse_at_most = self.case.mse_at_most if settings.get("judged", True) else None
        self.scene_file, self.picture_file = self.folder / f"{case}.npz", self.folder / f"{case}.npy"

    def rate(self) -> Callable[[], float]:
        """Return a function that measures the machine's rate, GFLOP/s."""
        from benchmark.calibration import MultiplyAdd
        from livecl.opencl.device import open_device

        return MultiplyAdd(open_device(self.device)).rate

    def machine(self) -> Answer:
        """Describe the machine and its present rate."""
        from benchmark.machine import facts
        from livecl.opencl.device import open_device

        return {**facts(open_device(self.device), self.root), "gflops": self.rate()()}

    def prepare(self) -> Answer:
        """Make a case's picture, and the scene of an iteration."""
        from benchmark.scenes import made, picture, save_scene, save_variants

        if self.case.kind in ("step", "run", "folder"):
            np.save(self.picture_file, picture(self.case.picture, self.case.side, self.photo))
        if self.case.kind == "step":
            save_scene(self.scene_file, made(self.case, self.photo, self.device))
        if self.case.kind == "folder":
            save_variants(np.load(self.picture_file), self.folder / "faces")
        return {}

    def check(self) -> Answer:
        """Check a case's results; whole runs are checked when they are timed."""
        from benchmark.checks import check_step
        from benchmark.scenes import load_scene

        if self.case.kind == "step":
            image, exact = np.load(self.picture_file), self.case.picture != "covers"
            return {"checked": check_step(image, load_scene(self.scene_file), self.device, exact=exact)}
        if self.case.kind in ("run", "folder"):
            return {}
        return {"checked": {"seconds": self.process_seconds()}}

    def time(self) -> Answer:
        """Time a case, and break it down."""
        from benchmark.calibration import repeated

        if self.case.kind == "step":
            return self.time_step()
        if self.case.kind == "run":
            return self.time_run()
        if self.case.kind == "folder":
            return self.time_whole(self.whole_folder)
        return {"time": repeated(self.process_seconds, self.rate(), self.repeats or PROCESSES).summary()}

    def time_step(self) -> Answer:
        """Time iterations that start from a scene, then break them down."""
        from benchmark import breakdown
        from benchmark.calibration import repeated
        from benchmark.machine import peak_megabytes
        from benchmark.scenes import load_scene

        trained = training(np.load(self.picture_file), load_scene(self.scene_file), self.device)

        def step() -> None:
            trained.step()

        start = time.perf_counter()
        while time.perf_counter() - start < WARM_UP:
            step()
        found = repeated(step, self.rate(), self.repeats)
        fitting = int(np.clip(BREAKDOWN_SECONDS / np.median(found.seconds), 1, breakdown.ITERATIONS))
        iterations = min(fitting, self.repeats or fitting)
        return {
            "time": found.summary(),
            "host": breakdown.host_steps(step, iterations),
            "kernels": breakdown.kernels(step, iterations),
            "memory_mb": peak_megabytes(),
        }

    def time_run(self) -> Answer:
        """Time a whole run, imports and compilation left out, and check its error."""
        from benchmark.machine import peak_megabytes

        self.warm_up()
        return {**self.time_whole(lambda: self.whole_run().mse), "memory_mb": peak_megabytes()}

    def time_whole(self, work: Callable[[], float]) -> Answer:
        """Time something that returns its error, once, and check the error."""
        from benchmark.calibration import repeated
        from benchmark.checks import check_error

        errors: list[float] = []
        found = repeated(lambda: errors.append(work()), self.rate(), 1)
        return {"time": found.summary(), "checked": check_error(errors[0], self.mse_at_most)}

    def break_down(self) -> Answer:
        """Break a whole run down by its parts, and time its outputs."""
        from benchmark import breakdown

        if self.case.kind != "run":
            return {}
        self.warm_up()
        clock = breakdown.Clock()
        with breakdown.wrapped(clock, breakdown.RUN_PARTS):
            result = self.whole_run()
        whole = result.seconds + result.compile_seconds
        parts = {label: 1e3 * seconds for label, seconds in clock.seconds.items()}
        parts[breakdown.OTHER] = 1e3 * whole - sum(parts.values())
        return {"parts": parts | self.outputs_ms()}

    def warm_up(self) -> None:
        """Run small pictures, one flat and one not, for imports and compilation."""
        import livecl
        from benchmark.scenes import warm_up_pictures
        from livecl.options import PRESETS

        for image in warm_up_pictures():
            livecl.vectorize(image, 3, options=PRESETS[self.case.preset](iterations=10), device=self.device)

    def whole_run(self, on_step: Any = None) -> Any:
        """Run the case's preset and schedule, on all pixels."""
        import livecl
        from livecl.options import PRESETS

        options, image = PRESETS[self.case.preset](), np.load(self.picture_file)
        given = {"schedule": self.case.schedule, "options": options, "device": self.device, "on_step": on_step}
        if "size" in inspect.signature(livecl.vectorize).parameters:
            given["size"] = 0
        return livecl.vectorize(image, self.case.paths or "auto", **given)

    def outputs_ms(self) -> dict[str, float]:
        """Return the ms of each output of a run; none in checkouts without `views`."""
        from benchmark.breakdown import OUTPUTS

        if not (self.root / "livecl" / "views").is_dir():
            return {}
        from livecl import views

        course, found = views.Course(), {}
        result = self.whole_run(course)
        for label, write in OUTPUTS:
            start = time.perf_counter()
            write(views, np.load(self.picture_file), result, course, self.folder)
            found[label] = 1e3 * (time.perf_counter() - start)
        return found

    def whole_folder(self) -> float:
        """Run the folder of variants in two workers; return the mean MSE."""
        import livecl

        recipe = livecl.Recipe(paths=self.case.paths)
        folders = self.folder / "faces", self.folder / "svgs"
        outcomes = livecl.vectorize_files(*folders, recipe=recipe, workers=2, skip_done=False)
        return float(np.mean([outcome.mse or np.inf for outcome in outcomes]))

    def process_seconds(self) -> float:
        """Return the seconds of a case's process."""
        from benchmark.startup import first_iteration_seconds, import_seconds

        if self.case.kind == "import":
            return import_seconds(self.root)
        return first_iteration_seconds(self.root, self.device, cold=self.case.cold)


def main(text: str) -> None:
    """Answer a request given as JSON. A failed check is an answer; other errors end the process."""
    request = json.loads(text)
    verb, answer_file = request.pop("verb"), Path(request["folder"]) / "answer.json"
    use_checkout(Path(request["root"]))
    name_processor(Path(request["root"]), request.get("device"))
    from benchmark.checks import CheckError

    try:
        answer = getattr(Worker(**request), verb)()
    except CheckError as error:
        answer = {"failed": str(error)}
    answer_file.write_text(json.dumps(answer), encoding="utf-8")
