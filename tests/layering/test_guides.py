# SPDX-License-Identifier: Apache-2.0
"""Layers of masks: whole shapes, in the order of depth that the picture shows."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings, shapes

from livecl.drawing import Drawing
from livecl.layering.guides import depth_order, mask_outline, masked_layers
from livecl.rendering import Rasterizer, render

RED, BLUE, GREEN, WHITE = (1, 0, 0, 1), (0, 0, 1, 1), (0, 0.6, 0, 1), (1.0, 1.0, 1.0)


def scene() -> Drawing:
    """A red disc, a blue one over its half, and a green one within the blue one and over nothing else."""
    layers = [([shapes.circle((25, 30), 15)], RED), ([shapes.circle((42, 30), 15)], BLUE)]
    return drawings.build([*layers, ([shapes.circle((48, 30), 5)], GREEN)], (60, 70), WHITE)


def masks_of(drawing: Drawing) -> NDArray[np.float32]:
    return np.clip(Rasterizer(drawing.size).coverages(drawing), 0, 1)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2), (2, 0, 1)])
def test_depth_is_read_off_the_picture_however_masks_are_ordered(order: tuple[int, ...]) -> None:
    drawing = scene()
    found = depth_order(render(drawing), masks_of(drawing)[list(order)])
    assert [order[k] for k in found] == [0, 1, 2]


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_a_thing_of_many_colours_stands_before_a_plain_one(order: tuple[int, ...]) -> None:
    """A house of wall, roof, door and windows before a meadow that goes on behind it, and the sky behind both."""
    sky = drawings.rectangle(0, 0, 80, 60), (0.6, 0.8, 1, 1)
    meadow = drawings.rectangle(0, 35, 80, 60), GREEN
    wall, roof = drawings.rectangle(20, 20, 60, 50), drawings.rectangle(16, 8, 64, 20)
    door, window = drawings.rectangle(24, 30, 34, 50), drawings.rectangle(42, 36, 54, 44)
    house = (wall, (0.9, 0.8, 0.6, 1)), (roof, RED), (door, (0.4, 0.2, 0.1, 1)), (window, BLUE)
    drawing = drawings.build([([outline], color) for outline, color in (sky, meadow, *house)], (60, 80), WHITE)
    coverages = masks_of(drawing)
    masks = np.stack([coverages[0], coverages[1], coverages[2:].max(axis=0)])
    found = depth_order(render(drawing), masks[list(order)])
    assert [order[k] for k in found] == [0, 1, 2]


def test_masks_that_do_not_overlap_stay_in_their_order() -> None:
    layers = [([shapes.circle((12 + 20 * k, 12), 5 + k % 2)], (RED, BLUE, GREEN)[k]) for k in range(3)]
    drawing = drawings.build(layers, (24, 70), WHITE)
    for order in ([0, 1, 2], [2, 0, 1]):
        assert depth_order(render(drawing), masks_of(drawing)[order]) == [0, 1, 2]


def test_whole_shapes_in_groups_of_the_names() -> None:
    drawing = scene()
    masks = masks_of(drawing)
    found = masked_layers(render(drawing), masks[[2, 0, 1]], ("green", "red", "blue"), np.ones(3))
    assert found.groups == (("red",), ("blue",), ("green",))
    np.testing.assert_allclose(found.colors, drawing.colors, atol=1e-6)
    coverages = Rasterizer(drawing.size).coverages(found)
    for mine, true in zip(coverages, masks, strict=True):
        assert np.minimum(mine, true).sum() > 0.97 * np.maximum(mine, true).sum()  # hidden parts, too


@pytest.mark.parametrize("soft", [True, False])
def test_outlines_of_masks_with_holes_and_parts(soft: bool) -> None:
    ring = [shapes.circle((30, 30), 20), drawings.reverse(shapes.circle((30, 30), 9))]
    drawing = drawings.build([([*ring, shapes.circle((62, 30), 6)], RED)], (60, 72))
    mask = masks_of(drawing)[0]
    outline = mask_outline(mask if soft else (mask >= 0.5).astype(np.float32))
    assert len(outline) == 3
    again = masks_of(Drawing.from_outlines([outline], RED, drawing.size))[0]
    assert np.abs(again - mask).sum() < (0.01 if soft else 0.03) * mask.sum()
    assert sum(map(len, outline)) <= 16  # not a node at each step of pixels


def test_a_mask_without_a_clear_pixel_has_the_mean_colour_of_its_pixels() -> None:
    """A bar that covers two thirds of a row, white elsewhere: of its pixels' colours that of a third of white."""
    drawing = drawings.build([([drawings.rectangle(4, 8, 30, 8 + 2 / 3)], RED)], (20, 40), WHITE)
    found = masked_layers(render(drawing), masks_of(drawing), ("bar",), np.ones(3))
    np.testing.assert_allclose(found.colors, [(1, 1 / 3, 1 / 3, 1)], atol=1e-5)


@pytest.mark.parametrize(("radius", "layers"), [(0.5, 0), (0.95, 0), (1.2, 1)])
def test_masks_of_less_than_three_square_pixels_have_no_layers(radius: float, layers: int) -> None:
    masks = masks_of(drawings.build([([shapes.circle((7.5, 5.5), radius)], RED)], (20, 40)))
    found = masked_layers(np.ones((20, 40, 3)), masks, ("speck",), np.ones(3))
    assert found.num_layers == layers and found.size == (20, 40)


def test_clear_pixels_say_nothing_of_a_mask_s_colour() -> None:
    masks = masks_of(drawings.build([([drawings.rectangle(4, 4, 30, 16)], RED)], (20, 40)))
    image = np.zeros((20, 40, 4))
    image[4:16, 4:14] = RED  # the rest of the mask, more than half of it, is clear and black
    found = masked_layers(image, masks, ("bar",), None)
    np.testing.assert_allclose(found.colors, [RED], atol=1e-6)
