# SPDX-License-Identifier: Apache-2.0
"""The one call: what it promises of any run, what its numbers mean, and that it reproduces what it is shown."""

from __future__ import annotations

import dataclasses
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support.runs import QUICK, SMALL, about, mse_of, three_shapes

import livecl
from livecl import Options, vectorize
from livecl.image.background import background_for
from livecl.image.reading import over_background, save_image
from livecl.run.callbacks import Step
from livecl.svg import quantize


@pytest.mark.parametrize(
    ("options", "share"),
    [
        (Options(placement="region", iterations=100), 1 / 16),
        (Options.paper(iterations=100), 1 / 4),
        (Options.released(iterations=100), 1 / 4),
    ],
    ids=["default", "paper", "released"],
)
def test_three_shapes_are_reproduced(options: Options, share: float, device: int) -> None:
    # An edge that is `d` px off makes an error of d^2 times its contrast squared on each of the pixels along it, so the
    # bound is that of the same picture with all edges off: by a quarter of a pixel where points take steps of 1 px to
    # the end, by a sixteenth where these get shorter. It is measured at an eighth, where the samples allow it.
    target = three_shapes()
    eighth = np.mean((three_shapes(shift=1 / 8) - target) ** 2)
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


@pytest.mark.parametrize("name", ["default", "paper"])
def test_the_result_holds_what_it_says(name: str, device: int, tmp_path: Path) -> None:
    options = dataclasses.replace(livecl.options.PRESETS[name](), iterations=15)
    result = vectorize(SMALL, schedule=[1, 2], options=options, device=device)
    for stage in result.stages:
        assert stage.mse == about(mse_of(stage.drawing, SMALL, device))
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
    options = Options(placement="region", iterations=4, revisions=2, prune=0.0)
    steps: list[Step] = []
    errors: list[tuple[float, float]] = []

    def on_step(step: Step) -> None:
        steps.append(step)
        errors.append((step.mse, mse_of(step.drawing, SMALL, device)))

    result = vectorize(SMALL, schedule=[1, 2], options=options, device=device, on_step=on_step)
    assert [(s.stage, s.iteration) for s in steps] == [(stage, i) for stage in range(4) for i in (1, 2, 3, 4)]
    assert {(s.num_stages, s.iterations) for s in steps} == {(4, 4)}
    assert [s.paths for s in steps] == [1] * 4 + [3] * 12
    assert all(mse == about(expected) for mse, expected in errors)
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
    assert result.mse == about(mse_of(result.drawing, SMALL, device))
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
    assert result.mse == about(mse_of(result.drawing, flat, device))


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


def test_the_number_of_paths_may_be_left_to_the_program(device: int) -> None:
    options = Options(placement="region", iterations=40, revisions=2)
    paths: list[int] = []
    result = vectorize(
        three_shapes(), "auto", options=options, device=device, on_step=lambda step: paths.append(step.paths)
    )
    assert 3 <= result.drawing.num_layers <= 12 and result.options.path_gain > 0
    assert len(paths) > 40 * len(result.stages)  # revisions were made, of no more than the stages placed
    assert max(paths) <= 2 ** len(result.stages) - 1
    for layer in range(result.drawing.num_layers):
        without = result.drawing.layer_subset(np.arange(result.drawing.num_layers) != layer)
        assert mse_of(without, three_shapes(), device) - result.mse >= result.options.path_gain - 1e-9


@pytest.mark.parametrize("kind", ["path", "text", "bytes", "file", "stream", "pillow", "array", "list"])
def test_each_kind_of_picture_gives_the_same(kind: str, tmp_path: Path, device: int) -> None:
    path = tmp_path / "picture.png"
    save_image(path, SMALL)
    pixels = livecl.read_image(path)
    options = Options(placement="region", iterations=2, revisions=0)
    with path.open("rb") as file:
        picture: Any = {
            "path": path,
            "text": str(path),
            "bytes": path.read_bytes(),
            "file": file,
            "stream": io.BytesIO(path.read_bytes()),
            "pillow": Image.open(path),
            "array": pixels,
            "list": pixels.tolist(),
        }[kind]
        found = vectorize(picture, 1, options=options, device=device)
    wanted = vectorize(pixels, 1, options=options, device=device)
    assert found.drawing._repr_svg_() == wanted.drawing._repr_svg_()


def test_large_pictures_are_worked_on_small_unless_all_pixels_are_wanted(device: int) -> None:
    large = np.kron(SMALL, np.ones((2, 2, 1)))
    options = Options(placement="region", iterations=2, revisions=0)
    small = vectorize(large, 1, options=options, device=device, size=24)
    assert small.working_size == (24, 24) and small.drawing.size == (48, 48)
    assert vectorize(large, 1, options=options, device=device).working_size == (48, 48)
    assert vectorize(large, 1, options=options, device=device, size=0).working_size == (48, 48)


def test_the_run_asks_whether_to_stop_between_any_two_pieces_of_work(device: int) -> None:
    """Warm-up and placement ask as well: a run that is to stop at the first question has placed nothing."""
    asked = []

    def stop() -> str:
        asked.append(None)
        return "enough"

    result = vectorize(SMALL, 4, device=device, control=livecl.Control(stop=stop))
    assert result.stopped == "enough" and result.drawing.num_layers == 0
    assert 1 <= len(asked) <= 2, "by the loop, which ends the run; in the search for structure, if that takes a moment"
    asked.clear()
    vectorize(
        SMALL,
        4,
        options=Options(placement="region", iterations=1, revisions=0),
        device=device,
        control=livecl.Control(stop=lambda: asked.append(None)),
    )
    steps = 3  # one for each of the stages 1, 2, 1
    assert len(asked) > 20 * steps


@pytest.mark.parametrize(
    ("keyword", "hint"),
    [
        ("path", "did you mean 'paths'"),
        ("iterations", r"options=Options\(iterations=...\)"),
        ("iteration", r"did you mean options=Options\(iterations=...\)"),
        ("xyzzy", "wanted one of image, paths"),
    ],
)
def test_unknown_keywords_get_a_hint(keyword: str, hint: str) -> None:
    with pytest.raises(TypeError, match=f"vectorize: there is no parameter '{keyword}'; .*{hint}"):
        vectorize(SMALL, **{keyword: 3})


def test_a_result_prints_as_three_lines(device: int) -> None:
    result = vectorize(SMALL, 1, options=Options(placement="region", iterations=1, revisions=0), device=device)
    drawing, error, time = str(result).splitlines()
    assert drawing == f"drawing of 1 layers, {result.drawing.num_segments} segments, 24 x 24 px"
    assert error == f"MSE {result.mse:.3g}" and time.endswith(result.device)
