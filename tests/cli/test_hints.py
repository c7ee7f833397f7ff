# SPDX-License-Identifier: Apache-2.0
"""Hints for drawings far from their pictures: the bound follows from the picture."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray
from support.results import result_of, sample_drawing

from livecl import Options
from livecl.cli.hints import fine_detail, hint, smooth_share
from livecl.run.recipe import Recipe

RAMP = np.tile(np.round(255 * np.linspace(0.4, 0.6, 160))[None, :, None] / 255, (90, 1, 3))
NOISE = np.clip(0.5 + 0.02 * np.random.default_rng(0).standard_normal((90, 160, 3)), 0, 1)


def said(image: NDArray[np.float64], mse: float, paths: int = 3, **changes: object) -> str:
    result = dataclasses.replace(result_of(sample_drawing(), np.zeros((240, 200, 3))), mse=mse)
    recipe = Recipe(paths=paths, options=Options(**changes))  # type: ignore[arg-type]
    return hint(recipe, result, image)


def test_a_smooth_ramp_asks_for_gradients() -> None:
    assert smooth_share(RAMP) > 0.9
    assert "--fills auto" in said(RAMP, 4e-4, fills="solid")
    assert "--fills auto" not in said(RAMP, 4e-4)
    assert said(RAMP, 1e-5, fills="solid") == ""  # less than is seen


@pytest.mark.parametrize("image", [NOISE, np.ones((90, 160, 3)), np.eye(90)[..., None].repeat(3, axis=2)])
def test_noise_flat_colour_and_lines_are_not_smooth(image: NDArray[np.float64]) -> None:
    assert smooth_share(image) < 0.05


def test_noise_is_named_as_such_and_not_answered_with_more_paths() -> None:
    grain = np.random.default_rng(0).random((90, 160, 3))
    assert "noise" in said(grain, 0.08) and "--paths" not in said(grain, 0.08)
    cells = np.kron(np.random.default_rng(1).random((9, 16, 3)), np.ones((10, 10, 1)))  # many inks are no noise
    assert "--paths 12" in said(cells, 0.05) and "noise" not in said(cells, 0.05)
    assert "noise" not in said(RAMP, 0.005)


def test_small_print_that_is_missing_is_named() -> None:
    page = np.ones((90, 160, 3))
    page[10:80:8, 10:150:4] = 0.1  # marks of a pixel
    page[10:80:8, 11:150:8] = 0.1
    fine = fine_detail(page, None)
    assert "small or thin parts" in said(page, 0.9 * fine)
    assert said(page, 0.02 * fine) == "", "most of them are there"
    assert "small or thin" not in said(page, 0.9 * fine, prune=2e-4), "left out on purpose"
    grain = np.random.default_rng(0).random((90, 160, 3))
    assert "small or thin" not in said(grain, 0.08)
    half = said(page, 0.3 * fine)
    assert "small or thin parts" in half and "noise" not in half, "far from the picture, though most of them are there"


def test_the_advice_for_small_print_leads_on() -> None:
    """Strokes where they are off; more pixels only where there are more."""
    page = np.ones((90, 160, 3))
    page[10:80:8, 10:150:4] = 0.1
    error = 0.9 * fine_detail(page, None)
    assert "--strokes auto" in said(page, error) and "--size" not in said(page, error)
    assert "--strokes" not in said(page, error, strokes="auto") and "--paths auto" in said(page, error, strokes="auto")
    result = dataclasses.replace(
        result_of(sample_drawing(), np.zeros((240, 200, 3))), mse=error, working_size=(90, 160)
    )
    assert "--size" in hint(Recipe(paths=3), result, np.kron(page, np.ones((2, 2, 1))))
    assert "--size" not in hint(Recipe(paths=3), result, page), "as many pixels as there are"


def test_pale_pictures_have_a_lower_bound() -> None:
    """A drawing of a pale picture that lacks half of it has a small error all the same."""
    page = np.ones((90, 160, 3))
    page[20:60, 30:90] = 1 - 12 / 255
    half = float(np.mean(np.var(page, axis=(0, 1)))) / 2
    assert half < 5e-4
    assert "far from the picture" in said(page, half)
    dark = page.copy()
    dark[20:60, 30:90] = 0
    assert said(dark, half) == ""
    assert "far from the picture" in said(dark, 6e-3)


def test_a_price_of_layers_that_leaves_gaps_is_named() -> None:
    halves = np.ones((90, 160, 3))
    halves[:, 80:] = 0
    far = 0.05  # of a variance of 0.25
    used = sample_drawing().num_layers
    assert "--prune" in said(halves, far, paths=used + 1, prune=2e-4)
    assert "--path-gain" in said(halves, far, paths=used + 1)
    assert "--paths" in said(halves, far, paths=used, prune=2e-4)  # none was left out


def test_transparent_pictures_vary_by_what_is_seen() -> None:
    clear = np.concatenate([NOISE, np.zeros((90, 160, 1))], axis=2)
    assert said(clear, 6e-5) == ""


def test_a_picture_of_one_pixel_is_not_smooth() -> None:
    assert smooth_share(np.zeros((1, 1, 3))) == 0
