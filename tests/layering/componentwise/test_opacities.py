# SPDX-License-Identifier: Apache-2.0
"""What is seen of an error in a picture without background: over black, over white, in training and in the end."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from reference import differences
from reference.composite import squared_error
from scipy.ndimage import gaussian_filter

import livecl
from livecl import Options
from livecl.image.errors import mse, visible_error, visible_mse
from livecl.image.reading import over_background, premultiplied
from livecl.layering.componentwise.painting import Painting
from livecl.layering.regions import RegionFinder, TargetPartitions
from livecl.layering.stack import LayerStack

SIDE = 80


def _over(image: NDArray[np.floating], background: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return premultiplied RGBA over a background."""
    return image[..., :3] + (1 - image[..., 3:]) * background


def _shadow() -> NDArray[np.float32]:
    """Return a square above its large soft shadow, straight RGBA."""
    square = np.zeros((SIDE, SIDE))
    square[14:50, 16:54] = 1
    alpha = 0.6 * gaussian_filter(np.roll(square, (9, 5), axis=(0, 1)), 6)
    alpha = np.where(square > 0, 1, alpha)
    return np.dstack([square * 0.9, square * 0.6, square * 0.2, alpha]).astype(np.float32)


@pytest.mark.parametrize("channels", [3, 4])
def test_squares_sum_to_what_is_seen(channels: int) -> None:
    rng = np.random.default_rng(channels)
    image, target = rng.uniform(size=(2, 5, 6, channels))
    seen, _ = squared_error(image, target)
    np.testing.assert_allclose(np.square(visible_error(image - target)).sum(axis=-1), seen, rtol=1e-12)
    assert visible_mse(image, target) == pytest.approx(np.mean(seen) / 3, rel=1e-12)


def test_it_is_the_mean_over_black_and_white() -> None:
    image, target = np.random.default_rng(0).uniform(size=(2, 5, 6, 4))
    over = [mse(_over(image, ground), _over(target, ground)) for ground in (np.zeros(3), np.ones(3))]
    assert visible_mse(image, target) == pytest.approx(np.mean(over), rel=1e-12)


def test_of_rgb_it_is_the_mean_squared_error() -> None:
    image, target = np.random.default_rng(0).uniform(size=(2, 5, 6, 3))
    assert visible_mse(image, target) == mse(image, target)
    assert visible_error(image) is image


@pytest.mark.parametrize("channels", [3, 4])
def test_gradient_of_the_reference(channels: int) -> None:
    image, target = np.random.default_rng(channels).uniform(size=(2, 3, 2, channels))
    numerical = differences.of_quadratic(lambda x: np.array([squared_error(x, target)[0].sum()]), image)
    np.testing.assert_allclose(squared_error(image, target)[1].ravel(), numerical[0], rtol=1e-6)


def test_a_layer_removes_what_is_seen() -> None:
    rng = np.random.default_rng(1)
    target, alpha = rng.uniform(size=(9, 8, 4)), rng.uniform(size=(9, 8))
    stack = LayerStack(np.zeros(4), np.zeros((0, 9, 8)), np.zeros((0, 4)), np.zeros_like(target))
    painting = Painting(target, stack)
    before = squared_error(stack.image, target)[0]
    np.testing.assert_allclose(painting.error, before, rtol=1e-5)
    (trial,) = painting.try_layers([alpha], np.array((0.2, 0.5, 0.3, 1.0)))
    painting.insert(trial)
    assert trial.gain == pytest.approx(before.sum() - squared_error(stack.image, target)[0].sum(), rel=1e-5)


def test_opacities_follow_a_wider_layer() -> None:
    # A spot of alpha 0.6 in a wider one of 0.3: with 0.3 added everywhere the spot is right at (0.6 - 0.3) / 0.7.
    spot, wide = np.zeros((2, 20, 20))
    spot[5:15, 5:15], wide[3:17, 3:17] = 1, 1
    color = np.array((0.2, 0.5, 0.3, 1.0))
    target = np.maximum(0.6 * spot, 0.3 * wide)[..., None] * color
    before = 0.6 * spot
    image = before[..., None] * color

    def painting(follow: bool) -> Painting:
        return Painting(target, LayerStack(np.zeros(4), before[None], color[None], image), follow)

    stays, follows = painting(False), painting(True)
    for work in (stays, follows):
        work.insert(*work.try_layers([0.3 * wide], color))
    error = squared_error(image, target)[0].sum()
    assert stays.error.sum() > 0.1 * error
    assert follows.error.sum() < 1e-4 * error
    # It is expected where the layer is tried; there, one opacity's change does not yet count for the other's.
    gains = [painting(follow).try_layers([0.3 * wide], color)[0].gain for follow in (False, True)]
    assert gains[0] < 0.9 * error
    assert gains[1] == pytest.approx(error, rel=0.1)


def test_what_is_opaque_stays_so() -> None:
    rng = np.random.default_rng(3)
    target, opaque = rng.uniform(size=(9, 8, 4)), np.ones((9, 8))
    stack = LayerStack(np.zeros(4), opaque[None], np.ones((1, 4)), np.ones((9, 8, 4)))
    work = Painting(target, stack, follow=True)
    color = np.array((0.2, 0.5, 0.3, 1.0))
    work.insert(*work.try_layers([rng.uniform(size=(9, 8)) * 0.5], color))
    np.testing.assert_allclose(stack.image[..., 3], 1, atol=1e-6)


def test_a_region_s_gain_is_what_is_seen() -> None:
    target = np.random.default_rng(2).uniform(size=(20, 20, 4))
    target[:, :9], target[:, 9:] = target[0, 0], 0.0
    image = np.zeros_like(target)
    best = next(iter(RegionFinder(TargetPartitions(target), image).best(squared_error(image, target)[0], 1)))
    assert np.array_equal(best.mask, np.broadcast_to(np.arange(20) < 9, (20, 20)))
    assert best.gain == pytest.approx(squared_error(image, target)[0].sum(), rel=1e-9)


def _disc(x: float, y: float, radius: float, soft: float) -> NDArray[np.float64]:
    """Return the coverage of a disc whose edge is `soft` px wide."""
    rows, columns = np.indices((SIDE, SIDE)) + 0.5
    return np.clip((radius - np.hypot(columns - x, rows - y)) / soft + 0.5, 0, 1)


def _discs() -> NDArray[np.float32]:
    """Return two discs with soft edges, a translucent one and one below it, straight RGBA."""
    image = np.zeros((SIDE, SIDE, 4))
    for coverage, rgb, opacity in (
        (_disc(30, 36, 22, 3), (0.9, 0.3, 0.1), 1.0),
        (_disc(50, 44, 20, 4), (0.1, 0.4, 0.9), 0.6),
    ):
        alpha = (coverage * opacity)[..., None]
        image = image * (1 - alpha) + alpha * np.array([*rgb, 1])
    image[..., :3] /= np.maximum(image[..., 3:], 1e-6)
    return np.clip(image, 0, 1).astype(np.float32)


@pytest.mark.parametrize("picture", [_discs, _shadow])
def test_soft_alpha_is_as_close_over_every_background_as_opaque_paths_on_white(
    picture: Callable[[], NDArray[np.float32]], device: int
) -> None:
    # Of opaque paths, as paint adds alpha and cannot take it away: one path is one step of a slope. On white,
    # translucent paths can be lighter than what they lie on, and one of them makes two steps (docs/svg.md). Without
    # merging, which by itself makes the run on white a third better. Of one colour each: a gradient is no step.
    image, paths = picture(), 8
    target = premultiplied(image)
    translucent = Options(merge=False, fills="solid")
    opaque = dataclasses.replace(translucent, opacity="opaque")
    rendered = livecl.render(livecl.vectorize(image, paths, options=translucent, device=device).drawing, device)
    on_white = livecl.vectorize(over_background(image, (1, 1, 1)), paths, options=opaque, device=device).mse
    checks = np.where((np.indices((SIDE, SIDE)) // 8).sum(axis=0)[..., None] % 2, 0.8, 0.4)
    for ground in (np.ones(3), np.zeros(3), checks):
        assert mse(_over(rendered, ground), _over(target, ground)) <= 1.2 * on_white


def test_training_minimizes_what_is_seen(device: int) -> None:
    image = _shadow()
    losses: list[float] = []
    seen: list[float] = []

    def on_step(step: livecl.Step) -> None:
        losses.append(step.loss)
        seen.append(visible_mse(step.image, premultiplied(image)))

    # Short steps, as the loss is that of the lines into which a path was flattened before.
    options = Options(iterations=6, revisions=0, shape="circle", radius=20, learning_rate=1e-3, untangle=False)
    livecl.vectorize(image, 1, options=options, device=device, on_step=on_step)
    # A step's loss is that of the drawing before it.
    assert losses[1:] == pytest.approx(seen[:-1], rel=1e-3)
