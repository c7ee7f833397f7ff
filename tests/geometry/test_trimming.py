# SPDX-License-Identifier: Apache-2.0
"""Trimmed outlines: within the rectangle the winding numbers are as before, and beyond it nothing is left."""

from __future__ import annotations

import numpy as np
import pytest
from support.drawings import blob, build, rectangle, reverse
from support.shapes import circle

import livecl
from livecl.geometry.bezier import curve_bounds
from livecl.geometry.trimming import trimmed_outline
from livecl.layering.revision.trimming import trimmed

LOW, HIGH = np.array([-4.0, -4.0]), np.array([104.0, 64.0])
SIZE = (60, 100)


def bounds(points: np.ndarray) -> np.ndarray:
    return curve_bounds(np.concatenate([points, np.roll(points[:, :1], -1, axis=0)], axis=1))


def test_within_the_rectangle_nothing_changes() -> None:
    points = circle((50, 30), 20)
    assert trimmed_outline(points, LOW, HIGH) is points
    handles = points.copy()
    handles[0, 1] = (50, -6)  # a handle beyond, of a curve within
    assert trimmed_outline(handles, LOW, HIGH) is handles


def test_beyond_it_nothing_is_left() -> None:
    assert trimmed_outline(circle((200, 30), 20), LOW, HIGH) is None


def test_a_rectangle_over_all_four_sides_becomes_the_page_and_its_bleed() -> None:
    cut = trimmed_outline(rectangle(-300, -200, 500, 400), LOW, HIGH)
    assert cut is not None
    np.testing.assert_allclose(bounds(cut), [*LOW, *HIGH])
    assert len(cut) <= 8


@pytest.mark.parametrize("seed", range(40))
def test_the_picture_stays(seed: int) -> None:
    """Blobs, crossing themselves or not, in both directions, also with holes that hang over."""
    rng = np.random.default_rng(seed)
    outline = [blob(seed, rng.uniform((0, 0), (100, 60)), rng.uniform(30, 160), int(rng.integers(2, 9)))]
    if seed % 3 == 0:
        outline.append(reverse(circle(tuple(rng.uniform((-20, -20), (120, 80))), rng.uniform(20, 60))))
    if seed % 2:
        outline = [reverse(path) for path in outline]
    drawing = build([(outline, (0.1, 0.3, 0.8, 0.9))], SIZE, background=(1, 1, 1))
    cut = trimmed(drawing)
    rasterizer = livecl.Rasterizer(SIZE, tolerance=1e-4)
    # Flattened at other places, each within 1e-4 px: an edge moves by 2e-4 px, of which a pixel has six at most.
    assert np.abs(rasterizer.forward(cut) - rasterizer.forward(drawing)).max() < 1.2e-3
    bleed = 2.0
    for row in cut.subpaths():
        box = bounds(cut.points[row])
        if np.any(bounds(drawing.points) != bounds(cut.points)):
            assert (box[:2] >= -2 * bleed - 1e-9).all() and (box[2:] <= np.array([100, 60]) + 2 * bleed + 1e-9).all()


def test_small_overhangs_and_strokes_stay() -> None:
    near = build([([circle((50, 30), 33)], (0, 0, 0, 1))], SIZE)  # 3 px over
    assert trimmed(near) is near
    far = build([([circle((50, 30), 90)], (0, 0, 0, 1))], SIZE)
    stroked = far.replace(strokes=livecl.drawing.Strokes(widths=[5], is_open=[False]))
    np.testing.assert_array_equal(trimmed(stroked).points, far.points)
    assert not np.array_equal(bounds(trimmed(far).points), bounds(far.points))
