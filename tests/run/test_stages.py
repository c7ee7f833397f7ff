# SPDX-License-Identifier: Apache-2.0
"""The outer loop: stages, revisions, and where it ends."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from support.runs import QUICK, SMALL, new_run, three_shapes

import livecl
from livecl import LiveclError, Options, vectorize
from livecl.run.callbacks import Step
from livecl.run.loop import train


@pytest.mark.parametrize("preset", [Options.paper, Options.released])
def test_each_stage_ends_with_the_schedule_s_number_of_paths(preset: Any, device: int) -> None:
    result = vectorize(SMALL, schedule="1,3,2", options=preset(iterations=5, segments=3), device=device)
    assert [stage.paths for stage in result.stages] == [1, 4, 6]
    assert [stage.iterations for stage in result.stages] == [5, 5, 5]
    assert sorted(result.drawing.stages) == [0, 1, 1, 1, 2, 2]  # in the paint order of the groups
    assert np.array_equal(np.diff(result.drawing.segment_offsets), np.full(6, 3))
    assert sorted(vectorize(SMALL, 5, options=QUICK, device=device).drawing.stages) == [0, 1, 1, 2, 2]
    assert vectorize(SMALL, options=preset(iterations=1), device=device).drawing.num_layers == 8


def test_the_baseline_in_one_stage(device: int) -> None:
    result = vectorize(SMALL, schedule=[6], options=Options.diffvg(iterations=5), device=device)
    assert [stage.paths for stage in result.stages] == [6]


@pytest.mark.parametrize("revisions", [0, 2])
def test_stages_for_which_no_path_is_worth_it_are_left_out(revisions: int, device: int) -> None:
    picture = np.ones((24, 24, 3))
    picture[6:18, 4:20] = (0.1, 0.4, 0.8)
    steps: list[tuple[str, str, int]] = []
    options = Options(placement="region", iterations=30, revisions=revisions, prune=1e-3)
    result = vectorize(
        picture,
        schedule=[1, 2, 3],
        options=options,
        device=device,
        on_step=lambda step: steps.append((step.kind, step.name, step.paths)),
    )
    assert len(result.stages) == 1 and result.drawing.num_layers == 1
    assert result.mse < 1e-3 and {paths for *_, paths in steps} == {1}
    revised = {("revise", f"revision {number + 1}") for number in range(revisions)}
    assert {tuple(names) for *names, _ in steps} == {("grow", "stage 1/3")} | revised


def test_no_further_stage_where_the_error_is_low_enough(device: int) -> None:
    options = Options(placement="region", iterations=40, revisions=2, simplify=False, primitives=False)
    stages = vectorize(SMALL, schedule=[1, 1, 1, 1, 1], options=options, device=device).stages
    enough = np.sqrt(stages[1].mse * stages[2].mse)
    steps: list[int] = []
    result = vectorize(
        SMALL,
        schedule=[1, 1, 1, 1, 1],
        options=dataclasses.replace(options, target_mse=float(enough)),
        device=device,
        on_step=lambda step: steps.append(step.stage),
    )
    assert sorted(set(steps)) == [0, 1, 2] and len(result.stages) == 3
    assert [stage.mse for stage in result.stages] == pytest.approx([stage.mse for stage in stages[:3]], rel=1e-3)


def test_a_loss_that_is_not_finite_stops_the_run_and_keeps_the_state(device: int) -> None:
    run_ = new_run(Options.paper(iterations=5), (1,), device)
    run_.begin()
    run_.step()
    good = run_.state.drawing
    bad = good.moved(good.points, good.colors * np.nan, good.background)
    run_.state.drawing = bad
    moments = run_.state.points.mean.copy()
    with pytest.raises(LiveclError, match=r"^loss or gradient is not finite in stage 1, step 2$"):
        run_.step()
    assert run_.state.drawing is bad and run_.state.iteration == 1
    assert np.array_equal(run_.state.points.mean, moments) and run_.state.points.ages.tolist() == [1] * 4


def test_revisions_lower_the_error_or_leave_the_drawing(device: int) -> None:
    options = Options(placement="region", iterations=10, revisions=5, prune=0.0)
    run_ = new_run(options, (2, 2), device, three_shapes())
    errors = []
    while not run_.finished:
        run_.begin()
        for _ in range(options.iterations):
            run_.step()
        run_.end()
        errors.append(run_.mse(run_.state.drawing))
        assert run_.state.drawing.num_layers == sum((2, 2)[: run_.state.stage])
        assert run_.state.pieces.shape == (run_.state.drawing.num_segments,)
        assert run_.state.points.mean.shape == run_.state.drawing.points.shape
    assert len(errors) > 2 and np.all(np.diff(errors[1:]) <= 0)
    outcomes = train(new_run(options, (2, 2), device, three_shapes()))
    assert len(outcomes) == 2, "revisions count for the last stage"
    assert outcomes[-1].iterations == options.iterations * (len(errors) - 1)


def test_a_run_stopped_in_a_revision_leaves_the_better_drawing(device: int) -> None:
    # After one step, a revision has taken a shape out and has only just put another in its place.
    options, before = Options(placement="region", iterations=30, prune=0.0), []

    def on_step(step: Step) -> bool:
        before.append(step.mse)
        return step.stage == 3

    result = vectorize(three_shapes(), schedule=[1, 1, 1], options=options, device=device, on_step=on_step)
    assert len(before) == 91 and before[-1] > before[-2]
    # For the file, colours are rounded by half of 1/255 at most: that much the root of the mean may grow.
    assert np.sqrt(result.mse) <= np.sqrt(before[-2]) + 0.5 / 255


@pytest.mark.parametrize(
    ("changes", "lengths"),
    [
        ({}, (50, 200)),
        ({"paths": (30, 1)}, (200, 200)),  # each layer decides on more
        ({"iterations": 100}, (30, 100)),
        ({"iterations": 20}, (20, 20)),
        ({"end_early": False}, (200, 200)),
        ({"revisions": 0}, (200, 200)),  # there may be no later stage
        ({"path_gain": 1e-5}, (200, 200)),  # what a stage gains is judged
    ],
)
def test_stages_that_others_follow_are_short(changes: dict[str, Any], lengths: tuple[int, int], device: int) -> None:
    changes = dict(changes)
    paths = changes.pop("paths", (31, 1))
    options = dataclasses.replace(Options(placement="region", prune=0.0), **changes)
    run_, found = new_run(options, paths, device, three_shapes()), []
    for _ in range(2):
        run_.begin()
        found.append(run_.state.length)
        run_.progress.error = 1.0
        run_.end()
    assert tuple(found) == lengths


@pytest.mark.parametrize("name", sorted(set(livecl.options.PRESETS) - {"released"}))
def test_revisions_have_a_loss_to_train_on(name: str, device: int) -> None:
    losses: list[float] = []
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=5, revisions=1)
    if options.placement == "structure":  # which is not revised
        options = dataclasses.replace(options, placement="region")
    vectorize(three_shapes(), 2, [2], options, device, on_step=lambda step: losses.append(step.loss))
    assert len(losses) == 10 and min(losses) > 0
