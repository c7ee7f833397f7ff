# SPDX-License-Identifier: Apache-2.0
"""Polylines: lengths, places along them, equal steps, directions."""

from __future__ import annotations

import numpy as np

from livecl.geometry.polylines import evenly, lengths_along, points_at, unit

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
