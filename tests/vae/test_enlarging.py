# SPDX-License-Identifier: Apache-2.0
"""Enlarged pictures: flat ones stay, edges keep their place and their slope."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.vae.enlarging import LIMIT, enlarge

#: What cutting off the logits costs: the grey level of the last logit kept, twice, for the stretch back to [0, 1].
CUT_OFF = 2 * np.exp(-LIMIT)


def test_flat_pictures_stay() -> None:
    grey = np.linspace(0, 1, 5)
    larger = enlarge(np.broadcast_to(grey[:, None, None], (5, 4, 4)), 9)
    assert larger.shape == (5, 9, 9)
    np.testing.assert_allclose(larger, np.broadcast_to(grey[:, None, None], (5, 9, 9)), rtol=0, atol=CUT_OFF)
    # Exact but for rounding where nothing is between: a few eps.
    np.testing.assert_allclose(larger[[0, 4]], np.stack([np.zeros((9, 9)), np.ones((9, 9))]), rtol=0, atol=1e-14)


def test_edge_keeps_place_and_slope() -> None:
    # Logits 1.5 (x - 3.25) across 8 px; a spline through points of a line is the line, away from where it is cut off.
    across = np.arange(8) + 0.5
    larger = enlarge(np.tile(1 / (1 + np.exp(-1.5 * (across - 3.25))), (1, 8, 1)), 64)[0, 32]
    x = (np.arange(64) + 0.5) / 8
    expected = 1 / (1 + np.exp(-1.5 * (x - 3.25)))
    near = np.abs(x - 3.25) < 1.5
    np.testing.assert_allclose(larger[near], expected[near], rtol=0, atol=CUT_OFF)


def test_stays_within_range() -> None:
    larger = enlarge(np.random.default_rng(0).integers(0, 2, size=(3, 6, 6)), 50)
    assert larger.min() == 0
    assert larger.max() == 1


def test_bad_arguments() -> None:
    with pytest.raises(ValueError, match=r"pictures: shape \(28, 28\), wanted \(B, H, W\)"):
        enlarge(np.zeros((28, 28)), 50)
    with pytest.raises(ValueError, match="size: got 0, wanted at least 1"):
        enlarge(np.zeros((1, 28, 28)), 0)
