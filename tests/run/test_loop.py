# SPDX-License-Identifier: Apache-2.0
"""What a loop returns of its stages: those finished, the one under way, and those of a run that failed."""

from __future__ import annotations

import itertools
import math
import time
from pathlib import Path

import numpy as np
import pytest
from support.runs import new_run
from support.shapes import build, rectangle

from livecl import Drawing, Options
from livecl.interruption import interruptible
from livecl.run.checkpoint import Checkpoints, load_checkpoint
from livecl.run.control import Stopped
from livecl.run.loop import Loop
from livecl.run.record import Record
from livecl.run.result import Stage

METHOD = Options(placement="region", iterations=3, revisions=0)


def _stage(iterations: int, seconds: float, mse: float = 0.1) -> Stage:
    return Stage(build([([rectangle(2, 2, 8, 8)], (1, 0, 0, 1))], (24, 24)), mse, iterations, seconds)


def test_a_revision_adds_its_effort_to_the_stage_before_it() -> None:
    record = Record([_stage(5, 1.0), _stage(7, 2.0)], iterations=3, seconds=0.5)
    first, last = record.with_stage(_stage(4, 0.25, mse=0.05), extends=True)
    assert first is record.stages[0]
    assert (last.iterations, last.seconds, last.mse) == (11, 2.25, 0.05)
    assert [stage.iterations for stage in record.with_stage(_stage(4, 0.25), extends=False)] == [5, 7, 4]
    assert [stage.iterations for stage in Record().with_stage(_stage(4, 0.25), extends=True)] == [4]
    assert [(stage.iterations, stage.seconds) for stage in record.lengthened()] == [(5, 1.0), (10, 2.5)]


def test_a_run_stopped_between_stages_has_those_that_ended(device: int) -> None:
    run = new_run(METHOD, (1, 1), device)
    loop = Loop(run)

    def check() -> None:
        if run.state.stage == 1 and not run.progress.placed and loop.record.stages:
            raise Stopped("time limit")

    with interruptible(check):
        loop.train()
    assert loop.stopped == "time limit" and len(loop.record.stages) == 1
    (stage,) = loop.stages()
    assert stage.drawing is loop.record.stages[0].drawing and stage.iterations == 3


@pytest.mark.parametrize("ruined", ["points", "colors"])
def test_of_a_run_that_failed_nothing_is_returned_that_is_not_finite(ruined: str, device: int) -> None:
    run = new_run(METHOD, (1, 1), device)
    loop = Loop(run)
    with run.all_or_nothing():
        assert run.begin()
    (begun,) = loop.salvaged_stages()
    assert math.isfinite(begun.mse) and begun.paths == 1
    getattr(run.state.drawing, ruined).setflags(write=True)
    getattr(run.state.drawing, ruined)[0] = np.nan
    assert loop.salvaged_stages() == []
    loop.record = Record([_stage(5, 1.0)])
    assert [type(stage.drawing) for stage in loop.salvaged_stages()] == [Drawing]
    assert loop.salvaged_stages()[0].iterations == 5


def test_time_after_the_last_stage_counts_for_it(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    loop = Loop(new_run(METHOD, (1,), device))
    loop.train()
    before, later = loop.record.stages[-1].seconds, time.perf_counter() + 100
    monkeypatch.setattr("livecl.run.loop.time.perf_counter", lambda: later)
    assert loop.stages()[-1].seconds >= before + 100


def test_a_checkpoint_holds_the_time_until_it_is_written(
    device: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def check() -> None:
        raise Stopped("time limit")

    run = new_run(METHOD, (1,), device)
    assert run.begin()
    run.progress.placed = True
    clock = itertools.count(7)
    monkeypatch.setattr("livecl.run.loop.time.perf_counter", lambda: float(next(clock)))
    with interruptible(check):
        Loop(run, checkpoints=Checkpoints(tmp_path / "run.checkpoint", {}, period=0)).train()
    _, record = load_checkpoint(tmp_path / "run.checkpoint", {})
    assert record.seconds >= 1, "a look at the clock, at the least, after that where training begins"
