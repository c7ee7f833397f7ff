# SPDX-License-Identifier: Apache-2.0
"""A run resumed from a saved state ends as if it had not stopped."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.states import SCHEDULE, assert_equal, disc_and_ring, load, save, start

from livecl import Options
from livecl.run.callbacks import Step
from livecl.run.loop import train
from livecl.run.run import Run
from livecl.svg import format_svg


def _copies_during(run_: Run, folder: Path, wanted: Callable[[Step], bool]) -> list[Path]:
    """Run to the end, and return the states saved after the steps wanted."""
    saved: list[Path] = []

    def on_step(step: Step) -> None:
        if wanted(step):
            saved.append(folder / f"{step.stage}-{step.iteration}.state")
            save(run_.progress, saved[-1])

    train(run_, on_step)
    return saved


RUNS = {
    "default": Options(iterations=52, revisions=2),
    "ending early": Options(placement="region", iterations=90, revisions=2),
    "distance weight": Options(iterations=35, revisions=1, loss="udf", xing_weight=0.01),
    "paper": Options.paper(iterations=35),
    "released": Options.released(iterations=35),
    "baseline": Options.diffvg(iterations=20),
    "background": Options(iterations=20, revisions=1, background="train", settle=0.3, decay=0.5),
    "enough": Options(iterations=20, revisions=3, path_gain=1e-4, target_mse=1e-7, opacity="train"),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_resumed_run_ends_as_if_it_had_not_stopped(name: str, device: int, tmp_path: Path) -> None:
    options, picture = RUNS[name], disc_and_ring()
    whole = Run(picture, start(options, seed=5), device)
    rng = np.random.default_rng(len(name))
    num_stages = len(SCHEDULE) + options.revisions
    # In each stage a step anywhere, one where pieces are looked at next, and the last: the stage is still to be closed.
    wanted = {(stage, int(rng.integers(1, options.iterations))) for stage in range(num_stages)}
    wanted |= {(1, 10), (1, 17)}

    def is_wanted(step: Step) -> bool:
        last = step.stage in (0, num_stages - 1) and step.iteration == step.iterations
        return last or (step.stage, step.iteration) in wanted

    saved = _copies_during(whole, tmp_path, is_wanted)
    assert len(saved) >= 4
    expected = format_svg(whole.state.drawing).encode()
    for path in saved:
        resumed = Run(picture, load(path), device)
        train(resumed)
        assert format_svg(resumed.state.drawing).encode() == expected, f"resumed from {path.name}"
        assert_equal(resumed.progress, whole.progress)


@pytest.mark.parametrize("name", ["default", "released"])
def test_a_run_resumed_between_stages(name: str, device: int, tmp_path: Path) -> None:
    options, picture = RUNS[name], disc_and_ring()
    whole = Run(picture, start(options), device)
    paths = []
    while not whole.finished:
        paths.append(tmp_path / f"{whole.state.stage}.state")
        save(whole.progress, paths[-1])
        whole.begin()
        while not whole.trained:
            whole.step()
        whole.end()
    assert len(paths) == len(SCHEDULE) + options.revisions
    for path in paths:
        resumed = Run(picture, load(path), device)
        train(resumed)
        assert_equal(resumed.progress, whole.progress)


def test_stopping_at_every_step_changes_nothing(device: int, tmp_path: Path) -> None:
    options, picture = Options(iterations=6, revisions=1), disc_and_ring()
    whole = Run(picture, start(options), device)
    train(whole)
    progress = start(options)
    for _ in range(100):
        run_ = Run(picture, progress, device)
        train(run_, lambda step: True)
        save(progress, tmp_path / "state")
        progress = load(tmp_path / "state")
        if run_.finished:
            break
    assert_equal(progress, whole.progress)


def test_the_outcome_of_a_resumed_run_goes_on_from_the_stage(device: int, tmp_path: Path) -> None:
    options, picture = Options.paper(iterations=12), disc_and_ring()
    first = Run(picture, start(options), device)
    (outcome,) = train(first, lambda step: step.iteration == 7)
    assert (outcome.iterations, outcome.paths) == (7, 1)
    save(first.progress, tmp_path / "state")
    outcomes = train(Run(picture, load(tmp_path / "state"), device))
    assert [(stage.iterations, stage.paths) for stage in outcomes] == [(5, 1), (12, 3)]
