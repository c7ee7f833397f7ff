# SPDX-License-Identifier: Apache-2.0
"""Outcome of a run: merged and pruned when all is done, never worse than before; and the errors it decides by."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from support.runs import QUICK, SMALL, new_run, started
from support.shapes import build, circle, rectangle

from livecl import Drawing, LiveclError, Options, vectorize
from livecl.drawing import Fills
from livecl.drawing.assembly import empty_drawing
from livecl.run.progress import Progress
from livecl.run.run import Run
from livecl.svg import format_svg, quantize
from livecl.training import step
from livecl.training.state import FREE, KEPT, State


def test_the_outcome_is_pruned_and_merged_when_all_is_done(device: int) -> None:
    run = started([FREE] * 4, device, merge=False)
    run.options = run.state.options = Options(placement="region", iterations=1, prune=1e-4, merge=False, revisions=8)
    assert run.outcome().num_layers == 4
    run.state.stage = len(run.plan)
    assert run.outcome().num_layers == 3
    run.options = run.state.options = Options(
        placement="region", iterations=1, prune=0.0, path_gain=1e-4, merge=False, revisions=8
    )
    assert run.outcome().num_layers == 3, "a path must be worth it wherever it comes from"
    run.state.holds[3] = KEPT
    assert run.outcome().num_layers == 4


def finished(drawing: Drawing, holds: list[int], device: int, background: tuple[float, ...] = (1, 1, 1)) -> Run:
    """Return a run that has come to its end with a drawing of a canvas all in one colour, and merges."""
    options = Options(placement="region", iterations=1, revisions=0, prune=1e-5)
    progress = Progress.start(empty_drawing(drawing.size, background), options, (drawing.num_layers,), 0)
    progress.state.add(drawing, np.arange(drawing.num_layers))
    progress.state.holds, progress.state.stage = np.array(holds, np.int8), 1
    return Run(np.full((*drawing.size, 3), background), progress, device)


def test_what_merging_makes_is_free_and_kept_layers_stay_so(device: int) -> None:
    # Two white halves on white are merged, and of no use; nor is a dot that is all but white, but it is kept.
    halves = [([rectangle(2, 4, 12, 20)], (1, 1, 1, 1)), ([rectangle(12, 4, 22, 20)], (1, 1, 1, 1))]
    dot = ([circle((12, 22), 1)], (0.99, 0.99, 0.99, 1))
    outcome = finished(build([*halves, dot], (24, 24)), [FREE, FREE, KEPT], device).outcome()
    assert outcome.num_layers == 1 and np.allclose(outcome.points[:, 0].mean(axis=0), (12, 22)), "the dot"
    assert finished(build([*halves, dot], (24, 24)), [FREE, FREE, FREE], device).outcome().num_layers == 0


def test_a_finished_run_neither_begins_nor_ends_a_phase(device: int) -> None:
    run = finished(build([([rectangle(2, 4, 12, 20)], (0, 0, 0, 1))], (24, 24)), [FREE], device)
    assert run.finished
    for act in (run.begin, run.end):
        with pytest.raises(ValueError, match="the run is finished"):
            act()
    with pytest.raises(ValueError, match="the phase has no fallback"):
        run.keep_if_better()


@pytest.mark.parametrize(("merge", "left"), [(True, 1), (False, 2)])
def test_neighbours_are_merged_at_the_end(merge: bool, left: int, device: int) -> None:
    drawing = build([([rectangle(x, 4, x + 10, 20)], (0.2, 0.3, 0.4, 1)) for x in (2, 12)], (24, 24))
    run = finished(drawing, [FREE, FREE], device)
    run.target = run.rasterizer.forward(drawing)
    run.options = run.state.options = Options(placement="region", iterations=1, revisions=0, prune=2e-3, merge=merge)
    assert run.outcome().num_layers == left


def test_layers_with_gradients_are_not_merged(device: int) -> None:
    # Both halves fade from white to red; for merging, which knows one colour, they would be one.
    halves = build([([rectangle(2, 4, 12, 20)], (1, 0, 0, 1)), ([rectangle(12, 4, 22, 20)], (1, 0, 0, 1))], (24, 24))
    fade = Fills.linear((0, 4), (0, 20), [(1, 1, 1, 1), (1, 0, 0, 1)])
    drawing = halves.replace(fills=fade.subset([0, 0]))
    run = finished(drawing, [FREE, FREE], device)
    run.target = run.rasterizer.forward(drawing)
    assert run.outcome().num_layers == 2


@pytest.mark.parametrize("part", ["loss", "points", "colors"])
def test_a_step_that_is_not_finite_changes_nothing(part: str, device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    run = started([FREE] * 4, device)
    before = run.state.drawing
    loss, gradients = run.objective.evaluate(run.state)
    if part == "loss":
        loss = np.nan
    else:
        getattr(gradients, part)[0] = np.nan
    monkeypatch.setattr(run.objective, "evaluate", lambda state: (loss, gradients))
    with pytest.raises(LiveclError, match="not finite in stage 3, step 1"):
        run.step()
    assert run.state.drawing is before and run.state.iteration == 0 and not run.state.points.ages.any()


def test_decisions_compare_the_visible_error(device: int) -> None:
    # Without a background, errors of alpha are seen in three channels: the visible error is larger than the mean.
    picture = np.dstack([SMALL, np.linspace(0, 1, 24)[:, None] * np.ones((24, 24))])
    run = new_run(Options(placement="region", iterations=5, revisions=0), (2,), device, picture)
    run.begin()
    between = float(np.sqrt(run.mse(run.state.drawing) * run.visible_mse(run.state.drawing)))
    assert run.mse(run.state.drawing) != pytest.approx(run.visible_mse(run.state.drawing), rel=0.05)
    run.options = run.state.options = Options(placement="region", iterations=5, revisions=0, target_mse=between)
    run.end()
    assert run.progress.error == run.visible_mse(run.state.drawing)


def test_the_outcome_is_never_worse_than_the_drawing_to_start_from(device: int) -> None:
    start = vectorize(SMALL, 2, options=Options(placement="region", iterations=9, revisions=0), device=device).drawing
    run = Run(SMALL, Progress.start(start, QUICK, (0,), 0), device)
    run.state.drawing = start.moved(start.points + 3, start.colors, start.background)
    assert format_svg(run.outcome()) == format_svg(start)


def test_the_outcome_in_a_revision_that_has_not_paid_is_the_drawing_before(device: int) -> None:
    run = started([FREE] * 4, device)
    before = run.state.drawing
    run.begin()
    revised = run.state.drawing
    run.state.drawing = revised.moved(revised.points + 3, revised.colors, revised.background)
    assert format_svg(run.outcome()) == format_svg(quantize(before))


def test_the_outcome_in_a_revision_holds_what_was_held_before_it(device: int) -> None:
    run = started([FREE, FREE, FREE, KEPT], device)
    assert run.begin()
    assert run.progress.fallback is not None
    run.state.holds[:] = FREE  # other layers, in another order
    run.state.drawing = run.state.drawing.moved(
        run.state.drawing.points + 3, run.state.drawing.colors, run.state.drawing.background
    )
    run.options = run.state.options = Options(placement="region", iterations=1, revisions=0, merge=False, prune=1.0)
    run.state.stage = len(run.plan)
    assert run.outcome().num_layers == 1, "the one that is kept, whatever it is worth"


def test_outlines_placed_by_regions_are_cut_to_a_bleed_at_no_cost(device: int) -> None:
    # Bands of a sunset go on far beyond the page, where no pixel holds them.
    picture = Path(__file__).resolve().parents[2] / "examples" / "sunset.png"
    options = Options(placement="region", fills="solid", iterations=60, revisions=1, simplify=False, primitives=False)
    free, cut = (
        vectorize(picture, 8, options=dataclasses.replace(options, trim=trim), device=device) for trim in (False, True)
    )
    beyond = [float(np.maximum(-run.drawing.points, run.drawing.points - 240).max()) for run in (free, cut)]
    assert beyond[0] > 20 and beyond[1] <= 8  # the bleed is 4 px; outlines are cut from twice that on
    assert cut.mse == pytest.approx(free.mse, rel=1e-3)


def test_what_loops_show_is_looked_at_once_a_phase(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[int] = []

    def noted(state: State, error: object = None) -> None:
        if error is not None:
            looks.append(state.iteration)

    monkeypatch.setattr(step, "untangle_outlines", noted)
    run = new_run(Options(placement="region", iterations=80, end_early=False), (1,), device, SMALL)
    run.begin()
    while not run.trained:
        run.step()
    assert looks == []
    run.untangle()
    assert looks == [80]
