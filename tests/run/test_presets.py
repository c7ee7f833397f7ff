# SPDX-License-Identifier: Apache-2.0
"""What the presets leave of pictures of their kinds: layers, nodes and colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.drawings import build
from support.shapes import circle

import livecl
from livecl import Drawing, Options
from livecl.drawing.assembly import empty_drawing
from livecl.run.beginning import placed_by

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SIZE = (96, 96)


def polygon(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return straight segments from corner to corner: (s, 3, 2)."""
    ends = np.roll(corners, -1, axis=0)
    return np.stack([corners, corners + (ends - corners) / 3, corners + 2 * (ends - corners) / 3], axis=1)


def star() -> Drawing:
    angles, radii = np.pi * np.arange(10) / 5, np.where(np.arange(10) % 2, 17.0, 42.0)
    corners = 48 + radii[:, None] * np.stack([np.sin(angles), -np.cos(angles)], axis=1)
    return build([([polygon(corners)], (0.98, 0.75, 0.12, 1.0))], SIZE)


def play() -> Drawing:
    triangle = polygon(np.array([[37.0, 28.0], [37.0, 68.0], [72.0, 48.0]]))
    return build(
        [([circle((48, 48), 42)], (0.24, 0.63, 0.24, 1.0)), ([triangle], (1.0, 1.0, 1.0, 1.0))], SIZE, background=None
    )


@pytest.mark.slow
@pytest.mark.parametrize("drawn", [star(), play()], ids=["star", "play button"])
def test_icons_have_the_layers_and_colours_that_a_person_draws(drawn: Drawing) -> None:
    found = livecl.vectorize(livecl.render(drawn, straight=True), options=Options.preset("icon")).drawing
    assert found.num_layers == drawn.num_layers
    np.testing.assert_allclose(found.colors, drawn.colors, atol=0.02)


@pytest.mark.slow
def test_clip_art_leaves_out_layers_that_the_default_has() -> None:
    image = livecl.read_image(EXAMPLES / "scene.png")
    default, clipart = (
        livecl.vectorize(image, 64, options=Options.preset(name, placement="region", background="white"))
        for name in ("default", "clipart")
    )
    assert clipart.drawing.num_layers < default.drawing.num_layers
    assert clipart.drawing.num_segments < default.drawing.num_segments
    assert clipart.mse < 3e-4


def test_small_shapes_that_icons_leave_out_leave_no_gaps() -> None:
    """A plate of pale cells, none of which is worth a layer of an icon, is no stack of layers without them."""
    rng = np.random.default_rng(4)
    image = np.ones((128, 128, 3), np.float32)
    image[4:124, 4:124] = 0.9, 0.45, 0.1
    for row, column in np.ndindex(10, 10):
        top, left = np.array([8, 8]) + 11 * np.array([row, column]) + rng.integers(0, 3, 2)
        height, width = rng.integers(5, 8, 2)
        image[top : top + height, left : left + width] = np.array([0.95, 0.65, 0.4]) - 0.04 * rng.integers(0, 3)
    drawing = empty_drawing((128, 128))
    default, icon = (placed_by(Options.preset(name), image, drawing, 256).placement for name in ("default", "icon"))
    assert (default, icon) == ("structure", "region")
