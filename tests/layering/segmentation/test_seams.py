# SPDX-License-Identifier: Apache-2.0
"""Seams that a renderer leaves where shapes abut within a pixel are no regions; thin lines that were drawn are."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.found import flat_regions

from livecl.layering.segmentation.flat import FlatRegions
from livecl.layering.segmentation.seams import find_seams

FloatArray = NDArray[np.float64]

WHITE, BLUE, NAVY, ORANGE = np.array([[255, 255, 255], [63, 81, 181], [20, 30, 90], [255, 152, 0]]) / 255


def over(page: FloatArray, color: FloatArray, left: float, right: float, slant: float = 0.0) -> None:
    """Composite a rectangle of rows 8 to 56 between two columns, its sides moved by `slant` px a row, exactly."""
    for row in range(8, 56):
        columns = np.arange(page.shape[1])
        ends = np.array([left, right]) + slant * (row - 8)
        coverage = np.clip(np.minimum(columns + 1, ends[1]) - np.maximum(columns, ends[0]), 0, 1)[:, None]
        page[row] = coverage * color + (1 - coverage) * page[row]


def white_page() -> FloatArray:
    return np.tile(WHITE, (64, 64, 1))


def regions(page: FloatArray) -> FlatRegions:
    """Return the regions of a picture as a file holds it, of 8 bits."""
    return flat_regions(np.round(page * 255) / 255)


@pytest.mark.parametrize("slant", [0.0, 0.13])
@pytest.mark.parametrize("share", [0.25, 0.4, 0.7])
def test_two_shapes_that_abut_have_no_line_between_them(share: float, slant: float) -> None:
    page = white_page()
    over(page, BLUE, 10, 30 + share, slant)
    over(page, NAVY, 30 + share, 50, slant)
    found = regions(page)
    assert len(found.sizes) == 3
    blue = np.flatnonzero(np.abs(found.colors - BLUE).max(axis=1) < 0.01)[0]
    shares = np.where(found.labels == blue, found.share, (found.other == found.cores[blue]) * (1 - found.share))
    assert shares.sum() / 48 == pytest.approx(20 + share, abs=0.2)


def test_a_lower_shape_of_the_same_outline_has_no_fringe() -> None:
    page = white_page()
    over(page, NAVY, 10.4, 50)
    over(page, ORANGE, 10.4, 40)
    assert len(regions(page).sizes) == 3  # white, orange, and the navy that orange leaves


def test_a_seam_shows_a_shape_that_goes_on_below() -> None:
    page = white_page()
    over(page, ORANGE, 4, 40)
    over(page, BLUE, 12, 30.6)
    over(page, NAVY, 30.6, 50)
    assert len(regions(page).sizes) == 4


def test_a_thin_line_between_two_shapes_that_was_drawn_is_a_region() -> None:
    page = white_page()
    over(page, BLUE, 10, 30)
    over(page, NAVY, 30, 50)
    over(page, ORANGE, 30.1, 30.9)  # of a colour that is nowhere else
    assert len(regions(page).sizes) == 4


def test_a_faint_line_across_one_colour_was_drawn() -> None:
    page = white_page()
    over(page, BLUE, 10, 50)
    over(page, WHITE, 30.4, 30.6)
    assert len(regions(page).sizes) == 4  # the line cuts the shape


def test_no_pixels_have_no_seams() -> None:
    none = np.zeros(0, np.int64)
    found = find_seams(np.zeros((4, 4, 3)), np.ones((4, 4), np.int64), np.zeros((2, 3)), none, none, 0.04)
    assert not len(found.found)
