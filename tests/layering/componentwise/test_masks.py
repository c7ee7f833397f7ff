# SPDX-License-Identifier: Apache-2.0
"""Regions as masks: holes, the connected part, the convex hull."""

import numpy as np
from scipy.ndimage import binary_fill_holes
from skimage.morphology import convex_hull_image

from livecl.layering.componentwise.masks import connected_part, convex_hull, filled_and_holes, holes, without_holes


def test_holes_and_what_they_fill_are_those_of_scipy():
    """Of random masks: a hole is closed by its sides, not its corners; a filled region is the region and its holes."""
    rng = np.random.default_rng(0)
    for share in (0.4, 0.6, 0.8):
        for _ in range(40):
            mask = rng.random(tuple(rng.integers(1, 40, 2))) < share
            filled, inner = filled_and_holes(mask, 1)
            np.testing.assert_array_equal(filled, binary_fill_holes(mask))
            np.testing.assert_array_equal(filled, np.logical_or.reduce([mask, *inner]))
            areas = [int(hole.sum()) for hole in inner]
            assert areas == sorted(areas, reverse=True) and all(
                np.array_equal(h, connected_part(h, tuple(np.argwhere(h)[0]))) for h in inner
            )
            np.testing.assert_array_equal(without_holes(mask), filled)
            assert [int(hole.sum()) for hole in holes(mask, 2)] == [area for area in areas if area >= 2]


def test_pixels_that_touch_at_corners_are_not_connected():
    mask = np.array([[1, 1, 0, 0], [0, 1, 0, 1], [0, 0, 1, 1]], bool)
    assert connected_part(mask, (0, 0)).tolist() == [[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]]


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
