# SPDX-License-Identifier: Apache-2.0
"""Gradients of the double build against differences of its own images, and of the float build against the double.

Two losses at once: sum(image * R), through `backward`, and the quadratic of `loss_and_gradients`, both with random
weights. Errors are relative to the norm of the whole gradient of that kind (points, colours, background).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from conftest import RasterizerFor
from reference import differences
from reference.composite import squared_error
from reference.rounding import colors_tolerance, image_tolerance, points_tolerance
from support import drawings, shapes
from support.case_losses import Losses

RELATIVE = 1e-6


def _check_points(losses: Losses, entries: Sequence[int] | None = None) -> None:
    points = losses.case.drawing.points
    entries = range(points.size) if entries is None else entries
    numerical = differences.by_small_steps(lambda x: losses(points=x), points, entries)
    for found, expected in zip(losses.gradients(), numerical, strict=True):
        norm = float(np.linalg.norm(found.points))
        assert norm > 0
        errors = np.abs(found.points.ravel()[entries] - expected)
        error = float(np.linalg.norm(errors))
        worst = np.unravel_index(entries[int(np.argmax(errors))], points.shape)
        assert error <= RELATIVE * norm, (
            f"relative error {error / norm:.2e}; worst at points{[int(i) for i in worst]}: "
            f"{found.points[worst]:.9f}, by differences {expected[np.argmax(errors)]:.9f}"
        )


def _check_colors(losses: Losses, entries: Sequence[int] | None = None) -> None:
    drawing = losses.case.drawing
    entries = range(drawing.colors.size) if entries is None else entries
    numerical = differences.of_quadratic(lambda x: losses(colors=x), drawing.colors, entries)
    for found, expected in zip(losses.gradients(), numerical, strict=True):
        error = np.linalg.norm(found.colors.ravel()[entries] - expected)
        assert error <= RELATIVE * np.linalg.norm(found.colors)
    if drawing.background is not None:
        numerical = differences.of_quadratic(lambda x: losses(background=x), drawing.background)
        for found, expected in zip(losses.gradients(), numerical, strict=True):
            # Nothing of the background may be seen; the colours' norm keeps the comparison meaningful then.
            scale = max(float(np.linalg.norm(expected)), float(np.linalg.norm(found.colors)))
            assert found.background is not None
            assert np.linalg.norm(found.background - expected) <= RELATIVE * scale


@pytest.mark.parametrize("name", drawings.CASES)
def test_points(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.CASES[name]()
    _check_points(Losses(rasterizer_for(case.drawing.size, np.float64), case))


@pytest.mark.parametrize("name", drawings.BORDER_CASES)
def test_points_with_edges_on_pixel_borders(rasterizer_for: RasterizerFor, name: str) -> None:
    # Where the derivative has two one-sided values, their mean is wanted, which is what central differences give.
    case = drawings.BORDER_CASES[name]()
    _check_points(Losses(rasterizer_for(case.drawing.size, np.float64), case))


def test_opposite_lines_on_one_border_are_an_exception(rasterizer_for: RasterizerFor) -> None:
    # An outline without area, out and back along a border: the change of |A| is no sum of what its two lines do, so a
    # gradient that is one (kernels/coverage.cl says so) cannot be right. The picture is, and the gradient stays finite.
    flat = drawings.build([([drawings.polygon([(5, 3), (5, 12)])], (1.0, 0.0, 0.0, 0.5))], (16, 16))
    rasterizer = rasterizer_for(flat.size, np.float64)
    assert np.array_equal(rasterizer.forward(flat), np.ones((16, 16, 3)))
    assert np.isfinite(rasterizer.backward(np.ones((16, 16, 3))).points).all()


@pytest.mark.parametrize("name", drawings.CASES)
def test_colors_opacities_background(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.CASES[name]()
    _check_colors(Losses(rasterizer_for(case.drawing.size, np.float64), case))


@pytest.mark.parametrize("name", drawings.CROWDS)
def test_many_layers(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.CROWDS[name]()
    losses = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    rng = np.random.default_rng(1)
    _check_points(losses, rng.choice(case.drawing.points.size, 60, replace=False).tolist())
    _check_colors(losses, rng.choice(case.drawing.colors.size, 40, replace=False).tolist())


@pytest.mark.parametrize("name", [*drawings.CASES, *drawings.CROWDS])
def test_many_directions(rasterizer_for: RasterizerFor, name: str) -> None:
    # All points at once along random directions: what no single entry shows, such as a vertex that is summed twice.
    case = {**drawings.CASES, **drawings.CROWDS}[name]()
    losses = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    rng = np.random.default_rng(2)
    gradients = losses.gradients()
    for _ in range(3):
        direction = rng.normal(size=case.drawing.points.shape)

        def along(step: np.ndarray, direction: np.ndarray = direction) -> np.ndarray:
            return losses(points=case.drawing.points + step * direction)

        expected = differences.by_small_steps(along, np.zeros(1), step=1e-6)[:, 0]
        for found, derivative in zip(gradients, expected, strict=True):
            scale = np.linalg.norm(found.points) * np.linalg.norm(direction)
            assert abs(np.sum(found.points * direction) - derivative) <= RELATIVE * scale


@pytest.mark.parametrize("name", [*drawings.CASES, *drawings.BORDER_CASES, *drawings.CROWDS])
def test_backward_and_loss_and_gradients_agree(rasterizer_for: RasterizerFor, name: str) -> None:
    case = {**drawings.CASES, **drawings.BORDER_CASES, **drawings.CROWDS}[name]()
    losses = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    loss, fused = losses.rasterizer.loss_and_gradients(case.drawing, losses.target, losses.weight, pieces=case.pieces)
    image = losses.rasterizer.forward(case.drawing, pieces=case.pieces)
    two_steps = losses.rasterizer.backward(losses.weight[..., None] * squared_error(image, losses.target)[1])
    assert loss == pytest.approx(losses()[1], rel=1e-12)
    scale = np.linalg.norm(two_steps.points)
    np.testing.assert_allclose(fused.points, two_steps.points, rtol=0, atol=1e-12 * scale)
    scale = np.linalg.norm(two_steps.colors)
    np.testing.assert_allclose(fused.colors, two_steps.colors, rtol=0, atol=1e-12 * scale)
    if two_steps.background is None:
        assert fused.background is None
    else:
        assert fused.background is not None
        np.testing.assert_allclose(fused.background, two_steps.background, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("name", [*drawings.CASES, *drawings.CROWDS])
def test_float_against_double(rasterizer_for: RasterizerFor, name: str) -> None:
    case = {**drawings.CASES, **drawings.CROWDS}[name]()
    single = Losses(rasterizer_for(case.drawing.size, np.float32), case)
    double = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    image = double.rasterizer.forward(case.drawing, pieces=case.pieces)
    # The quadratic loss's own d_image is linear in the image: 2 weight (image - target) over a background, and without
    # one up to 6 weight times an error that all four channels have.
    factor = 2 if image.shape[2] == 3 else 6
    d_error = single.weight[..., None] * squared_error(image, single.target)[1]
    allowed = factor / 2 * image_tolerance(case.drawing, case.pieces)
    d_images = single.d_image, d_error + allowed * np.sign(d_error)
    for found, exact, d_image in zip(single.gradients(), double.gradients(), d_images, strict=True):
        assert found.points.dtype == np.float64
        assert np.all(np.abs(found.points - exact.points) <= points_tolerance(case.drawing, case.pieces, d_image))
        tolerance = colors_tolerance(case.drawing, case.pieces, d_image)
        assert np.max(np.abs(found.colors - exact.colors)) <= tolerance
        if exact.background is not None:
            assert found.background is not None
            assert np.max(np.abs(found.background - exact.background)) <= tolerance


@pytest.mark.parametrize("name", drawings.BORDER_CASES)
def test_float_against_double_on_pixel_borders(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.BORDER_CASES[name]()
    single = Losses(rasterizer_for(case.drawing.size, np.float32), case)
    double = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    found, exact = single.gradients()[0], double.gradients()[0]
    tolerance = points_tolerance(case.drawing, case.pieces, single.d_image, on_borders=True)
    assert np.all(np.abs(found.points - exact.points) <= tolerance)


def test_saturated_edges_have_no_gradient(rasterizer_for: RasterizerFor) -> None:
    inside = drawings.blob(1, (10, 10), 3)
    drawing = drawings.build([([shapes.circle((10, 10), 8.3), inside], drawings.RED_GLASS)], (20, 20))
    rasterizer = rasterizer_for((20, 20), np.float64)
    rasterizer.forward(drawing, pieces=np.full(8, 6))
    d_points = rasterizer.backward(np.random.default_rng(3).normal(size=(20, 20, 3))).points
    assert not d_points[4:].any()
    assert d_points[:4].all()


def test_what_is_outside_has_no_gradient(rasterizer_for: RasterizerFor) -> None:
    case = drawings.CASES["outside and around"]()
    rasterizer = rasterizer_for(case.drawing.size, np.float64)
    rasterizer.forward(case.drawing, pieces=case.pieces)
    d_points = rasterizer.backward(np.random.default_rng(4).normal(size=(*case.drawing.size, 3))).points
    assert not d_points[case.drawing.segment_layers < 6].any()


def test_moving_a_border_edge_by_hand(rasterizer_for: RasterizerFor) -> None:
    # A white square over black with L = G . image: its right edge lies between columns 5 and 6. Moved by x, L changes
    # by x times the sum over the edge's rows of G in column 6 (x > 0) or 5 (x < 0); the derivative is their mean.
    drawing = drawings.build([([drawings.rectangle(3, 2, 6, 7)], shapes.WHITE)], (9, 10), (0, 0, 0))
    g = np.random.default_rng(5).normal(size=(9, 10, 3))
    for dtype, tolerance in ((np.float64, 1e-12), (np.float32, 1e-5)):
        rasterizer = rasterizer_for((9, 10), dtype)
        rasterizer.forward(drawing, pieces=np.ones(4, dtype=int))
        d_points = rasterizer.backward(g).points
        right = np.sum(g[2:7, 5:7]) / 2
        assert d_points[1, 0, 0] + d_points[2, 0, 0] == pytest.approx(right, abs=tolerance)
        bottom = np.sum(g[6:8, 3:6]) / 2
        assert d_points[2, 0, 1] + d_points[3, 0, 1] == pytest.approx(bottom, abs=tolerance)
