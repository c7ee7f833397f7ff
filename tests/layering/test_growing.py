# SPDX-License-Identifier: Apache-2.0
"""Regions grown by their price: neighbours are joined where one colour for both costs less than a layer."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.growing import grown


def stripes(*widths_and_colors: tuple[int, float]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return labels (4, W) and colours (4, W, 1) of upright stripes."""
    widths, colors = zip(*widths_and_colors, strict=True)
    labels = np.tile(np.repeat(np.arange(len(widths)), widths), (4, 1))
    return labels, np.array(colors)[labels][..., None]


def test_two_regions_are_joined_from_their_price_on() -> None:
    """Of 8 and 24 pixels, .5 apart: 8 * 24 / 32 * .25 = 1.5."""
    labels, image = stripes((2, 0.0), (6, 0.5))
    below, above = grown(labels, image, [1.49, 1.51])
    np.testing.assert_array_equal(below, labels)
    assert not above.any()


def test_the_cheapest_neighbour_is_joined_first() -> None:
    labels, image = stripes((5, 0.0), (1, 0.4), (5, 1.0))
    (found,) = grown(labels, image, [1.0])
    np.testing.assert_array_equal(found[0], [0] * 6 + [1] * 5)


def test_many_join_one_in_a_round_and_the_largest_stays() -> None:
    rng = np.random.default_rng(2)
    labels = np.arange(60 * 60).reshape(60, 60)
    image = np.full((60, 60, 3), 0.5) + rng.uniform(-0.02, 0.02, (60, 60, 3))
    image[20:40, 20:40] += 0.3
    (found,) = grown(labels, image, [1.0])
    assert len(np.unique(found)) == 2
    assert (found[20:40, 20:40] == found[30, 30]).all() and (found == found[30, 30]).sum() == 400


@pytest.mark.parametrize("price", [1e-4, 1e-2, 0.1])
def test_no_two_neighbours_are_left_that_would_be_joined(price: float) -> None:
    rng = np.random.default_rng(3)
    image = rng.random((20, 20, 3)) * 0.2
    (found,) = grown(np.arange(400).reshape(20, 20), image, [price])
    count = found.max() + 1
    areas = np.bincount(found.ravel())
    means = np.stack([np.bincount(found.ravel(), image[..., c].ravel()) for c in range(3)], axis=1) / areas[:, None]
    touching = {(a, b) for a, b in zip(found[:, 1:].ravel(), found[:, :-1].ravel(), strict=True) if a != b}
    touching |= {(a, b) for a, b in zip(found[1:].ravel(), found[:-1].ravel(), strict=True) if a != b}
    assert count > 1
    for a, b in touching:
        rise = areas[a] * areas[b] / (areas[a] + areas[b]) * np.square(means[a] - means[b]).sum()
        assert rise >= price * (1 - 1e-9)
