# SPDX-License-Identifier: Apache-2.0
"""Segments along polylines and the cheapest path of them."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.geometry.bezier import evaluate
from livecl.geometry.least_path import SAMPLES, SHARES, SegmentPrices, Segments, Tangents, cheapest_way, fit_curves

PRICES = SegmentPrices(line=2.0, curve=6.0, straying=3.5, straight=0.3, tolerance=0.4)


def arc(radius: float, angle: float) -> np.ndarray:
    """Return the samples of an arc from the x axis on: (1, SAMPLES + 2)."""
    return radius * np.exp(1j * angle * SHARES)[None]


@pytest.mark.parametrize("given", [False, True])
def test_a_cubic_is_found_again(given: bool) -> None:
    """From samples at equal steps of length; with the tangents of its ends too, which it then keeps."""
    cubic = np.array([0, 20 + 10j, 30 + 12j, 50])
    dense = evaluate(np.stack([cubic.real, cubic.imag], axis=1), np.linspace(0, 1, 4000)) @ (1, 1j)
    lengths = np.concatenate([[0], np.cumsum(np.abs(np.diff(dense)))])
    points = np.interp(SHARES * lengths[-1], lengths, dense)[None]
    tangents = None
    if given:
        first, last = ((step / np.abs(step))[None] for step in (cubic[1] - cubic[0], cubic[3] - cubic[2]))
        tangents = Tangents(first, last, np.zeros((1, 2), bool))
    handles, distances = fit_curves(points, np.ones((1, SAMPLES)), tangents, rounds=6)
    assert distances.max() < 0.02
    np.testing.assert_allclose(handles[0], cubic[1:3], atol=0.8)
    if tangents is not None:
        assert abs(((handles[0, 0] - cubic[0]) * tangents.first.conj()).imag[0]) < 1e-9


def test_samples_without_weight_do_not_count() -> None:
    points = arc(40, 1.0)
    points[0, 5] += 3
    weights = np.ones((1, SAMPLES))
    weights[0, 4] = 0
    _, distances = fit_curves(points, weights)
    assert np.delete(distances[0], [3, 4, 5]).max() < 0.01 and distances[0, 4] > 1


def test_prices_are_numbers_and_squared_distance_by_length() -> None:
    """An arc of sagitta h strays from its chord by 8/15 h^2 in the mean; where it is too far, it is no line."""
    flat, bent = (Segments(arc(r, 20 / r), np.array([20.0])) for r in (200.0, 20.0))
    (line,), (curve,) = flat.costs(PRICES)
    sagitta = 200 * (1 - np.cos(0.05))
    assert line == pytest.approx(2 + 3.5 * 20 * 8 / 15 * sagitta**2, rel=0.02)
    assert curve == pytest.approx(6, abs=1e-3)
    (line,), (curve,) = bent.costs(PRICES)
    assert np.isinf(line) and curve == pytest.approx(6, abs=1e-2)
    dear = SegmentPrices(line=3.0, curve=8.0, straying=7.0)  # the same segments at other prices
    (line,), (curve,) = flat.costs(dear)
    assert line == pytest.approx(3 + 7 * 20 * 8 / 15 * sagitta**2, rel=0.02) and curve == pytest.approx(8, abs=1e-3)


def test_lines_may_move_at_corners_but_not_at_smooth_ends() -> None:
    points = (np.linspace(0, 30, SAMPLES + 2) + 0.1j * np.ones(SAMPLES + 2))[None]
    points[:, [0, -1]] -= 0.1j
    ones = np.ones((1, SAMPLES))
    costs = [
        Segments(points, np.array([30.0]), ones, tangents).costs(PRICES)[0][0]
        for free in ((True, True), (False, False))
        for tangents in [Tangents(*np.ones((2, 1), complex), np.array([free]))]
    ]
    assert costs[0] == pytest.approx(2, abs=1e-3) and costs[1] == pytest.approx(2 + 3.5 * 30 * 0.01, rel=0.02)


def test_the_cheapest_way_pays_for_joins() -> None:
    """Four places: lines are cheap, but two in a row cost; without that price all are lines."""
    lines, curves = np.full((4, 4), np.inf), np.full((4, 4), np.inf)
    lines[np.arange(3), np.arange(1, 4)] = 1.0
    curves[np.arange(3), np.arange(1, 4)] = 2.0
    curves[0, 3] = 6.5
    assert cheapest_way(lines, curves) == ([0, 1, 2, 3], [True, True, True], 3.0)
    joins = np.array([[0.0] * 4, [0.0] * 4, [5.0] * 4])
    assert cheapest_way(lines, curves, joins) == ([0, 1, 2, 3], [True, False, True], 4.0)
    assert cheapest_way(lines, curves, joins + 2) == ([0, 3], [False], 6.5)
    assert not np.isfinite(cheapest_way(np.full((2, 2), np.inf), np.full((2, 2), np.inf))[2])


def test_a_segment_without_extent_and_tangents_has_handles_at_its_place() -> None:
    points, free = np.full((1, SAMPLES + 2), 3 + 4j), np.zeros((1, 2), bool)
    none = np.zeros(1, complex)
    handles, distances = fit_curves(points, np.ones((1, SAMPLES)), Tangents(none, none, free))
    np.testing.assert_allclose(handles, 3 + 4j)
    np.testing.assert_allclose(distances, 0)
