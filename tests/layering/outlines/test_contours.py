# SPDX-License-Identifier: Apache-2.0
"""Outlines of regions and what lies across them: runs below a neighbour, stray labels, points in regions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.found import flat_regions

from livecl.layering.outlines.contours import _SELF, PAGE, Contour, Outlines, _cleaned

RED, BLUE, GREEN = (0.8, 0.1, 0.1), (0.1, 0.2, 0.8), (0.1, 0.7, 0.2)


def facing(*across: int) -> Contour:
    """Return an outline whose points face these regions."""
    count = len(across)
    angles = 2 * np.pi * np.arange(count) / count
    points = 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return Contour(points, np.array(across), np.zeros(count, np.int64))


def marks(*regions: int) -> NDArray[np.bool_]:
    below = np.zeros(6, bool)
    below[list(regions)] = True
    return below


def test_runs_are_where_marked_regions_lie_across_around_the_start_as_well() -> None:
    contour = facing(1, 1, 0, 0, 0, 2, 2, 1)
    assert contour.runs(marks(0)) == [(2, 3)]
    assert contour.runs(marks(1)) == [(7, 3)]
    assert sorted(contour.runs(marks(0, 1)) or []) == [(2, 3), (7, 3), (7, 6)], "the whole run, then its parts"
    assert contour.runs(marks()) == []
    assert contour.runs(marks(0, 1, 2)) is None


def test_outlines_on_the_page_s_border_face_the_page() -> None:
    contour = facing(PAGE, PAGE, 0, 0)
    assert contour.runs(marks(PAGE)) == [(0, 2)]


@pytest.mark.parametrize(
    ("across", "wanted"),
    [
        ([1, 1, 2, 1, 1, 3, 3, 3], [1, 1, 1, 1, 1, 3, 3, 3]),  # one point within another's run
        ([1, 1, 2, 2, 2, 1, 1, 1], [1, 1, 2, 2, 2, 1, 1, 1]),
        ([_SELF, 1, 1, 1, _SELF, 2, 2, 2, _SELF], [2, 1, 1, 1, 1, 2, 2, 2, 2]),
        ([_SELF, _SELF], [PAGE, PAGE]),
    ],
)
def test_stray_and_unknown_labels_become_those_before_them(across: list[int], wanted: list[int]) -> None:
    assert _cleaned(np.array(across)).tolist() == wanted


def three() -> Outlines:
    """A red square of 20 px with a blue one of 8 px in it, beside a green band, on white."""
    image = np.ones((40, 60, 3))
    image[8:28, 6:26] = RED
    image[14:22, 12:20] = BLUE
    image[:, 40:50] = GREEN
    return Outlines(flat_regions(image))


def region(outlines: Outlines, color: tuple[float, ...]) -> int:
    return int(np.abs(outlines.regions.colors - color).max(axis=1).argmin())


def test_a_larger_outline_keeps_a_region_only_where_it_encloses_it() -> None:
    outlines = three()
    red = region(outlines, RED)
    own = outlines.outer(red)

    def moved(x: float, y: float, factor: float) -> Contour:
        points = factor * (own.points - own.points.mean(axis=0)) + own.points.mean(axis=0) + (x, y)
        return Contour(points, own.across, own.straight)

    assert outlines.keeps([red], own, own) and outlines.keeps([red], own, moved(0, 0, 1.5))
    assert not outlines.keeps([red], own, moved(0, 0, 0.9))
    larger = moved(8, 0, 1.5)  # a third wider, but 3 px of the left of the region lie outside
    assert abs(larger.area) > 2 * abs(own.area)
    assert not outlines.keeps([red], own, larger)


def test_outlines_enclose_their_regions_the_largest_first() -> None:
    outlines = three()
    red, blue = region(outlines, RED), region(outlines, BLUE)
    outer, hole = outlines.of((red,))
    assert abs(outer.area) == pytest.approx(400, rel=0.02) and abs(hole.area) == pytest.approx(64, rel=0.06)
    assert hole.is_hole_of(outer) and not outer.is_hole_of(outer)
    (both,) = outlines.of((red, blue))
    assert abs(both.area) == pytest.approx(400, rel=0.02)
    assert outlines.of((blue, red))[0] is both


def test_neighbours_face_each_other() -> None:
    outlines = three()
    red, blue, green = (region(outlines, color) for color in (RED, BLUE, GREEN))
    around = outlines.neighbors(red)
    assert blue in around and green not in around and red not in around
    assert around[blue] == pytest.approx(32, abs=4), "as many points as the border has px"
    assert PAGE in outlines.of((green,))[0].across and PAGE not in outlines.neighbors(green)


def test_shares_of_points_in_regions_count_a_pixel_beside_them() -> None:
    outlines = three()
    room = outlines.marks((region(outlines, RED),))
    inside, beside, off = (10.5, 12.5), (26.5, 12.5), (28.5, 12.5)
    assert outlines.share_in(np.array([inside, beside]), room) == 1
    assert outlines.share_in(np.array([inside, off]), room) == 0.5
    assert outlines.share_in(np.zeros((0, 2)), room) == 1


def test_an_outline_keeps_the_pixels_of_its_regions_or_does_not() -> None:
    outlines = three()
    red = region(outlines, RED)
    outer = outlines.outer(red)
    smaller = Contour((outer.points - 16) * 0.7 + 16, outer.across, outer.straight)
    hair = Contour((outer.points - (16, 18)) * 0.995 + (16, 18), outer.across, outer.straight)
    assert outlines.keeps((red,), outer, outer) and outlines.keeps((red,), outer, hair)
    assert not outlines.keeps((red,), outer, smaller)
    assert outlines.keeps((red,), smaller, outer), "one that is larger keeps all"
