# SPDX-License-Identifier: Apache-2.0
"""`Rasterizer.vjp`: the gradient of :meth:`backward`, without memory in between."""

from __future__ import annotations

import concurrent.futures

import numpy as np
import pytest
from conftest import RasterizerFor
from support import drawings


@pytest.mark.parametrize("name", ["translucent", "rgba", "holes"])
def test_products_are_those_of_backward(rasterizer_for: RasterizerFor, name: str) -> None:
    drawing = drawings.CASES[name]().drawing
    rasterizer = rasterizer_for(drawing.size, np.float64)
    image = rasterizer.forward(drawing)
    d_image = np.random.default_rng(1).normal(size=image.shape)
    expected = rasterizer.backward(d_image)

    rendered, pullback = rasterizer.vjp(drawing)
    found = pullback(d_image)

    np.testing.assert_array_equal(rendered, image)
    np.testing.assert_array_equal(found.points, expected.points)
    np.testing.assert_array_equal(found.colors, expected.colors)
    np.testing.assert_array_equal(found.background, expected.background)


def test_products_are_linear_and_repeatable(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.CASES["translucent"]().drawing
    image, pullback = rasterizer_for(drawing.size, np.float64).vjp(drawing)
    one, other = np.random.default_rng(2).normal(size=(2, *image.shape))

    first = pullback(one)
    both = pullback(one + other)

    np.testing.assert_array_equal(pullback(one).points, first.points)
    scale = np.abs(both.points).max()
    np.testing.assert_allclose(both.points, first.points + pullback(other).points, rtol=0, atol=1e-12 * scale)


def test_products_belong_to_their_drawing(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.CASES["translucent"]().drawing
    moved = drawing.replace(points=drawing.points + np.array([1.3, 0.4]))
    rasterizer = rasterizer_for(drawing.size, np.float64)
    image, pullback = rasterizer.vjp(drawing)
    d_image = np.ones_like(image)
    before = pullback(d_image)

    _, other = rasterizer.vjp(moved)  # neither rendering nor products of another drawing change it
    elsewhere = other(d_image)

    assert not np.array_equal(elsewhere.points, before.points)
    np.testing.assert_array_equal(pullback(d_image).points, before.points)


def test_products_in_another_thread(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.CASES["holes"]().drawing
    image, pullback = rasterizer_for(drawing.size, np.float64).vjp(drawing)
    d_image = np.random.default_rng(4).normal(size=image.shape)

    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        found = pool.submit(pullback, d_image).result(timeout=60)

    np.testing.assert_array_equal(found.points, pullback(d_image).points)


def test_pieces_are_fixed_for_image_and_products(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.CASES["translucent"]().drawing
    rasterizer = rasterizer_for(drawing.size, np.float64)
    pieces = np.full(drawing.num_segments, 3)
    image, pullback = rasterizer.vjp(drawing, pieces)
    d_image = np.ones_like(image)
    expected = pullback(d_image)

    pieces[:] = 1  # the caller's array is the caller's

    np.testing.assert_array_equal(pullback(d_image).points, expected.points)
    np.testing.assert_array_equal(image, rasterizer.forward(drawing, np.full(drawing.num_segments, 3)))


def test_products_refuse_other_shapes(rasterizer_for: RasterizerFor) -> None:
    drawing = drawings.CASES["translucent"]().drawing
    image, pullback = rasterizer_for(drawing.size, np.float64).vjp(drawing)

    with pytest.raises(ValueError, match="d_image: shape"):
        pullback(image[:-1])
