# SPDX-License-Identifier: Apache-2.0
"""Runs that are stopped: what they have done so far, and what asks them to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.runs import SMALL

import livecl
from livecl import Control, Options, vectorize
from livecl.interruption import interruptible
from livecl.options import PRESETS
from livecl.run.beginning import Beginning

START = livecl.vectorize(SMALL, 2, options=Options(iterations=5, revisions=0)).drawing


def test_paths_just_placed_that_are_worse_are_not_the_best(device: int) -> None:
    options, errors = Options.diffvg(iterations=150), []

    def on_step(step: Any) -> bool:
        errors.append(step.mse)
        return bool(step.stage == 1)

    whole = vectorize(SMALL, schedule=[2], options=options, device=device)
    result = vectorize(SMALL, schedule=[2, 8], options=options, device=device, on_step=on_step)
    assert errors[-1] > whole.mse, "or this tests nothing"
    assert result.svg == whole.svg and result.mse == whole.mse and result.stopped == "callback"
    assert [stage.iterations for stage in result.stages] == [151]


def test_stopped_before_there_is_a_path(device: int) -> None:
    result = vectorize(SMALL, 2, device=device, control=Control(time_limit=0))
    assert result.stopped == "time limit" and result.drawing.num_layers == 0
    assert [(stage.paths, stage.iterations) for stage in result.stages] == [(0, 0)]
    from_start = vectorize(SMALL, 2, device=device, start=START, control=Control(time_limit=0))
    assert from_start.drawing._repr_svg_() == START._repr_svg_()


@pytest.mark.parametrize(
    "wrong", [{"time_limit": -1}, {"time_limit": float("nan")}, {"period": "often"}, {"resume": True}]
)
def test_wrong_arguments(wrong: dict[str, Any]) -> None:
    (name,) = wrong
    with pytest.raises(ValueError, match=f"^{name}: "):
        Control(**wrong)


def test_all_presets_may_be_stopped(device: int) -> None:
    for name, options in PRESETS.items():
        result = vectorize(SMALL, 2, options=options(), device=device, on_step=lambda step: step.iteration == 3)
        assert result.stopped == "callback" and result.drawing.num_layers, name


def test_stopped_while_the_shapes_of_a_flat_picture_are_found(device: int, tmp_path: Path) -> None:
    image = np.ones((64, 64, 3))
    for number in range(16):
        row, column = 4 + 15 * (number // 4), 4 + 15 * (number % 4)
        image[row : row + 9, column : column + 9] = (0.1, 0.06 * number, 0.5)
    checks: list[None] = []
    with interruptible(lambda: checks.append(None)):
        Beginning(paths=16).progress(image.astype(np.float32))
    assert len(checks) > 16
    image[0, 0] = 0  # another picture, whose shapes are not known yet
    asked: list[None] = []

    def stop() -> str | None:
        asked.append(None)
        return "enough" if len(asked) >= 5 else None

    checkpoint = tmp_path / "run.checkpoint"
    result = vectorize(image, 16, device=device, control=Control(stop=stop, checkpoint=checkpoint))
    assert result.stopped == "enough" and result.drawing.num_layers == 0
    assert not checkpoint.exists()
    assert vectorize(image, 16, options=Options(iterations=2), device=device).drawing.num_layers >= 16
