# SPDX-License-Identifier: Apache-2.0
"""Amodal completion of single outlines, by known shapes: gaps closed, parts joined, a ring cut, trapping."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.found import flat_regions

from livecl.layering.outlines.completion import (
    TRAP,
    _points_between,
    completed_contour,
    cut_in_two,
    joined_contours,
    trapped,
)
from livecl.layering.outlines.contours import COMPLETED, Contour, Outlines
from livecl.layering.outlines.prices import PRICES, outline_price

RED, BLUE, WHITE = (0.9, 0.2, 0.1), (0.1, 0.2, 0.8), (1.0, 1.0, 1.0)
FINE, SIZE = 4, (60, 80)
ROWS, COLUMNS = (np.indices((FINE * SIZE[0], FINE * SIZE[1])) + 0.5) / FINE

Mask = NDArray[np.bool_]


def box(left: float, top: float, right: float, bottom: float) -> Mask:
    return np.asarray((left <= COLUMNS) & (right >= COLUMNS) & (top <= ROWS) & (bottom >= ROWS))


def disc(x: float, y: float, radius: float) -> Mask:
    return np.asarray(np.hypot(COLUMNS - x, ROWS - y) <= radius)


class Scene:
    """A red shape under a blue cover, on white."""

    def __init__(self, shape: Mask, cover: Mask) -> None:
        image = np.ones((*ROWS.shape, 3))
        image[shape], image[cover] = RED, BLUE
        mean = image.reshape(SIZE[0], FINE, SIZE[1], FINE, 3).mean(axis=(1, 3))
        self.outlines = Outlines(flat_regions(np.round(255 * mean) / 255))
        colors = self.outlines.regions.colors
        self.red = np.flatnonzero(np.abs(colors - RED).max(axis=1) < 0.01).tolist()
        self.below = self.outlines.marks(np.flatnonzero(np.abs(colors - BLUE).max(axis=1) < 0.01))
        self.parts = [self.outlines.outer(k) for k in self.red]
        self.room = self.outlines.room(self.red, self.below)

    @property
    def arguments(self) -> tuple[Mask, Mask, Outlines]:
        return self.below, self.room, self.outlines


def area(contour: Contour) -> float:
    return abs(contour.area)


def test_a_half_hidden_disc_is_a_whole_one() -> None:
    scene = Scene(disc(36, 30, 18), box(40, 4, 70, 56))
    (seen,) = scene.parts
    whole, price = completed_contour(seen, *scene.arguments, PRICES)
    assert area(whole) == pytest.approx(np.pi * 18**2, rel=0.02)
    assert price < outline_price(seen.points)
    assert (whole.across[whole.points[:, 0] > 43] == COMPLETED).all()
    assert not (whole.across[whole.points[:, 0] < 37] == COMPLETED).any()


def test_an_outline_below_nothing_stays() -> None:
    scene = Scene(disc(36, 30, 18), box(40, 4, 70, 56))
    (seen,) = scene.parts
    nothing = scene.outlines.marks(())
    whole, price = completed_contour(seen, nothing, scene.outlines.room(scene.red, nothing), scene.outlines, PRICES)
    assert whole is seen and price == outline_price(seen.points)


def test_nothing_is_made_up_where_there_is_no_room() -> None:
    """A cover of 6 px: the disc would show beyond it."""
    scene = Scene(disc(36, 30, 18) & box(0, 0, 40, 60), box(40, 4, 46, 56))
    whole, _ = completed_contour(scene.parts[0], *scene.arguments, PRICES)
    assert whole.points[:, 0].max() < 46.5
    assert area(whole) < 0.8 * np.pi * 18**2


@pytest.mark.parametrize("lower", [0, 2])
def test_two_parts_of_a_bar_are_joined_below_what_crosses_it(lower: float) -> None:
    cover = box(34, 4, 46, 56)
    scene = Scene(box(8, 20, 40, 34) | box(40, 20 + lower, 72, 34 + lower), cover)
    found = joined_contours(*scene.parts, *scene.arguments, PRICES)
    assert found is not None
    assert area(found[0]) == pytest.approx(64 * 14, rel=0.03)
    assert found[1] < sum(outline_price(part.points) for part in scene.parts)


def test_parts_that_do_not_see_each_other_stay_apart() -> None:
    scene = Scene(box(8, 4, 40, 18) | box(40, 40, 72, 54), box(34, 2, 46, 58))
    assert joined_contours(*scene.parts, *scene.arguments, PRICES) is None
    apart = Scene(box(8, 20, 32, 34) | box(48, 20, 72, 34), box(34, 4, 46, 56))  # white shows between
    assert joined_contours(*apart.parts, *apart.arguments, PRICES) is None


def test_a_ring_closes_below_what_covers_it() -> None:
    scene = Scene(disc(36, 30, 24) & ~disc(36, 30, 15), box(46, 25, 74, 35))
    (seen,) = scene.parts
    found = cut_in_two(seen, *scene.arguments, PRICES)
    assert found is not None
    assert sorted(map(area, found)) == pytest.approx([np.pi * 15**2, np.pi * 24**2], rel=0.03)
    assert cut_in_two(seen, scene.outlines.marks(()), scene.room, scene.outlines, PRICES) is None


def test_a_bar_below_a_cover_is_no_ring() -> None:
    scene = Scene(box(8, 20, 72, 34), box(34, 4, 46, 56))
    assert all(cut_in_two(part, *scene.arguments, PRICES) is None for part in scene.parts)


def test_what_ends_at_a_cover_goes_on_a_little_below_it() -> None:
    scene = Scene(box(8, 20, 40, 34), box(40, 4, 72, 56))
    (seen,) = scene.parts
    moved = trapped(seen, scene.below, scene.room, scene.outlines)
    ends = scene.below[seen.across]
    inner = np.all([np.roll(ends, shift) for shift in range(-3, 4)], axis=0)
    np.testing.assert_allclose((moved - seen.points)[inner], [(TRAP, 0)] * np.count_nonzero(inner), atol=0.05)
    assert (moved[~ends] == seen.points[~ends]).all()
    nothing = scene.outlines.marks(())
    np.testing.assert_array_equal(trapped(seen, nothing, scene.room, scene.outlines), seen.points)


def test_pixels_between_two_outlines_are_counted_by_their_centres() -> None:
    def square(low: float, high: float) -> Contour:
        points = np.array([(low, low), (high, low), (high, high), (low, high)])
        return Contour(points, np.zeros(4, np.int64), np.zeros(4, np.int64))

    points = _points_between(square(4, 8), square(2, 10))
    assert len(points) == 64 - 16 and (points % 1 == 0.5).all()
    assert not ((points > 4) & (points < 8)).all(axis=1).any()
