# SPDX-License-Identifier: Apache-2.0
"""Holes of known small drawings: the page or a shape behind is seen through them, or a shape lies on top."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.small_drawings import (
    BLUE,
    GREEN,
    RED,
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

from livecl.layering.outlines.contours import Outlines
from livecl.layering.segmentation.flat import clean_regions
from livecl.layering.structure.finding import found_structure
from livecl.layering.structure.views import _thinness, ground_regions


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


def test_panes_are_shapes_on_their_frame_where_so_many_are_asked_for() -> None:
    """Four panes are one shape behind the frame, unless as many layers are asked for as these on top of it make."""
    panes = [box(x, y, x + 26, y + 26) for x in (18, 52) for y in (8, 42)]
    discs = (disc(20, 84, 7), RED), (disc(48, 84, 7), GREEN)
    image = picture((box(14, 4, 82, 72), BLUE), *((pane, YELLOW) for pane in panes), *discs)
    for asked, number in ((0, 4), (4, 4), (6, 4), (7, 7)):
        layers = found_structure(image, np.ones(3), 99, asked=asked)
        assert layers is not None and len(layers.ranked) == number


def test_parts_are_joined_behind_a_band_unless_more_layers_are_asked_for() -> None:
    image = picture((box(20, 10, 76, 86), RED), (box(14, 42, 82, 52), BLUE))
    for asked, number in ((0, 2), (2, 2), (3, 3)):
        layers = found_structure(image, np.ones(3), 99, asked=asked)
        assert layers is not None and len(layers.ranked) == number


def test_shapes_of_the_ground_s_color_that_touch_are_not_the_ground() -> None:
    """A head upon a body on a plate: each touches two others, but one of them has its own colour."""
    body = box(30, 40, 66, 80)
    head = disc(48, 29, 10.6)
    layers = found(picture((box(4, 4, 92, 92), BLUE), (body, WHITE), (head, WHITE)))
    assert len(layers) == 3


def test_a_fragment_on_the_border_makes_no_ground_of_a_light_shape() -> None:
    """A light shape in a hole of a plate is a shape, though a few pixels of another colour lie at its border."""
    shape = box(40, 36, 54, 58)
    fragment = box(54, 44, 57, 47)
    layers = found(picture((box(10, 10, 86, 86), BLUE), (shape, WHITE), (fragment, RED)))
    assert sum(np.abs(color - WHITE).max() < 0.02 for _, color in layers) == 1


@pytest.mark.parametrize(("legs", "grounds"), [(True, 2), (False, 1)])
def test_a_small_hole_of_a_letter_shows_the_ground_and_a_mark_on_a_plate_does_not(legs: bool, grounds: int) -> None:
    image = np.ones((96, 96, 3))
    image[12:84, 20:76] = (0.7, 0.1, 0.1)
    if legs:
        image[48:84, 32:64] = 1.0  # the letter A, far from convex
    image[24:36, 40:56] = 1.0
    assert len(ground_regions(Outlines(clean_regions(image)), np.ones(3))) == grounds


def test_thinness_of_a_ring() -> None:
    """Of radii R and r: the width R - r by the root of pi R^2."""
    ring = np.hypot(X - 48, Y - 48)
    image = picture(((ring < 30) & (ring > 24), BLUE))
    contours = Outlines(clean_regions(image)).of((1,))
    assert _thinness(contours) == pytest.approx(6 / np.sqrt(np.pi * 30**2), rel=0.02)


@pytest.mark.parametrize("legs", [True, False])
def test_a_small_hole_of_a_letter_on_a_plate_shows_the_plate(legs: bool) -> None:
    """As on the page: the letter A has one; what lies on a square is a shape, though of the plate's colour."""
    letter = box(32, 24, 64, 72) & ~box(44, 32, 52, 40)
    if legs:
        letter &= ~box(40, 52, 56, 72)
    layers = found(picture((box(8, 8, 88, 88), BLUE), (letter, YELLOW)))
    assert len(layers) == (2 if legs else 3)
