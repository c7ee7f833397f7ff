# SPDX-License-Identifier: Apache-2.0
"""Sequences: layers that keep their identity, errors and times beside those of independent runs."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from support.drawings import BLUE, GREEN, RED, build, rectangle
from support.shapes import alone, circle

import livecl
from livecl.drawing.canvas import layer_boxes
from livecl.interpolation.blending import correspond
from livecl.options import Options
from livecl.run.sequences import vectorize_sequence

SIZE = (48, 64)
OPTIONS = Options(placement="region", iterations=150, revisions=1)


def frame(t: float, device: int, *, dot: bool = False) -> NDArray[np.float32]:
    """Return a picture of three things, and maybe a dark fourth one.

    While t goes from 0 to 1, a green rectangle shrinks, a red disc grows and moves by 24 px, a blue one shrinks: the
    largest is another one at the end.
    """
    layers = [
        ([rectangle(6, 26, 26 - 12 * t, 44 - 8 * t)], GREEN),
        ([circle((14 + 24 * t, 13), 6 + 4 * t)], RED),
        ([circle((50, 34), 9 - 4 * t)], BLUE),
    ]
    if dot:
        layers.append(([rectangle(54, 4, 62, 12)], (0.1, 0.1, 0.1, 1.0)))
    image: NDArray[np.float32] = livecl.render(build(layers, SIZE), device=device)
    return np.clip(image, 0, 1)


def movement(a: livecl.Drawing, b: livecl.Drawing) -> float:
    return float(np.linalg.norm(b.points - a.points, axis=-1).mean())


def test_layers_keep_their_identity(device: int) -> None:
    frames = [frame(t, device) for t in np.linspace(0, 1, 5)]
    result = vectorize_sequence(frames, paths=3, options=OPTIONS, device=device)
    assert len(result.drawings) == len(result.mse) == len(result.seconds) == 5
    colors = [drawing.colors[:, :3] for drawing in result.drawings]
    for drawing, own in zip(result.drawings, colors, strict=True):
        np.testing.assert_array_equal(drawing.subpath_offsets, result.drawings[0].subpath_offsets)
        # The things differ by 0.6 in a channel at least, and keep their colours, so the layers do.
        np.testing.assert_allclose(own, colors[0], atol=0.05)
    # Each layer follows its thing: the red disc's middle moves by 24 px in four steps. Where edges fit to a tenth of a
    # pixel (that is what the errors below say), so does the middle of what the layer covers.
    assert max(result.mse) < 1e-4
    red = int(np.argmin(np.abs(colors[0] - RED[:3]).sum(axis=1)))
    covers = [livecl.render(alone(drawing, red), device=device)[..., 0] for drawing in result.drawings]
    middles = [np.sum(cover * (np.arange(SIZE[1]) + 0.5)) / np.sum(cover) for cover in covers]
    np.testing.assert_allclose(np.diff(middles), 6, atol=0.2)


def test_neighbouring_frames_correspond(device: int) -> None:
    frames = [frame(t, device) for t in np.linspace(0, 1, 5)]
    result = vectorize_sequence(frames, paths=3, options=OPTIONS, device=device)
    runs = [livecl.vectorize(image, paths=3, options=OPTIONS, device=device) for image in frames]
    together = [movement(a, b) for a, b in itertools.pairwise(result.drawings)]
    apart = [movement(*correspond(a.drawing, b.drawing)) for a, b in itertools.pairwise(runs)]
    # Nothing moves by more than 6 px from frame to frame, but another thing becomes the first: runs of their own jump.
    assert max(together) < max(apart) / 3
    assert np.mean(together) < np.mean(apart)
    assert max(result.mse) < 1e-4


def test_a_picture_takes_twice_the_steps_of_a_stage_at_most(device: int) -> None:
    steps: list[int] = []
    frames = [frame(t, device) for t in (0, 0.1)]
    vectorize_sequence(
        frames,
        paths=3,
        options=dataclasses.replace(OPTIONS, end_early=False),
        add_paths=0,
        device=device,
        on_frame=lambda index, result: steps.append(sum(stage.iterations for stage in result.stages)),
    )
    assert steps[0] > steps[1] == 2 * OPTIONS.iterations


def test_paths_are_added_and_padded(device: int) -> None:
    frames = [frame(0, device), frame(0.2, device), frame(0.4, device, dot=True), frame(0.6, device, dot=True)]
    result = vectorize_sequence(frames, paths=3, options=OPTIONS, device=device)
    counts = [drawing.num_layers for drawing in result.drawings]
    assert counts == [counts[0]] * 4
    dark = int(np.argmin(result.drawings[-1].colors[:, :3].sum(axis=1)))
    sides = [np.ptp(layer_boxes(drawing)[dark].reshape(2, 2), axis=0) for drawing in result.drawings]
    np.testing.assert_array_equal(sides[:2], 0)
    covers = [livecl.render(alone(drawing, dark), device=device)[..., 0].sum() for drawing in result.drawings]
    np.testing.assert_allclose(covers, [0, 0, 64, 64], atol=3.2)  # edges 32 px long, right to within a tenth of a pixel
    x, y = layer_boxes(result.drawings[0])[dark][:2]
    assert 54 < x < 62
    assert 4 < y < 12
    assert result.mse[2] < 1e-3
    rendered = livecl.render(result.drawings[1], device=device)
    # The points that stand for the layer to come are not seen: the error is that of the run without them.
    assert np.mean(np.square(rendered - frames[1])) == pytest.approx(result.mse[1], rel=1e-3)


def test_without_paths_added(device: int) -> None:
    frames = [frame(0, device), frame(0.2, device, dot=True)]
    result = vectorize_sequence(frames, paths=3, options=OPTIONS, add_paths=0, device=device)
    assert result.drawings[0].num_layers == result.drawings[1].num_layers == 3
    assert result.mse[1] > 1e-2  # the dot is a fiftieth of the picture


def test_first_is_the_run_alone(device: int) -> None:
    image = frame(0, device)
    result = vectorize_sequence([image], paths=3, options=OPTIONS, device=device, seed=5)
    run = livecl.vectorize(image, paths=3, options=OPTIONS, device=device, seed=5)
    np.testing.assert_array_equal(result.drawings[0].points, run.drawing.points)
    assert result.mse == (run.mse,)


def test_same_bytes(device: int) -> None:
    frames = [frame(0, device), frame(0.3, device)]
    first, second = (vectorize_sequence(frames, paths=3, options=OPTIONS, device=device) for _ in range(2))
    for a, b in zip(first.drawings, second.drawings, strict=True):
        np.testing.assert_array_equal(a.points, b.points)


def test_transparent_pictures(device: int) -> None:
    def glass(t: float) -> NDArray[np.float32]:
        image = np.zeros((*SIZE, 4), np.float32)
        image[10:30, 10 + round(10 * t) : 40] = (0.8, 0.2, 0.1, 1)
        return image

    result = vectorize_sequence([glass(0), glass(1)], paths=1, options=OPTIONS, device=device)
    assert [drawing.background for drawing in result.drawings] == [None, None]
    # An opaque picture among them is still drawn over nothing.
    solid = np.ones((*SIZE, 3), np.float32)
    result = vectorize_sequence([glass(0), solid], paths=1, options=OPTIONS, device=device)
    assert result.drawings[1].background is None


def test_refine_iterations(device: int) -> None:
    calls = []
    vectorize_sequence(
        [frame(0, device), frame(0.1, device), frame(0.2, device)],
        paths=3,
        options=OPTIONS,
        refine_iterations=7,
        add_paths=0,
        device=device,
        on_frame=lambda index, result: calls.append((index, sum(stage.iterations for stage in result.stages))),
    )
    assert calls[1:] == [(1, 7), (2, 7)]


def test_stops_where_told(device: int) -> None:
    frames = (frame(t, device) for t in (0, 0.1, 0.2))
    result = vectorize_sequence(frames, paths=3, options=OPTIONS, device=device, on_frame=lambda index, _: index == 1)
    assert len(result.drawings) == 2


def test_starts_from_a_drawing(device: int) -> None:
    start = build([([circle((14, 14), 7)], RED)], SIZE)
    result = vectorize_sequence([frame(0, device)], start=start, options=OPTIONS, device=device)
    assert result.drawings[0].num_layers == 1


def test_refusals(device: int) -> None:
    with pytest.raises(ValueError, match="images: got none"):
        vectorize_sequence([], device=device)
    with pytest.raises(ValueError, match=r"images: 1 is of \(9, 9\) px, wanted \(48, 64\) as 0 has"):
        vectorize_sequence([frame(0, device), np.ones((9, 9, 3))], paths=1, options=OPTIONS, device=device)
    with pytest.raises(ValueError, match="images: 0 has the background's colour only"):
        vectorize_sequence([np.ones((9, 9, 3))], paths=1, options=OPTIONS, device=device)
    for add_paths in (-1, True, 1.5):
        with pytest.raises(ValueError, match="add_paths: got"):
            vectorize_sequence([frame(0, device)], add_paths=add_paths, device=device)
    with pytest.raises(ValueError, match="seed: got -1"):
        vectorize_sequence([frame(0, device)], seed=-1, device=device)
    released = Options.released(iterations=1)
    with pytest.raises(ValueError, match="variant 'released' trains the newest paths only"):
        vectorize_sequence([frame(0, device)] * 2, paths=1, options=released, device=device)


def test_large_pictures_are_worked_on_smaller() -> None:
    image = np.ones((60, 90, 3), np.float32)
    image[20:40, 30:60] = (0.9, 0.1, 0.2)
    sizes: list[object] = []

    def seen(_: int, result: livecl.Result) -> None:
        sizes.append((result.drawing.size, result.working_size))

    options = livecl.Options(iterations=5, revisions=0)
    frames = [image, np.roll(image, 3, axis=1)]
    result = livecl.vectorize_sequence(frames, paths=1, options=options, size=30, on_frame=seen)
    assert sizes == [((60, 90), (24, 37))] * 2
    for drawing, left in zip(result.drawings, (30, 33), strict=True):
        assert drawing.size == (60, 90)
        np.testing.assert_allclose(drawing.points[:, 0].min(axis=0), (left, 20), atol=3)
    with pytest.raises(ValueError, match=r"^images: 1 is of \(30, 45\) px, wanted \(60, 90\)"):
        livecl.vectorize_sequence([image, image[::2, ::2]], paths=1, options=options, size=30)
