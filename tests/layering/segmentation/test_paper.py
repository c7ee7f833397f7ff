# SPDX-License-Identifier: Apache-2.0
"""Paper under uneven light: flat drawings are found beneath light and noise, others are left to other explanations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from support.found import flat_regions

from livecl import vectorize
from livecl.layering.segmentation.paper import lit_regions, paper_of, without_shading

SIZE = (120, 160)
PRICE, KINDS = 0.05, ("linear", "radial")
INK, BLUE, PAPER = (0.15, 0.15, 0.15), (0.15, 0.25, 0.6), (0.93, 0.91, 0.87)


def sheet() -> NDArray[np.float64]:
    """A ring, a dot of its ink and a blue bar on paper, with soft edges."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]] + 0.5
    image = np.broadcast_to(PAPER, (*SIZE, 3)).copy()
    away = np.hypot(x - 50, y - 60)
    image[(away < 34) & (away > 26)] = INK
    image[np.hypot(x - 50, y - 60) < 6] = INK
    image[(abs(x - 120) < 22) & (abs(y - 85) < 7)] = BLUE
    return np.asarray(ndimage.gaussian_filter(image, (0.5, 0.5, 0)))


def lit(image: NDArray[np.float64], seed: int = 0, noise: float = 0.012) -> NDArray[np.float64]:
    """A picture by the light of a lamp at the left, and the same noise in all channels."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]] / 160
    grain = ndimage.gaussian_filter(np.random.default_rng(seed).normal(0, noise, SIZE), 0.4)
    seen = image * (1 - 0.3 * x - 0.1 * y * y)[..., None] + grain[..., None]
    return np.asarray(np.round(np.clip(seen, 0, 1) * 255) / 255)


def test_regions_are_those_of_the_drawing() -> None:
    image = lit(sheet())
    found = lit_regions(image, PRICE, KINDS)
    assert found is not None
    flat = flat_regions(sheet())
    assert len(found.sizes) == len(flat.sizes) == 5  # paper, ring, its inside, dot, bar
    true, own = np.sort(flat.sizes), np.sort(found.sizes)
    np.testing.assert_allclose(own, true, rtol=0.02, atol=12)
    paper = found.paint(frozenset((int(np.argmax(found.sizes)),)))
    assert not paper.solid
    np.testing.assert_array_equal(found.image, image)


def test_the_light_is_taken_out() -> None:
    image = lit(sheet(), noise=0.0)
    even = without_shading(image, paper_of(image))
    paper = np.abs(sheet() - PAPER).max(axis=2) < 1e-3
    assert np.ptp(image[paper], axis=0).max() > 0.2
    assert np.ptp(even[paper], axis=0).max() < 0.03


@pytest.mark.parametrize(
    "image",
    [
        lit(sheet(), noise=0.0),  # no noise: shading explains it
        sheet() + 0.01 * np.random.default_rng(0).normal(size=(*SIZE, 1)),  # no light: noise does
        np.random.default_rng(1).random((*SIZE, 3)),  # no paper
    ],
)
def test_other_pictures_are_none(image: NDArray[np.float64]) -> None:
    assert lit_regions(image, PRICE, KINDS) is None


def test_a_scan_is_its_shapes_on_paper(device: int) -> None:
    result = vectorize(lit(sheet(), seed=3).astype(np.float32), device=device)
    labels = result.drawing.labels
    assert result.drawing.num_layers == 4 and result.drawing.fills.any_gradients
    assert [any(word in label for label in labels) for word in ("blue", "ring", "rectangle center")] == [True] * 3
