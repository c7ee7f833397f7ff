# SPDX-License-Identifier: Apache-2.0
"""Polylines: lengths, places along them, equal steps, directions."""

from __future__ import annotations

import numpy as np
import pytest
from skimage.draw import polygon2mask

from livecl.geometry.polylines import evenly, lengths_along, points_at, polygon_mask, unit

#: An open polyline of sides of 5, 0 and 2 px, and a square of 8 px with needless corners.
BENT = np.array([(0, 0), (3, 4), (3, 4), (3, 6)], float)
SQUARE = np.array([(0, 0), (1, 0), (8, 0), (8, 8), (5, 8), (0, 8)], float)


def test_lengths_and_places_along_a_polyline() -> None:
    lengths = lengths_along(BENT)
    np.testing.assert_allclose(lengths, [0, 5, 5, 7])
    places = points_at(np.array([0, 2.5, 5, 6, 7]), BENT, lengths)
    np.testing.assert_allclose(places, [(0, 0), (1.5, 2), (3, 4), (3, 5), (3, 6)])


def test_equal_steps_begin_at_the_first_point_and_close_the_outline() -> None:
    np.testing.assert_allclose(evenly(SQUARE, 4), [(0, 0), (8, 0), (8, 8), (0, 8)])
    points = evenly(SQUARE)
    assert len(points) == 32, "a step of 1 px each"
    np.testing.assert_allclose(np.hypot(*(np.roll(points, -1, axis=0) - points).T), 1)
    assert len(evenly(SQUARE / 100)) == 8


def test_unit_vectors_of_any_shape_and_of_zero() -> None:
    np.testing.assert_allclose(unit(np.array([[(3, 4), (0, 0)]], float)), [[(0.6, 0.8), (0, 0)]])
    np.testing.assert_allclose(unit(np.array((0.0, -2e-200))), (0, -1))


@pytest.mark.parametrize("count", [3, 4, 7, 40, 300])
def test_pixels_within_a_polygon_are_those_of_another_library(count: int) -> None:
    # Points beyond the page, and outlines that cross themselves, by the even-odd rule; no centre lies on an edge.
    rng = np.random.default_rng(count)
    for _ in range(20):
        points = rng.uniform(-8, 32, (count, 2))
        assert np.array_equal(polygon_mask(points, (24, 31)), polygon2mask((24, 31), points[:, ::-1] - 0.5))


def test_pixels_within_a_polygon_through_their_centres() -> None:
    # A square between centres; its left and upper side belong to it, so that two that touch share no pixel.
    square = np.array([(1, 1), (3, 1), (3, 3), (1, 3)]) + 0.5
    mask = polygon_mask(square, (5, 5))
    assert np.argwhere(mask).tolist() == [[1, 1], [1, 2], [2, 1], [2, 2]]
    assert np.array_equal(polygon_mask(square[::-1], (5, 5)), mask)
    # The lowest vertex of a triangle, and one where its outline goes on, lie on the middle of a row.
    triangle = np.array([(0.5, 0.5), (4.6, 2.5), (0.5, 4.5)])
    assert polygon_mask(triangle, (5, 5)).sum(axis=1).tolist() == [0, 3, 5, 3, 0]
    assert not polygon_mask(np.array([(2.0, 2.0), (4.0, 2.0)]), (5, 5)).any()
