# SPDX-License-Identifier: Apache-2.0
"""Shapes behind others, found whole: discs, sticks, and light shapes that others lie across."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.layering.structure.finding import found_structure

WHITE, MANY = np.ones(3), 99


def painted(side: int, *shapes: tuple[tuple[float, float, float], Any]) -> NDArray[np.float32]:
    """Return a white picture of shapes, the lowest first: a colour, and whether a point (x, y), px, lies within."""
    y, x = (np.mgrid[: 4 * side, : 4 * side] + 0.5) / 4
    image = np.ones((4 * side, 4 * side, 3))
    for color, within in shapes:
        image[within(x, y)] = color
    return np.asarray(image.reshape(side, 4, side, 4, 3).mean(axis=(1, 3)), dtype=np.float32)


def test_a_disc_behind_another_is_round_whatever_is_written_on_it() -> None:
    """The letter touches the disc in front, so that the disc behind has an outline around it."""

    def letter(x: Any, y: Any) -> Any:
        bars = (np.abs(y - 30) < 3) | (np.abs(y - 47) < 3) | (np.abs(y - 64) < 3)
        return ((np.abs(x - 36) < 3) & (np.abs(y - 47) < 20)) | (bars & (x > 33) & (x < 66))

    image = painted(
        128,
        ((0.25, 0.32, 0.71), lambda x, y: np.hypot(x - 48, y - 48) < 40),
        ((1.0, 0.96, 0.61), letter),
        ((0.3, 0.69, 0.31), lambda x, y: np.hypot(x - 80, y - 80) < 40),
    )
    found = found_structure(image, WHITE, MANY)
    assert found is not None
    blue = max(range(len(found.layers)), key=lambda k: found.layers[k].color[2] - found.layers[k].color[0])
    assert found.masks[blue].sum() == pytest.approx(np.pi * 40**2, rel=0.02)


@pytest.mark.parametrize("shift", [0, 14])
def test_ends_in_one_line_are_one_shape_however_far_they_are(shift: int) -> None:
    """Two ends of a stick are visible for 16 px each above and below a box of 60 px; one may be moved aside."""
    image = painted(
        112,
        ((0.3, 0.4, 0.5), lambda x, y: (np.abs(x - 50) < 5) & (y > 10) & (y < 50)),
        ((0.3, 0.4, 0.5), lambda x, y: (np.abs(x - 50 - shift) < 5) & (y > 60) & (y < 102)),
        ((0.9, 0.2, 0.1), lambda x, y: (np.abs(x - 56) < 26) & (np.abs(y - 56) < 30)),
    )
    found = found_structure(image, WHITE, MANY)
    assert found is not None
    assert len(found.ranked) == (3 if shift else 2)


def test_a_white_eye_under_a_brow_is_a_shape() -> None:
    """Brow and pupil lie on the face, so that the eye is seen through no gap between several shapes."""
    image = painted(
        128,
        ((1.0, 0.7, 0.2), lambda x, y: np.hypot(x - 64, y - 64) < 56),
        ((1.0, 1.0, 1.0), lambda x, y: np.hypot(x - 64, y - 64) < 18),
        ((0.2, 0.1, 0.2), lambda x, y: np.hypot(x - 64, y - 66) < 7),
        ((0.2, 0.1, 0.2), lambda x, y: (np.abs(y - 48) < 3) & (np.abs(x - 64) < 24)),
    )
    found = found_structure(image, WHITE, MANY)
    assert found is not None
    whites = [k for k in found.ranked if found.layers[k].color.min() > 0.99]
    assert len(whites) == 1


@pytest.mark.parametrize("glint", [60.5, 67.5])
def test_white_and_iris_of_an_eye_are_whole_behind_what_lies_on_them(glint: float) -> None:
    """All end at the lid, one straight line: neither is an arch around the next. A glint lies on the pupil's rim."""

    def above_the_lid(radius: float, middle: float) -> Any:
        return lambda x, y: (np.hypot(x - 64, y - middle) < radius) & (y < 80)

    white, iris = above_the_lid(16, 80), above_the_lid(11, 77)
    image = painted(
        128,
        ((1.0, 0.78, 0.24), lambda x, y: np.hypot(x - 64, y - 64) < 58),
        ((1.0, 1.0, 1.0), white),
        ((0.49, 0.27, 0.2), iris),
        ((0.0, 0.0, 0.0), above_the_lid(7, 77)),
        ((1.0, 1.0, 1.0), lambda x, y: np.hypot(x - glint, y - 73.5) < 2),
    )
    found = found_structure(image, WHITE, MANY)
    assert found is not None
    y, x = np.mgrid[:128, :128] + 0.5
    for whole in (white(x, y), iris(x, y)):
        overlaps = [np.sum(mask & whole) / np.sum(mask | whole) for mask in found.masks[found.ranked]]
        assert max(overlaps) > 0.95
