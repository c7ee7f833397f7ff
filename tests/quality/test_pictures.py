# SPDX-License-Identifier: Apache-2.0
"""Measures of pictures, where the answers are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from livecl.image.errors import mse
from livecl.quality.pictures import psnr, ssim


def test_picture_measures() -> None:
    target = np.random.default_rng(0).uniform(0.2, 0.8, (20, 30, 3))
    assert mse(target + 0.1, target) == pytest.approx(0.01)
    assert psnr(target + 0.1, target) == pytest.approx(20)
    assert (mse(target, target), psnr(target, target)) == (0, math.inf)
    assert ssim(target, target) == pytest.approx(1)
    assert ssim(1 - target, target) < 0


@pytest.mark.parametrize("side", [3, 4, 6, 7, 8])
def test_ssim_of_small_pictures(side: int) -> None:
    target = np.random.default_rng(0).uniform(size=(side, 9, 3))
    assert ssim(target, target) == pytest.approx(1)


def test_picture_measures_refuse_other_shapes() -> None:
    with pytest.raises(ValueError, match="image: shape"):
        mse(np.zeros((4, 4, 3)), np.zeros((4, 4, 4)))
    with pytest.raises(ValueError, match="at least 3 px"):
        ssim(np.zeros((2, 9, 3)), np.zeros((2, 9, 3)))
