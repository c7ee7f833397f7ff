# SPDX-License-Identifier: Apache-2.0
"""Runs that start from a drawing: they begin at its error, never end above it, and leave locked layers alone."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.states import stopped_and_resumed

import livecl
from livecl import Drawing, Options, vectorize
from livecl.image.errors import mse
from livecl.run.loop import train
from livecl.run.progress import Progress
from livecl.run.run import Run
from livecl.svg import quantize

#: Training alone.
AS_TRAINED: dict[str, Any] = {"simplify": False, "primitives": False}
OPTIONS = Options(iterations=30, revisions=0)


def _shapes(shift: float = 0.0) -> NDArray[np.float32]:
    """Return a disc, a bar across it and a spot, 32 x 36, with soft edges, `shift` px to the right."""
    rows, columns = (np.indices((32 * 4, 36 * 4)) + 0.5) / 4
    columns = columns - shift
    picture = np.ones((32 * 4, 36 * 4, 3))
    picture[np.hypot(rows - 15, columns - 15) < 10] = (0.85, 0.2, 0.1)
    picture[(np.abs(rows - 16) < 3) & (np.abs(columns - 17) < 14)] = (0.1, 0.2, 0.7)
    picture[np.hypot(rows - 24, columns - 27) < 4] = (0.2, 0.7, 0.2)
    return picture.reshape(32, 4, 36, 4, 3).mean(axis=(1, 3)).astype(np.float32)


@pytest.fixture(scope="module")
def drawing(device: int) -> Drawing:
    return vectorize(_shapes(), 3, options=Options(iterations=80, max_segments=4), device=device).drawing


def test_the_first_loss_is_the_drawing_s_error(drawing: Drawing, device: int) -> None:
    losses: list[float] = []
    target = _shapes(1.0)
    vectorize(target, options=OPTIONS, device=device, start=drawing, on_step=lambda step: losses.append(step.loss))
    # The loss is summed in single precision over 3456 numbers of at most 1.
    assert losses[0] == pytest.approx(mse(livecl.render(drawing, device), target), rel=1e-4)
    assert len(losses) == OPTIONS.iterations


def test_a_refined_drawing_has_the_same_layers_and_a_lower_error(drawing: Drawing, device: int) -> None:
    target = _shapes(1.5)
    before = mse(livecl.render(drawing, device), target)
    result = vectorize(target, options=Options(iterations=60, revisions=0), device=device, start=drawing)
    assert result.drawing.num_layers == drawing.num_layers
    np.testing.assert_array_equal(result.drawing.stages, drawing.stages)
    assert result.mse < before / 4  # the shapes can follow: the rest is how well 60 steps settle


@pytest.mark.parametrize("iterations", [1, 2, 5])
def test_the_result_is_never_worse_than_the_start(drawing: Drawing, iterations: int, device: int) -> None:
    # Steps of 3 px from a good drawing first make it worse.
    options = Options(iterations=iterations, revisions=0, learning_rate=3.0, settle=1.0, **AS_TRAINED)
    result = vectorize(_shapes(), options=options, device=device, start=drawing)
    error = mse(livecl.render(drawing, device), _shapes())
    assert result.mse <= error * (1 + 1e-6)  # ours is of differences in single precision
    if iterations == 1:
        np.testing.assert_array_equal(result.drawing.points, drawing.points)


def test_paths_are_added_to_the_start(drawing: Drawing, device: int) -> None:
    target = _shapes()
    target[2:6, 26:34] = (0.9, 0.8, 0.1)
    result = vectorize(target, 1, options=OPTIONS, device=device, start=drawing)
    assert result.drawing.num_layers == drawing.num_layers + 1
    assert result.drawing.stages.max() == drawing.stages.max() + 1
    assert [stage.paths for stage in result.stages] == [drawing.num_layers, drawing.num_layers + 1]


@pytest.mark.parametrize("lock", [[0], [1, 2], [0, 1, 2], np.array([2])])
def test_locked_layers_stay_as_they_are(drawing: Drawing, lock: Any, device: int) -> None:
    # Everything that changes layers is on: loops, snapping of opacities, revisions, pruning, further paths.
    start = quantize(drawing.replace(colors=drawing.colors * (1, 1, 1, 0.95)))
    options = Options(iterations=24, revisions=2, prune=1e-3, xing_weight=0.01)
    result = vectorize(_shapes(2.0), 2, options=options, device=device, start=start, lock=lock)
    kept = start.layer_subset(lock)
    for layer in range(kept.num_layers):
        alone = kept.layer_subset([layer])
        same = [
            np.array_equal(other.points, alone.points) and np.array_equal(other.colors, alone.colors)
            for other in (result.drawing.layer_subset([k]) for k in range(result.drawing.num_layers))
        ]
        assert sum(same) == 1


def test_free_layers_change_where_others_are_locked(drawing: Drawing, device: int) -> None:
    options = dataclasses.replace(OPTIONS, **AS_TRAINED)
    result = vectorize(_shapes(1.5), options=options, device=device, start=drawing, lock=[0])
    moved = (result.drawing.points != drawing.points).any(axis=(1, 2))
    assert set(drawing.segment_layers[moved]) == {1, 2}


def test_a_run_from_a_drawing_is_saved_and_goes_on_equal(drawing: Drawing, tmp_path: Path, device: int) -> None:
    target, options = _shapes(1.0), Options(iterations=12, revisions=1)

    def beginning() -> Progress:
        return Progress.start(drawing, options, (0, 1), 0, np.array([True, False, False]))

    whole = Run(target, beginning(), device)
    expected = train(whole)[-1].drawing
    for stop in ((0, 6), (1, 6), (2, 6)):
        resumed = stopped_and_resumed(target, beginning(), stop, tmp_path / "state", device)
        assert resumed._repr_svg_() == expected._repr_svg_()


def test_an_empty_start_is_none(device: int) -> None:
    empty = livecl.drawing.empty_drawing((32, 36), (1, 1, 0))
    result = vectorize(_shapes(), 2, options=OPTIONS, device=device, start=empty)
    assert result.drawing.num_layers == 2
    np.testing.assert_array_equal(result.drawing.background, (1, 1, 0))
    assert len(result.stages) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lock": [0]}, r"^lock: names layers of a drawing"),
        ({"lock": [7]}, r"^lock: got \[7\], wanted numbers of the 3 layers"),
        ({"lock": [-1]}, r"^lock: got \[-1\], wanted numbers of the 3 layers of start, from 0 on"),
        ({"lock": ["a"]}, r"^lock: got"),
        ({"size": True}, r"^start: a canvas of 30x10 px, wanted the proportions of the picture, 36x32 px"),
        ({"options": Options.released()}, r"^start: variant 'released'"),
    ],
)
def test_what_cannot_be_started_from_is_named(
    drawing: Drawing, arguments: dict[str, Any], message: str, device: int
) -> None:
    start = None if message.startswith("^lock: names layers") else drawing
    if arguments.pop("size", False):
        start = drawing.replace(size=(10, 30))
    with pytest.raises(ValueError, match=message):
        vectorize(_shapes(), device=device, start=start, **arguments)
