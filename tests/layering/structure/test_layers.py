# SPDX-License-Identifier: Apache-2.0
"""Known small drawings: the layers that a person would draw are found, whole and in order."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.draw import polygon2mask

from livecl import read_image
from livecl.geometry.crossings import polygon_crossing_area
from livecl.layering.outlines.completion import completed_contour, filled_out
from livecl.layering.outlines.contours import Outlines
from livecl.layering.outlines.prices import PRICES
from livecl.layering.segmentation.flat import flat_regions
from livecl.layering.structure.layers import find_layers
from livecl.layering.structure.parts import with_parts
from livecl.layering.structure.twins import few_alike

SIZE = (96, 96)
FINE = 4  # samples of a pixel's side
RED, GREEN, BLUE, YELLOW = (0.9, 0.2, 0.2), (0.2, 0.7, 0.3), (0.15, 0.3, 0.75), (0.97, 0.85, 0.25)
WHITE, GREY = (1.0, 1.0, 1.0), (0.6, 0.6, 0.6)

Mask = NDArray[np.bool_]


def _samples() -> tuple[NDArray[Any], NDArray[Any]]:
    rows, columns = np.indices((FINE * SIZE[0], FINE * SIZE[1]))
    return (columns + 0.5) / FINE, (rows + 0.5) / FINE


X, Y = _samples()


def disc(x: float, y: float, radius: float) -> Mask:
    return np.asarray(np.hypot(X - x, Y - y) <= radius)


def box(left: float, top: float, right: float, bottom: float) -> Mask:
    return np.asarray((left <= X) & (right >= X) & (top <= Y) & (bottom >= Y))


def picture(*layers: tuple[Mask, Any], ground: Any = WHITE) -> NDArray[np.float64]:
    """Paint layers over a ground, at 8 bits, each pixel the mean of its samples."""
    image = np.ones((*X.shape, 3)) * ground
    for mask, color in layers:
        image[mask] = color
    mean = image.reshape(SIZE[0], FINE, SIZE[1], FINE, 3).mean(axis=(1, 3))
    return np.asarray(np.round(255 * mean) / 255)


def found(image: NDArray[Any], ground: Any = WHITE) -> list[tuple[Mask, NDArray[Any]]]:
    layers = find_layers(with_parts(flat_regions(image), np.array(ground)), np.array(ground))
    result = []
    for layer in layers:
        mask = np.zeros(SIZE, bool)
        for points in layer.outlines:
            mask ^= polygon2mask(SIZE, points[:, ::-1] - 0.5)
        result.append((mask, layer.color))
    return result


def overlap(mask: Mask, wanted: Mask) -> float:
    whole = wanted.reshape(SIZE[0], FINE, SIZE[1], FINE).mean(axis=(1, 3)) >= 0.5
    return float((mask & whole).sum() / (mask | whole).sum())


def check(image: NDArray[Any], *wanted: tuple[Mask, Any], ground: Any = WHITE, least: float = 0.95) -> None:
    """The layers are these and no others, in this order."""
    layers = found(image, ground)
    assert len(layers) == len(wanted)
    for (mask, color), (shape, paint) in zip(layers, wanted, strict=True):
        assert np.abs(color - paint).max() < 0.02
        assert overlap(mask, shape) > least


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


def test_what_lies_on_a_disc_makes_no_hole_in_it() -> None:
    layers = (disc(48, 48, 34), YELLOW), (disc(40, 44, 8), BLUE), (disc(60, 50, 7), RED)
    assert len(found(picture(*layers))) == 3
    mask, color = found(picture(*layers))[0]
    assert np.abs(color - YELLOW).max() < 0.02 and overlap(mask, layers[0][0]) > 0.98


def test_a_ring_on_the_ground_has_a_hole() -> None:
    ring = disc(48, 48, 34) & ~disc(48, 48, 22)
    check(picture((ring, BLUE)), (ring, BLUE))


def test_a_light_triangle_on_a_plate_is_a_shape_on_a_white_page_too() -> None:
    plate = box(15, 15, 81, 81)
    triangle = (Y <= 72) & (np.abs(X - 48) <= (Y - 22) / 2)
    assert triangle.sum() > 0.25 * plate.sum()  # a hole as large of a ring shows the page
    check(picture((plate, RED), (triangle, WHITE)), (plate, RED), (triangle, WHITE))


def test_a_light_shape_unlike_its_plate_is_no_hole_though_it_is_central() -> None:
    plate = box(14, 8, 74, 88)  # the distance of the ellipse from its sides deviates by about a seventh
    ellipse = np.hypot((X - 44) / 18, (Y - 48) / 24) <= 1
    button, play = disc(48, 48, 40), (X >= 37) & (np.abs(Y - 48) <= (69 - X) * 20 / 32)
    for ground, light in ((plate, ellipse), (button, play)):
        check(picture((ground, RED), (light, WHITE)), (ground, RED), (light, WHITE))


def test_a_counter_like_its_letter_shows_the_page() -> None:
    letter = (np.hypot((X - 48) / 30, (Y - 48) / 38) <= 1) & (np.hypot((X - 48) / 14, (Y - 48) / 24) > 1)
    check(picture((letter, BLUE)), (letter, BLUE))
    nut = (np.abs(Y - 48) <= 30) & (np.abs(X - 48) * np.sqrt(3) + np.abs(Y - 48) <= 60) & ~disc(48, 48, 18)
    check(picture((nut, BLUE)), (nut, BLUE))  # evenly around it, whatever its shape


def test_a_small_even_hole_shows_the_page() -> None:
    bow, shaft = disc(30, 48, 18), box(44, 44, 86, 52)
    key = (bow & ~disc(30, 48, 9)) | (shaft & ~bow)
    assert 0.1 < 81 / (324 + 8 * 38 / np.pi) < 0.2  # its share: less than that of an uneven hole
    check(picture((key, BLUE)), (key, BLUE))


def test_a_ring_on_a_disc_shows_the_disc() -> None:
    ring = disc(48, 48, 28) & ~disc(48, 48, 20)
    check(picture((disc(48, 48, 40), YELLOW), (ring, RED)), (disc(48, 48, 40), YELLOW), (ring, RED))


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


def test_white_letters_on_a_plate_are_shapes() -> None:
    letter = box(30, 24, 40, 66) | box(30, 58, 60, 66)
    layers = (box(12, 12, 84, 84), BLUE), (letter, WHITE)
    check(picture(*layers), *layers)


@pytest.mark.parametrize("color", [WHITE, RED])
def test_a_shape_on_a_plate_that_is_cut_in_parts_is_no_view_of_what_lies_around(color: Any) -> None:
    plate, *parts = found(picture((box(12, 12, 84, 84), BLUE), (disc(48, 34, 12), color), (disc(48, 58, 14), color)))
    assert overlap(plate[0], box(12, 12, 84, 84)) > 0.95
    assert len(parts) == 2 and all(np.abs(paint - color).max() < 0.02 for _, paint in parts)


def test_a_window_is_no_view_of_a_shape_behind_that_mirrors_would_make_less_simple() -> None:
    window, mirrors = box(26, 36, 70, 62), [box(4, 44, 16, 52), box(80, 44, 92, 52)]
    layers = found(picture((box(16, 30, 80, 70), GREEN), *((mirror, RED) for mirror in mirrors), (window, RED)))
    for shape in (box(16, 30, 80, 70), window, *mirrors):
        assert max(overlap(mask, shape) for mask, _ in layers) > 0.9
    assert len(layers) == 4


def test_a_mouth_is_no_view_of_spots_that_lie_on_the_face() -> None:
    face, mouth, spots = disc(48, 48, 34), disc(48, 58, 20), [disc(22, 22, 14), disc(74, 22, 14)]
    layers = found(picture((face, YELLOW), (mouth, RED), *((spot, RED) for spot in spots)))
    assert len(layers) == 4
    for shape in (mouth, *spots):
        assert max(overlap(mask, shape) for mask, _ in layers) > 0.95


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
        layers = find_layers(outlines, np.array(WHITE), apart=apart)
        assert sum(bool(layer.shown & red) for layer in layers) == number


def test_mirror_twins_are_one_shape_below_what_covers_their_middle() -> None:
    """A jacket, below two lapels and the shirt between them: none of the three covers its whole middle."""
    jacket = disc(48, 90, 40) & (Y <= 88)
    lapels = [box(32, 40, 40, 88), box(56, 40, 64, 88)]
    layers = found(picture((jacket, BLUE), (box(40, 40, 56, 88), GREEN), *((lapel, RED) for lapel in lapels)))
    assert overlap(layers[0][0], jacket) > 0.9 and np.abs(layers[0][1] - BLUE).max() < 0.02
    assert sum(np.abs(color - BLUE).max() < 0.02 for _, color in layers) == 1
