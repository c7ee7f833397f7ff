# SPDX-License-Identifier: Apache-2.0
"""Noise and compression of a picture are measured, and buy no layers."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from support.found import flat_regions

from livecl.drawing.assembly import empty_drawing
from livecl.layering.outlines.contours import Outlines
from livecl.layering.segmentation.noise import BESIDE, MOST_RINGING, RADIUS, RADIUS_OF_NOISE, _ringing, noise_level
from livecl.layering.segmentation.small import without_small
from livecl.layering.structure import placing
from livecl.layering.structure.layers import find_layers

FloatArray = NDArray[np.float64]
WHITE = np.ones(3)
SIZE = 128


def flat() -> FloatArray:
    """A disc before a bar, a ring and a small pale disc, anti-aliased."""
    at = (np.arange(4 * SIZE) + 0.5) / 4
    x, y = np.meshgrid(at, at)
    image = np.ones((4 * SIZE, 4 * SIZE, 3))
    image[(y > 70) & (y < 95) & (x > 8) & (x < 120)] = (0.2, 0.6, 0.3)
    image[np.hypot(x - 50, y - 70) < 30] = (0.85, 0.2, 0.25)
    ring = np.hypot(x - 96, y - 34)
    image[(ring < 24) & (ring > 16)] = (0.1, 0.25, 0.7)
    image[np.hypot(x - 100, y - 112) < 9] = (0.98, 0.8, 0.3)
    return np.asarray(np.round(255 * image.reshape(SIZE, 4, SIZE, 4, 3).mean(axis=(1, 3))) / 255)


def wavy() -> FloatArray:
    """A disc on a shape of five bays, anti-aliased."""
    at = (np.arange(4 * SIZE) + 0.5) / 4
    x, y = np.meshgrid(at - 64, at - 62)
    image = np.ones((4 * SIZE, 4 * SIZE, 3))
    image[np.hypot(x, y) < 46 + 9 * np.sin(5 * np.arctan2(y, x))] = (0.85, 0.2, 0.25)
    image[np.hypot(x, y - 8) < 16] = (0.98, 0.8, 0.3)
    return np.asarray(np.round(255 * image.reshape(SIZE, 4, SIZE, 4, 3).mean(axis=(1, 3))) / 255)


def ramp() -> FloatArray:
    image = flat()
    image[40:100, 20:110] = np.linspace(0.2, 0.9, 90)[None, :, None] * (1.0, 0.6, 0.3)
    return np.asarray(np.round(255 * image) / 255)


def noisy(image: FloatArray) -> FloatArray:
    scattered = 255 * image + np.random.default_rng(5).normal(0, 4, image.shape)
    return np.asarray(np.round(np.clip(scattered, 0, 255)) / 255)


def jpeg(image: FloatArray) -> FloatArray:
    file = io.BytesIO()
    Image.fromarray(np.round(255 * image).astype(np.uint8)).save(file, "JPEG", quality=50)
    return np.asarray(Image.open(file).convert("RGB"), np.float64) / 255


def test_clean_pictures_have_no_noise() -> None:
    assert noise_level(flat()) == 0
    assert noise_level(ramp()) == 0
    assert noise_level(np.ones((3, 3, 3))) == 0


def test_white_noise_is_measured() -> None:
    grey = np.full((64, 64, 3), 0.5) + np.random.default_rng(1).normal(0, 2 / 255, (64, 64, 3))
    # 12 288 responses, each shared by 9 pixels: 5 % is three standard deviations of their root mean square.
    assert noise_level(grey) == pytest.approx(2 / 255, rel=0.05)


@pytest.mark.parametrize("spoil", [noisy, jpeg])
def test_noise_buys_no_layers(spoil: Callable[[FloatArray], FloatArray]) -> None:
    image = spoil(flat())
    assert noise_level(image) > 0
    regions = flat_regions(image)
    layers = find_layers(Outlines(regions), WHITE)
    clean = find_layers(Outlines(flat_regions(flat())), WHITE)
    assert len(clean) == 4
    assert len(layers) == len(clean)
    one_color = RADIUS + RADIUS_OF_NOISE * regions.noise
    assert all(min(np.abs(layer.color - other.color).max() for other in clean) <= one_color for layer in layers)
    assert placing.structure_kind(image.astype(np.float32), WHITE, 4, None)


@pytest.mark.parametrize("spoil", [noisy, jpeg])
def test_noise_buys_no_nodes(spoil: Callable[[FloatArray], FloatArray]) -> None:
    numbers = []
    for image in (wavy(), spoil(wavy())):
        drawing = empty_drawing((SIZE, SIZE), WHITE)
        layers = placing.place_structure(image.astype(np.float32), drawing, 4, 4)
        assert layers is not None
        numbers.append(max(len(path) for outlines in layers.outlines for path in outlines))
    assert numbers[1] <= numbers[0]


def test_borders_err_by_the_noise_over_their_contrast() -> None:
    regions = flat_regions(flat())
    assert regions.border_noise == 0
    two = dataclasses.replace(
        regions,
        labels=np.array([[0, 1], [0, 1]]),
        colors=np.array([[0.2, 0.5, 0.5], [0.6, 0.4, 0.5]]),
        noise=0.02,
    )
    assert two.border_noise == pytest.approx(0.02 / 0.4)


@pytest.mark.parametrize("spoil", [noisy, jpeg])
def test_slopes_are_no_noise(spoil: Callable[[FloatArray], FloatArray]) -> None:
    assert not placing.structure_kind(spoil(ramp()).astype(np.float32), WHITE, 99, None)


def test_a_faint_strip_along_an_edge_is_ringing_only_in_a_noisy_picture() -> None:
    parts = np.zeros((20, 20), np.int64)
    parts[9], parts[10:] = 1, 2  # a strip of one row between two areas
    colors = np.array([[0.2] * 3, [0.4] * 3, [1.0] * 3])
    sure = np.array([True, False, True])
    for noise, kept in ((0.0, 3), (1 / 255, 2)):
        found = without_small(parts.copy(), colors, 2, 0.01, sure, noise)
        assert len(np.unique(found)) == kept


def test_a_small_blend_of_its_neighbours_is_none_of_its_own() -> None:
    parts = np.zeros((20, 20), np.int64)
    parts[:, 10:] = 2
    parts[5:9, 9] = 1  # 4 px
    colors = np.array([[0.2] * 3, [0.6, 0.6, 0.6], [1.0] * 3])
    for color, kept in ((0.6, 2), (0.9, 3)):
        colors[1, 0] = color
        found = without_small(parts.copy(), colors, 3, 0.01, np.array([True, False, True]), 0.0)
        assert len(np.unique(found)) == kept


@pytest.mark.parametrize(
    ("columns", "level", "found"),
    [
        (range(2, 2 + BESIDE - 1), 4, 2),  # beside an edge, as far as ringing is looked for: half of the deviation
        (range(2), 4, 0),  # mixed pixels
        (range(2 + BESIDE - 1, 15), 4, 0),  # farther off
        (range(2, 15), 40, 255 * MOST_RINGING),
    ],
)
def test_ringing_is_what_deviates_beside_edges(columns: range, level: float, found: float) -> None:
    """An edge between the columns 14 and 15; `columns` on both sides of it, from 0 on, deviate by some levels."""
    nearest = np.zeros((20, 30), np.int64)
    nearest[:, 15:] = 1
    shown = np.array([(0.2, 0.3, 0.4), (0.8, 0.7, 0.6)])[nearest]
    image = shown.copy()
    for column in columns:
        image[:, [14 - column, 15 + column], 1] += level / 255
    assert 255 * _ringing(image, shown, nearest) == pytest.approx(found)
    assert _ringing(shown + 1, shown, np.zeros_like(nearest)) == 0, "without an edge"
