# SPDX-License-Identifier: Apache-2.0
"""Flat regions by known values: mixtures of two cores, means, components, how flat a picture is."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.layering.segmentation.flat import (
    SMALLEST,
    Mixture,
    explain,
    flat_regions,
    flatness,
    grid_components,
    means_of,
)


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


def test_means_of_labels() -> None:
    labels = np.array([[0, 1, 1], [3, 3, 1]])
    image = np.arange(6.0).reshape(2, 3, 1)
    np.testing.assert_allclose(means_of(labels, image), [[0], [8 / 3], [0], [3.5]])


def test_components_are_joined_by_what_holds_between_neighbours() -> None:
    right, down = np.array([[True, False], [False, True]]), np.array([[False, False, True]])
    labels = grid_components(right, down)
    assert labels[0, 0] == labels[0, 1] and labels[1, 1] == labels[1, 2] == labels[0, 2]
    assert len(np.unique(labels)) == 3
    slanted = np.array([[True, False]]), np.zeros((1, 2), bool)  # down to the right, down to the left
    joined = grid_components(np.zeros((2, 2), bool), np.zeros((1, 3), bool), *slanted)
    assert joined[0, 0] == joined[1, 1] and len(np.unique(joined)) == 5


def test_flatness_tells_cores_from_slopes_and_noise() -> None:
    flat = np.ones((20, 30, 3))
    flat[:, 15:] = 0.2
    assert flatness(flat) == (1.0, 0.0, 2)
    ramp = np.broadcast_to(np.linspace(0, 0.3, 30)[:, None], (20, 30, 3))  # 2.6 levels a pixel
    assert flatness(ramp)[1] == pytest.approx(29 * 20 / (29 * 20 + 19 * 30))
    noise = np.random.default_rng(0).uniform(size=(20, 30, 3))
    assert flatness(noise)[0] < 0.1


@pytest.mark.parametrize("share", [0.3, 0.8])
def test_mixed_pixels_belong_to_the_core_that_most_of_them_is(share: float) -> None:
    image = np.zeros((10, 21, 3))
    image[:, 10], image[:, 11:] = share, 1.0
    regions = flat_regions(image)
    left, right = regions.labels[0, 0], regions.labels[0, 20]
    assert len(regions.sizes) == 2 and regions.sizes.sum() == 210
    assert (regions.labels[:, 10] == (right if share > 0.5 else left)).all()
    np.testing.assert_allclose(regions.share[:, 10], max(share, 1 - share))
    np.testing.assert_allclose(regions.colors[[left, right]], [[0] * 3, [1] * 3])
    assert regions.noise == 0 and regions.alike(left, left) and not regions.alike(left, right)


@pytest.mark.parametrize("pixels", [SMALLEST - 1, SMALLEST])
def test_regions_of_too_few_pixels_go_to_their_neighbour(pixels: int) -> None:
    image = np.ones((12, 30, 3))
    image[5, 4 : 4 + pixels] = 0.0
    assert len(flat_regions(image).sizes) == 1 + (pixels >= SMALLEST)
