# SPDX-License-Identifier: Apache-2.0
"""Mixtures of two cores by known values."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.layering.segmentation.mixtures import Mixture, explain


def explained(values: list[float], labels: list[int], colors: list[float]) -> Mixture:
    """Explain a row of grey pixels; `colors` are those of the cores from 1 on."""
    image = np.array(values)[None, :, None]
    return explain(image, np.array(labels)[None], np.array([0.0, *colors])[:, None])


def test_a_pixel_between_two_cores_is_their_mixture() -> None:
    mixture = explained([0, 0, 0.25, 1, 1], [1, 1, 0, 2, 2], [0, 1])
    assert (mixture.rows.tolist(), mixture.columns.tolist()) == ([0], [2])
    assert (mixture.first[0], mixture.second[0]) == (1, 2)
    assert mixture.share[0] == pytest.approx(0.75) and mixture.miss[0] == pytest.approx(0)


def test_what_no_mixture_is_misses_the_nearest_by_the_rest() -> None:
    mixture = explained([0.2, 0.2, 0.9, 0.6, 0.6], [1, 1, 0, 2, 2], [0.2, 0.6])
    assert mixture.miss[0] == pytest.approx(0.3)
    assert (mixture.second[0], mixture.share[0]) == (2, 0)


def test_of_cores_that_explain_as_well_the_nearer_ones_are_taken() -> None:
    """A miss of a quarter of a level is less than what a pixel of distance counts."""
    mixture = explained([0, 0, 0.25, 0.249, 0.5], [3, 1, 0, 2, 4], [0, 0.249, 0, 0.5])
    assert {int(mixture.first[0]), int(mixture.second[0])} <= {1, 2}
    assert mixture.miss[0] == pytest.approx(0.001)


def test_a_pixel_beside_one_core_is_all_of_it_and_one_beside_none_is_unexplained() -> None:
    mixture = explained([0.5, 0.4, 0.5, 0.5, 0.9], [1, 0, 0, 0, 0], [0.5])
    near, far = mixture.columns <= 2, mixture.columns > 2
    assert (mixture.first[near] == 1).all() and (mixture.share == 1).all()
    np.testing.assert_allclose(mixture.miss[near], [0.1, 0])
    assert (mixture.first[far] == 0).all() and np.isinf(mixture.miss[far]).all()
