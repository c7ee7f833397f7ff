# SPDX-License-Identifier: Apache-2.0
"""What an outline costs: by how much it turns in all, and its corners."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.geometry.polylines import polygon_area
from livecl.layering.outlines.prices import PRICES, hidden_price, outline_price, sliver_price

FloatArray = NDArray[np.float64]
FULL = 2 * np.pi
SQUARE, BAY = [(0, 0), (40, 0), (40, 40), (0, 40)], [(0, 0), (60, 0), (60, 20), (20, 20), (20, 60), (0, 60)]


def polygon(corners: list[tuple[float, float]]) -> FloatArray:
    """Points a px apart on a closed polygon."""
    ends = np.roll(np.array(corners, float), -1, axis=0)
    sides = zip(np.array(corners, float), ends, strict=True)
    return np.concatenate([np.linspace(a, b, int(np.hypot(*(b - a))), endpoint=False) for a, b in sides])


def circle(radius: float) -> FloatArray:
    angles = FULL * np.arange(round(FULL * radius)) / round(FULL * radius)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@pytest.mark.parametrize("radius", [20, 60])
def test_a_circle_turns_once_and_has_no_corner(radius: float) -> None:
    assert outline_price(circle(radius)) == pytest.approx(FULL, abs=1e-6)


@pytest.mark.parametrize(("corners", "turns", "count"), [(SQUARE, 1.0, 4), (BAY, 1.5, 6)])
def test_corners_cost_what_they_turn_and_a_price_each(
    corners: list[tuple[float, float]], turns: float, count: int
) -> None:
    """A corner that turns the other way, as in a bay, is turned back elsewhere: both count."""
    price = outline_price(polygon(corners))
    assert price == pytest.approx(turns * FULL + count * PRICES.corner, rel=0.03)
    free = dataclasses.replace(PRICES, corner=0.0)
    assert outline_price(polygon(corners), free) == pytest.approx(turns * FULL, rel=0.03)


def test_the_price_is_that_of_the_outline_whichever_way_it_runs() -> None:
    points = polygon(BAY)
    assert outline_price(points[::-1]) == pytest.approx(outline_price(points), rel=0.03)
    assert outline_price(np.roll(points, 9, axis=0)) == pytest.approx(outline_price(points), rel=0.03)


def test_jitter_of_a_border_costs_little() -> None:
    """Steps of half a pixel, to and fro, at every other point of a circle of 30 px."""
    points = circle(30) * (1 + np.where(np.arange(len(circle(30))) % 2, 0.25, -0.25)[:, None] / 30)
    assert outline_price(points) == pytest.approx(FULL, rel=0.05)


def test_outlines_of_a_few_points_turn_once() -> None:
    assert outline_price(polygon([(0, 0), (1, 0), (1, 1), (0, 1)])) == FULL


def test_areas_have_the_sign_of_the_way_round() -> None:
    assert polygon_area(polygon(SQUARE)) == pytest.approx(1600)
    assert polygon_area(polygon(SQUARE)[::-1]) == pytest.approx(-1600)
    assert polygon_area(polygon(BAY) + np.array((7, -3))) == pytest.approx(2000)


def test_a_hidden_area_costs_by_its_share_and_much_where_a_sliver_is_seen() -> None:
    assert hidden_price(10, 10) == hidden_price(8, 10) == 0
    assert hidden_price(-20, 10) == pytest.approx(PRICES.hidden * np.log(2))
    assert sliver_price(PRICES.sliver) == 0
    disc, crescent = FULL, 2 * FULL  # what they turn by at least, the second with its two tips
    assert hidden_price(4, 1) < crescent - disc < hidden_price(12, 1)
