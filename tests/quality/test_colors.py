# SPDX-License-Identifier: Apache-2.0
"""Colours as people see them: differences of pictures, and layers in a colour of the picture."""

from __future__ import annotations

import numpy as np
import pytest
from support.drawings import build, rectangle

from livecl.drawing.fills import Fills, concatenate_fills
from livecl.quality import color_difference, colors_in_picture, main_colors


def test_color_difference_is_a_mean_over_pixels() -> None:
    black, white = np.zeros((4, 6, 3)), np.ones((4, 6, 3))
    assert color_difference(black, black) == 0
    assert color_difference(black, white) == pytest.approx(100, abs=1e-3)  # L* 0 and 100, a* = b* = 0
    half = black.copy()
    half[:2] = 1
    assert color_difference(black, half) == pytest.approx(50, abs=1e-3)
    with pytest.raises(ValueError, match="shape"):
        color_difference(black, white[:2])


def test_a_colour_of_the_picture_has_twenty_pixels() -> None:
    image = np.zeros((8, 10, 3))
    image[:2] = (1, 0, 0)  # 20 pixels
    image[2:4, :9] = (0, 0, 1)
    image[3, 0] = 0  # 17 pixels are left of the blue ones
    assert sorted(map(tuple, main_colors(image).tolist())) == [(0, 0, 0), (1, 0, 0)]
    assert len(main_colors(image, least=17)) == 3


def test_layers_in_a_colour_of_the_picture() -> None:
    image = np.zeros((8, 10, 3))
    image[:2] = (1, 0, 0)
    box = [rectangle(1, 1, 5, 5)]
    colors = [(1, 0, 0, 1), (0.99, 0, 0, 1), (0.8, 0.2, 0, 1), (0.5, 0.5, 0.5, 0.5), (0.5, 0.5, 0.5, 1)]
    drawing = build([(box, color) for color in colors], (8, 10))
    gradient = Fills.linear((0, 0), (9, 0), [(0, 0, 0, 1), (1, 1, 1, 1)])
    drawing = drawing.replace(fills=concatenate_fills([Fills.solid(4), gradient]))
    # Not looked at: the translucent one, and the gradient; orange is not in the picture.
    assert colors_in_picture(drawing, image) == (2, 3)
    assert colors_in_picture(drawing, np.linspace(0, 1, 240).reshape(8, 10, 3)) == (0, 3)
