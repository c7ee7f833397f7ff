# SPDX-License-Identifier: Apache-2.0
"""Drift of colour: gradients drift, flat colours with edges between them do not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.drift import Changes

EVERYWHERE = np.ones((40, 40), bool)
RAMP = np.tile(np.round(np.linspace(0.2, 0.7, 40) * 255)[:, None, None] / 255, (1, 40, 3))
SLOW = np.tile(np.round(np.linspace(0.5, 0.52, 40) * 255)[:, None, None] / 255, (1, 40, 3))


def steps() -> NDArray[np.float64]:
    """Return stripes of two colours, 4 px wide, with an antialiased row between."""
    image = np.full((40, 40, 3), 0.3)
    image[(np.arange(40) // 4) % 2 == 0] = 0.8
    image[::8] = 0.55
    return image


def flat_with_an_edge() -> NDArray[np.float64]:
    """Return one colour but for an edge pixel at its border."""
    image = np.full((40, 40, 3), 0.3)
    image[0, 20] = 0.5
    return image


def half_a_ramp() -> NDArray[np.float64]:
    """Return one colour that a ramp begins at: a gradient whose stops lie within the layer."""
    image = np.full((40, 40, 3), RAMP[0, 0, 0])
    image[26:] = RAMP[:14]
    return image


@pytest.mark.parametrize(
    ("image", "drifts"),
    [(RAMP, True), (SLOW, True), (half_a_ramp(), True), (steps(), False), (flat_with_an_edge(), False)],
    ids=["ramp", "slow ramp", "half a ramp", "steps", "flat with an edge"],
)
def test_what_drifts(image: NDArray[np.float64], drifts: bool) -> None:
    assert Changes.of(image).drift(EVERYWHERE) == drifts


def test_edges_to_other_pixels_do_not_count() -> None:
    image = np.full((40, 40, 3), 0.9)
    own = np.zeros((40, 40), bool)
    own[8:32, 8:32] = True
    image[own] = half_a_ramp()[own]
    assert Changes.of(image).drift(own)
    image[own] = 0.3
    assert not Changes.of(image).drift(own)
