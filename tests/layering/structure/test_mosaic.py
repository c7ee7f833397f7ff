# SPDX-License-Identifier: Apache-2.0
"""Pixel art: layers of whole cells that show the picture exactly, few of them, whatever the number of its parts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import livecl
from livecl.geometry.bezier import signed_area
from livecl.geometry.outlines import polygon_path
from livecl.layering.structure import structure_kind
from livecl.layering.structure.mosaic import LEAST_SIDE, MOST_PARTS, corner_count, loops, mosaic_of, simplest

PALETTE = np.array([[255, 255, 255], [25, 25, 51], [204, 51, 51], [230, 180, 51], [51, 128, 204]]) / 255
WHITE = np.ones(3)


def sprite(cells: int, side: int, colors: int = 5, seed: int = 0) -> NDArray[np.float32]:
    """Return a picture of random cells, of the page's colour at its border."""
    numbers = np.random.default_rng(seed).integers(0, colors, (cells, cells))
    numbers[[0, -1]] = numbers[:, [0, -1]] = 0
    return np.repeat(np.repeat(PALETTE[numbers], side, axis=0), side, axis=1).astype(np.float32)


@pytest.mark.parametrize("side", [2, 5])
def test_a_sprite_of_many_parts_is_a_path_for_each_colour_and_exact(side: int, device: int) -> None:
    image = sprite(24, side)
    result = livecl.vectorize(image, device=device)
    assert len(np.unique(np.round(result.drawing.colors, 2), axis=0)) == result.drawing.num_layers == len(PALETTE)
    np.testing.assert_allclose(livecl.render(result.drawing, device), image, atol=1e-6)


def test_alpha_shows_where_a_sprite_has_no_cells(device: int) -> None:
    image = sprite(24, 3)
    straight = np.concatenate([image, (image != 1).any(axis=-1, keepdims=True)], axis=2).astype(np.float32)
    result = livecl.vectorize(straight, device=device)
    assert result.drawing.background is None and result.drawing.num_layers == len(PALETTE) - 1
    seen = livecl.render(result.drawing, device, straight=True)
    np.testing.assert_allclose(seen[..., 3], straight[..., 3], atol=1e-6)


def test_parts_of_a_small_sprite_are_layers_of_their_own() -> None:
    image = np.ones((12, 12, 3), np.float32)
    image[2:6, 2:6] = image[7:10, 7:10] = (0.8, 0.2, 0.2)
    mosaic = mosaic_of(image)
    assert mosaic is not None and mosaic.num_parts == 3
    found = mosaic.layers(WHITE, 8)
    assert found is not None and len(found[1]) == 2
    united = mosaic.layers(WHITE, 1)
    assert united is not None and [len(layer.outlines) for layer in united[1]] == [2]


def test_only_cells_of_several_pixels_and_few_colours_are_pixel_art() -> None:
    assert structure_kind(sprite(24, LEAST_SIDE), WHITE, 256, None) == "cells"
    assert structure_kind(sprite(4, 8), WHITE, 256, None) == "shapes"  # few parts: someone lies in front
    disc = np.ones((200, 200, 3), np.float32)
    disc[np.hypot(*(np.indices((200, 200)) - 99.5)) < 60] = 0  # steps of a pixel are a round shape
    assert mosaic_of(disc) is None and structure_kind(disc, WHITE, 256, None) == "shapes"
    ramp = np.linspace(0, 1, 24, dtype=np.float32)[None, :, None] * np.ones((24, 1, 3), np.float32)
    assert mosaic_of(ramp) is not None and structure_kind(ramp, WHITE, 256, None) is None
    noise = np.random.default_rng(0).uniform(size=(40, 40, 3)).astype(np.float32)
    assert mosaic_of(noise) is None
    assert mosaic_of(np.repeat(np.repeat(noise, 8, axis=0), 8, axis=1)) is None


def test_a_layer_goes_on_below_later_ones_where_that_saves_corners() -> None:
    own = np.ones((5, 5), bool)
    own[2, 2] = own[0, 3] = own[4, :2] = False
    later = np.zeros_like(own)
    later[2, 2] = later[0, 3] = True
    whole = simplest(own, later)
    np.testing.assert_array_equal(whole, own | later)
    assert corner_count(whole) == 6 and corner_count(own) == 14
    later[:] = False
    np.testing.assert_array_equal(simplest(own, later), own)  # the ground shows there


def test_outlines_have_the_area_of_their_cells_and_touch_at_corners_only() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        mask = rng.uniform(size=(9, 7)) < 0.5
        paths = [polygon_path(np.stack([columns, rows], axis=1)) for rows, columns in loops(mask)]
        assert sum(map(len, paths)) == corner_count(mask)
        areas = [signed_area(np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)) for path in paths]
        assert abs(sum(areas)) == pytest.approx(mask.sum())


def test_many_parts_cost_no_more_than_few() -> None:
    image = sprite(64, 2)
    mosaic = mosaic_of(image)
    assert mosaic is not None and mosaic.num_parts > 10 * MOST_PARTS
    assert structure_kind(image, WHITE, 256, None) == "cells"
