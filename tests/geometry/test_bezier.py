# SPDX-License-Identifier: Apache-2.0
"""Vectors in the plane by known values: cross products, where lines meet."""

from __future__ import annotations

import numpy as np

from livecl.geometry.bezier import cross, meeting_point


def test_cross_is_the_area_between_two_vectors_positive_from_x_to_y() -> None:
    a, b = np.array([[2.0, 0], [0, 3], [1, 1]]), np.array([[0.0, 3], [2, 0], [-2, -2]])
    np.testing.assert_array_equal(cross(a, b), [6, -6, 0])


def test_lines_meet_wherever_their_points_and_however_long_their_directions() -> None:
    p, u = np.array([[1.0, 5], [-3, 5]]), np.array([[2.0, 0], [-7, 0]])
    q, v = np.array([[4.0, 0], [4, 9]]), np.array([[0.0, 1], [0, -3]])
    np.testing.assert_allclose(meeting_point(p, u, q, v), [[4, 5], [4, 5]])
    assert not np.isfinite(meeting_point(p[0], u[0], q[0], u[1])).any()  # parallel
