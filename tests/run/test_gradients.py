# SPDX-License-Identifier: Apache-2.0
"""Runs with gradient fills: drawings to start from, locked layers, names, holes, sequences, and pictures with alpha."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import rectangle

import livecl
from livecl import Drawing, Options, vectorize
from livecl.drawing import LINEAR, RADIAL, SOLID, Fills
from livecl.drawing.fills import concatenate_fills
from livecl.geometry.outlines import circle, reversed_path
from livecl.image.errors import mse
from livecl.run.sequences import vectorize_sequence

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
    np.testing.assert_allclose(result.drawing.fills.geometry[0], start.fills.geometry[0], atol=5e-4)
    np.testing.assert_allclose(result.drawing.fills.stop_colors[:2], start.fills.stop_colors[:2], atol=1 / 255)
    assert np.abs(result.drawing.fills.geometry[1] - start.fills.geometry[1]).max() > 1


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
