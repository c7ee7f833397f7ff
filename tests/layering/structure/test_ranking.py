# SPDX-License-Identifier: Apache-2.0
"""Layers of fills over each other on one outline: both are found, ranked together, and trained."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import rectangle

import livecl
from livecl.drawing import LINEAR, Drawing
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.geometry.outlines import circle
from livecl.layering.fills.ramps import Shading
from livecl.layering.structure.finding import structure_of
from livecl.layering.structure.placing import place_structure
from livecl.layering.structure.ranking import Structure

SHADING = Shading(("linear", "radial"), 1e-7)
PINK, WHITE = (1.0, 0.4, 0.9), np.ones(3)


@functools.cache
def drawing() -> Drawing:
    """A shape in a gradient and again in pink that fades out, and a disc before it."""
    shape, disc = rectangle(12, 12, 84, 84), circle(np.array([60.0, 70.0]), 18.0, 4)
    base = Fills.linear((10, 10), (40, 90), [(0.1, 0.7, 0.7, 1), (0.1, 0.4, 0.9, 1)])
    fading = Fills.linear((84, 8), (60, 84), [(*PINK, 0), (*PINK, 0), (*PINK, 0.7)], [0, 0.55, 1])
    fills = concatenate_fills([base, fading, Fills.solid(1)])
    colors = [(0.1, 0.5, 0.8, 1), (*PINK, 1), (0.9, 0.8, 0.1, 1)]
    return Drawing.from_outlines([[shape], [shape], [disc]], colors, (96, 96), background=WHITE, fills=fills)


@pytest.fixture
def target(device: int) -> NDArray[np.float32]:
    return (np.round(livecl.render(drawing(), device) * 255) / 255).astype(np.float32)


def structure(target: NDArray[np.float32], most: int) -> Structure:
    return structure_of(target, WHITE, most, SHADING)


def test_a_shape_shaded_twice_is_two_layers_of_one_outline(target: NDArray[np.float32]) -> None:
    found = structure(target, 3)
    assert [layer.over for layer in found.layers] == [0, 1, 0]
    assert found.layers[0].outlines is found.layers[1].outlines
    np.testing.assert_array_equal(found.masks[0], found.masks[1])
    np.testing.assert_allclose(found.layers[1].color, PINK, atol=0.08)
    assert sorted(found.ranked.tolist()) == [0, 1, 2]
    assert [found.fills_of(k).any_gradients for k in range(3)] == [True, True, False]
    assert found.mistaken < 0.01


def test_the_layer_below_comes_first_and_one_over_it_shows_where_that_does(target: NDArray[np.float32]) -> None:
    found = structure(target, 3)
    ranked = found.ranked.tolist()
    assert ranked.index(0) < ranked.index(1)
    np.testing.assert_array_equal(found.shows(np.array([1])), found.shows(np.array([0])))
    assert 0 < found.gains[1] < found.gains[0]


def test_pixels_have_no_weight_while_a_layer_over_them_is_missing(target: NDArray[np.float32]) -> None:
    empty = empty_drawing(target.shape[:2]).replace(background=WHITE)
    first = place_structure(target, empty, 2, 3, SHADING)
    assert first is not None and first.numbers.tolist() == [0, 2]
    assert first.weight[20, 20] == 0 and first.weight[70, 60] == 1


def test_a_run_finds_both_fills(target: NDArray[np.float32], device: int) -> None:
    result = livecl.vectorize(target, 3, device=device)
    assert result.drawing.num_layers == 3
    assert result.drawing.fills.kinds[:2].tolist() == [LINEAR, LINEAR]
    assert result.mse < 5e-5
    alphas = result.drawing.fills.colors_at(1, np.array([(20.0, 20.0), (20.0, 80.0)]))[:, 3]
    assert alphas[0] < 0.1 and alphas[1] > 0.3
