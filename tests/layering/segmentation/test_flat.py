# SPDX-License-Identifier: Apache-2.0
"""Flat regions by known values: how flat a picture is, which region a mixed pixel belongs to."""

from __future__ import annotations

import numpy as np
import pytest
from support.found import flat_regions

from livecl.layering.segmentation.flat import SMALLEST, flatness


def test_flatness_tells_cores_from_slopes_and_noise() -> None:
    flat = np.ones((20, 30, 3))
    flat[:, 15:] = 0.2
    assert flatness(flat) == (1.0, 0.0, 0.0, 2)
    ramp = np.broadcast_to(np.linspace(0, 0.3, 30)[:, None], (20, 30, 3))  # 2.6 levels a pixel
    assert flatness(ramp).slopes == pytest.approx(29 * 20 / (29 * 20 + 19 * 30))
    bands = np.broadcast_to(np.repeat(np.arange(15) / 255, 2)[:, None], (20, 30, 3))  # two columns a level
    assert flatness(bands).bands == pytest.approx(14 * 20 / (29 * 20 + 19 * 30))
    apart = np.ones((20, 30, 3))
    apart[:, 15:] = 253 / 255
    assert flatness(apart) == (1.0, 0.0, 0.0, 2), "bands of shading are one level apart"
    noise = np.random.default_rng(0).uniform(size=(20, 30, 3))
    assert flatness(noise).cored < 0.1


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
