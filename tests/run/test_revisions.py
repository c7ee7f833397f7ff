# SPDX-License-Identifier: Apache-2.0
"""Revisions: what they merge, take out and place anew, when they are kept, and when they end."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from support.runs import new_run, scripted, started
from support.shapes import build, circle, rectangle

import livecl
from livecl import Drawing, Options
from livecl.drawing import Fills
from livecl.drawing.assembly import empty_drawing
from livecl.layering.revision.pruning import least_useful
from livecl.run.phases import Revise
from livecl.run.progress import Progress
from livecl.run.run import Run
from livecl.training.state import FREE, KEPT, LOCKED

QUICK = Options(placement="region", iterations=1, prune=0.0)


@pytest.mark.parametrize(
    ("gain", "prune", "kept", "failures"),
    [
        (1.01 * Revise.least_gain, 0.0, True, 0),
        (0.99 * Revise.least_gain, 0.0, True, 2),
        (1.01 * Revise.least_gain, 3e-3, True, 2),
        (1.01 * Revise.min_improvement, 0.0, True, 2),
        (0.99 * Revise.min_improvement, 0.0, False, 2),
    ],
)
def test_a_revision_is_kept_if_it_lowers_the_error_by_enough_and_counts_if_that_is_worth_another_one(
    gain: float, prune: float, kept: bool, failures: int, device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    after = 1 - gain
    run = started([FREE] * 4, device)
    run.options = dataclasses.replace(run.options, prune=prune)
    before, run.progress.failures = run.state.drawing, 1
    assert run.begin()
    assert run.progress.fallback is not None and run.progress.fallback.drawing is before
    revised = run.state.drawing
    run.progress.fallback = dataclasses.replace(run.progress.fallback, error=0.1)
    scripted(run, [0.1 * after] * (2 if kept else 1), monkeypatch)
    assert run.end() == kept
    assert run.progress.failures == failures
    assert run.state.drawing is (revised if kept else before)
    assert run.progress.fallback is None and run.state.stage == 3 and not run.progress.placed
    assert len(run.state.pieces) == run.state.drawing.num_segments == len(run.state.points.mean)
    if not kept:
        assert np.array_equal(run.state.pieces, run.rasterizer.pieces(before)), "those of the drawing before"


def test_revisions_end_when_they_fail_too_often_or_have_nothing_to_replace(device: int) -> None:
    run = started([FREE, KEPT, KEPT, KEPT], device)
    assert not run.finished
    for failures in range(Revise.max_failures):
        run.progress.failures = failures
        assert not run.finished
    run.progress.failures = Revise.max_failures
    assert run.finished
    assert started([KEPT, LOCKED, KEPT, KEPT], device).finished
    growing = new_run(QUICK, (1,), device)
    growing.progress.failures = Revise.max_failures
    assert not growing.finished, "there is no layer yet, nor any revision"


@pytest.mark.parametrize("failures", [0, 1])
def test_a_revision_replaces_the_least_useful_layer_and_after_failures_the_next(failures: int, device: int) -> None:
    run = started([FREE] * 4, device, merge=False)
    before = run.state.drawing
    order = least_useful(run, before)
    assert order[0] == 3, "a dot of nearly the background's colour"
    run.progress.failures = failures
    assert run.begin()
    drawing = run.state.drawing
    outlines = [[each.cubics[each.segment_layers == k] for k in range(4)] for each in (before, drawing)]
    kept = [k for k, own in enumerate(outlines[0]) if any(np.array_equal(own, outline) for outline in outlines[1])]
    assert sorted(set(range(4)) - set(kept)) == [order[failures]]
    assert drawing.num_layers == 4, "one is placed for the one taken out"
    assert drawing.stages.max() == 1


@pytest.mark.parametrize("hold", [KEPT, LOCKED])
def test_layers_that_are_held_are_not_replaced(hold: int, device: int) -> None:
    run = started([FREE, FREE, FREE, hold], device, merge=False)
    before = run.state.drawing
    assert run.begin()
    assert any(
        np.array_equal(before.points[before.segment_layers == 3], run.state.drawing.points[own])
        for own in (run.state.drawing.segment_layers == k for k in range(run.state.drawing.num_layers))
    )
    assert sorted(run.state.holds) == sorted([FREE, FREE, FREE, hold])


@pytest.mark.parametrize(("failures", "merges"), [(0, True), (1, False)])
def test_revisions_merge_every_other_time_that_they_fail(
    failures: int, merges: bool, device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[Any] = []

    def merge(*arguments: Any) -> Any:
        calls.append(arguments)
        raise InterruptedError

    monkeypatch.setattr("livecl.run.phases.merge_neighbors", merge)
    run = started([KEPT, FREE, FREE, FREE], device)
    run.progress.failures = failures
    if merges:
        with pytest.raises(InterruptedError):
            run.begin()
        assert calls[0][2].tolist() == [False, True, True, True], "only layers that are free"
    else:
        assert run.begin()
    unmerged = started([FREE] * 4, device, merge=False)
    assert unmerged.begin() and len(calls) == merges


def revising(drawing: Drawing, device: int, **changes: Any) -> Run:
    """Return a run at its first revision, of which the drawing shows the picture as it is."""
    options = Options(placement="region", iterations=1, prune=0.0, **changes)
    progress = Progress.start(empty_drawing(drawing.size), options, (drawing.num_layers,), 0)
    progress.state.add(drawing, np.arange(drawing.num_layers))
    progress.state.stage, progress.asked = 1, drawing.num_layers
    run = Run(livecl.render(drawing, device), progress, device)
    run.state.pieces = run.rasterizer.pieces(drawing)
    return run


def test_the_more_layers_the_more_are_replaced(device: int) -> None:
    dots = [([circle((2 + 4 * (k % 6), 2 + 4 * (k // 6)), 1 + k / 36)], (0, 0, 0, 1)) for k in range(33)]
    run = revising(build(dots, (24, 24)), device)
    assert Revise(0)._replaced(run).tolist() == [0, 1], "one of 16, the smallest"


def test_after_failures_with_all_layers_it_begins_again(device: int) -> None:
    run = started([FREE, FREE, KEPT, KEPT], device)
    order = [layer for layer in least_useful(run, run.state.drawing) if layer < 2]
    replaced = []
    for run.progress.failures in range(4):
        replaced += Revise(0)._replaced(run).tolist()
    assert replaced == 2 * order


@pytest.mark.parametrize(("rise", "merged"), [(0.9, True), (1.1, False)])
def test_a_merge_in_a_revision_may_cost_a_little(
    rise: float, merged: bool, device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Two halves, 40 px each, in colours that differ by as much as their merge may cost, on 576 px; and a large disc.
    differ = np.sqrt(rise * Revise.merging_loss * 576 / 40)
    halves = [([rectangle(x, 1, x + 4, 11)], (0.5 + d, 0.5 + d, 0.5 + d, 1)) for x, d in ((2, 0), (6, differ))]
    run = revising(build([*halves, ([circle((16, 17), 6)], (0, 0, 0, 1))], (24, 24)), device, segments=8)
    monkeypatch.setattr("livecl.run.phases.place", lambda *arguments: 0)
    assert run.begin()
    assert run.state.drawing.num_layers == (1 if merged else 2), "without the least useful of them"


def test_revisions_do_not_merge_gradients(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    halves = build([([rectangle(x, 4, x + 10, 20)], (1, 0, 0, 1)) for x in (2, 12)], (24, 24))
    fade = Fills.linear((0, 4), (0, 20), [(1, 1, 1, 1), (1, 0, 0, 1)])
    run = revising(halves.replace(fills=fade.subset([0, 0])), device)
    monkeypatch.setattr("livecl.run.phases.place", lambda *arguments: 0)
    assert run.begin()
    assert run.state.drawing.fills.any_gradients, "of the one that is left"


@pytest.mark.parametrize(("schedule", "refilled"), [((1, 2, 1), True), ((1, 2, 2), False), ((4,), False)])
def test_layers_are_filled_anew_when_the_last_paths_are_placed_or_else_in_the_first_revision(
    schedule: tuple[int, ...], refilled: bool, device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[bool]] = []
    monkeypatch.setattr("livecl.run.phases.fill", lambda run, layers: asked.append(layers.tolist()))
    run = started([FREE] * 4, device, merge=False)
    run.progress.schedule = schedule
    run.progress.asked = 4
    assert Revise(0).begin(run)
    assert len(asked) == 2 - refilled, "the layer that is placed anew, and all of them"
    assert refilled or asked[-1] == [True] * 4


@pytest.mark.parametrize(("stage", "revisions", "filled"), [(0, 8, 1), (1, 8, 2), (1, 0, 1)])
def test_the_last_stage_fills_those_before_it_anew_where_revisions_follow(
    stage: int, revisions: int, filled: int, device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = build([([rectangle(x, 4, x + 5, 20)], (0, 0, 0, 1)) for x in (2, 14)], (24, 24))
    options = Options(placement="region", iterations=1, prune=0.0, revisions=revisions, end_early=False)
    progress = Progress.start(empty_drawing((24, 24), np.ones(3)), options, (1, 1), 0)
    run = Run(livecl.render(target, device), progress, device)
    asked: list[int] = []
    monkeypatch.setattr("livecl.run.phases.fill", lambda run, layers: asked.append(int(layers.sum())))
    for _ in range(stage + 1):
        assert run.begin()
        run.step()
        run.end()
    assert asked[-1] == filled
