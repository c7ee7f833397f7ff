# SPDX-License-Identifier: Apache-2.0
"""Pictures with alpha as targets of colour and alpha: over any background the drawing looks like the picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import livecl
from livecl import Options, Rasterizer, vectorize
from livecl.image.background import background_for, border_color, check_background, target_over
from livecl.image.errors import mse, visible_mse
from livecl.image.reading import over_background, premultiplied
from livecl.layering.contributions import layer_alphas, removal_changes

SIDE = 48


def _disc(x: float, y: float, radius: float, soft: float) -> NDArray[np.float64]:
    """Return the coverage of a disc whose edge is `soft` px wide."""
    rows, columns = np.indices((SIDE, SIDE)) + 0.5
    return np.clip((radius - np.hypot(columns - x, rows - y)) / soft + 0.5, 0, 1)


def _picture(soft: float = 1.0, hidden: float = 0.0) -> NDArray[np.float32]:
    """Return two translucent discs and an opaque one, straight RGBA; clear pixels have the colour `hidden`."""
    image = np.zeros((SIDE, SIDE, 4))
    for coverage, rgb, opacity in (
        (_disc(18, 24, 13, soft), (0.9, 0.2, 0.1), 0.5),
        (_disc(30, 24, 13, soft), (0.1, 0.3, 0.9), 0.5),
        (_disc(24, 36, 7, soft), (1.0, 0.8, 0.1), 1.0),
    ):
        alpha = (coverage * opacity)[..., None]
        image = image * (1 - alpha) + alpha * np.array([*rgb, 1])
    alpha = image[..., 3:]
    straight = np.where(alpha > 0, image[..., :3] / np.where(alpha > 0, alpha, 1), hidden)
    return np.concatenate([straight, alpha], axis=2).astype(np.float32)


def _over(premultiplied_image: NDArray[Any], background: NDArray[Any]) -> NDArray[Any]:
    return premultiplied_image[..., :3] + (1 - premultiplied_image[..., 3:]) * background


def test_the_drawing_has_no_background_and_looks_alike_over_all(device: int) -> None:
    image = _picture()
    result = vectorize(image, 4, options=Options(iterations=100), device=device)
    assert result.drawing.background is None
    rendered, target = livecl.render(result.drawing, device), premultiplied(image)
    assert result.mse == pytest.approx(mse(rendered, target), rel=1e-6)
    white_run = vectorize(over_background(image, (1, 1, 1)), 4, options=Options(iterations=100), device=device)
    checks = (np.indices((SIDE, SIDE)) // 6).sum(axis=0) % 2
    for background in (np.ones(3), np.zeros(3), checks[..., None] * np.full(3, 0.5) + 0.25):
        difference = mse(_over(rendered, background), _over(target, background))
        # Over a background b an error is dC - b dA, of which both parts are in the loss: sum over RGB of its square is
        # at most 2 (sum dC^2 + 3 dA^2), so its mean at most 2 * 4 / 3 * 3 of the mean over four channels.
        assert difference <= 8 * result.mse
        assert difference < 4 * max(white_run.mse, 1e-5)


def test_the_color_of_clear_pixels_does_not_count(device: int) -> None:
    options = Options(iterations=12, revisions=0)
    first, second = (vectorize(_picture(hidden=hidden), 3, options=options, device=device) for hidden in (0.0, 0.7))
    assert first.svg == second.svg
    assert first.mse == second.mse


def test_opacities_of_layers_are_those_of_the_picture(device: int) -> None:
    result = vectorize(_picture(), 3, options=Options(iterations=150), device=device)
    opacities = sorted(result.drawing.colors[:, 3])
    np.testing.assert_allclose(opacities, (0.5, 0.5, 1.0), atol=0.05)  # of the picture's three, within 13 levels


@pytest.mark.parametrize("preset", ["default", "paper", "diffvg"])
def test_every_rule_of_placement_takes_a_picture_with_alpha(preset: str, device: int) -> None:
    options = livecl.options.PRESETS[preset](iterations=10, background="none")
    result = vectorize(_picture(), 3, options=options, device=device)
    assert result.drawing.background is None
    assert result.mse < np.mean(np.square(premultiplied(_picture())))


def test_a_picture_all_clear(device: int) -> None:
    image = np.zeros((9, 11, 4))
    result = vectorize(image, 2, options=Options(iterations=5), device=device)
    assert result.drawing.num_layers == 0
    assert result.mse == 0


def test_opaque_alpha_is_none(device: int) -> None:
    image = np.ones((8, 8, 4))
    image[2:5, 2:5, :3] = 0.3
    options = Options(iterations=3, revisions=0)
    assert vectorize(image, 1, options=options).svg == vectorize(image[..., :3], 1, options=options).svg


def test_a_missing_layer_changes_the_error_as_told(device: int) -> None:
    image = premultiplied(_picture())
    drawing = vectorize(_picture(), 4, options=Options(iterations=20, revisions=0), device=device).drawing
    rasterizer = Rasterizer(drawing.size, device)
    changes = removal_changes(drawing, layer_alphas(drawing, rasterizer), image)
    seen = removal_changes(drawing, layer_alphas(drawing, rasterizer), image, seen=True)
    error, visible_error = mse(rasterizer.forward(drawing), image), visible_mse(rasterizer.forward(drawing), image)
    for layer in range(drawing.num_layers):
        without = drawing.layer_subset(np.arange(drawing.num_layers) != layer)
        # Renders are in single precision: about 1e-7 in every pixel, against differences of up to 1.
        assert changes[layer] == pytest.approx(mse(rasterizer.forward(without), image) - error, abs=1e-6)
        assert seen[layer] == pytest.approx(visible_mse(rasterizer.forward(without), image) - visible_error, abs=1e-6)


RED_BORDER = np.full((6, 7, 3), 0.5, np.float32)
RED_BORDER[[0, -1]] = RED_BORDER[:, [0, -1]] = (0.8, 0.1, 0.1)
RED_BORDER[0, :3] = 1


def test_background_words() -> None:
    clear = np.concatenate([RED_BORDER, np.full((6, 7, 1), 0.5, np.float32)], axis=2)
    assert background_for("picture", RED_BORDER) == pytest.approx((0.8, 0.1, 0.1))
    assert background_for("picture", clear) is None
    assert background_for("none", RED_BORDER) is None
    assert background_for("white", clear) == (1, 1, 1)
    assert background_for("train", clear) == (1, 1, 1)
    assert background_for("#336699", clear) == pytest.approx((0.2, 0.4, 0.6))
    assert background_for("auto", RED_BORDER) == pytest.approx((0.8, 0.1, 0.1))
    assert background_for("picture", clear, (0, 1, 0)) == (0, 1, 0)
    assert background_for("none", clear, (0, 1, 0)) is None


def test_a_picture_without_a_ground_is_over_white() -> None:
    halves = np.full((20, 20, 3), 0.25, np.float32)
    halves[:, 10:] = 0.75
    assert background_for("picture", halves) == (1, 1, 1)
    nearly = halves.copy()
    nearly[:, 7:] = 0.75  # five eighths of the border
    assert background_for("picture", nearly) == (1, 1, 1)
    paper = np.full((20, 20, 3), 254 / 255, np.float32)
    assert background_for("picture", paper) == (1, 1, 1)


def test_light_shapes_on_a_coloured_ground_are_no_holes_of_it() -> None:
    image = np.full((60, 80, 3), (0.2, 0.6, 0.4), np.float32)
    image[15:45, 20:60] = 1
    drawing = vectorize(image, options=Options(iterations=10)).drawing
    np.testing.assert_allclose(drawing.background, (0.2, 0.6, 0.4), atol=0.01)
    np.testing.assert_allclose(drawing.colors, [(1, 1, 1, 1)], atol=0.01)


def test_corners_of_another_color_are_the_ground_of_a_plate() -> None:
    rows, columns = np.indices((64, 64)) + 0.5
    corner = np.hypot(*(np.maximum(np.abs(along - 32) - 24, 0) for along in (rows, columns)))
    plate = np.where(corner[..., None] < 8, (0.2, 0.6, 0.4), 1.0).astype(np.float32)
    drawing = vectorize(plate, options=Options(iterations=10)).drawing
    np.testing.assert_array_equal(drawing.background, 1)
    np.testing.assert_allclose(drawing.colors, [(0.2, 0.6, 0.4, 1)], atol=0.01)
    plate[0, 0] = 0  # of one corner nothing follows
    assert background_for("picture", plate) == pytest.approx((0.2, 0.6, 0.4))


def test_the_border_s_color_is_that_of_most_of_it() -> None:
    assert border_color(RED_BORDER) == pytest.approx((0.8, 0.1, 0.1))
    assert border_color(np.zeros((5, 5, 4), np.float32)) == (1, 1, 1)
    assert border_color(np.full((1, 1, 3), 0.25, np.float32)) == pytest.approx((0.25, 0.25, 0.25))


@pytest.mark.parametrize("text", ["picture", "none", "auto", "train", "white", "#123456", "rebeccapurple"])
def test_what_a_background_may_be(text: str) -> None:
    check_background(text)
    assert Options(background=text).background == text


def test_what_a_background_may_not_be() -> None:
    with pytest.raises(
        ValueError, match=r"^background: got 'nothing', wanted a colour.*, or one of picture, none, auto"
    ):
        check_background("nothing")


def test_target_over() -> None:
    image = _picture(hidden=0.3)
    flat = target_over(image, (0.2, 0.4, 0.6))
    np.testing.assert_allclose(flat, _over(target_over(image, None), np.array((0.2, 0.4, 0.6))), atol=1e-6)
    np.testing.assert_array_equal(target_over(image[..., :3], None)[..., 3], 1)
