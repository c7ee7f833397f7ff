# SPDX-License-Identifier: Apache-2.0
"""Paths along polylines: their price, the way round, and the rest of loops."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.geometry import refinement
from livecl.geometry.bezier import signed_area
from livecl.geometry.corners import find_corners, noise_of
from livecl.geometry.crossings import CROSSING_AREA, crossing_area
from livecl.geometry.ellipses import ellipses_of
from livecl.geometry.tracing import TracingPrices, traced_path

FloatArray = NDArray[np.float64]


def blob(count: int = 180, waves: int = 5, depth: float = 3.0) -> FloatArray:
    """A smooth closed polyline at steps of about 1 px."""
    angles = 2 * np.pi * np.arange(count) / count
    radii = 26 + depth * np.cos(waves * angles)
    return np.asarray(40 + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def cubics_of(path: FloatArray) -> FloatArray:
    return np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)


def test_cheaper_segments_are_more() -> None:
    counts = [len(traced_path(blob(), 0.0, TracingPrices(segment=price))) for price in (1e-3, 0.05, 2.0, 2e4)]
    assert counts == sorted(counts, reverse=True) and counts[0] > counts[-1]
    assert counts[-1] == 4  # an ellipse is the simplest of all


def test_noise_raises_the_price_of_segments() -> None:
    noisy = blob() + 0.2 * np.random.default_rng(5).normal(size=(180, 2))
    priced, unpriced = (len(traced_path(noisy, 0.2, TracingPrices(noise=noise))) for noise in (12.0, 0.0))
    assert priced <= len(traced_path(blob(), 0.0)) < unpriced


def test_paths_run_the_way_of_the_polyline_and_keep_its_area() -> None:
    for points in (blob(), blob(depth=0.0)):  # the second is a circle
        area = signed_area(cubics_of(traced_path(points, 0.0)))
        assert area > 0
        assert signed_area(cubics_of(traced_path(points[::-1], 0.0))) == pytest.approx(-area, rel=2e-3)
        assert area == pytest.approx(np.pi * (26**2 + np.ptp(np.hypot(*(points - 40).T)) ** 2 / 8), rel=5e-3)


def test_the_same_polyline_gives_the_same_path_anywhere() -> None:
    points = blob() + np.stack([np.linspace(0, 1, 180) ** 2, np.zeros(180)], axis=1)  # no two bends alike
    path, shift = traced_path(points, 0.01), np.array((100.0, -50.0))
    assert np.array_equal(path, traced_path(points, 0.01))
    moved = traced_path(points + shift, 0.01) - shift  # rounding decides where a closed path begins
    begins = int(np.argmin(np.hypot(*(moved[:, 0] - path[0, 0]).T)))
    np.testing.assert_allclose(np.roll(moved, -begins, axis=0), path, atol=1e-6)


def test_a_polyline_that_crosses_itself_becomes_a_path_that_does_not() -> None:
    angles = 2 * np.pi * np.arange(200) / 200
    eight = np.stack([40 + 30 * np.cos(angles), 40 + 12 * np.sin(2 * angles) + 6 * np.sin(angles)], axis=1)
    assert crossing_area(cubics_of(np.stack([eight, eight, eight], axis=1))) > CROSSING_AREA
    assert crossing_area(cubics_of(traced_path(eight, 0.0))) <= CROSSING_AREA


@pytest.mark.parametrize("count", [5, 8, 12])
def test_the_smallest_polylines_are_circles(count: int) -> None:
    angles = 2 * np.pi * np.arange(count) / count
    points = 5 + 0.8 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    path = traced_path(points, 0.0)
    area = count / 2 * 0.64 * np.sin(2 * np.pi / count)
    assert len(path) == 4 and signed_area(cubics_of(path)) == pytest.approx(area, rel=1e-3)


def test_noise_at_long_waves_counts_neighbours_that_deviate_alike() -> None:
    angles = 2 * np.pi * np.arange(1600) / 1600
    circle = 1600 / (2 * np.pi) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    random = np.random.default_rng(2).normal(size=1600)
    alone, together = 0.1 * random, 0.1 * np.repeat(random[:400], 4)
    noisy = [circle * (1 + deviation / 255)[:, None] for deviation in (alone, together)]
    # 400 third differences, neighbours correlated: the median is right to about a tenth.
    assert noise_of(noisy[:1], 4) == pytest.approx(0.1, rel=0.2)
    # Four neighbours that deviate alike are one number: its variance counts four times.
    assert noise_of(noisy[1:], 4) == pytest.approx(0.2, rel=0.2)
    assert noise_of(noisy[1:]) < 0.08
    wavy = noisy[1] * (1 + 0.1 * np.sin(3 * angles))[:, None]
    paths = [len(traced_path(wavy, noise_of([wavy]), waves=waves)) for waves in (0.0, noise_of([wavy], 4))]
    assert paths[1] < paths[0]


def test_noise_is_measured_beside_corners() -> None:
    side = np.linspace(0, 40, 40, endpoint=False)
    zero, full = np.zeros(40), np.full(40, 40.0)
    corners = np.stack(
        [np.concatenate([side, full, 40 - side, zero]), np.concatenate([zero, side, full, 40 - side])], axis=1
    )
    assert noise_of([corners]) == pytest.approx(0, abs=1e-12)
    noisy = corners + 0.1 * np.random.default_rng(2).normal(size=corners.shape)
    assert noise_of([noisy]) == pytest.approx(0.1, rel=0.3)
    assert noise_of([]) == 0
    assert len(find_corners(corners, 0.0).corners) == 4
    assert len(find_corners(noisy, 0.1).corners) == 4


def test_moments_give_back_an_ellipse() -> None:
    angles = 2 * np.pi * np.arange(4000) / 4000
    axes = np.array([(12.0, 9.0), (-3.0, 4.0)])
    points = (7, -2) + np.cos(angles)[:, None] * axes[0] + np.sin(angles)[:, None] * axes[1]
    found = ellipses_of(points)[0]
    np.testing.assert_allclose(found.center, (7, -2), atol=1e-9)
    np.testing.assert_allclose(np.abs(found.axes), np.abs(axes), rtol=1e-5)
    np.testing.assert_allclose(found.distances(points), 0, atol=1e-4)
    assert signed_area(found.cubics()) == pytest.approx(np.pi * 15 * 5, rel=1e-3)
    assert signed_area(ellipses_of(points[::-1])[0].cubics()) < 0


def test_many_unknowns_are_solved_as_few_are(monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.linspace(0, 2 * np.pi, 1200, endpoint=False)
    radius = 240 * (1 + 0.12 * np.sin(20 * t))
    points = radius[:, None] * np.stack([np.cos(t), np.sin(t)], axis=1)
    paths = []
    for many in (0, 10**6):
        monkeypatch.setattr(refinement, "MANY", many)
        paths.append(traced_path(points, 0.1))

    assert len(paths[0]) > 40
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-6)
