# SPDX-License-Identifier: Apache-2.0
"""Xing loss, eq. (3) and (4): value against the reference, gradient against differences."""

from __future__ import annotations

import numpy as np
import pytest
from reference import xing

from livecl.training.xing import xing_loss

#: One segment for each branch: D1 = 1 and 0, each with ReLU open and closed.
BRANCHES = {
    "right turn, CD against it": [(0, 0), (2, 0.1), (2.5, 2), (1, 0.3)],
    "right turn, CD with it": [(0, 0), (2, 0.1), (2.5, 2), (0.4, 3)],
    "left turn, CD against it": [(0, 0), (2, 0.1), (2.5, -2), (4, 1)],
    "left turn, CD with it": [(0, 0), (2, 0.1), (2.5, -2), (0.4, -3)],
}


def _differences(cubics: np.ndarray, step: float = 1e-6) -> np.ndarray:
    slopes = np.zeros_like(cubics)
    for entry in np.ndindex(cubics.shape):
        values = []
        for sign in (1, -1):
            moved = cubics.copy()
            moved[entry] += sign * step
            values.append(xing.xing_loss(moved))
        slopes[entry] = (values[0] - values[1]) / (2 * step)
    return slopes


@pytest.mark.parametrize("name", BRANCHES)
def test_each_branch(name: str) -> None:
    cubics = np.array([BRANCHES[name]], dtype=np.float64)
    value, d_cubics = xing_loss(cubics)
    assert (value > 0) == ("against" in name)
    assert value == pytest.approx(xing.xing_loss(cubics), abs=1e-15)
    np.testing.assert_allclose(d_cubics, _differences(cubics), atol=1e-9)
    assert d_cubics.any() == ("against" in name)


def test_many_segments() -> None:
    cubics = np.random.default_rng(0).normal(scale=5, size=(200, 4, 2)) + 30
    value, d_cubics = xing_loss(cubics)
    assert value == pytest.approx(xing.xing_loss(cubics), rel=1e-13)
    assert d_cubics.shape == (200, 4, 2)
    expected = _differences(cubics)
    np.testing.assert_allclose(d_cubics, expected, atol=1e-6 * np.linalg.norm(expected))


def test_is_the_mean_over_segments() -> None:
    cubics = np.array([BRANCHES["right turn, CD against it"], BRANCHES["right turn, CD with it"]], dtype=np.float64)
    value, d_cubics = xing_loss(cubics)
    alone, d_alone = xing_loss(cubics[:1])
    assert value == pytest.approx(alone / 2)
    np.testing.assert_allclose(d_cubics, np.concatenate([d_alone / 2, np.zeros((1, 4, 2))]), atol=1e-15)


def test_straight_on_counts_as_no_right_turn() -> None:
    cubics = np.array([[(0, 0), (1, 0), (2, 0), (3, 1)]], dtype=np.float64)
    value, d_cubics = xing_loss(cubics)
    assert value == pytest.approx(np.sqrt(0.5))
    # D1 = 0 is held constant: the derivative of sin(AB, CD) alone, by cos(45 degrees) of the angle's.
    quarter = np.sqrt(0.5)
    np.testing.assert_allclose(
        d_cubics[0], [(0, quarter), (0, -quarter), (quarter / 2, -quarter / 2), (-quarter / 2, quarter / 2)]
    )


@pytest.mark.parametrize("short", ["AB", "CD", "both"])
@pytest.mark.parametrize("length", [0.0, 9.9e-4])
def test_no_direction_no_loss(short: str, length: float) -> None:
    a, b, c, d = np.array(BRANCHES["right turn, CD against it"], dtype=np.float64)
    if short != "CD":
        b = a + np.array((length, 0))
    if short != "AB":
        d = c - np.array((0, length))
    value, d_cubics = xing_loss(np.array([[a, b, c, d]]))
    assert value == 0
    assert not d_cubics.any()


def test_just_long_enough() -> None:
    a, _, c, d = np.array(BRANCHES["right turn, CD against it"], dtype=np.float64)
    cubics = np.array([[a, a + np.array((1.01e-3, 0)), c, d]])
    value, d_cubics = xing_loss(cubics)
    assert value == pytest.approx(xing.xing_loss(cubics), rel=1e-12)
    assert value > 0
    assert np.all(np.isfinite(d_cubics))


def test_no_segments() -> None:
    value, d_cubics = xing_loss(np.zeros((0, 4, 2)))
    assert value == 0
    assert d_cubics.shape == (0, 4, 2)


def test_does_not_depend_on_place_size_or_turn() -> None:
    cubics = np.random.default_rng(1).normal(scale=5, size=(50, 4, 2))
    value, _ = xing_loss(cubics)
    turn = np.array([[np.cos(1), np.sin(1)], [-np.sin(1), np.cos(1)]])
    assert xing_loss(3 * cubics @ turn + np.array((7, -9)))[0] == pytest.approx(value, rel=1e-12)


def test_mirror_image_has_the_same_loss() -> None:
    cubics = np.random.default_rng(2).normal(scale=5, size=(50, 4, 2))
    assert xing_loss(cubics * (1, -1))[0] == pytest.approx(xing_loss(cubics)[0], rel=1e-12)


def test_untangles() -> None:
    # Down the gradient, a crossed segment loses its crossing: the loss falls to 0 and stays.
    cubics = np.array([BRANCHES["right turn, CD against it"]], dtype=np.float64)
    for _ in range(200):
        value, d_cubics = xing_loss(cubics)
        cubics = cubics - 0.1 * d_cubics
    assert value < 1e-2
