# SPDX-License-Identifier: Apache-2.0
"""The outer loop: what it promises of any run, what its numbers mean, and that it reproduces what it is shown."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path
from typing import Any

import drawings
import numpy as np
import pytest
from numpy.typing import NDArray
from reference.distance import distance
from reference.flatten import flatten
from reference.rounding import UNIT, image_tolerance

import livecl
from livecl import Drawing, LiveclError, Options, Rasterizer, State, vectorize, vectorizer
from livecl.background import background_for
from livecl.drawing import empty_drawing
from livecl.image import over_background
from livecl.launcher import Launcher
from livecl.losses import xing_loss
from livecl.objective import DISTANCE_TOLERANCE
from livecl.svg import quantize
from livecl.vectorizer import Step, Vectorizer, run

#: Samples of a pixel along each axis in the pictures drawn here.
SAMPLES = 8


def _three_shapes(side: int = 40, shift: float = 0.0) -> NDArray[np.float64]:
    """Return a disc, a rectangle that overlaps it and an ellipse on it, `shift` px to the left, box-filtered."""
    rows, columns = (np.indices((side * SAMPLES, side * SAMPLES)) + 0.5) * 40 / (side * SAMPLES)
    columns = columns + shift
    picture = np.ones((side * SAMPLES, side * SAMPLES, 3))
    picture[np.hypot(columns - 15, rows - 19) < 12.3] = (0.9, 0.2, 0.1)
    picture[(columns > 20.3) & (columns < 36.6) & (rows > 6.2) & (rows < 20.9)] = (0.1, 0.3, 0.8)
    picture[np.hypot((columns - 12) / 1.4, rows - 27) < 5.2] = (0.2, 0.7, 0.3)
    return picture.reshape(side, SAMPLES, side, SAMPLES, 3).mean(axis=(1, 3))


SMALL = _three_shapes(24)
QUICK = Options.paper(iterations=6)


def _mse(drawing: Drawing, target: NDArray[Any], device: int) -> float:
    image = livecl.render(drawing, device).astype(np.float64)
    return float(np.mean((image - target.astype(np.float32).astype(np.float64)) ** 2))


def _about(mse: float) -> Any:
    """Return what compares as a mean of squared differences, each of which is rounded by a unit in single precision."""
    return pytest.approx(mse, rel=1e-9, abs=2 * UNIT * np.sqrt(mse))


def _new_run(options: Options, schedule: tuple[int, ...], device: int, target: NDArray[Any] = SMALL) -> Vectorizer:
    drawing = empty_drawing(target.shape[:2], background_for(options.background, target))
    return Vectorizer(target, State.start(drawing, options, schedule, 0), device)


@pytest.mark.parametrize(
    ("options", "share"),
    [
        (Options(iterations=100), 1 / 16),
        (Options.paper(iterations=100), 1 / 4),
        (Options.released(iterations=100), 1 / 4),
    ],
    ids=["default", "paper", "released"],
)
def test_three_shapes_are_reproduced(options: Options, share: float, device: int) -> None:
    # An edge that is `d` px off makes an error of d^2 times its contrast squared on each of the pixels along it, so the
    # bound is that of the same picture with all edges off: by a quarter of a pixel where points take steps of 1 px to
    # the end, by a sixteenth where these get shorter. It is measured at an eighth, where the samples allow it.
    target = _three_shapes()
    eighth = np.mean((_three_shapes(shift=1 / 8) - target) ** 2)
    result = vectorize(target, schedule=[1, 1, 1], options=options, device=device)
    assert result.drawing.num_layers == 3
    assert result.mse < eighth * (share * 8) ** 2
    assert [stage.mse for stage in result.stages] == sorted((stage.mse for stage in result.stages), reverse=True)
    # Each layer is one of the shapes.
    for color in [(0.9, 0.2, 0.1), (0.1, 0.3, 0.8), (0.2, 0.7, 0.3)]:
        assert np.abs(result.drawing.colors[:, :3] - color).max(axis=1).min() < 0.15


@pytest.mark.parametrize("name", ["default", "paper", "released", "diffvg"])
def test_the_same_seed_gives_the_same_bytes(name: str, device: int) -> None:
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=12)
    first, second = (vectorize(SMALL, schedule=[1, 2], options=options, device=device, seed=3) for _ in range(2))
    assert first.svg == second.svg
    assert [stage.mse for stage in first.stages] == [stage.mse for stage in second.stages]
    other = vectorize(SMALL, schedule=[1, 2], options=options, device=device, seed=4)
    assert (other.svg == first.svg) == (options.placement != "random" and options.shape != "random")


CHANGES: dict[str, tuple[Options, dict[str, Any]]] = {
    "iterations": (QUICK, {"iterations": 7}),
    "segments": (QUICK, {"segments": 5}),
    "loss": (QUICK, {"loss": "mse"}),
    "xing_weight": (Options.diffvg(iterations=6), {"xing_weight": 1.0}),
    "max_segments": (Options(iterations=2, revisions=0, max_segments=4), {"max_segments": 12}),
    "placement": (QUICK, {"placement": "random"}),
    "placement by regions": (QUICK, {"placement": "region"}),
    "shape": (QUICK, {"shape": "random"}),
    "shape by fit": (QUICK, {"shape": "outline"}),
    "holes": (Options(iterations=2, revisions=0), {"holes": False}),
    "merge": (Options(iterations=2, revisions=0, full_rate_side=0.0), {"merge": False}),
    "settle": (QUICK, {"settle": 0.1}),
    "revisions": (Options(iterations=10, revisions=0), {"revisions": 3}),
    "prune": (Options(iterations=2, revisions=0), {"prune": 0.1}),
    "target_mse": (QUICK, {"target_mse": 0.9}),
    "path_gain": (QUICK, {"path_gain": 0.9}),
    "untangle": (Options.diffvg(iterations=40, learning_rate=2.0), {"untangle": True}),
    "background": (QUICK, {"background": "#8080ff"}),
    "radius": (QUICK, {"radius": 3.0}),
    "tau": (QUICK, {"tau": 4.0}),
    "color_threshold": (QUICK, {"color_threshold": 1.5}),
    "bins": (QUICK, {"bins": 1}),
    "learning_rate": (QUICK, {"learning_rate": 0.5}),
    "color_learning_rate": (QUICK, {"color_learning_rate": 0.05}),
    "full_rate_side": (QUICK, {"full_rate_side": 48.0}),
    "decay": (Options.paper(iterations=30), {"decay": 0.01}),
    "new_color": (QUICK, {"new_color": "random"}),
    "opacity": (Options.paper(iterations=30), {"opacity": "opaque"}),
    "variant": (QUICK, {"variant": "released"}),
}


def _ring() -> NDArray[np.float64]:
    rows, columns = np.indices((24, 24)) + 0.5
    distance = np.hypot(rows - 12, columns - 12)
    return np.where(((distance > 5) & (distance < 9))[..., None], (0.8, 0.2, 0.1), (1.0, 1.0, 1.0))


@pytest.mark.parametrize("name", CHANGES)
def test_every_option_changes_the_result(name: str, device: int) -> None:
    base, changes = CHANGES[name]
    image = _ring() if name in ("holes", "merge") else SMALL
    results = [vectorize(image, 3, [1, 2], dataclasses.replace(base, **c), device).svg for c in ({}, changes)]
    assert results[0] != results[1]


def test_no_option_is_left_out_above() -> None:
    changed = {field for _, changes in CHANGES.values() for field in changes}
    assert changed == {field.name for field in dataclasses.fields(Options)}


@pytest.mark.parametrize("preset", [Options.paper, Options.released])
def test_each_stage_ends_with_the_schedule_s_number_of_paths(preset: Any, device: int) -> None:
    result = vectorize(SMALL, schedule="1,3,2", options=preset(iterations=5, segments=3), device=device)
    assert [stage.paths for stage in result.stages] == [1, 4, 6]
    assert [stage.iterations for stage in result.stages] == [5, 5, 5]
    assert result.drawing.stages.tolist() == [0, 1, 1, 1, 2, 2]
    assert np.array_equal(np.diff(result.drawing.segment_offsets), np.full(6, 3))
    assert vectorize(SMALL, 5, options=QUICK, device=device).drawing.stages.tolist() == [0, 1, 1, 2, 2]
    assert vectorize(SMALL, options=preset(iterations=1), device=device).drawing.num_layers == 8


def test_the_baseline_in_one_stage(device: int) -> None:
    result = vectorize(SMALL, schedule=[6], options=Options.diffvg(iterations=5), device=device)
    assert [stage.paths for stage in result.stages] == [6]


@pytest.mark.parametrize("name", ["default", "paper"])
def test_the_result_holds_what_it_says(name: str, device: int, tmp_path: Path) -> None:
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=15)
    result = vectorize(SMALL, schedule=[1, 2], options=options, device=device)
    for stage in result.stages:
        assert stage.mse == _about(_mse(stage.drawing, SMALL, device))
        assert stage.paths == stage.drawing.num_layers and stage.drawing.size == (24, 24) and stage.seconds > 0
        saved = quantize(stage.drawing)
        assert np.array_equal(saved.points, stage.drawing.points)
        assert np.array_equal(saved.colors, stage.drawing.colors)
    last = result.stages[-1]
    assert result.drawing is last.drawing and result.mse == last.mse
    assert result.seconds == pytest.approx(sum(stage.seconds for stage in result.stages))
    assert result.compile_seconds > 0 and result.options == options
    assert result.device == str(livecl.list_devices()[device])
    assert result._repr_svg_() == result.svg
    result.save_svg(tmp_path / "drawing.svg")
    assert (tmp_path / "drawing.svg").read_text(encoding="utf-8") == result.svg
    read = livecl.read_svg(tmp_path / "drawing.svg")
    assert np.array_equal(read.points, result.drawing.points)
    np.testing.assert_allclose(read.colors, result.drawing.colors, atol=1e-5)


def test_the_callback_gets_the_numbers_of_each_step(device: int) -> None:
    options = Options(iterations=4, revisions=2, prune=0.0)
    steps: list[Step] = []
    errors: list[tuple[float, float]] = []

    def on_step(step: Step) -> None:
        steps.append(step)
        errors.append((step.mse, _mse(step.drawing, SMALL, device)))

    result = vectorize(SMALL, schedule=[1, 2], options=options, device=device, on_step=on_step)
    assert [(s.stage, s.iteration) for s in steps] == [(stage, i) for stage in range(4) for i in (1, 2, 3, 4)]
    assert {(s.num_stages, s.iterations) for s in steps} == {(4, 4)}
    assert [s.paths for s in steps] == [1] * 4 + [3] * 12
    assert all(mse == _about(expected) for mse, expected in errors)
    # Watching does not change the run, nor does asking for the error.
    assert vectorize(SMALL, schedule=[1, 2], options=options, device=device).svg == result.svg


def test_the_loss_told_is_that_before_the_step(device: int) -> None:
    # Without a distance weight it is the mean squared error: of the blank picture at first, with a circle on it.
    options = Options.paper(iterations=5, loss="mse", xing_weight=0.0)
    steps: list[tuple[float, float]] = []
    vectorize(SMALL, 1, options=options, device=device, on_step=lambda step: steps.append((step.loss, step.mse)))
    # The lines of the loop are chosen anew in every tenth step only: their distance from the curve, 0.02 px, may double
    # meanwhile, which on an outline of up to 40 px changes less than 1 px^2 of the 576.
    np.testing.assert_allclose([loss for loss, _ in steps[1:]], [mse for _, mse in steps[:-1]], atol=1 / 576)
    assert len({round(loss, 3) for loss, _ in steps}) > 3


def test_the_callback_may_stop_the_run(device: int) -> None:
    seen: list[tuple[int, int]] = []

    def on_step(step: Step) -> bool:
        seen.append((step.stage, step.iteration))
        return seen[-1] == (1, 2)

    result = vectorize(SMALL, schedule=[1, 2, 3], options=QUICK, device=device, on_step=on_step)
    assert seen == [(0, i) for i in range(1, 7)] + [(1, 1), (1, 2)]
    assert [(stage.iterations, stage.paths) for stage in result.stages] == [(6, 1), (2, 3)]
    assert result.mse == _about(_mse(result.drawing, SMALL, device))
    first = vectorize(SMALL, schedule=[1, 2, 3], options=QUICK, device=device, on_step=lambda step: True)
    assert [(stage.iterations, stage.paths) for stage in first.stages] == [(1, 1)]


def test_an_error_in_the_callback_reaches_the_caller(device: int) -> None:
    def on_step(step: Step) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        vectorize(SMALL, 1, options=QUICK, device=device, on_step=on_step)


IMAGES: list[tuple[Any, str]] = [
    (np.ones((4, 4, 2)), r"^image: shape \(4, 4, 2\), wanted \(H, W, 3\)"),
    (np.ones((4, 4, 5)), r"^image: shape \(4, 4, 5\)"),
    (np.ones(4), r"^image: shape \(4,\)"),
    (np.ones((0, 4, 3)), r"^image: shape \(0, 4, 3\)"),
    (np.full((4, 4, 3), 255, np.int32), r"^image: numbers of type int32, wanted floats"),
    (np.full((4, 4, 3), 1.5), r"^image: all numbers must be finite and within \[0, 1\]"),
    (np.full((4, 4, 3), -1e-3), r"^image: all numbers must be finite"),
    (np.full((4, 4, 3), np.nan), r"^image: all numbers must be finite"),
]


@pytest.mark.parametrize(("image", "message"), IMAGES)
def test_images_that_are_none_are_refused(image: Any, message: str, device: int) -> None:
    with pytest.raises(ValueError, match=message):
        vectorize(image, 1, options=QUICK, device=device)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"paths": 0}, "paths"),
        ({"paths": -3}, "paths"),
        ({"paths": 2.5}, "paths"),
        ({"paths": "all"}, "paths"),
        ({"schedule": "1,x"}, "schedule"),
        ({"schedule": [0]}, "schedule"),
        ({"paths": 3, "schedule": [1, 1]}, "schedule"),
        ({"paths": "auto", "schedule": [1, 1]}, "schedule"),
        ({"seed": -1}, "seed"),
        ({"seed": 0.5}, "seed"),
        ({"seed": True}, "seed"),
    ],
)
def test_arguments_that_cannot_be_used_are_named(arguments: dict[str, Any], name: str, device: int) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: ") as caught:
        vectorize(SMALL, options=QUICK, device=device, **arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("background", ["white", "#204080", "train"])
def test_alpha_is_laid_over_the_background(background: str, device: int) -> None:
    rows, columns = np.indices((20, 26)) + 0.5
    alpha = np.clip(9 - np.hypot(rows - 10, columns - 12), 0, 1)
    image = np.concatenate([np.broadcast_to([0.9, 0.4, 0.1], (20, 26, 3)), alpha[..., None]], axis=2)
    options = Options.paper(iterations=6, background=background)
    result = vectorize(image, 2, options=options, device=device)
    flat = over_background(image, background_for(background, image) or (1, 1, 1))
    assert result.svg == vectorize(flat, 2, options=options, device=device).svg
    assert result.mse == _about(_mse(result.drawing, flat, device))


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


@pytest.mark.parametrize("shape", [(9, 13), (9, 13, 3), (9, 13, 4)])
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_pictures_of_every_kind_are_the_same_picture(shape: tuple[int, ...], dtype: type, device: int) -> None:
    image = np.full(shape, 1.0, dtype)
    image[3:7, 2:9] = 0.25
    if len(shape) == 3 and shape[2] == 4:
        image[..., 3] = 1
    expected = np.ones((9, 13, 3), np.float32)
    expected[3:7, 2:9] = 0.25
    options = Options.paper(iterations=3)
    assert vectorize(image, 1, options=options, device=device).svg == vectorize(expected, 1, options=options).svg


@pytest.mark.parametrize("name", ["default", "paper", "released", "diffvg"])
@pytest.mark.parametrize("size", [(1, 1), (1, 30), (17, 2)])
def test_the_smallest_pictures(name: str, size: tuple[int, int], device: int) -> None:
    image = np.random.default_rng(0).uniform(size=(*size, 3))
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=4)
    result = vectorize(image, 3, options=options, device=device)
    assert result.drawing.size == size and np.isfinite(result.mse) and result.svg.startswith("<svg")


@pytest.mark.parametrize("name", ["default", "paper", "released", "diffvg"])
def test_a_blank_picture(name: str, device: int) -> None:
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=6)
    result = vectorize(np.ones((16, 20, 3)), 2, options=options, device=device)
    assert np.isfinite(result.mse) and result.svg.startswith("<svg")
    if name != "diffvg":
        assert result.mse < 1e-4
    if name == "default":
        assert result.drawing.num_layers == 0 and result.mse == 0


@pytest.mark.parametrize(("side", "full", "step"), [(24, 240, 0.1), (24, 24, 1), (24, 12, 1), (24, 0, 1)])
def test_points_take_smaller_steps_on_a_small_canvas(side: int, full: float, step: float, device: int) -> None:
    vectorizer = _new_run(Options(full_rate_side=full), (2,), device, _three_shapes(side))
    vectorizer.begin()
    before = vectorizer.state.drawing.points
    vectorizer.step()  # Adam's first step is the rate, where there is a gradient
    assert np.abs(vectorizer.state.drawing.points - before).max() == pytest.approx(step, rel=1e-3)


def test_the_number_of_paths_may_be_left_to_the_program(device: int) -> None:
    options = Options(iterations=40, revisions=2)
    paths: list[int] = []
    result = vectorize(
        _three_shapes(), "auto", options=options, device=device, on_step=lambda step: paths.append(step.paths)
    )
    assert 3 <= result.drawing.num_layers <= 12 and result.options.path_gain > 0
    assert len(paths) > 40 * len(result.stages)  # revisions were made, of no more than the stages placed
    assert max(paths) <= 2 ** len(result.stages) - 1
    for layer in range(result.drawing.num_layers):
        without = result.drawing.layer_subset(np.arange(result.drawing.num_layers) != layer)
        assert _mse(without, _three_shapes(), device) - result.mse >= result.options.path_gain - 1e-9


@pytest.mark.parametrize("revisions", [0, 2])
def test_stages_for_which_no_path_is_worth_it_are_left_out(revisions: int, device: int) -> None:
    picture = np.ones((24, 24, 3))
    picture[6:18, 4:20] = (0.1, 0.4, 0.8)
    steps: list[tuple[int, int]] = []
    options = Options(iterations=30, revisions=revisions, prune=1e-3)
    result = vectorize(
        picture,
        schedule=[1, 2, 3],
        options=options,
        device=device,
        on_step=lambda step: steps.append((step.stage, step.paths)),
    )
    assert len(result.stages) == 1 and result.drawing.num_layers == 1
    assert result.mse < 1e-3 and {paths for _, paths in steps} == {1}
    assert {stage for stage, _ in steps} == set(range(1 + revisions))


def test_no_further_stage_where_the_error_is_low_enough(device: int) -> None:
    options = Options(iterations=40, revisions=2)
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


def test_adam_moves_points_by_one_pixel_and_colors_by_a_hundredth(device: int) -> None:
    run_ = _new_run(Options.paper(iterations=10), (2,), device)
    run_.begin()
    before = run_.state.drawing
    run_.step()
    after = run_.state.drawing
    moved, changed = np.abs(after.points - before.points), np.abs(after.colors - before.colors)
    assert moved.max() == pytest.approx(1, abs=1e-3) and changed.max() == pytest.approx(0.01, abs=1e-5)
    assert np.median(moved) == pytest.approx(1, abs=1e-3)  # Adam's first step is the sign of the gradient


def test_moments_of_older_paths_survive_a_new_stage(device: int) -> None:
    run_ = _new_run(Options.paper(iterations=4), (1, 2), device)
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


def _closeness(run_: Vectorizer, layers: NDArray[Any] | None = None) -> NDArray[np.float64]:
    """Return ReLU(tau - d) of some layers or all, (N, H, W), px, from the same lines that the loop measures with."""
    drawing = run_.state.drawing
    share = np.sqrt(run_.rasterizer.tolerance / DISTANCE_TOLERANCE)
    outlines = flatten(drawing, np.ceil(run_.state.pieces * share).astype(np.int32))
    wanted = range(drawing.num_layers) if layers is None else layers
    tau = run_.state.options.tau
    return np.stack([np.maximum(tau - distance(outlines[layer], drawing.size), 0) for layer in wanted])


def _squared_error(run_: Vectorizer, target: NDArray[Any]) -> NDArray[np.float64]:
    image = run_.rasterizer.forward(run_.state.drawing, run_.state.pieces).astype(np.float64)
    return np.square(image - target).sum(axis=-1)


def _pupil() -> NDArray[np.float64]:
    """Return a black disc within a pale one, 24 x 24: of the two the black one holds more error, and it lies on top."""
    away = np.hypot(*(np.indices((24, 24)) - 11.5))
    picture = np.ones((24, 24, 3))
    picture[away < 10], picture[away < 4] = 0.85, 0.0
    return picture


# Sums of 576 pixels' weights and of their weighted errors, in single precision; distances of nearly 0 are off by more,
# but they are few.
LOSS_TOLERANCE = 2 * 576 * UNIT


def test_the_paper_s_loss_is_its_equations_2_and_4(device: int) -> None:
    target = SMALL
    run_ = _new_run(Options.paper(iterations=6, xing_weight=0.5), (1, 2), device)
    for _ in range(2):
        run_.begin()
        for _ in range(6):
            drawing = run_.state.drawing
            closeness = _closeness(run_)
            weight = (closeness / closeness.sum(axis=(1, 2), keepdims=True)).mean(axis=0)
            expected = (weight * _squared_error(run_, target)).sum() / 3 + 0.5 * xing_loss(drawing.cubics)[0]
            assert run_.step() == pytest.approx(expected, rel=LOSS_TOLERANCE)
        run_.end()


def test_the_program_s_loss_is_its_map_of_weights(device: int) -> None:
    # w = (10 - min(|d|, 10)) / 10 of the newest stage's paths together, scaled to a maximum of 1, to which the maps of
    # the stages before are added, as they were at their end; the sum is clipped to [0, 1].
    # A shorter reach than 10 px leaves pixels for the later stages to differ in.
    tau, target = 4.0, _pupil()
    run_ = _new_run(Options.released(iterations=3, xing_weight=0.5, tau=tau), (1, 1, 2), device, target)
    kept = np.zeros((24, 24))
    for stage in range(3):
        run_.begin()
        for step in range(4):
            drawing = run_.state.drawing
            newest = np.flatnonzero(drawing.stages == stage)
            closeness = _closeness(run_, newest).max(axis=0) / tau
            weight = np.minimum(closeness / closeness.max() + kept, 1)
            if step == 3:
                kept = weight
                break
            error = (weight * _squared_error(run_, target)).mean()
            xing = xing_loss(drawing.cubics[np.isin(drawing.segment_layers, newest)])[0]
            assert run_.step() == pytest.approx(error + 0.5 * xing, rel=LOSS_TOLERANCE)
        run_.end()


def test_learning_rates_fall_in_a_stage_and_with_the_age(device: int) -> None:
    # A constant gradient makes Adam's steps as long as its learning rate; that of the background is one nearly, as the
    # path lies off the canvas. Only points and colours of paths follow `settle` and `decay`, so the paths are watched.
    options = Options.paper(iterations=8, settle=0.25, decay=0.5, loss="mse", xing_weight=0.0)
    run_ = _new_run(options, (1,), device)
    run_.begin()
    lengths = []
    for _ in range(8):
        before = run_.state.drawing.colors
        mean, square, ages = (getattr(run_.state.colors, name).copy() for name in ("mean", "square", "ages"))
        run_.step()
        after = run_.state.colors
        corrected = after.mean / (1 - 0.9 ** after.ages[:, None])
        direction = corrected / (np.sqrt(after.square / (1 - 0.999 ** after.ages[:, None])) + 1e-8)
        change = before - run_.state.drawing.colors
        free = (run_.state.drawing.colors > 0) & (run_.state.drawing.colors < 1)
        lengths.append(float(np.median((change / direction)[free])))
        assert after.ages[0] == ages[0] + 1 and mean.shape == square.shape
    progress = np.arange(8) / 8
    settled = np.where(progress < 0.5, 1, 1 - 0.75 * (2 * progress - 1))
    np.testing.assert_allclose(lengths, 0.01 * settled * (1 - 0.5 * np.arange(8) / 500), rtol=1e-6)


def test_a_loss_that_is_not_finite_stops_the_run_and_keeps_the_state(device: int) -> None:
    run_ = _new_run(Options.paper(iterations=5), (1,), device)
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
    options = Options(iterations=10, revisions=5, prune=0.0)
    run_ = _new_run(options, (2, 2), device, _three_shapes())
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
    outcomes = run(_new_run(options, (2, 2), device, _three_shapes()))
    assert len(outcomes) == 2, "revisions count for the last stage"
    assert outcomes[-1].iterations == options.iterations * (len(errors) - 1)


def test_a_run_stopped_in_a_revision_leaves_the_better_drawing(device: int) -> None:
    # After one step, a revision has taken a shape out and has only just put another in its place.
    options, before = Options(iterations=40, prune=0.0), []

    def on_step(step: Step) -> bool:
        before.append(step.mse)
        return step.stage == 3

    result = vectorize(_three_shapes(), schedule=[1, 1, 1], options=options, device=device, on_step=on_step)
    assert len(before) == 121 and before[-1] > before[-2]
    # For the file, colours are rounded by half of 1/255 at most: that much the root of the mean may grow.
    assert np.sqrt(result.mse) <= np.sqrt(before[-2]) + 0.5 / 255


def test_the_program_s_weight_goes_with_paths_on_top_only() -> None:
    for changes in ({"placement": "region"}, {"revisions": 1}):
        with pytest.raises(ValueError, match=r"^variant: "):
            Options.released(**changes)


@pytest.mark.parametrize("name", sorted(set(livecl.options.PRESETS) - {"released"}))
def test_revisions_have_a_loss_to_train_on(name: str, device: int) -> None:
    losses: list[float] = []
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=5, revisions=1)
    vectorize(_three_shapes(), 2, [2], options, device, on_step=lambda step: losses.append(step.loss))
    assert len(losses) == 10 and min(losses) > 0


CASES = ["translucent", "holes", "across the canvas's borders", "tangles", "33x50"]


@pytest.mark.parametrize("name", CASES)
def test_bands_change_nothing_but_the_order_of_sums(name: str, device: int) -> None:
    case = drawings.CASES[name]()
    drawing, pieces = case.drawing, case.pieces
    rng = np.random.default_rng(0)
    channels = 3 if drawing.background is not None else 4
    target, weight = rng.uniform(size=(*drawing.size, channels)), rng.uniform(size=drawing.size)
    whole = Rasterizer(drawing.size, device)
    image = whole.forward(drawing, pieces)
    loss, gradients = whole.loss_and_gradients(drawing, target, weight, pieces)
    closeness = whole.distance_weight(drawing, pieces=pieces)
    num_pixels = drawing.size[0] * drawing.size[1]
    for max_tiles in (1, 11):
        banded = Rasterizer(drawing.size, device, max_tiles=max_tiles)
        assert np.array_equal(banded.forward(drawing, pieces), image)
        banded_loss, banded_gradients = banded.loss_and_gradients(drawing, target, weight, pieces)
        assert banded_loss == pytest.approx(loss, rel=num_pixels * UNIT)
        for found, expected in [
            (banded_gradients.points, gradients.points),
            (banded_gradients.colors, gradients.colors),
            (banded_gradients.background, gradients.background),
        ]:
            if expected is not None:
                np.testing.assert_allclose(found, expected, rtol=0, atol=num_pixels * UNIT * np.abs(expected).max())
        np.testing.assert_allclose(
            banded.distance_weight(drawing, pieces=pieces), closeness, rtol=num_pixels * UNIT, atol=0
        )
        again = banded.backward(np.ones_like(image))
        assert np.isfinite(again.points).all()
    assert np.max(np.abs(image)) <= 1 + image_tolerance(drawing, pieces)


def test_memory_is_bounded_by_the_tiles_of_a_band(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: dict[str, int] = {}
    reserve = Launcher.reserve

    def recording(self: Launcher, name: str, num_bytes: int) -> Any:
        sizes[name] = max(sizes.get(name, 0), num_bytes)
        return reserve(self, name, num_bytes)

    monkeypatch.setattr(Launcher, "reserve", recording)
    covers = [([drawings.rectangle(-1, -1, 200, 200)], (*color, 0.5)) for color in np.eye(3)] * 20
    drawing = drawings.build(covers, (96, 80))
    target, weight = np.zeros((96, 80, 3)), np.ones((96, 80))
    strip = 60 * 10  # tiles of 60 layers in a strip of 80 px
    largest = {}
    for max_tiles in (1, 3 * strip, 1 << 17):
        sizes.clear()
        rasterizer = Rasterizer((96, 80), device, max_tiles=max_tiles)
        rasterizer.distance_weight(drawing)
        rasterizer.loss_and_gradients(drawing, target, weight)
        largest[max_tiles] = {name: sizes[name] for name in ("area", "d_coverage", "closeness")}
    for name in ("area", "d_coverage", "closeness"):
        tile = 8 * 32  # bytes: 8 columns of a strip of 8 rows in single precision
        assert largest[1][name] == strip * tile
        assert largest[3 * strip][name] == 3 * strip * tile
        assert largest[1 << 17][name] == 12 * strip * tile


@pytest.mark.parametrize("options", [Options.paper(iterations=4), Options(iterations=4, revisions=1)])
def test_the_loop_is_the_same_in_bands(options: Options, device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = vectorize(SMALL, schedule=[1, 2], options=options, device=device)
    monkeypatch.setattr(vectorizer, "Rasterizer", functools.partial(Rasterizer, max_tiles=2))
    banded = vectorize(SMALL, schedule=[1, 2], options=options, device=device)
    assert banded.drawing.num_layers == whole.drawing.num_layers
    # Sums of gradients in another order, which a few steps of Adam do not yet make more of.
    np.testing.assert_allclose(banded.drawing.points, whole.drawing.points, atol=0.01)
    np.testing.assert_allclose(banded.drawing.colors, whole.drawing.colors, atol=1.01 / 255)
    assert banded.mse == pytest.approx(whole.mse, rel=0.01)
