# SPDX-License-Identifier: Apache-2.0
"""Adam against the textbook's formula, rows of different ages, and the learning rates' courses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from livecl.training.adam import Adam, decayed, settling


def _textbook(gradients: Sequence[float], rates: Sequence[float]) -> list[float]:
    """Changes of one number, Algorithm 1 of Kingma and Ba (2015), as it stands there."""
    beta1, beta2, epsilon = 0.9, 0.999, 1e-8
    m = v = 0.0
    changes = []
    for t, (g, rate) in enumerate(zip(gradients, rates, strict=True), start=1):
        m = beta1 * m + (1 - beta1) * g
        v = beta2 * v + (1 - beta2) * g**2
        m_hat = m / (1 - beta1**t)
        v_hat = v / (1 - beta2**t)
        changes.append(-rate * m_hat / (math.sqrt(v_hat) + epsilon))
    return changes


def test_follows_the_textbook() -> None:
    # Each change is a few dozen operations from the gradients, in another order than the formula's; the averages lose
    # relative precision by cancellation only where gradients of both signs nearly cancel, hence the absolute part.
    rng = np.random.default_rng(0)
    gradients = rng.normal(size=(40, 5, 3, 2)) * 10.0 ** rng.integers(-6, 3, size=(5, 3, 2))
    rates = rng.uniform(0.01, 2, size=40)
    adam = Adam.start((5, 3, 2))
    found = np.array([adam.step(gradient, rate) for gradient, rate in zip(gradients, rates, strict=True)])
    for index in np.ndindex(5, 3, 2):
        expected = _textbook(gradients[(slice(None), *index)].tolist(), rates.tolist())
        np.testing.assert_allclose(found[(slice(None), *index)], expected, rtol=1e-10, atol=1e-13)


def test_first_step_is_the_learning_rate_against_the_gradient() -> None:
    gradient = np.array([[3.0, -0.2], [1e-3, 40.0]])
    np.testing.assert_allclose(Adam.start((2, 2)).step(gradient, 0.5), -0.5 * np.sign(gradient), rtol=2e-5)


def test_a_tiny_gradient_is_damped_by_epsilon_as_in_the_textbook() -> None:
    # Where |g| is about 1e-8, epsilon matters, and an implementation that adds it before the correction differs.
    gradients, adam = [2e-8, -1e-8, 3e-9], Adam.start((1, 1))
    found = [float(adam.step(np.array([[g]]), 1.0)[0, 0]) for g in gradients]
    np.testing.assert_allclose(found, _textbook(gradients, [1.0] * 3), rtol=1e-12)


def test_no_gradient_no_change() -> None:
    adam = Adam.start((3, 4))
    for _ in range(3):
        assert np.array_equal(adam.step(np.zeros((3, 4)), 1.0), np.zeros((3, 4)))


def test_rows_of_different_ages_are_corrected_each_by_its_own() -> None:
    rng = np.random.default_rng(1)
    gradients, adam = rng.normal(size=(30, 6, 2)), Adam.start((2, 2))
    joined = [0, 0, 7, 7, 7, 20]
    found = np.full((30, 6, 2), np.nan)
    for t in range(30):
        if t == 7:
            adam.extend(3)
        if t == 20:
            adam.extend(1)
        rows = len(adam.ages)
        found[t, :rows] = adam.step(gradients[t, :rows], 0.3)
    assert adam.ages.tolist() == [30, 30, 23, 23, 23, 10]
    for row, first in enumerate(joined):
        assert np.isnan(found[:first, row]).all()
        for column in range(2):
            expected = _textbook(gradients[first:, row, column].tolist(), [0.3] * (30 - first))
            np.testing.assert_allclose(found[first:, row, column], expected, rtol=1e-10, atol=1e-13)


def test_learning_rate_of_each_row() -> None:
    gradient = np.random.default_rng(2).normal(size=(4, 3, 2))
    rates = np.array([0.0, 0.1, 1.0, 2.5])
    together = Adam.start((4, 3, 2)).step(gradient, rates)
    for row, rate in enumerate(rates):
        assert np.array_equal(together[row], Adam.start((1, 3, 2)).step(gradient[row : row + 1], float(rate))[0])


def test_the_gradient_is_left_as_it_was() -> None:
    gradient = np.ones((2, 2))
    Adam.start((2, 2)).step(gradient, 1.0)
    assert np.array_equal(gradient, np.ones((2, 2)))


@pytest.mark.parametrize("rows", [[2, 0], np.array([True, False, True]), slice(1, None), slice(None)])
def test_subset_is_a_copy_of_the_rows(rows: object) -> None:
    adam = Adam.start((3, 2))
    adam.step(np.arange(6.0).reshape(3, 2), 1.0)
    adam.ages[:] = [5, 6, 7]
    part = adam.subset(rows)
    for name in ("mean", "square", "ages"):
        assert np.array_equal(getattr(part, name), getattr(adam, name)[rows])
    before = adam.mean.copy(), adam.square.copy(), adam.ages.copy()
    part.step(np.ones_like(part.mean), 1.0)
    assert all(np.array_equal(a, b) for a, b in zip(before, (adam.mean, adam.square, adam.ages), strict=True))


def test_decay_is_piecewise_linear_in_the_age() -> None:
    # By the factor 0.4 after each 500 steps, straight lines between.
    knots = np.arange(5)
    np.testing.assert_allclose(decayed(500 * knots, 0.4, 500), 0.4**knots, rtol=1e-14)
    ages = np.arange(2001)
    np.testing.assert_allclose(decayed(ages, 0.4, 500), np.interp(ages, 500 * knots, 0.4**knots), rtol=1e-13)
    np.testing.assert_allclose(decayed(np.array([250, 750]), 0.4, 500), [0.7, 0.28], rtol=1e-14)


def test_no_decay_by_the_factor_1() -> None:
    assert np.array_equal(decayed(np.array([0, 1, 499, 500, 12345]), 1.0, 500), np.ones(5))


def test_settling_falls_in_the_second_half_of_a_stage() -> None:
    assert [settling(p, 0.1) for p in (0.0, 0.25, 0.5)] == [1, 1, 1]
    assert settling(0.75, 0.1) == pytest.approx(0.55, rel=1e-14)
    assert settling(1.0, 0.1) == pytest.approx(0.1, rel=1e-14)
    assert [settling(p, 1.0) for p in (0.0, 0.6, 1.0)] == [1, 1, 1]
    shares = [settling(p, 0.0) for p in np.linspace(0.5, 1, 11)]
    np.testing.assert_allclose(np.diff(shares), -0.1, rtol=1e-12)
