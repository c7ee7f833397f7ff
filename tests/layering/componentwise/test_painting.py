# SPDX-License-Identifier: Apache-2.0
"""New layers tried in, and put into, a picture of layers, against compositing everything again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering import stack
from livecl.layering.componentwise.painting import Painting
from livecl.layering.stack import LayerStack

#: Pictures are held in single precision: a few roundings of numbers up to 1.
ROUNDING = 8 * 2.0**-24


def _composite(background: NDArray[Any], alphas: list[NDArray[Any]], colors: list[NDArray[Any]]) -> NDArray[Any]:
    image = np.broadcast_to(background, (*alphas[0].shape, 3)).astype(np.float64)
    for alpha, color in zip(alphas, colors, strict=True):
        image = image + alpha[..., None] * (color - image)
    return image


def _scene(seed: int) -> tuple[NDArray[Any], list[NDArray[Any]], list[NDArray[Any]], NDArray[Any]]:
    rng = np.random.default_rng(seed)
    alphas = []
    for _ in range(4):
        alpha = np.zeros((12, 15))
        top, left = rng.integers(0, 6, size=2)
        alpha[top : top + 6, left : left + 7] = rng.uniform(0.2, 1, size=alpha[top : top + 6, left : left + 7].shape)
        alphas.append(alpha)
    return rng.uniform(size=3), alphas, list(rng.uniform(size=(4, 3))), rng.uniform(size=(12, 15, 3))


def _painting(
    target: NDArray[Any],
    image: NDArray[Any],
    background: NDArray[Any],
    alphas: list[NDArray[Any]],
    colors: list[NDArray[Any]],
) -> Painting:
    return Painting(target, LayerStack(background, np.array(alphas), np.array(colors), image))


def _patch() -> NDArray[Any]:
    coverage = np.zeros((12, 15))
    coverage[2:9, 3:12] = 0.75
    return coverage


def test_several_layers_are_inserted_where_they_were_tried() -> None:
    background, alphas, colors, target = _scene(9)
    work = _painting(target, _composite(background, alphas, colors), background, alphas, colors)
    rng = np.random.default_rng(3)
    for _ in range(5):
        coverage = np.roll(_patch(), rng.integers(-3, 4, size=2), axis=(0, 1))
        before = work.error.sum(dtype=np.float64)
        (trial,) = work.try_layers([coverage], rng.uniform(size=3))
        work.insert(trial)
        assert before - work.error.sum(dtype=np.float64) == pytest.approx(trial.gain, abs=target.size * ROUNDING)
    assert sorted(work.stack.order.tolist()) == list(range(9))


def test_a_layer_beneath_what_hides_its_errors() -> None:
    # A ring's hole is filled already: painted on top, the whole disc would hide what fills it.
    target = np.ones((16, 16, 3))
    target[2:14, 2:14] = 0.2
    target[6:10, 6:10] = (1.0, 0.0, 0.0)
    hole = np.zeros((16, 16))
    hole[6:10, 6:10] = 1
    work = _painting(target, np.ones((16, 16, 3)), np.ones(3), [hole], [np.array([1.0, 0.0, 0.0])])
    disc = np.zeros((16, 16))
    disc[2:14, 2:14] = 1
    (trial,) = work.try_layers([disc], np.full(3, 0.2))
    assert trial.depth == 0
    work.insert(trial)
    assert work.stack.order.tolist() == [1, 0]
    assert work.error.sum() == pytest.approx(0, abs=target.size * ROUNDING)


@pytest.mark.parametrize(("pixels", "depth"), [(2, 1), (8, 0)])
def test_a_lower_depth_must_be_better_by_enough(pixels: int, depth: int) -> None:
    # On top, a grey square of 400 px spoils a few black ones: by that it removes 2 / 396 or 8 / 384 less.
    target = np.ones((24, 24, 3))
    target[2:22, 2:22] = 0.5
    target[2, 2 : 2 + pixels] = 0
    line, square = np.zeros((2, 24, 24))
    line[2, 2 : 2 + pixels], square[2:22, 2:22] = 1, 1
    image = np.ones((24, 24, 3))
    image[2, 2 : 2 + pixels] = 0
    work = _painting(target, image, np.ones(3), [line], [np.zeros(3)])
    (trial,) = work.try_layers([square], np.full(3, 0.5))
    assert trial.depth == depth


def test_a_small_overlap_counts_where_every_second_pixel_is_looked_at() -> None:
    # A black spot of 2 x 2 px, of which one is looked at, under a pale square of 900.
    target, image = np.ones((2, 34, 34, 3))
    target[2:32, 2:32] = 0.9
    target[10:12, 10:12] = image[10:12, 10:12] = 0
    spot, square = np.zeros((2, 34, 34))
    spot[10:12, 10:12], square[2:32, 2:32] = 1, 1
    work = _painting(target, image, np.ones(3), [spot], [np.zeros(3)])
    (trial,) = work.try_layers([square], np.full(3, 0.9), roughly=True)
    assert trial.depth == 0


def test_nothing_covered_changes_nothing() -> None:
    background, alphas, colors, target = _scene(1)
    before = _composite(background, alphas, colors)
    work = _painting(target, before, background, alphas, colors)
    (trial,) = work.try_layers([np.zeros((12, 15))], np.zeros(3))
    assert trial.gain == 0
    work.insert(trial)
    np.testing.assert_allclose(work.stack.image, before, atol=ROUNDING)


def test_too_many_layers_count_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    background, alphas, colors, target = _scene(2)
    before = _composite(background, alphas, colors)
    monkeypatch.setattr(stack, "MAX_NUMBERS", 100)
    work = _painting(target, before, background, alphas, colors)
    (trial,) = work.try_layers([_patch()], np.zeros(3))
    work.insert(trial)
    assert work.stack.order.tolist() == [0, 1, 2, 3, 4]
