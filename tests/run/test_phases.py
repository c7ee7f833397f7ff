# SPDX-License-Identifier: Apache-2.0
"""Decisions of a run: what each phase changes, whether it is kept, which phases are left out, and who is told."""

from __future__ import annotations

import itertools
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from support.runs import SMALL, new_run, scripted, three_shapes
from support.shapes import build, circle, rectangle

import livecl
from livecl import Options, Rasterizer, Step, vectorize
from livecl.drawing import Fills
from livecl.image.reading import premultiplied
from livecl.run.loop import train
from livecl.run.phases import Grow, Recolor, Redraw, Refine, Revise, Stroke, Thin, fill, place, plan_of
from livecl.run.progress import Progress
from livecl.run.run import Run
from livecl.views.course import Course

QUICK = Options(placement="region", iterations=1, prune=0.0)


def end_of_phase(run: Run) -> bool:
    assert run.begin()
    return run.end()


def test_the_plan_of_a_schedule() -> None:
    assert plan_of((0, 2, 3), 2) == (Refine(), Grow(2), Grow(3), Revise(0), Revise(1))
    assert [phase.kind for phase in plan_of((0, 1), 1)] == ["refine", "grow", "revise"]
    assert plan_of((2,), 1, "auto", True) == (Stroke(), Redraw(), Grow(2), Thin(), Revise(0), Recolor())
    assert plan_of((2,), 1, "only", True) == (Stroke(), Redraw(), Recolor())


def colors_on_the_way(options: Options, device: int) -> list[tuple[str, str, set[tuple[int, ...]]]]:
    """Kind and name of the stage of each step of a run, and the layers' colours to 8 bits."""
    seen = []

    def look(step: Step) -> None:
        codes = np.rint(step.drawing.colors[:, :3] * 255).astype(int)
        seen.append((step.kind, step.name, {tuple(code) for code in codes.tolist()}))

    vectorize(SMALL, 3, options=options, device=device, on_step=look)
    return seen


@pytest.mark.parametrize("placement", ["region", "structure"])
def test_training_keeps_to_a_palette(placement: Literal["region", "structure"], device: int) -> None:
    options = Options(placement=placement, iterations=4, revisions=1, palette="#123456,#fedcba,#00ff00")
    seen = colors_on_the_way(options, device)
    assert seen and all(codes <= {(0x12, 0x34, 0x56), (0xFE, 0xDC, 0xBA), (0, 255, 0)} for *_, codes in seen)


def test_a_run_is_trained_in_its_few_colours_at_the_end(device: int) -> None:
    seen = colors_on_the_way(Options(placement="region", iterations=4, revisions=1, colors=2), device)
    last = [(name, codes) for kind, name, codes in seen if kind == "recolor"]
    assert len(last) == 4 and seen[-1][0] == "recolor"
    assert {name for name, _ in last} == {"recoloring"}
    assert all(codes == last[0][1] and len(codes) <= 2 for _, codes in last)
    assert max(len(codes) for kind, _, codes in seen if kind == "grow") > 2


def test_few_colours_are_chosen_even_where_the_error_is_low_or_revisions_fail(device: int) -> None:
    for options in ({"target_mse": 1.0}, {"revisions": 8}):
        seen = colors_on_the_way(Options(placement="region", iterations=1, colors=2, **options), device)
        assert seen[-1][0] == "recolor"
        assert [kind for kind, *_ in seen].count("recolor") == 1


@pytest.mark.parametrize(
    ("errors", "reached"),
    [
        ([0.5, 0.3], [1, 2]),
        ([0.5, 0.46], [1, 2]),  # just enough for two paths
        ([0.5, 0.45, 0.42], [1, 2, 4]),  # a fall of .03 is too little for three
        ([0.5, 0.47], [1, 4]),
        ([0.5, 0.6], [1, 4]),
        ([1e9], [1]),  # the first stage is never judged by its gain
        ([0.01], [6]),
        ([0.5, 0.3, 0.01], [1, 2, 6]),
    ],
)
def test_growth_ends_where_paths_gain_too_little_and_all_where_the_error_is_low(
    errors: list[float], reached: list[int], device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = Options(placement="region", iterations=1, path_gain=0.0199, target_mse=0.01, revisions=2)
    run = new_run(options, (1, 2, 3, 1), device)
    scripted(run, errors, monkeypatch)
    stages = []
    for _ in errors:
        assert end_of_phase(run)
        stages.append(run.state.stage)
    assert stages == reached
    assert run.finished == (reached[-1] == 6)
    assert run.progress.schedule == (1, 2, 3, 1), "an input"
    assert run.progress.asked == sum((1, 2, 3, 1)[: len(errors)])


def test_a_refinement_does_not_end_growth(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    start = vectorize(SMALL, 1, options=Options(placement="region", iterations=1, revisions=0), device=device).drawing
    options = Options(placement="region", iterations=1, path_gain=0.5, revisions=1)
    run = Run(SMALL, Progress.start(start, options, (0, 2), 0), device)
    scripted(run, [0.2, 0.3, 0.2], monkeypatch)
    assert not end_of_phase(run), "it was worse than before"
    assert run.state.drawing is start and run.state.stage == 1 and run.progress.failures == 0


@pytest.mark.parametrize("place", [0, 1])
def test_no_path_worth_placing_leaves_out_the_stages_left(place: int, device: int) -> None:
    picture = np.ones((24, 24, 3))
    if place:
        picture[6:18, 4:20] = (0.1, 0.4, 0.8)
    steps: list[Step] = []
    result = vectorize(
        picture,
        schedule=[1, 2, 3],
        options=Options(placement="region", iterations=30, revisions=1, prune=1e-3),
        device=device,
        on_step=steps.append,
    )
    assert {step.name for step in steps if step.kind == "grow"} == {"stage 1/3"}
    assert {step.stage for step in steps if step.kind == "revise"} <= {3} and len(result.stages) == 1


def test_layers_that_may_change_get_gradients(device: int) -> None:
    plain = build([([rectangle(2, 2, 22, 22)], (0.5, 0.5, 0.5, 1))], (24, 24))
    fade = Fills.linear((2, 0), (22, 0), [(0, 0, 0, 1), (1, 1, 1, 1)])
    run = new_run(Options(iterations=1, fills="auto"), (1,), device, livecl.render(plain.replace(fills=fade), device))
    run.state.add(plain, np.arange(1))
    fill(run, np.zeros(1, bool))
    assert not run.state.drawing.fills.any_gradients
    fill(run, np.ones(1, bool))
    assert run.state.drawing.fills.any_gradients
    assert run.state.fills.geometry.mean.shape == (1, 3, 2) and run.state.fills.stops.mean.shape == (2, 5)


def test_a_stage_that_finds_nothing_to_place_is_the_last(device: int) -> None:
    drawing = build([([rectangle(4, 4, 20, 20)], (0.2, 0.4, 0.6, 1))], (24, 24))
    run = new_run(
        Options(placement="region", iterations=1, revisions=1), (1, 2, 3), device, livecl.render(drawing, device)
    )
    run.state.add(drawing, np.arange(1))
    assert not run.begin() and run.revising and not run.finished


def test_training_knows_what_structure_has_not_placed_yet_and_what_it_hides(device: int) -> None:
    # A block over a part of a disc: the block is placed first, and the disc's anchor below it cannot be seen.
    shapes = [([circle((20, 24), 12)], (0.8, 0.1, 0.1, 1)), ([rectangle(23, 6, 45, 42)], (0.1, 0.3, 0.8, 1))]
    image = livecl.render(build(shapes, (48, 48)), device)
    run = new_run(Options(iterations=1, revisions=0, merge=False, opacity="opaque"), (1, 1), device, image)
    assert run.begin()
    weight = run.state.kept_weight
    assert weight is not None and weight[24, 14] == 0 and weight[24, 40] == 1, "the disc is to come"
    run.end()
    assert run.begin()
    assert run.state.kept_weight is not None and run.state.kept_weight.all()
    assert run.state.hidden is not None and len(run.state.hidden) == run.state.drawing.num_segments
    assert run.state.hidden.any() and not run.state.hidden.all()


def test_new_layers_are_labelled_with_their_stage(device: int) -> None:
    start = vectorize(
        SMALL, 1, options=Options(placement="region", iterations=1, revisions=0), device=device
    ).drawing.replace(stages=[4])
    run = Run(
        SMALL,
        Progress.start(start, Options(placement="region", iterations=1, revisions=1, prune=0.0), (0, 1, 1), 0),
        device,
    )
    for _ in range(3):
        end_of_phase(run)
    assert sorted(run.state.drawing.stages) == [4, 5, 6]
    run.begin()
    assert sorted(run.state.drawing.stages)[:2] == [4, 5] and run.state.drawing.stages.max() <= 6, "no stage of its own"


def test_nothing_is_placed_for_what_gradients_show_already(device: int) -> None:
    drawing = build([([rectangle(2, 4, 22, 20)], (0.5, 0.5, 0.5, 1))], (24, 24))
    drawing = drawing.replace(fills=Fills.linear((2, 0), (22, 0), [(0, 0, 0, 1), (1, 1, 1, 1)]))
    options = Options(placement="region", iterations=1, revisions=0)
    run = new_run(options, (1, 1), device, livecl.render(drawing, device))
    run.state.add(drawing, np.arange(1))
    assert place(run, 2, 0) == 0
    run.state.drawing = drawing.replace(fills=None)
    assert place(run, 2, 0) == 2


@pytest.mark.parametrize(("background", "at_once"), [((1, 1, 1), True), (None, False)])
def test_new_layers_get_their_gradients_at_once_over_a_background(
    background: tuple[float, ...] | None, at_once: bool, device: int
) -> None:
    """Over nothing they wait for the first revision: paint adds alpha and cannot take it away."""
    ramp = Fills.linear((2, 0), (22, 0), [(0.8, 0.2, 0.1, 1), (0.6, 0.2, 0.4, 1)])
    drawing = build([([rectangle(2, 4, 22, 20)], (0.7, 0.2, 0.25, 1))], (24, 24)).replace(fills=ramp)
    image = livecl.render(drawing.replace(background=background), device, straight=True)
    run = new_run(Options(placement="region", fills="auto", iterations=1, revisions=1), (1,), device, image)
    assert end_of_phase(run)
    assert run.state.drawing.fills.any_gradients is at_once
    run.begin()
    assert run.revising and run.state.drawing.fills.any_gradients


class Watcher:
    """Notes what it is told."""

    def __init__(self) -> None:
        self.kinds: list[str] = []
        self.ends: list[tuple[str, bool, float]] = []

    def __call__(self, step: Step) -> None:
        self.kinds.append(step.kind)

    def on_stage(self, step: Step, kept: bool) -> None:
        assert step.iteration == step.iterations
        self.ends.append((step.name, kept, step.mse))


def test_callbacks_are_told_what_was_decided(device: int) -> None:
    watcher = Watcher()
    options = Options(placement="region", iterations=15, revisions=8)
    run = new_run(options, (1, 2), device, three_shapes())
    train(run, watcher)
    names, kept, errors = zip(*watcher.ends, strict=True)
    assert names[:3] == ("stage 1/2", "stage 2/2", "revision 1") and kept[:2] == (True, True)
    assert watcher.kinds == ["grow"] * 30 + ["revise"] * 15 * (len(names) - 2)
    assert {True, False} <= set(kept[2:]), "some pay, some do not"
    for (before, after), is_kept in zip(itertools.pairwise(errors[1:]), kept[2:], strict=True):
        assert (after < before) if is_kept else (after == before), "it goes on with the drawing before"


@pytest.mark.parametrize("seed", [0, 5])
def test_films_of_transparent_pictures_show_what_was_kept(seed: int, device: int) -> None:
    rng = np.random.default_rng(seed)
    picture: NDArray[np.float64] = np.kron(rng.uniform(size=(4, 4, 4)), np.ones((8, 8, 1)))
    watcher = Watcher()
    course = Course(1, on_step=watcher)
    options = Options(placement="region", iterations=6, revisions=6)
    vectorize(picture, schedule=(1, 2), options=options, device=device, on_step=course)
    kept = {int(name.split()[1]) + 1 for name, was_kept, _ in watcher.ends[2:] if was_kept}
    assert {frame.stage for frame in course.frames} == {0, 1} | kept
    rasterizer, target = Rasterizer((32, 32), device), premultiplied(picture.astype(np.float32))
    last = course.frames[-1].drawing
    error = float(np.mean(np.square(rasterizer.forward(last).astype(np.float64) - target)))
    assert error == pytest.approx(watcher.ends[-1][2], rel=1e-9)
