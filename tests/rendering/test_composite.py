# SPDX-License-Identifier: Apache-2.0
"""Composite: images and the gradients of colours, opacities and background, against the reference's recurrence."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from reference import images
from reference.composite import composite_backward, squared_error
from reference.rounding import UNIT, colors_tolerance, image_tolerance
from support import drawings

import livecl
from livecl.drawing.assembly import empty_drawing
from livecl.image.reading import premultiplied


def _random_image(case: drawings.Case, seed: int = 0) -> np.ndarray:
    channels = 4 if case.drawing.background is None else 3
    return np.random.default_rng(seed).normal(size=(*case.drawing.size, channels))


@pytest.mark.parametrize("name", [*drawings.ALL_CASES, *drawings.CROWDS])
def test_double_image_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = {**drawings.ALL_CASES, **drawings.CROWDS}[name]()
    image = rasterizer_for(case.drawing.size, np.float64).forward(case.drawing, pieces=case.pieces)
    assert image.dtype == np.float64
    np.testing.assert_allclose(image, images.render(case.drawing, case.pieces), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", [*drawings.ALL_CASES, *drawings.CROWDS])
def test_float_image_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = {**drawings.ALL_CASES, **drawings.CROWDS}[name]()
    image = rasterizer_for(case.drawing.size, np.float32).forward(case.drawing, pieces=case.pieces)
    assert image.dtype == np.float32
    error = np.abs(image - images.render(case.drawing, case.pieces))
    assert np.all(error <= image_tolerance(case.drawing, case.pieces))


@pytest.mark.parametrize("name", [*drawings.ALL_CASES, *drawings.CROWDS])
def test_double_color_gradients_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = {**drawings.ALL_CASES, **drawings.CROWDS}[name]()
    drawing, d_image = case.drawing, _random_image(case)
    rasterizer = rasterizer_for(drawing.size, np.float64)
    rasterizer.forward(drawing, pieces=case.pieces)
    found = rasterizer.backward(d_image)
    share = images.layer_coverages(drawing, case.pieces)
    _, d_colors, d_background = composite_backward(d_image, share, drawing.colors, drawing.background)
    scale = np.sum(np.abs(d_image))
    assert found.colors.dtype == np.float64 and found.colors.shape == drawing.colors.shape
    np.testing.assert_allclose(found.colors, d_colors, rtol=0, atol=1e-10 * scale)
    if drawing.background is None:
        assert found.background is None
    else:
        assert found.background is not None
        np.testing.assert_allclose(found.background, d_background, rtol=0, atol=1e-10 * scale)


@pytest.mark.parametrize("name", [*drawings.ALL_CASES, *drawings.CROWDS])
def test_float_color_gradients_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = {**drawings.ALL_CASES, **drawings.CROWDS}[name]()
    drawing, d_image = case.drawing, _random_image(case)
    rasterizer = rasterizer_for(drawing.size, np.float32)
    rasterizer.forward(drawing, pieces=case.pieces)
    found = rasterizer.backward(d_image)
    share = images.layer_coverages(drawing, case.pieces)
    _, d_colors, d_background = composite_backward(d_image, share, drawing.colors, drawing.background)
    tolerance = colors_tolerance(drawing, case.pieces, d_image)
    assert np.max(np.abs(found.colors - d_colors)) <= tolerance
    if drawing.background is not None:
        assert found.background is not None
        assert np.max(np.abs(found.background - d_background)) <= tolerance


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_loss_is_the_weighted_squared_error(rasterizer_for: RasterizerFor, dtype: type) -> None:
    rng = np.random.default_rng(8)
    for name in ("translucent", "rgba", "13x7", "1x1", "33x50"):
        case = drawings.CASES[name]()
        target, weight = rng.uniform(size=_random_image(case).shape), rng.uniform(size=case.drawing.size)
        loss, _ = rasterizer_for(case.drawing.size, dtype).loss_and_gradients(
            case.drawing, target, weight, pieces=case.pieces
        )
        image = images.render(case.drawing, case.pieces)
        error, d_image = squared_error(image, target)
        expected = float(np.sum(weight * error))
        # d(loss) = weight |d_image| d(image), summed; and the rounding of as many partial sums.
        slopes = weight[..., None] * np.abs(d_image)
        rounding = float(np.sum(slopes * image_tolerance(case.drawing, case.pieces))) + UNIT * image.size * expected
        assert isinstance(loss, float)
        assert loss == pytest.approx(expected, rel=0, abs=rounding if dtype is np.float32 else 1e-8)


@pytest.mark.parametrize(
    ("background", "expected"),
    [
        ((1, 1, 1), [[(0.5, 0.25, 0.75), (0, 0, 1), (0, 0, 1)], [(1, 0.5, 0.5), (1, 0.5, 0.5), (1, 1, 1)]]),
        (
            None,
            [[(0.25, 0, 0.5, 0.75), (0, 0, 1, 1), (0, 0, 1, 1)], [(0.5, 0, 0, 0.5), (0.5, 0, 0, 0.5), (0, 0, 0, 0)]],
        ),
    ],
    ids=["rgb", "rgba"],
)
def test_two_rectangles_by_hand(
    rasterizer_for: RasterizerFor, background: tuple[int, int, int] | None, expected: list[list[tuple[float, ...]]]
) -> None:
    layers: list[drawings.Layer] = [
        ([drawings.rectangle(0, 0, 2, 2)], (1, 0, 0, 0.5)),
        ([drawings.rectangle(0.5, 0, 3, 1)], (0, 0, 1, 1)),
    ]
    drawing = drawings.build(layers, (2, 3), background)
    image = rasterizer_for((2, 3), np.float64).forward(drawing, pieces=np.ones(8, dtype=int))
    np.testing.assert_allclose(image, expected, atol=1e-14)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_premultiplied_image_lies_over_any_background(rasterizer_for: RasterizerFor, dtype: type) -> None:
    case = drawings.CASES["rgba"]()
    rasterizer = rasterizer_for(case.drawing.size, dtype)
    rgba = rasterizer.forward(case.drawing, pieces=case.pieces).copy()
    background = np.array((0.2, 0.5, 0.7))
    opaque = rasterizer.forward(case.drawing.replace(background=background), pieces=case.pieces)
    # 5 roundings a layer for either image, of numbers up to 1.
    over = rgba[..., :3] + (1 - rgba[..., 3:]) * background
    np.testing.assert_allclose(over, opaque, rtol=0, atol=2 * 5 * 3 * np.finfo(dtype).eps)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_no_layers(rasterizer_for: RasterizerFor, dtype: type) -> None:
    rasterizer = rasterizer_for((9, 11), dtype)
    background = np.array((0.25, 0.5, 1.0))
    d_image = np.random.default_rng(9).normal(size=(9, 11, 3))
    image = rasterizer.forward(empty_drawing((9, 11), background))
    np.testing.assert_array_equal(image, np.broadcast_to(background, (9, 11, 3)))
    gradients = rasterizer.backward(d_image)
    assert gradients.points.shape == (0, 3, 2) and gradients.colors.shape == (0, 4)
    assert gradients.background is not None
    # 99 sums, of partial sums of about the root of 99.
    rounding = 99 * np.finfo(dtype).eps
    np.testing.assert_allclose(gradients.background, d_image.sum(axis=(0, 1)), rtol=0, atol=rounding)
    assert not rasterizer.distance_weight(empty_drawing((9, 11))).any()
    loss, gradients = rasterizer.loss_and_gradients(empty_drawing((9, 11)), np.zeros((9, 11, 3)), np.ones((9, 11)))
    assert loss == pytest.approx(3 * 99, rel=1e-6)
    assert gradients.background == pytest.approx(2 * 99, rel=1e-6)
    image = rasterizer.forward(empty_drawing((9, 11), None))
    assert image.shape == (9, 11, 4) and not image.any()
    assert rasterizer.backward(np.ones((9, 11, 4))).background is None


def test_opaque_layer_hides_what_is_below(rasterizer_for: RasterizerFor) -> None:
    case = drawings.CASES["hidden below opaque"]()
    rasterizer = rasterizer_for(case.drawing.size, np.float32)
    image = rasterizer.forward(case.drawing, pieces=case.pieces).copy()
    hidden = case.drawing.segment_layers == 0
    top = rasterizer.forward(case.drawing.layer_subset([1, 2, 3]), pieces=case.pieces[~hidden])
    # C + 1 (c - C) is c but for two roundings, of numbers up to 1.
    np.testing.assert_allclose(image, top, rtol=0, atol=2 * UNIT)
    rasterizer.forward(case.drawing, pieces=case.pieces)
    gradients = rasterizer.backward(_random_image(case))
    assert gradients.background is not None
    assert not gradients.points[hidden].any() and not gradients.colors[0].any() and not gradients.background.any()
    assert gradients.colors[1].all(), "the opaque layer's opacity depends on what it hides"


def test_gradients_of_a_pixel_by_hand(rasterizer_for: RasterizerFor) -> None:
    # One pixel, half of it covered with opacity 1/2 over white, and L = (1, 2, 4) . image.
    drawing = drawings.build([([drawings.rectangle(0.25, -1, 0.75, 2)], (0.5, 0.25, 0, 0.5))], (1, 1))
    rasterizer = rasterizer_for((1, 1), np.float64)
    image = rasterizer.forward(drawing, pieces=np.ones(4, dtype=int))
    np.testing.assert_allclose(image, [[(0.875, 0.8125, 0.75)]], atol=1e-15)
    gradients = rasterizer.backward(np.array([[(1.0, 2.0, 4.0)]]))
    d_alpha = 1 * (0.5 - 1) + 2 * (0.25 - 1) + 4 * (0 - 1)
    np.testing.assert_allclose(gradients.colors, [(0.25, 0.5, 1, 0.5 * d_alpha)], atol=1e-15)
    assert gradients.background is not None
    np.testing.assert_allclose(gradients.background, np.array((0.75, 1.5, 3)), atol=1e-15)
    # An edge moved outward by 1 covers 1 more; each corner has the share of the edge that moves with it: half, as the
    # pixel is the middle third of the edge.
    expected = np.zeros((4, 3, 2))
    expected[:, 0, 0] = np.array((-1, 1, 1, -1)) * 0.5 * 0.5 * d_alpha
    np.testing.assert_allclose(gradients.points, expected, atol=1e-14)


def test_only_drawings_are_rendered(device: int) -> None:
    for wrong in ([1, 2], np.zeros((3, 4))):
        with pytest.raises(TypeError, match=r"^drawing: got (list|ndarray), wanted a livecl\.Drawing"):
            livecl.render(wrong, device)
        with pytest.raises(TypeError, match=r"^drawing: got"):
            livecl.Rasterizer((4, 4), device).forward(wrong)


def test_straight_rgba_is_what_pictures_are_read_as(device: int) -> None:
    drawing = drawings.build([([drawings.rectangle(0.5, 0, 2, 2)], (1.0, 0.5, 0.0, 0.5))], (2, 3), None)
    straight, image = livecl.render(drawing, device, straight=True), livecl.render(drawing, device)
    np.testing.assert_allclose(straight[0], [[1, 0.5, 0, 0.25], [1, 0.5, 0, 0.5], [0, 0, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(premultiplied(straight), image, atol=1e-6)
