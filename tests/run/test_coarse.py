# SPDX-License-Identifier: Apache-2.0
"""Coarse to fine: fewer pixels until the last steps, the picture's own canvas and errors in all that is returned."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from skimage import data
from support.runs import about, mse_of
from support.shapes import build, circle

import livecl.run.coarse
from livecl import Control, Options, vectorize
from livecl.drawing.assembly import empty_drawing, scaled
from livecl.errors import LiveclError
from livecl.run.callbacks import Step
from livecl.run.coarse import LEAST_PIXELS, coarse_size
from livecl.run.loop import Loop
from livecl.run.progress import Progress
from livecl.run.result import RunError
from livecl.views import Course

SIDE = 360
PHOTOGRAPH = np.asarray(data.astronaut()[:SIDE, 40 : 40 + SIDE] / 255)
#: 4000 pixels for each of 15 paths are those of 245 x 245.
FEW, PATHS = Options(placement="region", iterations=3, revisions=0, pixels_per_path=4000), (7, 8)
COARSE = (245, 245)


def planned(schedule: tuple[int, ...] = PATHS, layers: int = 0, **changes: Any) -> Progress:
    shapes = [([circle((9, 9), 5)], (1, 0, 0, 1))] * layers
    drawing = build(shapes, (SIDE, SIDE)) if layers else empty_drawing((SIDE, SIDE))
    return Progress.start(drawing, dataclasses.replace(FEW, **changes), schedule, 0)


@pytest.mark.parametrize(
    ("progress", "size", "wanted"),
    [
        (planned(), (SIDE, SIDE), COARSE),
        (planned(), (2 * SIDE, SIDE // 2), (490, 122)),  # the area counts, and the proportions stay
        (planned(), (2 * SIDE, 2 * SIDE), COARSE),
        (planned((1,)), (SIDE, SIDE), (240, 240)),  # never fewer
        (planned((16,)), (SIDE, SIDE), (253, 253)),
        (planned((17,)), (SIDE, SIDE), (SIDE, SIDE)),  # more than half of the pixels
        (planned((1,)), (339, 339), (339, 339)),
        (planned(pixels_per_path=0), (SIDE, SIDE), (SIDE, SIDE)),
        (planned(layers=1), (SIDE, SIDE), (SIDE, SIDE)),
        (planned(placement="structure"), (SIDE, SIDE), (SIDE, SIDE)),
        (planned(placement="component"), (SIDE, SIDE), (SIDE, SIDE)),
    ],
)
def test_as_many_pixels_as_the_paths_need(progress: Progress, size: tuple[int, int], wanted: tuple[int, int]) -> None:
    assert coarse_size(progress, size) == wanted
    assert np.prod(wanted) > 0.99 * min(np.prod(size), LEAST_PIXELS)


def test_all_that_is_returned_is_on_the_picture_s_canvas(device: int) -> None:
    sizes, course = [], Course()

    def look(step: Step) -> bool | None:
        sizes.append(step.image.shape[:2])
        return course(step)

    result = vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device, on_step=look)
    assert set(sizes) == {COARSE}
    assert len(result.stages) == 2
    assert result.drawing is result.stages[-1].drawing
    for stage in result.stages:
        assert stage.drawing.size == (SIDE, SIDE)
        assert stage.mse == about(mse_of(stage.drawing, PHOTOGRAPH, device))
    assert result.mse == result.stages[-1].mse
    assert result.seconds == pytest.approx(sum(stage.seconds for stage in result.stages))
    assert {drawing.size for drawing in course.drawings(result=result)} == {(SIDE, SIDE)}
    again = vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device)
    assert again.svg == result.svg


def test_the_last_steps_lower_the_error(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    errors = []
    for polish in (livecl.run.coarse.polished, lambda context, drawing, free: drawing):
        monkeypatch.setattr("livecl.run.coarse.polished", polish)
        errors.append(vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device).mse)
    assert errors[0] < 0.99 * errors[1]


def test_steps_that_raise_the_error_are_taken_back(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def worse(context: Any, drawing: Any, free: Any) -> Any:
        return empty_drawing(drawing.size)

    monkeypatch.setattr("livecl.run.coarse.polished", worse)
    result = vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device)
    assert result.drawing.num_layers == sum(PATHS)
    assert result.mse == about(mse_of(result.drawing, PHOTOGRAPH, device))


def test_a_stop_at_the_last_steps_leaves_the_drawing_before_them(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    polish, refining = livecl.run.coarse.polished, []

    def stopping(context: Any, drawing: Any, free: Any) -> Any:
        refining.append(drawing)
        return polish(context, drawing, free)

    monkeypatch.setattr("livecl.run.coarse.polished", stopping)
    control = Control(stop=lambda: "enough" if refining else None)
    result = vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device, control=control)
    assert result.stopped == "enough"
    assert np.array_equal(result.drawing.points, refining[0].points)
    assert result.mse == about(mse_of(result.drawing, PHOTOGRAPH, device))


def test_a_run_that_is_stopped_has_no_last_steps(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def unwanted(*arguments: Any) -> Any:
        raise AssertionError("polished")

    monkeypatch.setattr("livecl.run.coarse.polished", unwanted)
    result = vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device, on_step=lambda step: True)
    assert result.stopped == "callback"
    assert result.drawing.size == (SIDE, SIDE)
    assert result.drawing.num_layers == PATHS[0]
    assert result.mse == about(mse_of(result.drawing, PHOTOGRAPH, device))


def test_a_failed_run_keeps_its_drawing_on_the_picture_s_canvas(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    train = Loop.train

    def failing(loop: Loop) -> None:
        train(loop)
        raise LiveclError("lost")

    monkeypatch.setattr(Loop, "train", failing)
    with pytest.raises(RunError, match="lost") as caught:
        vectorize(PHOTOGRAPH, schedule=PATHS, options=FEW, device=device)
    assert caught.value.result is not None
    assert caught.value.result.drawing.size == (SIDE, SIDE)
    assert caught.value.result.drawing.num_layers == sum(PATHS)


def test_shapes_stay_shapes(device: int) -> None:
    drawing = build([([circle((120, 120), 50)], (1, 0, 0, 1))], (240, 240))
    target = livecl.render(scaled(drawing, (SIDE, SIDE)), device)
    result = vectorize(target, schedule=(1,), options=dataclasses.replace(FEW, iterations=60), device=device)
    assert "<circle" in result.svg
    assert result.mse < 1e-5
