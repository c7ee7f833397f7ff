# SPDX-License-Identifier: Apache-2.0
"""Shapes of one colour that touch are told apart where both outlines go on; silhouettes are left whole."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from skimage.draw import polygon2mask
from support.found import flat_regions

from livecl.layering.outlines.contours import Outlines
from livecl.layering.structure.layers import find_layers
from livecl.layering.structure.parts import with_more_parts, with_parts
from livecl.layering.structure.views import ground_regions

SIZE, FINE = 96, 4
RED, WHITE, BLUE = np.array([0.9, 0.2, 0.2]), np.ones(3), np.array([0.15, 0.3, 0.75])
Mask = NDArray[np.bool_]


def shape(*points: tuple[float, float]) -> Mask:
    """Return the samples within a polygon, (x, y) px."""
    return np.asarray(polygon2mask((FINE * SIZE, FINE * SIZE), FINE * np.array(points)[:, ::-1] - 0.5))


def disc(x: float, y: float, radius: float) -> Mask:
    rows, columns = (np.indices((FINE * SIZE, FINE * SIZE)) + 0.5) / FINE
    return np.asarray(np.hypot(columns - x, rows - y) <= radius)


def small(mask: Mask) -> NDArray[np.float64]:
    return np.asarray(mask.reshape(SIZE, FINE, SIZE, FINE).mean(axis=(1, 3)))


def found(*layers: tuple[Mask, NDArray[Any]]) -> list[Mask]:
    """Return the masks of the layers found in a picture of some on white, the largest first."""
    image = np.ones((SIZE, SIZE, 3))
    for mask, color in layers:
        cover = small(mask)[..., None]
        image = image * (1 - cover) + cover * color
    pixels = np.round(255 * image) / 255
    masks = []
    for layer in find_layers(with_parts(flat_regions(pixels), WHITE), WHITE):
        mask = np.zeros((SIZE, SIZE), bool)
        for points in layer.outlines:
            mask ^= polygon2mask(mask.shape, points[:, ::-1] - 0.5)
        masks.append(mask)
    return sorted(masks, key=lambda mask: -int(mask.sum()))


def overlap(mask: Mask, wanted: Mask) -> float:
    whole = small(wanted) >= 0.5
    return float((mask & whole).sum() / (mask | whole).sum())


HEAD = shape((14, 48), (46, 16), (46, 80))
SHAFT = shape((46, 38), (84, 38), (84, 58), (46, 58))


def test_an_arrow_is_a_head_and_a_shaft() -> None:
    head, shaft = found((HEAD | SHAFT, RED))
    assert overlap(head, HEAD) > 0.97 and overlap(shaft, SHAFT) > 0.8  # it may go on below the head


def test_a_tilted_arrow_is_a_head_and_a_shaft() -> None:
    turn = np.array([[0.8, 0.6], [-0.6, 0.8]])

    def turned(*points: tuple[float, float]) -> Mask:
        return shape(*(np.array(points) - 48) @ turn + 48)

    head = turned((14, 48), (46, 16), (46, 80))
    shaft = turned((46, 38), (84, 38), (84, 58), (46, 58))
    masks = found((head | shaft, RED))
    assert len(masks) == 2 and overlap(masks[0], head) > 0.97 and overlap(masks[1], shaft) > 0.8


def test_two_discs_of_one_color_across_each_other_are_two_whole_discs() -> None:
    left, right = disc(34, 48, 24), disc(66, 48, 20)
    masks = found((left | right, RED))
    assert len(masks) == 2 and overlap(masks[0], left) > 0.97 and overlap(masks[1], right) > 0.97


def test_a_part_that_another_color_lies_across_stays_one() -> None:
    band = shape((58, 28), (66, 28), (66, 68), (58, 68))
    head, shaft, across = found((HEAD | SHAFT, RED), (band, BLUE))
    assert overlap(head, HEAD) > 0.97 and overlap(shaft, SHAFT) > 0.8 and overlap(across, band) > 0.97


def test_a_cross_a_comb_and_a_bump_are_one_shape_each() -> None:
    bar = shape((10, 40), (86, 40), (86, 56), (10, 56))
    assert len(found((bar | shape((40, 10), (56, 10), (56, 86), (40, 86)), RED))) == 1
    teeth = [shape((x, 56), (x + 8, 56), (x + 8, 80), (x, 80)) for x in (14, 34, 54, 74)]
    assert len(found((np.any([bar, *teeth], axis=0), RED))) == 1
    assert len(found((bar | disc(48, 44, 14), RED))) == 1


def test_letters_and_what_has_holes_are_not_cut() -> None:
    bowl, stem = disc(40, 50, 22), shape((56, 10), (66, 10), (66, 72), (56, 72))
    assert len(found(((bowl | stem) & ~disc(38, 50, 12), RED))) == 1


def test_a_sign_in_a_large_picture_is_not_cut() -> None:
    image = 1 - small(HEAD | SHAFT)[..., None] * (WHITE - RED)
    page = np.pad(image, ((0, 210), (0, 210), (0, 0)), constant_values=1.0)
    assert [with_parts(flat_regions(pixels), WHITE).count for pixels in (image, page)] == [3, 2]


def test_a_silhouette_is_cut_further_where_more_parts_are_asked_for() -> None:
    battery = shape((26, 30), (70, 30), (70, 86), (26, 86)), shape((38, 14), (58, 14), (58, 30), (38, 30))
    image = 1 - small(battery[0] | battery[1])[..., None] * (WHITE - RED)
    whole = with_parts(flat_regions(image), WHITE)
    assert whole.count == 2  # with the ground
    cut = with_more_parts(whole, 1)
    areas = [abs(cut.outer(k).area) for k in range(cut.count) if k not in (cut.ground or ())]
    assert np.allclose(sorted(areas), [20 * 16, 44 * 56], rtol=0.02)
    square = with_parts(flat_regions(1 - small(battery[0])[..., None] * (WHITE - RED)), WHITE)
    assert with_more_parts(square, 3) is square  # nothing to cut


def test_of_cuts_that_are_asked_for_the_shortest_come_first() -> None:
    head = disc(48, 48, 32) | disc(16, 48, 9) | disc(80, 48, 9)
    whole = with_parts(flat_regions(1 - small(head)[..., None] * (WHITE - RED)), WHITE)
    assert whole.count == 2
    for number in (1, 2):
        cut = with_more_parts(whole, number)
        areas = sorted(abs(cut.outer(k).area) for k in range(cut.count) if k not in (cut.ground or ()))
        assert len(areas) == number + 1 and areas[0] < 200 and areas[-1] > 3000


def test_what_a_head_surrounds_is_no_ground_once_the_ears_are_cut_off_it() -> None:
    ears = (disc(14, 34, 14) | disc(82, 34, 14)) & ~disc(48, 52, 29)
    head = disc(48, 52, 34) & ~disc(48, 52, 29)
    whole = with_parts(flat_regions(1 - small(head | ears)[..., None] * (WHITE - RED)), WHITE)
    face = whole.regions.labels[52, 48]
    assert whole.ground is not None and face not in whole.ground
    cut = with_more_parts(whole, 2)
    assert cut.count == whole.count + 2 and cut.ground == whole.ground
    assert face in ground_regions(Outlines(cut.regions), WHITE)  # by itself it would be
