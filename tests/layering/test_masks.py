# SPDX-License-Identifier: Apache-2.0
"""Regions as masks: the convex hull."""

import numpy as np
from skimage.morphology import convex_hull_image

from livecl.layering.masks import convex_hull


def test_the_hull_of_three_corners_is_their_triangle_with_its_border():
    mask = np.zeros((5, 5), bool)
    mask[0, 0] = mask[4, 0] = mask[4, 4] = True
    np.testing.assert_array_equal(convex_hull(mask), np.tri(5, dtype=bool))


def test_nothing_has_no_hull_and_a_pixel_is_its_own():
    mask = np.zeros((4, 6), bool)
    assert not convex_hull(mask).any()
    mask[3, 5] = True
    np.testing.assert_array_equal(convex_hull(mask), mask)


def test_hulls_are_those_of_scikit_image():
    rng = np.random.default_rng(0)
    for share in (0.01, 0.05, 0.3):
        for _ in range(60):
            mask = rng.random(tuple(rng.integers(1, 40, 2))) < share
            if mask.any():
                np.testing.assert_array_equal(convex_hull(mask), convex_hull_image(mask))
