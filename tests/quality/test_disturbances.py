# SPDX-License-Identifier: Apache-2.0
"""Disturbed pictures: strength, range, repeatability."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from livecl.quality import disturbed


def test_noise_has_the_stated_strength_and_is_repeatable() -> None:
    grey = np.full((64, 64, 3), 0.5)
    noisy = disturbed(grey, "noise")
    # 12 288 numbers: the standard deviation of their standard deviation is 1/157 of it.
    assert np.std(noisy) == pytest.approx(4 / 255, rel=0.04)
    assert np.array_equal(noisy, disturbed(grey, "noise")) and not np.array_equal(noisy, disturbed(grey, "noise", 1))
    assert np.array_equal(noisy * 255, np.rint(noisy * 255))
    assert disturbed(np.ones((8, 8, 3)), "noise").max() == 1


def test_jpeg_is_what_a_file_of_quality_50_shows() -> None:
    image = np.zeros((16, 16, 3))
    image[:, 5:] = (1, 0, 0)
    file = io.BytesIO()
    Image.fromarray((255 * image).astype(np.uint8)).save(file, "JPEG", quality=50)
    wanted = np.asarray(Image.open(file), dtype=float) / 255
    assert disturbed(image, "jpeg") == pytest.approx(wanted)
    assert not np.allclose(wanted, image, atol=0.01)


def test_unknown_disturbances_are_refused() -> None:
    with pytest.raises(ValueError, match="kind: got 'rain', wanted 'jpeg' or 'noise'"):
        disturbed(np.ones((4, 4, 3)), "rain")
