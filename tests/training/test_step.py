# SPDX-License-Identifier: Apache-2.0
"""Single steps of training: how far points and colours move, and what older paths keep."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray
from support.runs import SMALL, new_run, three_shapes
from support.shapes import build, polygon, rectangle

from livecl import Gradients, Options, render, vectorize
from livecl.drawing import Fills
from livecl.rendering.fills import FillGradients
from livecl.run.callbacks import Step
from livecl.training.state import State
from livecl.training.step import choose_pieces, hold_still, move, untangle_outlines, untangles_now


def test_only_a_trained_background_changes(device: int) -> None:
    # By 0.01 a step towards the picture's, which is darker in one channel only; nothing else pulls so early.
    target = SMALL * np.array([0.5, 1.0, 1.0])
    target[:, :, 1:] = 1.0
    options = Options.paper(iterations=4, loss="mse")
    for background, color in [("white", (1, 1, 1)), ("#ff8000", (1, 128 / 255, 0))]:
        fixed = vectorize(target, 1, options=dataclasses.replace(options, background=background), device=device)
        np.testing.assert_allclose(fixed.drawing.background, color, atol=1e-12)
    trained = vectorize(target, 1, options=dataclasses.replace(options, background="train"), device=device)
    np.testing.assert_allclose(trained.drawing.background, (0.96, 1, 1), atol=0.5 / 255 + 0.002)


@pytest.mark.parametrize(("side", "full", "step"), [(24, 240, 0.1), (24, 24, 1), (24, 12, 1), (24, 0, 1)])
def test_points_take_smaller_steps_on_a_small_canvas(side: int, full: float, step: float, device: int) -> None:
    vectorizer = new_run(Options(full_rate_side=full), (2,), device, three_shapes(side))
    vectorizer.begin()
    before = vectorizer.state.drawing.points
    vectorizer.step()  # Adam's first step is the rate, where there is a gradient
    assert np.abs(vectorizer.state.drawing.points - before).max() == pytest.approx(step, rel=1e-3)


def test_adam_moves_points_by_one_pixel_and_colors_by_a_hundredth(device: int) -> None:
    run_ = new_run(Options.paper(iterations=10), (2,), device)
    run_.begin()
    before = run_.state.drawing
    run_.step()
    after = run_.state.drawing
    moved, changed = np.abs(after.points - before.points), np.abs(after.colors - before.colors)
    assert moved.max() == pytest.approx(1, abs=1e-3) and changed.max() == pytest.approx(0.01, abs=1e-5)
    assert np.median(moved) == pytest.approx(1, abs=1e-3)  # Adam's first step is the sign of the gradient


def test_moments_of_older_paths_survive_a_new_stage(device: int) -> None:
    run_ = new_run(Options.paper(iterations=4), (1, 2), device)
    run_.begin()
    for _ in range(4):
        run_.step()
    run_.end()
    mean, square = run_.state.points.mean.copy(), run_.state.points.square.copy()
    assert np.abs(mean).max() > 0
    run_.begin()
    state = run_.state
    assert np.array_equal(state.points.mean[:4], mean) and np.array_equal(state.points.square[:4], square)
    assert not state.points.mean[4:].any() and not state.points.square[4:].any()
    assert state.points.ages.tolist() == [4] * 4 + [0] * 8 and state.colors.ages.tolist() == [4, 0, 0]
    run_.step()
    assert state.points.ages.tolist() == [5] * 4 + [1] * 8


def test_colors_stay_within_their_range(device: int) -> None:
    options = Options.diffvg(iterations=40, color_learning_rate=0.3, background="train")

    def on_step(step: Step) -> None:
        assert step.drawing.colors.min() >= 0 and step.drawing.colors.max() <= 1

    result = vectorize(SMALL, schedule=[4], options=options, device=device, on_step=on_step)
    assert result.drawing.colors.min() == 0 or result.drawing.colors.max() == 1


@pytest.mark.parametrize("opacity", ["snap", "train", "opaque"])
def test_opacities(opacity: str, device: int) -> None:
    options = Options.paper(iterations=30, opacity=opacity)
    seen = []
    vectorize(SMALL, 3, options=options, device=device, on_step=lambda step: seen.append(step.drawing.colors[:, 3]))
    last, all_of_them = seen[-1], np.concatenate(seen)
    assert np.all((all_of_them >= 0) & (all_of_them <= 1))
    if opacity == "opaque":
        assert np.all(all_of_them == 1)
    else:
        assert all_of_them.min() < 1
        assert opacity != "snap" or not np.any((last > 0.9) & (last < 1))


def test_learning_rates_fall_in_a_stage_and_with_the_age() -> None:
    # A constant gradient makes Adam's steps as long as its learning rate, whatever the gradient's size.
    options = Options.paper(iterations=8, settle=0.25, decay=0.5, learning_rate=2.0, color_learning_rate=0.01)
    drawing = build([([rectangle(3, 4, 9, 11)], (0.5, 0.5, 0.5, 0.5))], (24, 24))
    state = State.start(drawing, options, 0)
    gradients = Gradients(points=np.full((4, 3, 2), 7.0), colors=np.full((1, 4), -0.3), background=None)
    progress = np.arange(8) / 8
    settled = np.where(progress < 0.5, 1, 1 - 0.75 * (2 * progress - 1))
    for state.iteration, share in enumerate(settled * (1 - 0.5 * np.arange(8) / 500)):
        before = state.drawing
        move(state, gradients)
        np.testing.assert_allclose(before.points - state.drawing.points, 2.0 * share, rtol=1e-6)
        np.testing.assert_allclose(state.drawing.colors - before.colors, 0.01 * share, rtol=1e-6)


def _two_fades(options: Options) -> State:
    """Return a state of two gradient layers, the first of which is locked."""
    drawing = build([([rectangle(x, 4, x + 8, 20)], (1, 0, 0, 1)) for x in (2, 12)], (24, 24))
    fade = Fills.linear((0, 4), (0, 20), [(1, 1, 1, 0.95), (1, 0, 0, 0.5)])
    return State.start(drawing.replace(fills=fade.subset([0, 0])), options, 0, np.array([True, False]))


def _ones(state: State) -> Gradients:
    """Return a gradient of 1 in all that a state trains."""
    drawing = state.drawing
    fills = FillGradients(
        np.ones(drawing.fills.geometry.shape),
        np.ones(drawing.fills.stop_positions.shape),
        np.ones(drawing.fills.stop_colors.shape),
    )
    return Gradients(np.ones(drawing.points.shape), np.ones(drawing.colors.shape), None, fills)


def test_locked_layers_and_hidden_points_get_no_gradient() -> None:
    state = _two_fades(Options())
    state.hidden = np.zeros((8, 3), bool)
    state.hidden[6, 1] = True
    gradients = _ones(state)
    hold_still(state, gradients)
    assert not gradients.points[:4].any() and not gradients.points[6, 1].any()
    assert np.count_nonzero(gradients.points[4:] == 1) == 2 * 11
    assert gradients.colors.tolist() == [[0] * 4, [1] * 4]
    assert gradients.fills is not None
    assert not gradients.fills.geometry[0].any() and gradients.fills.geometry[1].all()
    assert gradients.fills.stop_positions.tolist() == [0, 0, 1, 1]
    assert gradients.fills.stop_colors.tolist() == [[0] * 4] * 2 + [[1] * 4] * 2


def test_colors_of_a_palette_stay_and_opacities_do_not() -> None:
    state = _two_fades(Options())
    state.keeps_colors = True
    gradients = dataclasses.replace(_ones(state), widths=np.ones(2))
    hold_still(state, gradients)
    assert gradients.colors.tolist() == [[0] * 4, [0, 0, 0, 1]]
    assert gradients.widths is not None and gradients.widths.tolist() == [0, 1]


@pytest.mark.parametrize(("placement", "straight"), [("structure", True), ("region", False)])
def test_lines_of_structure_stay_lines_and_steps_go_by_the_longer_side(placement: str, straight: bool) -> None:
    drawing = build([([rectangle(3, 4, 9, 11)], (1, 0, 0, 1))], (24, 48))
    state = State.start(drawing, Options(placement=placement, full_rate_side=96), 0)  # type: ignore[arg-type]
    gradients = dataclasses.replace(_ones(state), fills=None)
    gradients.points[:, 1] *= -1
    gradients.points[:, 0] *= 2
    move(state, gradients)
    points = state.drawing.points
    np.testing.assert_allclose(drawing.points[:, 0] - points[:, 0], 0.5, rtol=1e-6)
    thirds = points[:, 0] + (np.roll(points[:, 0], -1, axis=0) - points[:, 0]) / 3
    assert np.allclose(points[:, 1], thirds, atol=1e-9) == straight


@pytest.mark.parametrize(
    ("opacity", "iteration", "alphas"),
    [("opaque", 9, [0.95, 0.5, 0.95, 0.5]), ("snap", 9, [0.94, 0.49, 1, 0.49]), ("snap", 1, [0.94, 0.49, 0.94, 0.49])],
)
def test_opacities_of_stops_are_held_like_those_of_layers(opacity: str, iteration: int, alphas: list[float]) -> None:
    # Adam's first step is the rate, 0.01; locked layers are not held still here: another function does that.
    state = _two_fades(Options(opacity=opacity, iterations=10, settle=1.0))
    state.iteration = iteration
    move(state, _ones(state))
    np.testing.assert_allclose(state.drawing.fills.stop_colors[:, 3], alphas, atol=1e-6)


def test_nearly_opaque_layers_become_opaque_but_locked_ones_do_not() -> None:
    drawing = build([([rectangle(x, 4, x + 8, 20)], (1, 0, 0, 0.95)) for x in (2, 12)], (24, 24))
    state = State.start(drawing, Options(opacity="snap", iterations=10), 0, np.array([True, False]))
    state.iteration = 9
    gradients = dataclasses.replace(_ones(state), fills=None)
    hold_still(state, gradients)
    move(state, gradients)
    assert state.drawing.colors[:, 3].tolist() == [0.95, 1.0]
    assert np.array_equal(state.drawing.points[:4], drawing.points[:4])


def test_lines_of_segments_are_counted_anew_where_too_few_or_four_times_too_many() -> None:
    class Needs:
        def pieces(self, drawing: object) -> NDArray[np.int32]:
            return np.array([2, 4, 8, 16], np.int32)

    state = State.start(build([([rectangle(3, 4, 9, 11)], (1, 0, 0, 1))], (24, 24)), Options(), 0)
    for held, chosen in (
        ([2, 4, 8, 16], [2, 4, 8, 16]),
        ([4, 8, 16, 32], [4, 8, 16, 32]),  # twice as many as needed are kept
        ([2, 4, 7, 16], [2, 4, 8, 16]),
        ([2, 4, 17, 16], [2, 4, 8, 16]),
    ):
        state.pieces = np.array(held, np.int32)
        choose_pieces(state, Needs())  # type: ignore[arg-type]
        assert state.pieces.tolist() == chosen


def test_loops_are_left_in_locked_layers() -> None:
    eight = polygon([(2, 2), (10, 10), (10, 2), (2, 12)])
    drawing = build([([np.add(eight, (x, 0))], (1, 0, 0, 1)) for x in (0, 12)], (24, 24))
    state = State.start(drawing, Options(), 0, np.array([True, False]))
    untangle_outlines(state, lambda drawing: 0.0)
    assert np.array_equal(state.drawing.points[:4], drawing.points[:4])
    assert not np.array_equal(state.drawing.points[4:], drawing.points[4:])


def test_a_loop_is_kept_where_it_shows_something(device: int) -> None:
    # Two lobes on either side of a crossing, the upper one larger; the picture shows both, or the upper one alone.
    eight = polygon([(2, 4), (14, 4), (4, 20), (12, 20)])
    upper = polygon([(2, 4), (14, 4), (8, 13.6)])
    for shape, kept in ((eight, True), (upper, False)):
        wanted, drawing = (build([([path], (1, 0, 0, 1))], (24, 24)) for path in (shape, eight))
        state = State.start(drawing, Options(), 0)
        untangle_outlines(state, new_run(Options(), (1,), device, render(wanted, device)).visible_mse)
        assert np.array_equal(state.drawing.points, drawing.points) == kept


def test_only_small_loops_are_cut_without_a_look_at_what_they_show() -> None:
    # Two lobes on either side of a crossing, the lower one of 35, 4 and 2 px^2.
    shapes = [polygon([(2, 4), (14, 4), (8 - half, 20), (8 + half, 20)]) for half in (4, 1.35, 0.9)]
    drawing = build([([shape], (1, 0, 0, 1)) for shape in shapes], (24, 30))
    state = State.start(drawing, Options(), 0)
    untangle_outlines(state)
    moved = (state.drawing.points != drawing.points).any(axis=(1, 2))
    assert not moved[:8].any() and moved[8:].any()


def test_loops_are_looked_for_every_25_steps_of_the_second_half_and_at_its_end() -> None:
    state = State.start(build([([rectangle(3, 4, 9, 11)], (1, 0, 0, 1))], (24, 24)), Options(iterations=110), 0)
    looked = [state.iteration for state.iteration in range(1, 111) if untangles_now(state)]
    assert looked == [75, 100, 110]


def test_strokes_stay_as_wide_as_a_tenth_of_a_pixel_and_fills_stay_fills() -> None:
    drawing = build([([rectangle(x, 4, x + 8, 20)], (1, 0, 0, 1)) for x in (2, 12)], (24, 24))
    state = State.start(drawing.replace(strokes=drawing.strokes.with_widths([0.15, 0.0])), Options(), 0)
    gradients = dataclasses.replace(_ones(state), fills=None, widths=np.ones(2))
    for _ in range(3):
        move(state, gradients)
    assert state.drawing.strokes.widths.tolist() == [0.1, 0.0]


def test_adam_starts_anew_for_segments_that_lost_a_loop() -> None:
    shapes = [polygon([(2, 2), (10, 10), (10, 2), (2, 12)]), rectangle(14, 2, 20, 10)]
    state = State.start(build([([shape], (1, 0, 0, 1)) for shape in shapes], (24, 24)), Options(), 0)
    state.points.mean[:], state.points.square[:], state.points.ages[:] = 1, 1, 7
    before = state.drawing.points
    untangle_outlines(state, lambda drawing: 0.0)
    moved = (state.drawing.points != before).any(axis=(1, 2))
    assert moved[:4].any() and not moved[4:].any()
    assert np.array_equal(state.points.ages, np.where(moved, 0, 7))
    assert np.array_equal(state.points.mean[:, 0, 0], np.where(moved, 0, 1))
