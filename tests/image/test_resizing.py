# SPDX-License-Identifier: Apache-2.0
"""Pictures reduced and drawings enlarged: sizes, means over areas, and that the two agree."""

from __future__ import annotations

import numpy as np
import pytest
from support import drawings, shapes

import livecl
from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import MAX_COORDINATE
from livecl.image.reading import premultiplied
from livecl.image.resizing import (
    DETAIL_IS_LOST,
    cell_side,
    detail_lost,
    reduced,
    working_size,
    working_size_of,
)

RNG = np.random.default_rng(3)


@pytest.mark.parametrize(
    ("size", "side", "expected"),
    [
        ((1500, 2000), 512, (443, 591)),
        ((2000, 1500), 512, (591, 443)),
        ((512, 512), 512, (512, 512)),
        ((513, 100), 512, (513, 100)),
        ((1, 4000), 512, (1, 4000)),
        ((4, 900_000), 512, (1, 242_863)),
        ((30, 20), 512, (30, 20)),
        ((3000, 2000), 0, (3000, 2000)),
        ((1, 900_000), 16, (1, 15_179)),
    ],
)
def test_working_size(size: tuple[int, int], side: int, expected: tuple[int, int]) -> None:
    assert working_size(size, side) == expected


def test_cells_of_pixel_art_stay_whole() -> None:
    cells = RNG.integers(0, 2, (30, 30, 1)).repeat(3, axis=2).astype(np.float32)
    enlarged = cells.repeat(20, axis=0).repeat(20, axis=1)
    assert cell_side(enlarged) == 20
    assert working_size_of(enlarged, 512) == (510, 510)  # 17 px a cell
    assert working_size_of(enlarged, 600) == (600, 600)
    np.testing.assert_allclose(reduced(enlarged, (510, 510)), cells.repeat(17, axis=0).repeat(17, axis=1), atol=1e-6)
    assert working_size_of(enlarged, 20) == working_size((600, 600), 20)  # less than a pixel a cell
    other = RNG.uniform(size=(600, 700, 3))
    assert cell_side(other) == 1 and working_size_of(other, 512) == working_size((600, 700), 512)


@pytest.mark.parametrize("side", [-1, 1, 15, 1.5, True, "512"])
def test_working_size_is_a_whole_number(side: int) -> None:
    with pytest.raises(ValueError, match=r"^size: got "):
        working_size((10, 10), side)


def test_small_print_is_said_to_be_lost() -> None:
    lines = np.ones((64, 64, 3), np.float32)
    lines[::4] = 0
    disc = np.ones((256, 256, 3), np.float32)
    disc[np.hypot(*(np.indices((256, 256)) - 127.5)) < 60] = 0
    assert detail_lost(lines, (64, 64)) == 0
    assert detail_lost(lines, (16, 16)) > DETAIL_IS_LOST > detail_lost(disc, (128, 128)) > 0


def overlaps(pixels: int, cells: int) -> np.ndarray:
    """Return the share of each of `cells` (rows) that each of `pixels` (columns) covers on the same length."""
    first = np.arange(cells)[:, None] * pixels / cells
    end = first + pixels / cells
    column = np.arange(pixels)
    return np.clip(np.minimum(end, column + 1) - np.maximum(first, column), 0, None) * cells / pixels


@pytest.mark.parametrize("size", [(3, 4), (7, 1), (1, 10), (5, 10)])
def test_pixels_are_means_over_their_area(size: tuple[int, int]) -> None:
    image = RNG.random((7, 10, 3)).astype(np.float32)
    expected = np.einsum("ai,bj,ijc->abc", overlaps(7, size[0]), overlaps(10, size[1]), image)
    # Sums of at most 70 numbers of at most 1 in float32.
    np.testing.assert_allclose(reduced(image, size), expected, atol=70 * np.finfo(np.float32).eps)


def test_own_size_changes_nothing() -> None:
    image = RNG.random((7, 10, 4)).astype(np.float32)
    np.testing.assert_array_equal(reduced(image, (7, 10)), image)


def test_colors_count_by_their_alpha() -> None:
    image = RNG.random((8, 6, 4)).astype(np.float32)
    image[:4, :3, 3] = 0  # the colour there shows nowhere
    small = reduced(image, (2, 2))
    expected = premultiplied(image).reshape(2, 4, 2, 3, 4).mean(axis=(1, 3))
    np.testing.assert_allclose(premultiplied(small), expected, atol=20 * np.finfo(np.float32).eps)
    np.testing.assert_array_equal(small[0, 0], 0)


def test_a_reduced_render_is_the_render_of_the_scaled_drawing(device: int | None) -> None:
    # Coverage is a mean over a pixel's area, so one opaque layer reduced by 4 is what the smaller outline covers, up to
    # the flattening's tolerance of 0.02 px, of each size, along an edge that is at most a pixel's diagonal long.
    drawing = drawings.build([([shapes.circle((50, 30), 20)], (0.2, 0.5, 0.8, 1.0))], (64, 96))
    small = reduced(livecl.render(drawing, device), (16, 24))
    np.testing.assert_allclose(livecl.render(scaled(drawing, (16, 24)), device), small, atol=(0.02 + 0.02 / 4) * 2**0.5)


def test_scaled_stretches_to_the_canvas() -> None:
    drawing = drawings.build([([shapes.circle((5, 5), 3)], (0.2, 0.5, 0.8, 0.5))], (10, 20))
    large = scaled(drawing, (30, 20))
    assert large.size == (30, 20)
    np.testing.assert_allclose(large.points, drawing.points * (1, 3))
    np.testing.assert_array_equal(large.colors, drawing.colors)
    assert scaled(drawing, (10, 20)) is drawing


def test_scaled_keeps_within_what_a_drawing_takes() -> None:
    drawing = Drawing(points=np.full((1, 3, 2), MAX_COORDINATE), colors=np.ones((1, 4)), size=(4, 4))
    assert scaled(drawing, (8, 8)).points.max() == MAX_COORDINATE
