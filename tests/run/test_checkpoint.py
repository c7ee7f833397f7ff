# SPDX-License-Identifier: Apache-2.0
"""Runs that are stopped, or fail: they end with the best drawing so far, and go on to the end of whole ones."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from numpy.typing import NDArray
from support.device_work import opencl_error
from support.runs import SMALL, three_shapes

import livecl
from livecl import CheckpointError, Control, DeviceError, Options, Recipe, Result, RunError, vectorize
from livecl.opencl.launcher import Launcher
from livecl.run.checkpoint import discard_checkpoint, is_checkpoint
from livecl.training.archive import read_archive, write_archive
from livecl.training.objective import Objective

START = livecl.vectorize(SMALL, 2, options=Options(placement="region", iterations=5, revisions=0)).drawing


def with_alpha() -> NDArray[np.float64]:
    """Return the picture with a soft hole in it."""
    rows, columns = np.indices((24, 24)) + 0.5
    alpha = np.clip((np.hypot(rows - 12, columns - 8) - 5) / 4, 0, 1)
    return np.dstack([SMALL, alpha])


#: Arguments of runs in which all that a checkpoint must hold plays a part.
RUNS: dict[str, dict[str, Any]] = {
    "revisions": {"schedule": [1, 2], "options": Options(placement="region", iterations=26, revisions=3), "seed": 4},
    "alpha": {"image": with_alpha(), "paths": 3, "options": Options(placement="region", iterations=12, revisions=2)},
    "start and lock": {
        "start": START,
        "lock": [0],
        "paths": 2,
        "options": Options(placement="region", iterations=12, revisions=2),
    },
    "refinement": {"start": START, "options": Options(placement="region", iterations=20, revisions=1)},
    "auto": {"paths": "auto", "options": Options(placement="region", iterations=10, revisions=1, target_mse=2e-3)},
    "chance": {"schedule": [2, 2], "options": Options.diffvg(iterations=15)},
    "released": {"schedule": [1, 2], "options": Options.released(iterations=15)},
    "paper": {"schedule": [1, 2], "options": Options.paper(iterations=15, background="train")},
}


def same(one: Result, other: Result) -> bool:
    """Whether two results are the same to the last bit, but for the time they took."""

    def facts(result: Result) -> list[Any]:
        return [(livecl.svg.format_svg(stage.drawing), stage.mse, stage.iterations) for stage in result.stages]

    return one.svg == other.svg and facts(one) == facts(other) and one.stopped == other.stopped


def after(count: int) -> Callable[[], str | None]:
    """Return a `Control.stop` that stops when it is asked for so-manieth time."""
    asked = itertools.count(1)
    return lambda: "enough" if next(asked) >= count else None


@pytest.mark.parametrize("name", RUNS)
def test_a_run_stopped_again_and_again_ends_the_same(name: str, device: int, tmp_path: Path) -> None:
    arguments = {"image": SMALL, "device": device, **RUNS[name]}
    whole = vectorize(**arguments)
    rng, path, stops = np.random.default_rng(len(name)), tmp_path / "checkpoint", 0
    while True:
        # It is asked after each step and, in placement and merging, before each try: a stop may come anywhere.
        # Ever later, as each time the placement that was stopped begins anew.
        control = Control(stop=after(int(rng.integers(2, 9 * 1.4**stops))), checkpoint=path, resume=True)
        result = vectorize(**arguments, control=control)
        if result.stopped is None:
            break
        assert result.stopped == "enough"
        stops += 1
    assert stops >= 2
    assert same(result, whole)


def test_checkpoints_at_every_step_change_nothing(device: int, tmp_path: Path) -> None:
    arguments = {"image": SMALL, "device": device, **RUNS["revisions"]}
    path = tmp_path / "checkpoint"
    result = vectorize(**arguments, control=Control(checkpoint=path, period=0))
    assert same(result, vectorize(**arguments))
    steps: list[Any] = []
    again = vectorize(**arguments, control=Control(checkpoint=path, resume=True), on_step=steps.append)
    assert same(again, result) and not steps, "the end is in the checkpoint"
    discard_checkpoint(path)
    assert list(tmp_path.iterdir()) == []


def test_a_short_run_writes_no_checkpoint(device: int, tmp_path: Path) -> None:
    vectorize(
        SMALL,
        1,
        options=Options(placement="region", iterations=2, revisions=0),
        control=Control(checkpoint=tmp_path / "checkpoint"),
    )
    assert list(tmp_path.iterdir()) == []


def test_a_recipe_goes_on_too(device: int, tmp_path: Path) -> None:
    recipe = Recipe(paths=3, size=24, precision=1, options=Options(placement="region", iterations=8, revisions=1))
    whole = recipe.vectorize(three_shapes(), device)
    path = tmp_path / "checkpoint"
    stopped = recipe.vectorize(three_shapes(), device, control=Control(stop=after(30), checkpoint=path))
    assert stopped.stopped == "enough" and stopped.working_size == (24, 24) and stopped.drawing.size == (40, 40)
    assert same(recipe.vectorize(three_shapes(), device, control=Control(checkpoint=path, resume=True)), whole)


def test_a_stop_is_asked_for_in_placement_and_merging(device: int) -> None:
    asked: list[int] = []
    steps: list[int] = []

    def stop() -> None:
        asked.append(len(steps))

    options = Options(placement="region", iterations=3, revisions=1)
    vectorize(SMALL, 6, [6], options, device, on_step=lambda step: steps.append(1), control=Control(stop=stop))
    # Before the first step it is asked for each path at least, and so it is in the revision.
    assert asked.count(0) > 6 and asked.count(3) > 2


def stopped_run(path: Path, device: int) -> dict[str, Any]:
    """Leave a checkpoint, and return the arguments of the run."""
    arguments: dict[str, Any] = {
        "image": SMALL,
        "paths": 3,
        "options": Options(placement="region", iterations=5, revisions=0),
    }
    result = vectorize(**arguments, device=device, on_step=lambda _: True, control=Control(checkpoint=path))
    assert result.stopped == "callback"
    assert is_checkpoint(path)
    return {**arguments, "device": device}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"options": Options(placement="region", iterations=6, revisions=0)}, "iterations was 5, is 6"),
        (
            {"options": Options(placement="region", iterations=5, merge=False)},
            "revisions was 0, is 8; merge was True, is False",
        ),
        ({"paths": 4}, "schedule was [1, 2], is [1, 2, 1]"),
        ({"seed": 2}, "seed was 0, is 2"),
        ({"image": SMALL[::-1]}, "another picture"),
        ({"image": three_shapes()}, "pixels was 24x24 px, 3 channels, is 40x40 px, 3 channels"),
        ({"start": START}, "another drawing to start from"),
    ],
)
def test_a_checkpoint_of_another_run_is_refused(
    changes: dict[str, Any], message: str, device: int, tmp_path: Path
) -> None:
    path = tmp_path / "checkpoint"
    arguments = stopped_run(path, device)
    before = path.read_bytes()
    with pytest.raises(CheckpointError) as caught:
        vectorize(**{**arguments, **changes}, control=Control(checkpoint=path, resume=True))
    assert str(caught.value).startswith(f"{path}: is a checkpoint of another run: ")
    assert message in str(caught.value) and "\n" not in str(caught.value)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(("name", "value"), [("version", "0.0.1"), ("device", "GPU of old")])
def test_another_version_or_device_is_refused(name: str, value: str, device: int, tmp_path: Path) -> None:
    path = tmp_path / "checkpoint"
    arguments = stopped_run(path, device)
    facts, arrays = read_archive(path)
    facts["identity"][name] = value
    write_archive(path, facts, arrays)
    with pytest.raises(CheckpointError, match=f"{name} was {value}, is "):
        vectorize(**arguments, control=Control(checkpoint=path, resume=True))
    assert is_checkpoint(path)


def test_what_is_no_checkpoint_is_refused_and_stays(device: int, tmp_path: Path) -> None:
    path = tmp_path / "checkpoint"
    arguments = stopped_run(path, device)
    data = path.read_bytes()
    facts, arrays = read_archive(path)
    write_archive(tmp_path / "other", {"format": 1}, arrays)
    write_archive(tmp_path / "later", {**facts, "format": 99}, arrays)
    write_archive(tmp_path / "lacking", {**facts, "state": {}}, arrays)
    cut = [data[:length] for length in (0, 1, 100, len(data) // 2, len(data) - 1)]
    others = [b"text", bytes(1000), *((tmp_path / name).read_bytes() for name in ("other", "later", "lacking"))]
    for content in (*cut, *others):
        path.write_bytes(content)
        with pytest.raises(CheckpointError) as caught:
            vectorize(**arguments, control=Control(checkpoint=path, resume=True))
        assert str(caught.value).startswith(f"{path}: is no checkpoint that can be read: ")
        assert "\n" not in str(caught.value) and path.read_bytes() == content


def test_a_checkpoint_that_cannot_be_written_is_warned_of_once(
    device: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    arguments = {
        "image": SMALL,
        "device": device,
        "paths": 2,
        "options": Options(placement="region", iterations=5, revisions=0),
    }
    path = tmp_path / "missing" / "checkpoint"
    with caplog.at_level(logging.WARNING, logger="livecl"):
        result = vectorize(**arguments, control=Control(checkpoint=path, period=0))
    assert same(result, vectorize(**arguments))
    assert caplog.messages == [f"{path}: cannot be written (No such file or directory); the run goes on without"]


def fails_from(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str, count: int, failure: Callable[..., Any]) -> None:
    """Have a method do something else from its so-manieth call on."""
    original, calls = getattr(owner, name), itertools.count(1)

    def method(*arguments: Any, **keywords: Any) -> Any:
        return (original if next(calls) < count else failure)(*arguments, **keywords)

    monkeypatch.setattr(owner, name, method)


def failing(error: BaseException) -> Callable[..., Any]:
    def fail(*_: Any, **__: Any) -> None:
        raise error

    return fail


def device_error() -> BaseException:
    """Return what pyopencl raises when a device is gone."""
    return opencl_error(cl.RuntimeError, cl.status_code.INVALID_COMMAND_QUEUE)


#: Ten steps a stage; the warm-up takes one.
FAILING: dict[str, Any] = {
    "image": SMALL,
    "schedule": [1, 2],
    "options": Options(placement="region", iterations=10, revisions=1),
}


def failed(path: Path) -> RunError:
    with pytest.raises(RunError) as caught:
        vectorize(**FAILING, control=Control(checkpoint=path))
    return caught.value


def goes_on(monkeypatch: pytest.MonkeyPatch, path: Path) -> None:
    """Check that the run that failed ends as if it had not."""
    monkeypatch.undo()
    assert same(vectorize(**FAILING, control=Control(checkpoint=path, resume=True)), vectorize(**FAILING))


@pytest.mark.parametrize(("step", "stage"), [(13, 2), (11, 2), (25, 3), (5, 1)])
def test_a_loss_that_is_not_finite(step: int, stage: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    evaluate = Objective.evaluate

    def spoiled(*arguments: Any) -> Any:
        loss, gradients = evaluate(*arguments)
        return np.nan * loss, gradients

    fails_from(monkeypatch, Objective, "evaluate", step, spoiled)
    error = failed(tmp_path / "checkpoint")
    number = step - 10 * (stage - 1)
    assert str(error) == f"loss or gradient is not finite in stage {stage}, step {number}"
    assert error.result is not None and error.result.stopped == str(error)
    assert error.result.drawing.num_layers and error.result.mse < np.mean((1 - SMALL) ** 2)
    assert sum(stage.iterations for stage in error.result.stages) == step - 1
    goes_on(monkeypatch, tmp_path / "checkpoint")


def test_a_device_that_is_lost_in_a_later_stage(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    first = vectorize(**FAILING).stages[0]
    evaluate = Objective.evaluate
    lost = failing(device_error())

    def last(*arguments: Any) -> Any:  # from now on nothing runs on the device
        monkeypatch.setattr(Launcher, "__call__", lost)
        return evaluate(*arguments)

    fails_from(monkeypatch, Objective, "evaluate", 14, last)
    error = failed(tmp_path / "checkpoint")
    assert isinstance(error.__cause__, DeviceError) and "failed: clEnqueueNDRange" in str(error)
    assert error.result is not None
    assert error.result.svg == livecl.svg.format_svg(first.drawing) and error.result.mse == first.mse
    goes_on(monkeypatch, tmp_path / "checkpoint")


def test_a_device_that_is_lost_in_the_first_stage(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[Any] = []
    vectorize(**FAILING, on_step=lambda step: seen.append(step.drawing) or len(seen) == 6)

    evaluate = Objective.evaluate

    def last(*arguments: Any) -> Any:
        monkeypatch.setattr(Launcher, "__call__", failing(device_error()))
        return evaluate(*arguments)

    fails_from(monkeypatch, Objective, "evaluate", 7, last)
    error = failed(tmp_path / "checkpoint")
    assert error.result is not None and np.isnan(error.result.mse), "there was no device to measure it with"
    assert error.result.svg == livecl.svg.format_svg(livecl.svg.quantize(seen[-1]))
    goes_on(monkeypatch, tmp_path / "checkpoint")


@pytest.mark.parametrize("where", ["livecl.run.phases.place_paths", "livecl.run.phases.least_useful"])
def test_memory_that_runs_out_in_placement(where: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    original, done = eval(where, {"livecl": livecl}), itertools.count(1)
    count = 3 if where.endswith("place_paths") else 1  # the first is that of the warm-up

    def place(*arguments: Any) -> Any:
        if next(done) >= count:
            raise MemoryError
        return original(*arguments)

    monkeypatch.setattr(where, place)
    error = failed(tmp_path / "checkpoint")
    assert str(error) == "out of memory" and isinstance(error.__cause__, MemoryError)
    assert error.result is not None and error.result.stages[-1].iterations == 10
    goes_on(monkeypatch, tmp_path / "checkpoint")


def test_a_failure_before_there_is_a_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("livecl.run.loop.Loop._train_phase", failing(MemoryError()))
    assert failed(tmp_path / "checkpoint").result is None


def test_leftovers_of_a_killed_writing_are_deleted_with_the_checkpoint(
    device: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "checkpoint"
    stopped_run(path, device)
    (tmp_path / "other.tmp").touch()
    with monkeypatch.context() as patched:  # of Path: on Python 3.10 it calls the functions of os by other names
        patched.setattr(Path, "replace", failing(SystemExit()))
        patched.setattr(Path, "unlink", lambda *_, **__: None)
        with pytest.raises(SystemExit):
            write_archive(path, {}, {})
    assert len(list(tmp_path.glob(".livecl-*.tmp"))) == 1
    discard_checkpoint(path)
    assert [file.name for file in tmp_path.iterdir()] == ["other.tmp"]
