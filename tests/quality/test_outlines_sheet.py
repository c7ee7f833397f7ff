# SPDX-License-Identifier: Apache-2.0
"""Picture of outlines: size, place and colours."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from support.drawings import build, rectangle

from livecl.quality import draw_outlines


def test_each_layer_has_a_line_of_its_own_colour_where_its_outline_is() -> None:
    color = (1.0, 0.0, 0.0, 1.0)
    drawing = build([([rectangle(2, 2, 10, 10)], color), ([rectangle(12, 4, 20, 12)], color)], (16, 24))
    shown = draw_outlines(drawing, Image.new("RGB", (96, 64), "white"))
    assert shown.size == (96, 64)
    pixels = np.asarray(shown, dtype=int)
    colored = pixels.max(axis=2) - pixels.min(axis=2) > 60
    rows, columns = np.nonzero(colored)
    # Four pixels a px: the boxes span rows 8 to 48 and columns 8 to 80, and nothing is drawn within them. Half of
    # a line of one pixel lies on either side.
    assert [rows.min(), rows.max(), columns.min(), columns.max()] == pytest.approx([8, 48, 8, 80], abs=1)
    assert not colored[20:28, 20:28].any()
    first, second = pixels[24, 6:11], pixels[32, 46:51]
    assert not np.array_equal(first.min(axis=0), second.min(axis=0))
