# SPDX-License-Identifier: Apache-2.0
"""When a picture is placed by structure: where it is flat, and where its layers show what it shows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.structure import placing

WHITE = np.ones(3)


def two_squares(level: float) -> NDArray[np.float32]:
    image = np.ones((64, 64, 3), np.float32)
    image[10:40, 10:40] = (level, 0.2, 0.2)
    image[25:55, 25:55] = (0.1, 0.3, 0.8)
    return image


def test_flat_pictures_are_structured_and_ramps_are_not() -> None:
    assert placing.structured(two_squares(0.9), WHITE)
    assert not placing.structured(np.ones((64, 64, 3), np.float32), WHITE)  # nothing but ground
    ramp = np.linspace(0, 1, 64, dtype=np.float32)[None, :, None] * np.ones((64, 1, 3), np.float32)
    assert not placing.structured(ramp, WHITE)


def test_layers_that_hide_what_the_picture_shows_are_no_structure(monkeypatch: pytest.MonkeyPatch) -> None:
    find_layers = placing.find_layers
    monkeypatch.setattr(placing, "find_layers", lambda *arguments: find_layers(*arguments)[::-1])
    # Reversed, the lower square comes last and is whole: it hides a quarter of the other, 225 of 4096 px.
    assert placing.structured(two_squares(0.7), WHITE)
    monkeypatch.setattr(placing, "find_layers", lambda *arguments: find_layers(*arguments)[:1])
    # Of 64 x 64 px, 900 show the other square: more than a tenth of those within regions.
    assert not placing.structured(two_squares(0.6), WHITE)


def test_too_few_paths_for_the_shapes_are_no_structure() -> None:
    assert placing.structured(two_squares(0.9), WHITE, 2)
    assert not placing.structured(two_squares(0.9), WHITE, 1)  # a square of 675 px or more would be left out
    speck = two_squares(0.9)
    speck[5:8, 5:8] = 0.5  # 9 px of half the contrast: 9 / 4 of 4096 px is 5.5e-4, in all channels
    assert not placing.structured(speck, WHITE, 2)
    speck[5:8, 5:8] = 0.6
    assert placing.structured(speck, WHITE, 2)
