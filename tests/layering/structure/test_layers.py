# SPDX-License-Identifier: Apache-2.0
"""Known small drawings: the layers that a person would draw are found, whole and in order."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skimage.draw import polygon2mask
from support.found import flat_regions
from support.small_drawings import (
    BLUE,
    GREEN,
    GREY,
    RED,
    SIZE,
    WHITE,
    YELLOW,
    X,
    Y,
    box,
    check,
    disc,
    found,
    overlap,
    picture,
)

from livecl import read_image
from livecl.geometry.crossings import polygon_crossing_area
from livecl.layering.outlines.completion import completed_contour, filled_out
from livecl.layering.outlines.contours import Outlines
from livecl.layering.outlines.prices import PRICES
from livecl.layering.structure.layers import Assumptions, find_layers
from livecl.layering.structure.parts import with_parts
from livecl.layering.structure.twins import few_alike


def test_a_disc_behind_a_disc_is_whole() -> None:
    layers = (disc(40, 48, 26), RED), (disc(64, 48, 20), BLUE)
    check(picture(*layers), *layers)


def test_a_disc_of_which_a_third_of_the_rim_is_seen_is_whole() -> None:
    layers = (disc(48, 40, 26), RED), (box(10, 26, 86, 86), BLUE)
    check(picture(*layers), *layers)


def test_a_thin_shade_along_a_rim_is_no_disc_behind_it() -> None:
    rim = disc(48, 48, 36)
    outlines = Outlines(flat_regions(picture((rim, YELLOW), (rim & ~disc(45, 46, 36), RED))))
    shade, face = (int(outlines.regions.labels[y, x]) for x, y in ((77, 68), (40, 40)))
    below = outlines.marks([face])
    arguments = outlines.outer(shade), below, outlines.room([shade], below), outlines
    assert abs(filled_out(*arguments, PRICES).area) < 1600
    assert abs(filled_out(*arguments, dataclasses.replace(PRICES, sliver=99)).area) > 3500  # as it has tips


def test_a_board_keeps_the_corner_that_a_disc_hides() -> None:
    layers = (box(10.5, 12.5, 70.5, 66.5), RED), (disc(66, 62, 22), BLUE)
    check(picture(*layers), *layers, least=0.98)


def test_an_outline_that_turns_just_where_it_disappears_pays_for_it() -> None:
    outlines = Outlines(flat_regions(picture((box(10.5, 12.5, 70.5, 66.5), RED), (disc(66, 62, 22), BLUE))))
    red = next(k for k in range(outlines.count) if abs(outlines.regions.colors[k][0] - RED[0]) < 0.02)
    disc_over_it = next(k for k in range(outlines.count) if abs(outlines.regions.colors[k][2] - BLUE[2]) < 0.02)
    below = outlines.marks([disc_over_it])
    room = outlines.room([red], below)
    whole, _ = completed_contour(outlines.outer(red), below, room, outlines, PRICES)
    cut, _ = completed_contour(outlines.outer(red), below, room, outlines, dataclasses.replace(PRICES, accident=0.0))
    assert abs(whole.area) > 0.98 * 60 * 54
    assert abs(cut.area) < 0.95 * 60 * 54  # a line from where the board disappears to where it comes back


def test_a_shape_whose_gap_does_not_close_by_itself_is_as_convex_as_it_may_be() -> None:
    whole = box(18, 20, 78, 76)
    image = picture((whole, RED), (whole & disc(70, 48, 34), BLUE))  # one silhouette: a bay on the left, and the rest
    outlines = Outlines(flat_regions(image))
    red, blue = (int(outlines.regions.labels[48, column]) for column in (22, 60))
    below = outlines.marks([blue])
    arguments = below, outlines.room([red], below), outlines, PRICES
    bay = outlines.outer(red)
    assert completed_contour(bay, *arguments)[0] is bay
    # Up to the line through the ends of the bay, where the disc's rim meets the sides of the box. Two pixels before
    # these its tips are narrower than a pixel.
    width = 70 - np.sqrt(34**2 - 28**2) - 18
    assert abs(filled_out(bay, *arguments).area) == pytest.approx(width * 56, abs=2 * 56)


def test_a_shape_is_not_filled_out_over_ground_that_shows() -> None:
    whole = box(18, 20, 78, 76)
    image = picture((whole, RED), (whole & disc(70, 48, 34), BLUE), (disc(44, 48, 5), WHITE))
    outlines = Outlines(flat_regions(image))
    red, blue = (int(outlines.regions.labels[48, column]) for column in (22, 60))
    below = outlines.marks([blue])
    bay = outlines.outer(red)
    assert filled_out(bay, below, outlines.room([red], below), outlines, PRICES) is bay


def test_the_ground_is_seen_between_two_arms_that_meet_on_a_third() -> None:
    arms = (box(10, 60, 86, 80), RED), (box(14, 20, 26, 64), BLUE), (box(26, 20, 70, 30), GREEN)
    last = (box(60, 30, 70, 61), YELLOW)
    speck = (box(26, 56, 31, 60), GREY)  # touches no ground outside
    layers = found(picture(*arms, last, speck))
    assert len(layers) == 5 and all(np.abs(color - WHITE).max() > 0.02 for _, color in layers)


def test_a_bar_on_both_sides_of_a_disc_is_one() -> None:
    layers = (box(8, 40, 88, 54), GREEN), (disc(48, 47, 18), RED)
    check(picture(*layers), *layers)


def test_a_board_on_both_sides_of_a_bar_is_one() -> None:
    layers = (box(12, 24, 84, 70), BLUE), (box(40, 8, 54, 88), YELLOW)
    check(picture(*layers), *layers)


def test_petals_that_could_each_be_one_with_either_neighbor_stay_four() -> None:
    petals = [np.abs(X - x) + np.abs(Y - y) <= 20 for x, y in ((48, 26), (70, 48), (48, 70), (26, 48))]
    masks = [mask for mask, _ in found(picture(*((petal, BLUE) for petal in petals), (disc(48, 48, 8), YELLOW)))]
    assert len(masks) == 5
    assert all(max(overlap(mask, petal) for mask in masks) > 0.9 for petal in petals)


def test_segments_of_a_ring_below_spots_are_one() -> None:
    ring = disc(48, 48, 36) & ~disc(48, 48, 28)
    spots = [(disc(48 + 32 * np.cos(a), 48 + 32 * np.sin(a), 8), YELLOW) for a in (0.3, 2.4, 4.5)]
    masks = [mask for mask, _ in found(picture((ring, BLUE), *spots))]
    assert len(masks) == 4 and overlap(masks[0], ring) > 0.95


@pytest.mark.parametrize("levels", [4, 8, 12])
@pytest.mark.parametrize("ground", [WHITE, GREY])
def test_pale_shapes_are_two(levels: int, ground: Any) -> None:
    pale = tuple(channel - levels / 255 for channel in ground)
    layers = (disc(28, 48, 16), pale), (box(56, 30, 86, 66), pale)
    image = picture(*layers, ground=ground)
    masks = sorted((mask for mask, _ in found(image, ground)), key=lambda mask: mask.nonzero()[1].min())
    assert len(masks) == 2
    assert overlap(masks[0], layers[0][0]) > 0.9 and overlap(masks[1], layers[1][0]) > 0.9


def test_equal_colors_apart_stay_two() -> None:
    image = picture((disc(28, 48, 14), RED), (disc(68, 48, 14), RED))
    assert len(found(image)) == 2


def test_the_same_layers_every_time() -> None:
    image = picture((disc(40, 48, 26), RED), (disc(64, 48, 20), BLUE), (box(8, 40, 88, 46), GREEN))
    first, second = found(image), found(image)
    assert all(np.array_equal(a[0], b[0]) for a, b in zip(first, second, strict=True))


def test_a_blank_page_has_no_layers() -> None:
    assert found(np.ones((*SIZE, 3))) == []


def test_crossing_lines_are_one_layer_over_the_page() -> None:
    lines = np.zeros_like(X, dtype=bool)
    for at in (20, 38, 56, 74):
        lines |= box(6, at, 90, at + 3) | box(at, 6, at + 3, 90)
    check(picture((lines, BLUE)), (lines, BLUE))


def test_white_marks_among_many_on_a_plate_are_shapes() -> None:
    marks = [(box(16, y, 80, y + 5), WHITE if y in (29, 65) else BLUE) for y in range(17, 80, 12)]
    layers = found(picture((box(8, 8, 88, 88), RED), *marks))
    assert len(marks) == 6 and len(layers) == 7
    assert sum(np.abs(color - WHITE).max() < 0.02 for _, color in layers) == 2


def test_many_shapes_of_one_color_are_not_looked_at_in_pairs() -> None:
    """The time of many letters or pixels grows with their number, not with that of their pairs."""
    dots = [disc(8 + 10 * i, 8 + 10 * j, 3) for i in range(9) for j in range(9)]
    colors = [BLUE] * 70 + [RED] * 11
    outlines = Outlines(flat_regions(picture(*zip(dots, colors, strict=True))))
    alike = few_alike(outlines, list(range(outlines.count)))
    np.testing.assert_allclose(
        outlines.regions.colors[alike].mean(axis=0), (np.array(WHITE) + 11 * np.array(RED)) / 12, atol=0.01
    )


@pytest.mark.parametrize("name", ["clip_1f43f", "clip_1f3bf"])
def test_parts_are_not_joined_where_their_outlines_would_cross(name: str, data_dir: Path) -> None:
    # A chipmunk's tail, leg and ear, of one colour, lie around its body: bridges from tail to leg cross below it. Of an
    # outline that crosses itself a path keeps the larger lobe.
    image = read_image(data_dir / "pics" / f"{name}.png")[..., :3]
    ground = image[0, 0].astype(np.float64)
    layers = find_layers(with_parts(flat_regions(image), ground), ground)
    assert max(polygon_crossing_area(points) for layer in layers for points in layer.outlines) < 3


@pytest.mark.parametrize("name", ["clip_1f5d2", "clip_1f33d"])
def test_completed_outlines_keep_what_their_shapes_show(name: str, data_dir: Path) -> None:
    # Lines of a pad, seen through slots in its page, are one shape with its rings: a straight line across that shape
    # would run below the page, and cut half of the lines off.
    image = read_image(data_dir / "pics" / f"{name}.png")[..., :3]
    ground = image[0, 0].astype(np.float64)
    outlines = with_parts(flat_regions(image), ground)
    for layer in find_layers(outlines, ground):
        shown = np.isin(outlines.regions.labels, list(layer.shown))
        whole = np.logical_or.reduce([polygon2mask(shown.shape, p[:, ::-1] - 0.5) for p in layer.outlines])
        assert (whole & shown).sum() > 0.9 * shown.sum() - 10


@pytest.mark.parametrize("opacity", [1.0, 0.5])
def test_shapes_go_on_below_opaque_ones_only(opacity: float) -> None:
    # Below a translucent shape, what goes on shows through.
    whole, front = disc(40, 48, 26), box(44, 14, 80, 82)
    rgb = picture((whole, RED), (front, BLUE))
    bare, cover = (picture((mask, (0, 0, 0)), ground=(1, 1, 1))[..., 0] for mask in (whole | front, front))
    alpha = 1 - bare - (1 - opacity) * (1 - cover)
    straight = np.where((alpha > 0)[..., None], (rgb - bare[..., None]) / np.maximum(1 - bare, 1e-9)[..., None], 0)
    image = np.concatenate([alpha[..., None] * straight, alpha[..., None]], axis=-1)
    shapes = [mask for mask, color in found(image, np.zeros(4)) if color[0] > color[2]]
    assert len(shapes) == 1
    assert overlap(shapes[0], whole if opacity == 1 else whole & ~front) > 0.95


def test_regions_kept_apart_are_joined_with_none() -> None:
    image = picture((box(10, 40, 86, 56), RED), (box(40, 30, 56, 66), BLUE))
    outlines = with_parts(flat_regions(image), np.array(WHITE))
    regions = outlines.regions
    red = {k for k in range(outlines.count) if np.abs(regions.colors[k] - RED).max() < 0.02}
    for apart, number in ((set(), 1), ({min(red)}, 2), (red, 2)):
        layers = find_layers(outlines, np.array(WHITE), assumed=Assumptions(apart=frozenset(apart)))
        assert sum(bool(layer.shown & red) for layer in layers) == number


def test_mirror_twins_are_one_shape_below_what_covers_their_middle() -> None:
    """A jacket, below two lapels and the shirt between them: none of the three covers its whole middle."""
    jacket = disc(48, 90, 40) & (Y <= 88)
    lapels = [box(32, 40, 40, 88), box(56, 40, 64, 88)]
    layers = found(picture((jacket, BLUE), (box(40, 40, 56, 88), GREEN), *((lapel, RED) for lapel in lapels)))
    assert overlap(layers[0][0], jacket) > 0.9 and np.abs(layers[0][1] - BLUE).max() < 0.02
    assert sum(np.abs(color - BLUE).max() < 0.02 for _, color in layers) == 1
