# SPDX-License-Identifier: Apache-2.0
"""Runs with gradient fills: drawings to start from, locked layers, names, holes, sequences, and pictures with alpha."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import rectangle
from support.states import stopped_and_resumed

import livecl
from livecl import Drawing, Options, vectorize
from livecl.drawing import LINEAR, RADIAL, SOLID, Fills
from livecl.drawing.fills import concatenate_fills
from livecl.geometry.outlines import circle, reversed_path
from livecl.image.errors import mse
from livecl.image.masks import Masks
from livecl.rendering.rasterizer import Rasterizer
from livecl.run.loop import train
from livecl.run.progress import Progress
from livecl.run.recipe import Recipe
from livecl.run.run import Run
from livecl.run.sequences import vectorize_sequence
from livecl.svg import quantize

WARM, COOL = (0.9, 0.3, 0.1, 1.0), (0.2, 0.3, 0.8, 1.0)
OPTIONS = Options(iterations=40, revisions=0)
#: The numbers of fills.
PARTS = ("kinds", "geometry", "stop_offsets", "stop_positions", "stop_colors")


def two(shift: float = 0.0, *, hole: bool = False) -> Drawing:
    """Return a square with a linear gradient and a disc with a radial one, 40 x 64 px, the disc `shift` px lower."""
    square, center = [rectangle(4, 6, 30, 34)], (46.0, 16.0 + shift)
    if hole:
        square.append(reversed_path(rectangle(12, 14, 22, 26)))
    fills = [
        Fills.linear((4, 6), (30, 34), [WARM, COOL]),
        Fills.radial(center, (center[0] + 12, center[1]), (center[0], center[1] + 12), [COOL, (0.8, 0.9, 0.9, 1.0)]),
    ]
    outlines = [square, [circle(np.array(center), 12.0, 4)]]
    return Drawing.from_outlines(outlines, [WARM, COOL], (40, 64), fills=concatenate_fills(fills))


def picture(drawing: Drawing, device: int) -> NDArray[np.float32]:
    return livecl.render(drawing, device)


def named(drawing: Drawing) -> Drawing:
    return drawing.replace(names=("wall", "sun"))


def assert_same_fill(a: Drawing, b: Drawing, layer: int) -> None:
    for part in PARTS:
        np.testing.assert_array_equal(
            getattr(a.fills.subset([layer]), part), getattr(b.fills.subset([layer]), part), err_msg=part
        )


def test_both_gradients_are_found(device: int) -> None:
    result = vectorize(picture(two(), device), 2, options=OPTIONS, device=device)
    assert sorted(result.drawing.fills.kinds.tolist()) == [LINEAR, RADIAL]
    assert result.mse < 1e-4


def test_a_start_keeps_its_gradients_and_follows_the_picture(device: int) -> None:
    start, target = two(), picture(two(3.0), device)
    before = mse(picture(start, device), target)
    result = vectorize(target, options=OPTIONS, device=device, start=start)
    assert result.drawing.fills.kinds.tolist() == [LINEAR, RADIAL]
    assert result.mse < before / 4
    assert result.drawing.fills.geometry[1, 0, 1] > start.fills.geometry[1, 0, 1] + 1


def test_locked_gradients_stay_as_they_are(device: int) -> None:
    start, target = named(two()), picture(two(3.0), device)
    result = vectorize(target, options=OPTIONS, device=device, start=start, lock=[0])
    assert result.drawing.names == ("wall", "sun")
    assert_same_fill(result.drawing, quantize(start), 0)
    assert np.abs(result.drawing.fills.geometry[1] - start.fills.geometry[1]).max() > 1


def test_all_gradients_locked_are_the_drawing_itself(device: int) -> None:
    start = quantize(two())
    result = vectorize(picture(two(3.0), device), options=OPTIONS, device=device, start=start, lock=[0, 1])
    assert result.drawing.fills.kinds.tolist() == [LINEAR, RADIAL]
    for layer in (0, 1):
        assert_same_fill(result.drawing, start, layer)
    np.testing.assert_array_equal(result.drawing.points, start.points)


def test_solid_leaves_the_gradients_of_a_start(device: int) -> None:
    """The option is about layers that are placed; a drawing's own gradients are trained."""
    options, target = dataclasses.replace(OPTIONS, fills="solid"), picture(two(3.0), device)
    result = vectorize(target, 1, options=options, device=device, start=two())
    assert result.drawing.fills.kinds.tolist()[:2] == [LINEAR, RADIAL] and not result.drawing.fills.kinds[2:].any()


def test_a_run_with_gradients_is_saved_and_goes_on_equal(tmp_path: Path, device: int) -> None:
    target, start = picture(two(2.0), device), two().layer_subset([0])
    options = Options(placement="region", iterations=12, revisions=1)

    def beginning() -> Progress:
        return Progress.start(start, options, (0, 1), 0, np.array([True]))

    expected = train(Run(target, beginning(), device))[-1].drawing
    assert sorted(expected.fills.kinds.tolist()) == [LINEAR, RADIAL]
    for stop in ((0, 6), (1, 6), (2, 6)):
        resumed = stopped_and_resumed(target, beginning(), stop, tmp_path / "state", device)
        assert resumed._repr_svg_() == expected._repr_svg_()


def test_the_layer_of_a_mask_is_shaded(device: int) -> None:
    drawing = two()
    masks = Masks(("wall", "sun"), np.clip(Rasterizer(drawing.size).coverages(drawing), 0, 1))
    result = Recipe(paths=1, options=OPTIONS, masks=masks).vectorize(picture(drawing, device), device)
    kinds = dict(zip(result.drawing.groups, result.drawing.fills.kinds.tolist(), strict=True))
    assert kinds == {("wall",): LINEAR, ("sun",): RADIAL}
    assert result.mse < 1e-4


def test_paths_that_are_added_get_gradients_and_the_start_keeps_its_own(device: int) -> None:
    start = named(two()).layer_subset([0])
    result = vectorize(picture(two(), device), 1, options=OPTIONS, device=device, start=start)
    kinds = dict(zip(result.drawing.names, result.drawing.fills.kinds.tolist(), strict=True))
    assert kinds["wall"] == LINEAR and sorted(kinds.values()) == [LINEAR, RADIAL]
    assert result.mse < 1e-4


def test_a_hole_shows_the_ground(device: int) -> None:
    result = vectorize(picture(two(hole=True), device), 2, options=OPTIONS, device=device)
    shown = picture(result.drawing, device)
    assert np.abs(shown[17:23, 14:20] - 1).max() < 0.02
    assert result.drawing.fills.any_gradients and result.mse < 2e-4


def test_a_sequence_keeps_each_layer_s_kind(device: int) -> None:
    frames = [picture(two(shift), device) for shift in (0.0, 2.0, 4.0)]
    result = vectorize_sequence(frames, paths=2, options=OPTIONS, device=device)
    kinds = [drawing.fills.kinds.tolist() for drawing in result.drawings]
    assert sorted(kinds[0]) == [LINEAR, RADIAL] and kinds == [kinds[0]] * 3
    sun = kinds[0].index(RADIAL)
    rows = [drawing.fills.geometry[sun, 0, 1] for drawing in result.drawings]
    assert np.diff(rows) == pytest.approx([2, 2], abs=1)
    assert max(result.mse) < 5e-4


def test_a_sequence_from_a_drawing_adds_a_shaded_path(device: int) -> None:
    """The sun rises in the second picture: before, its layer has no area; later, it is the same layer."""
    wall = two().layer_subset([0])
    frames = [picture(wall, device), picture(two(), device), picture(two(2.0), device)]
    result = vectorize_sequence(frames, options=OPTIONS, device=device, start=wall)
    assert [drawing.fills.kinds.tolist() for drawing in result.drawings] == [[LINEAR, RADIAL]] * 3
    sun = [drawing.points[drawing.segment_layers == 1] for drawing in result.drawings]
    assert np.ptp(sun[0], axis=(0, 1)) == pytest.approx(0, abs=1e-9)
    assert result.drawings[2].fills.geometry[1, 0, 1] > result.drawings[1].fills.geometry[1, 0, 1] + 1
    assert max(result.mse) < 5e-4


def test_alpha_that_fades_is_one_layer(device: int) -> None:
    fade = Fills.linear((4, 0), (56, 0), [(*WARM[:3], 0.95), (*WARM[:3], 0.1)])
    drawing = Drawing.from_outlines([[rectangle(4, 6, 56, 34)]], WARM, (40, 64), fills=fade).replace(background=None)
    image = livecl.render(drawing, device, straight=True)
    result = vectorize(image, 4, options=OPTIONS, device=device)
    assert result.drawing.background is None and result.drawing.fills.kinds.tolist() == [LINEAR]
    assert result.mse < 5e-5


@pytest.mark.parametrize("background", [(1.0, 1.0, 1.0), None])
def test_regions_over_nothing_wait_for_the_revision(background: tuple[float, float, float] | None, device: int) -> None:
    """Paint adds alpha and cannot take it away: what a gradient covers too much, no further path mends."""
    drawing = two().replace(background=background)
    image = livecl.render(drawing, device, straight=True)
    options = dataclasses.replace(OPTIONS, placement="region")
    result = vectorize(image, 2, options=options, device=device)
    assert result.drawing.fills.any_gradients == (background is not None)


def test_solid_asks_for_none(device: int) -> None:
    options = dataclasses.replace(OPTIONS, fills="solid")
    result = vectorize(picture(two(), device), 4, options=options, device=device)
    assert set(result.drawing.fills.kinds.tolist()) == {SOLID}
