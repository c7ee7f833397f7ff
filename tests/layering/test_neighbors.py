# SPDX-License-Identifier: Apache-2.0
"""Flat regions, and neighbours of one colour."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from support import drawings, shapes
from support.drawings import rectangle

from livecl.drawing.drawing import Drawing
from livecl.layering.contributions import layer_alphas, visible_shares
from livecl.layering.neighbors import flat_labels, mergeable_pairs
from livecl.quality.layers import num_mergeable

SIZE = (12, 16)
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)


def drawn(*layers: tuple[shapes.Path, ArrayLike], background: ArrayLike | None = (1.0, 1.0, 1.0)) -> Drawing:
    return drawings.build([([path], color) for path, color in layers], SIZE, background)


def opacity(color: tuple[float, ...], alpha: float) -> tuple[float, ...]:
    return (*color[:3], alpha)


def test_flat_regions() -> None:
    target = np.zeros((4, 9, 3))
    target[:, 3:, 0] = 1.0  # a second region
    target[:, 5:, 0] -= np.linspace(0, 0.15, 4)  # a slow gradient goes on in it
    target[0, 0] = 0.05  # just about the same
    target[3, 0, 2] = 0.06  # one channel differs
    regions = flat_labels(target)
    assert len(np.unique(regions)) == 3
    assert len(np.unique(regions[:, 3:])) == 1
    assert regions[0, 0] == regions[0, 2] != regions[3, 0]


def test_flat_regions_are_not_joined_across_corners() -> None:
    assert len(np.unique(flat_labels(np.eye(2)[..., None] * np.ones(3)))) == 4


def test_one_pixel_is_one_region() -> None:
    assert flat_labels(np.zeros((1, 1, 3))).tolist() == [[0]]


def test_mergeable_pairs() -> None:
    drawing = drawn(
        (rectangle(0, 0, 4, 4), RED),
        (rectangle(4, 0, 8, 4), (0.96, 0.04, 0.0, 1.0)),  # beside layer 0, nearly its colour
        (rectangle(8.5, 0, 12.5, 4), RED),  # a mixed pixel away from layer 1
        (rectangle(0, 8, 4, 12), RED),  # far off
        (rectangle(4, 8, 8, 12), opacity(RED, 0.9)),  # beside layer 3, but less opaque
        (rectangle(8, 8, 12, 12), BLUE),  # another colour
    )
    pairs = mergeable_pairs(drawing, visible_shares(layer_alphas(drawing)))
    assert pairs.tolist() == [[0, 1], [1, 2]]
    assert num_mergeable(drawing.num_layers, pairs) == 2
