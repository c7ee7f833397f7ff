# SPDX-License-Identifier: Apache-2.0
"""Circles and ellipses through points on a part of them."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.layering.outlines.primitives import FARTHEST, fitted_primitive


def arc(axes: tuple[float, float], start: float, end: float, turn: float = 0.0) -> np.ndarray:
    at = np.linspace(start, end, max(16, int((end - start) * max(axes))))
    x, y = axes[0] * np.cos(at), axes[1] * np.sin(at)
    return np.stack([50 + x * np.cos(turn) - y * np.sin(turn), 40 + x * np.sin(turn) + y * np.cos(turn)], axis=1)


@pytest.mark.parametrize("angle", [1.2, 2.5, 5.0])
def test_a_circle_is_known_by_a_part(angle: float) -> None:
    found = fitted_primitive(arc((30, 30), 0.3, 0.3 + angle))
    assert found is not None
    np.testing.assert_allclose(np.hypot(*(found - (50, 40)).T), 30, atol=1e-6)
    assert np.hypot(*np.diff(found, axis=0).T) == pytest.approx(1, abs=0.01)


def test_an_ellipse_is_known_by_more() -> None:
    found = fitted_primitive(arc((40, 20), 0, 4, 0.5))
    assert found is not None
    whole = arc((40, 20), 0, 2 * np.pi, 0.5)
    assert np.hypot(*(found[:, None] - whole[None]).transpose(2, 0, 1)).min(axis=1).max() < 0.6  # half a step
    assert fitted_primitive(arc((40, 20), 0, 2, 0.5)) is None


def test_what_is_neither_fits_none() -> None:
    square = np.array([(x, y) for x in range(20) for y in (0, 19)] + [(x, y) for y in range(20) for x in (0, 19)])
    assert fitted_primitive(square.astype(float)) is None
    line = np.stack([np.arange(40.0), 0.02 * np.arange(40.0)], axis=1)
    assert fitted_primitive(line) is None
    assert fitted_primitive(arc((30, 30), 0, 2)[:6]) is None


def test_points_on_slanted_lines_fit_none() -> None:
    # Of some in a thousand such lines the conic found is exactly singular.
    rng = np.random.default_rng(0)
    for count in range(12, 200):
        for turn in rng.uniform(0, np.pi, 10):
            along = np.arange(count)[:, None] * (np.cos(turn), np.sin(turn))
            assert fitted_primitive(rng.uniform(0, 250, 2) + along) is None


@pytest.mark.parametrize("at", [(90.0, 40.0), (50.0, 60.0)])
def test_no_point_of_an_ellipse_may_lie_farther_off_than_the_limit(at: tuple[float, float]) -> None:
    """One of 160 points, at an end of an axis, moves outwards; the fit follows by little."""
    for share, fits in ((0.85, True), (1.2, False)):
        points = arc((40, 20), 0, 2 * np.pi)[:-1]
        index = int(np.hypot(*(points - at).T).argmin())
        outward = (points[index] - (50, 40)) / np.hypot(*(points[index] - (50, 40)))
        points[index] += share * FARTHEST * outward
        assert (fitted_primitive(points) is not None) == fits
