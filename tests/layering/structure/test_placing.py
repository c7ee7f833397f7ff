# SPDX-License-Identifier: Apache-2.0
"""Placement by structure by known values: points that no pixel decides on, noise of outlines, the last resort."""

from __future__ import annotations

import numpy as np
from support.shapes import rectangle

from livecl.drawing import Drawing
from livecl.layering.structure.finding import found_structure, structure_of
from livecl.layering.structure.placing import hidden_points, outline_noise

WHITE = np.ones(3)


def test_points_below_another_layer_are_hidden_and_those_on_the_edge_of_the_canvas_are_not() -> None:
    """A plate that fills the canvas, and a square over its lower right quarter, around which its corner is hidden."""
    plate, square = rectangle(0, 0, 40, 30), rectangle(20, 15, 40, 30)
    drawing = Drawing.from_outlines([[plate], [square]], [(0, 0, 1, 1), (1, 0, 0, 1)], (30, 40))
    top = np.ones((30, 40), np.int64)
    top[15:, 20:] = 2
    hidden = hidden_points(drawing, np.array([0, 1]), top)
    anchors = drawing.points[:, 0]
    np.testing.assert_array_equal(hidden[:, 0], [*((anchors[:4] == (40, 30)).all(axis=1)), *[False] * 4])
    alone = hidden_points(drawing.layer_subset([0]), np.array([0]), np.ones((30, 40), np.int64))
    assert not alone.any()


def disc(noise: float) -> np.ndarray:
    """A dark disc on white, anti-aliased by distance, with noise."""
    y, x = np.mgrid[:96, :96] + 0.5
    cover = np.clip(30.5 - np.hypot(x - 48, y - 48), 0, 1)[..., None]
    picture = 1 - cover * (0.9, 0.7, 0.2)
    return np.round(255 * np.clip(picture + noise * np.random.default_rng(3).normal(size=picture.shape), 0, 1)) / 255


def test_only_outlines_of_a_noisy_picture_have_noise_at_long_waves() -> None:
    clean, noisy = (found_structure(disc(noise), WHITE, 4) for noise in (0.0, 8 / 255))
    assert clean is not None and noisy is not None
    assert outline_noise(clean)[1] == 0
    points, waves = outline_noise(noisy)
    assert points > 0 and waves >= noisy.regions.border_noise > 0


def test_the_flat_regions_stand_for_a_picture_that_no_shapes_explain() -> None:
    picture = np.random.default_rng(5).random((24, 24, 3))
    assert found_structure(picture, WHITE, 2) is None
    found = structure_of(picture, WHITE, 2)
    assert len(found.layers) >= 1 and found.masks.shape[1:] == (24, 24)
