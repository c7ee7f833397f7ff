# SPDX-License-Identifier: Apache-2.0
"""What a subprocess does for the benchmark: one request, one answer.

Every case is measured in a process of its own, so that its memory is its own, and so that the package of another
checkout can be measured by the same code. A scene is made and checked in other processes than the one that is timed.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmark.request import Request

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

Answer = dict[str, Any]


def main(text: str) -> None:
    """Answer a request given as JSON, in JSON. A failed check is an answer; other errors end the process."""
    request = Request.from_json(text)
    root = Path(request.root).resolve()
    sys.path.insert(0, str(root))
    import livecl

    if Path(livecl.__file__).resolve().parent.parent != root:
        raise RuntimeError(f"livecl was imported from {livecl.__file__}, wanted {root}")
    from benchmark.checks import CheckError

    try:
        answer = {"machine": machine, "prepare": prepare, "check": check, "time": measure}[request.verb](request)
    except CheckError as error:
        answer = {"failed": str(error)}
    request.answer_file.write_text(json.dumps(answer), encoding="utf-8")


def machine(request: Request) -> Answer:
    """Tell what the machine is, and calibrate it."""
    from benchmark.calibration import calibrate
    from benchmark.machine import facts
    from livecl.opencl.device import open_device

    opened = open_device(request.device)
    return {**facts(opened, Path(request.root)), **calibrate(opened)}


def prepare(request: Request) -> Answer:
    """Make the scene of an iteration and count what is in it; for a whole run, make only its picture."""
    from benchmark.scene_file import save_scene
    from benchmark.scenes import made, picture

    case = request.the_case
    if case.kind not in ("step", "course"):
        return {}
    np.save(request.picture_file, picture(case.picture, case.side, request.photo))
    if case.kind == "course":
        return {}
    state = made(case, request.photo, request.device)
    save_scene(request.scene_file, state)
    return counted([(state.drawing, 1)], state.options.tau)


def check(request: Request) -> Answer:
    """Check that a case does what it should; for a whole run, also count what its stages have to deal with."""
    from benchmark.checks import check_error, check_step

    case = request.the_case
    if case.kind == "step":
        from benchmark.scene_file import load_scene

        image, state = np.load(request.picture_file), load_scene(request.scene_file)
        return {"checked": check_step(image, state, request.device, exact=case.picture != "covers")}
    if case.kind == "course":
        from benchmark.measure import course
        from livecl.options import Options

        result = course(case, np.load(request.picture_file), request.device)
        stages = [(stage.drawing, stage.iterations) for stage in result.stages]
        return {"checked": check_error(result.mse, case.mse_at_most), **counted(stages, Options.paper().tau)}
    from benchmark.startup import process_seconds

    return {"checked": {"seconds": process_seconds(case, Path(request.root), request.device)}}


def measure(request: Request) -> Answer:
    """Time a case."""
    from benchmark.measure import Machine, measure_course, measure_process, measure_step
    from livecl.opencl.device import open_device

    case, machine = request.the_case, Machine(open_device(request.device), request.device)
    if case.kind == "step":
        return measure_step(case, np.load(request.picture_file), request.scene_file, machine, request.repeats)
    if case.kind == "course":
        return measure_course(case, np.load(request.picture_file), machine, request.repeats)
    return measure_process(case, Path(request.root), machine, request.repeats)


def counted(stages: list[tuple[Drawing, int]], tau: float) -> Answer:
    """Return the counts of the last drawing, its operations, and the floor of so many iterations on each drawing."""
    from benchmark.counts import counts
    from benchmark.floor import floor, operations
    from benchmark.limit import Floor
    from livecl.geometry.bezier import pieces_for
    from livecl.rendering.rasterizer import TOLERANCE

    total = Floor(0, 0, 0)
    for drawing, iterations in stages:
        scene = counts(drawing, pieces_for(drawing.cubics, TOLERANCE), tau)
        total += floor(scene).times(iterations)
    return {
        "counts": dataclasses.asdict(scene),
        "operations": operations(scene),
        "floor": dataclasses.asdict(total),
    }
