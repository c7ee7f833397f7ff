# SPDX-License-Identifier: Apache-2.0
"""Evidence of depth, by known values: T-junctions, bulges, and the paint order that agrees best with all of it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.outlines.contours import AFTER, BEFORE, OWN, UNCLEAR, Contour
from livecl.layering.outlines.prices import PRICES
from livecl.layering.structure.depth import _bulge, _hull, _junctions
from livecl.layering.structure.ordering import paint_order

#: Radius, px, of a disc whose outline faces region 1 below its middle, and region 2 above it.
RADIUS = 20.0
SIZES = np.array([50, 40, 30, 20])


def disc(radius: float = RADIUS, straight: int = UNCLEAR) -> Contour:
    """Return a disc's outline; `straight` tells whose outline runs through where region 1 gives way to 2."""
    count = round(2 * np.pi * radius)
    angles = 2 * np.pi * (np.arange(count) + 0.5) / count
    points = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.where(angles < np.pi, 1, 2)
    kinds = np.zeros(count, np.int64)
    kinds[int(np.argmax(across == 2))] = straight
    return Contour(points, across, kinds)


def marks(*regions: int) -> NDArray[np.bool_]:
    below = np.zeros(6, bool)
    below[list(regions)] = True
    return below


@pytest.mark.parametrize(
    ("kind", "of_1", "of_2"),
    [(UNCLEAR, 0, 0), (OWN, PRICES.hull, PRICES.hull), (BEFORE, -PRICES.stem, 0), (AFTER, 0, -PRICES.stem)],
)
def test_who_runs_through_a_junction_lies_in_front(kind: int, of_1: float, of_2: float) -> None:
    contour = disc(straight=kind)
    hull = _hull(contour.points)
    assert _junctions(contour, 1, hull, 1000, PRICES) == of_1
    assert _junctions(contour, 2, hull, 1000, PRICES) == of_2
    assert _junctions(contour, 3, hull, 1000, PRICES) == 0


def test_junctions_in_a_bay_say_the_opposite() -> None:
    contour = disc(straight=OWN)
    around = _hull(3 * contour.points)
    assert _junctions(contour, 1, around, 1000, PRICES) == PRICES.bay < 0 < PRICES.hull
    assert _junctions(contour, 1, None, 1000, PRICES) == PRICES.hull


@pytest.mark.parametrize("turned", [1, -1])
def test_a_half_disc_bulges_by_an_eighth_of_pi(turned: int) -> None:
    """Half of pi r^2 over the square of 2 r, but for half a step at each end; whichever way the outline runs."""
    whole = disc()
    contour = Contour(whole.points[::turned], whole.across[::turned], whole.straight)
    assert _bulge(contour, marks(1)) == pytest.approx(np.pi / 8, rel=0.05)
    assert _bulge(contour, marks(3)) == 0
    assert _bulge(contour, marks(1, 2)) == 0, "all around it is no bulge"


def test_a_bay_is_a_negative_bulge() -> None:
    """A square with a half disc cut out of one side, where region 1 lies."""
    arc = disc().points[disc().across == 1][::-1]
    side = np.linspace(arc[-1], (60, 0), 30)
    corner = np.array([(60.0, 60), (-60, 60), (-60, 0)])
    points = np.concatenate([arc, side, corner])
    across = np.where(np.arange(len(points)) < len(arc), 1, 2)
    contour = Contour(points, across, np.zeros(len(points), np.int64))
    assert _bulge(contour, marks(1)) == pytest.approx(-np.pi / 8, rel=0.05)


def test_the_paint_order_follows_the_evidence() -> None:
    front = {(0, 1): 1.0, (1, 2): 1.0, (2, 3): 0.5}  # the first of each pair lies in front
    assert paint_order(front, [0, 1, 2, 3], SIZES, []) == [3, 2, 1, 0]
    assert paint_order({}, [0, 1, 2, 3], SIZES, []) == [0, 1, 2, 3], "the largest below"
    assert paint_order({**front, (1, 0): 3.0}, [0, 1, 2, 3], SIZES, []) == [0, 3, 2, 1], "both ways are weighed"


def test_what_contradicts_least_is_kept_in_a_circle() -> None:
    front = {(0, 1): 2.0, (1, 2): 2.0, (2, 0): 0.1}
    assert paint_order(front, [0, 1, 2], SIZES, []) == [2, 1, 0]


def test_regions_of_one_shape_follow_each_other() -> None:
    front = {(0, 1): 1.0, (1, 2): 1.0}
    order = paint_order(front, [0, 1, 2, 3], SIZES, [(0, 3)])
    assert abs(order.index(0) - order.index(3)) == 1
    assert order.index(2) < order.index(1) < order.index(0)
