# SPDX-License-Identifier: Apache-2.0
"""What the figure of blended drawings measures."""

from __future__ import annotations

import numpy as np
import pytest
from figures import blending
from support.drawings import GREEN, RED, build
from support.shapes import circle

from livecl.interpolation.blending import interpolate

SIZE = (32, 40)


def test_orderness_measures() -> None:
    a, b = build([([circle((16, 16), 4)], RED)], SIZE), build([([circle((22, 16), 8)], GREEN)], SIZE)
    drawings = interpolate(a, b, [0, 0.5, 1])
    stray, at_ends, between, moved, fill = blending.measure(a, b, drawings)
    # Areas of radii 4, 6 and 8: 36 in place of the mean of 16 and 64.
    assert stray == pytest.approx(4 / 40)
    assert (at_ends, between) == (0, 0)
    assert moved > 6
    assert fill == pytest.approx(np.abs(np.subtract(RED, GREEN))[:3].mean())
