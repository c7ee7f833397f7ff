# SPDX-License-Identifier: Apache-2.0
"""Fills over each other by known ones: colours and opacities are found again, and none where one fill does."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.fills import LINEAR, RADIAL
from livecl.layering.fills.overlays import fit_overlaid
from livecl.layering.fills.ramps import Paint, fit_paint

KINDS = ("linear", "radial")
PRICE = 0.03
PINK = (1.0, 0.4, 0.9)
#: Centres of 60 x 60 pixels.
POINTS = np.stack(np.meshgrid(np.arange(60) + 0.5, np.arange(60) + 0.5), axis=-1).reshape(-1, 2)


def ramp(start: tuple[float, float], end: tuple[float, float], *stops: tuple[float, ...]) -> Paint:
    """Return a linear gradient of evenly placed stops."""
    geometry = np.array([start, end, (0, 0)], dtype=float)
    colors = np.array(stops, dtype=float)
    return Paint(LINEAR, colors[0], geometry, np.linspace(0, 1, len(stops)), colors, 0.0)


BASE = ramp((0, 0), (20, 60), (0.1, 0.7, 0.7, 1), (0.1, 0.4, 0.9, 1))
FADING = ramp((60, 0), (50, 60), (*PINK, 0), (*PINK, 0), (*PINK, 0.7))


def eight_bits(colors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.round(colors * 255) / 255


def test_two_fills_over_each_other_are_found_again() -> None:
    wanted = eight_bits(dataclasses.replace(BASE, over=(FADING,)).at(POINTS))
    assert fit_paint(POINTS, wanted, np.ones(len(POINTS)), PRICE, KINDS).error > 0.2, "one is not enough"
    found = fit_overlaid(POINTS, wanted, PRICE, KINDS)
    assert found is not None and len(found.over) == 1
    assert np.abs(found.at(POINTS) - wanted).max() < 3.5 / 255
    np.testing.assert_allclose(found.over[0].at(POINTS)[:, :3].mean(axis=0), PINK, atol=0.05)
    below = dataclasses.replace(found, over=())
    np.testing.assert_allclose(below.at(POINTS), BASE.at(POINTS), atol=0.03)


def test_a_round_shadow_on_one_colour_is_found_again() -> None:
    shadow = Paint(
        RADIAL,
        np.array([0.1, 0.0, 0.2, 1.0]),
        np.array([(60.0, 50.0), (85.0, 50.0), (60.0, 75.0)]),
        np.array([0.0, 1.0]),
        np.array([(0.1, 0.0, 0.2, 0.8), (0.1, 0.0, 0.2, 0.0)]),
        0.0,
    )
    wanted = eight_bits(dataclasses.replace(BASE, over=(shadow,)).at(POINTS))
    found = fit_overlaid(POINTS, wanted, PRICE, KINDS)
    assert found is not None and found.over[0].kind == RADIAL
    np.testing.assert_allclose(found.over[0].geometry[0], (60, 50), atol=3)
    assert np.mean(np.abs(found.at(POINTS) - wanted).max(axis=1) < 3.5 / 255) > 0.98


def test_there_is_no_other_fill_over_one_that_does() -> None:
    wanted = eight_bits(BASE.at(POINTS))
    one = fit_paint(POINTS, wanted, np.ones(len(POINTS)), PRICE, KINDS)
    assert fit_overlaid(POINTS, wanted, PRICE, KINDS, most=one.error + PRICE * (one.numbers + 24)) is None


def test_what_costs_less_otherwise_is_left() -> None:
    wanted = eight_bits(dataclasses.replace(BASE, over=(FADING,)).at(POINTS))
    found = fit_overlaid(POINTS, wanted, PRICE, KINDS)
    assert found is not None
    assert fit_overlaid(POINTS, wanted, PRICE, KINDS, most=found.error + PRICE * found.numbers) is None


def test_numbers_count_the_outline_again_and_a_moved_fill_shows_the_same() -> None:
    both = dataclasses.replace(BASE, over=(FADING,))
    assert both.numbers == BASE.numbers + FADING.numbers + 24
    offset = np.array([7.0, -3.0])
    np.testing.assert_allclose(both.shifted(offset).at(POINTS + offset), both.at(POINTS))
    assert not both.solid
