# SPDX-License-Identifier: Apache-2.0
"""Offsets of outlines: exact for circles and polygons; segments that vanish are left out."""

from __future__ import annotations

import numpy as np
from support.line_art import arc, polygon
from support.outlined_drawings import rounded

from livecl.geometry.offsetting import offset_outline


def test_a_circle_grows_and_shrinks_by_the_distance() -> None:
    circle = arc(50, 40, 20)[0]

    for distance in (5.0, -5.0):
        found = offset_outline(circle, distance)
        assert found is not None
        np.testing.assert_allclose(found, arc(50, 40, 20 + distance)[0], atol=1e-9)


def test_corners_stay_corners_and_lines_lines() -> None:
    found = offset_outline(polygon((10, 10), (50, 10), (50, 30), (30, 20), (10, 30))[0], 2)

    assert found is not None
    np.testing.assert_allclose(found[:3, 0], [(8, 8), (52, 8), (52, 30 + 2 * np.sqrt(5) / 2 + 1)], atol=1e-9)
    thirds = found[:, 0] + (np.roll(found[:, 0], -1, axis=0) - found[:, 0]) / 3
    np.testing.assert_allclose(found[:, 1], thirds, atol=1e-9)


def test_arcs_that_the_offset_turns_round_are_left_out() -> None:
    found = offset_outline(rounded(10, 10, 60, 40, 3), -4)

    assert found is not None
    np.testing.assert_allclose(found[:, 0], [(14, 14), (66, 14), (66, 46), (14, 46)], atol=1e-9)


def test_short_segments_are_left_out_where_asked() -> None:
    blunt = polygon((10, 10), (50, 10), (50, 30), (30.5, 49.5), (29.5, 49.5), (10, 30))[0]

    pointed = offset_outline(blunt, 0, 2)

    assert pointed is not None
    np.testing.assert_allclose(pointed[3, 0], (30, 50), atol=1e-9)


def test_nothing_is_left_of_a_shape_that_is_too_thin() -> None:
    assert offset_outline(polygon((10, 10), (50, 10), (50, 14), (10, 14))[0], -5) is None
