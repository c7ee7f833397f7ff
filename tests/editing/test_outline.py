# SPDX-License-Identifier: Apache-2.0
"""Editable outlines of shapes whose description is known: polygons, round shapes and both, with wiggles."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.editing.constraints import Joins
from livecl.editing.outline import Fit, editable_outline, editable_outlines
from livecl.editing.trace import sampled
from livecl.geometry import bezier
from livecl.svg import read_svg
from livecl.svg.outline_data import format_outline, rounded_points
from livecl.svg.shapes import ellipse_outline, rectangle_outline


def cubics_of(points: np.ndarray) -> np.ndarray:
    return np.concatenate([points, np.roll(points[:, :1], -1, axis=0)], axis=1)


def split(cubics: np.ndarray, count: int, wiggle: float = 0.0, seed: int = 0) -> np.ndarray:
    """Return an outline cut into `count` pieces a segment, their ends moved by `wiggle` px (standard deviation)."""
    t = np.arange(count) / count
    pieces = np.concatenate([bezier.subsegment(np.repeat(c[None], count, 0), t, t + 1 / count) for c in cubics])
    points = pieces[:, :3] + np.random.default_rng(seed).normal(0, wiggle, (len(pieces), 1, 2))
    return cubics_of(points)


def polygon(*corners: tuple[float, float]) -> np.ndarray:
    starts = np.array(corners)
    steps = np.roll(starts, -1, axis=0) - starts
    return cubics_of(np.stack([starts, starts + steps / 3, starts + 2 * steps / 3], axis=1))


def edited(cubics: np.ndarray, fit: Fit | None = None) -> np.ndarray:
    traced = sampled(cubics)
    assert traced is not None
    path = editable_outline(traced, fit or Fit())
    assert path is not None
    return path


def joins_of(path: np.ndarray) -> Joins:
    return Joins(path, np.roll(np.arange(len(path)), -1), np.ones(len(path), bool))


def data_of(path: np.ndarray) -> str:
    rows = np.arange(len(path))
    return format_outline(rounded_points(path, np.roll(rows, -1), np.ones(len(path), bool), 3), 3)


def distance(path: np.ndarray, cubics: np.ndarray) -> float:
    """Return the largest distance of one outline's points from the other's, px."""
    ours, true = (bezier.flatten(c, 1e-3).corners for c in (cubics_of(path), cubics))
    dense = bezier.evaluate(cubics, np.linspace(0, 1, 400)).reshape(-1, 2)
    assert len(true)
    return float(np.hypot(*(ours[:, None] - dense[None]).transpose(2, 0, 1)).min(axis=1).max())


def test_several_prices_give_what_each_gives_alone() -> None:
    """Segments are fitted once; a price only chooses among them."""
    traced = sampled(split(polygon((10, 10), (60, 14), (70, 50), (40, 64), (12, 48)), 3, 0.3))
    assert traced is not None
    fits = [Fit(), Fit(tolerance=0.2, straight=0.15, straying=12.0), Fit(corner=9.0, straying=1.0, tolerance=2.0)]
    together, alone = editable_outlines(traced, fits), [editable_outline(traced, fit) for fit in fits]
    counts = set()
    for path, expected in zip(together, alone, strict=True):
        assert path is not None and expected is not None
        np.testing.assert_array_equal(path, expected)
        counts.add(len(path))
    assert len(counts) > 1  # prices make a difference


@pytest.mark.parametrize("seed", range(4))
def test_polygon_of_many_pieces_is_its_sides(seed: int) -> None:
    """Corners within .15 px, level and plumb sides exactly so, from 40 nodes that stray by .05 px."""
    true = polygon((20, 20), (80, 20), (80, 60), (50, 90), (20, 60))
    path = edited(split(true, 8, 0.05, seed))
    letters = [letter for letter in data_of(path) if letter.isalpha()]
    assert len(path) == 5 and "c" not in letters and letters.count("h") + letters.count("v") + 1 >= 3
    gaps = np.hypot(*(path[:, 0][:, None] - true[:, 0][None]).transpose(2, 0, 1))
    assert gaps.min(axis=1).max() < 0.15


def test_rounded_rectangle_is_sides_and_quarters_with_smooth_joins() -> None:
    true = cubics_of(rectangle_outline(20, 20, 90, 60, 15, 15)[0][:, :3])
    path = edited(split(true, 5, 0.03))
    assert len(path) == 8
    assert data_of(path).count("h") + data_of(path).count("v") >= 3
    into, out = path[:, 0] - np.roll(path[:, 2], 1, axis=0), path[:, 1] - path[:, 0]
    angles = np.angle((out[:, 0] + 1j * out[:, 1]) / (into[:, 0] + 1j * into[:, 1]))
    assert np.abs(angles).max() < 1e-6
    assert distance(path, true) < 0.3


@pytest.mark.parametrize("radius", [4.0, 12.0, 60.0])
def test_circle_takes_few_smooth_nodes(radius: float) -> None:
    true = ellipse_outline(80, 80, radius, radius)[0]
    path = edited(split(true, 6, 0.02))
    assert 2 <= len(path) <= 4
    assert distance(path, true) < 0.4


def test_half_disc_keeps_its_corners() -> None:
    disc = ellipse_outline(50, 50, 30, 30)[0]
    half = np.concatenate([disc[:2], [[[20, 50], [40, 50], [60, 50], [80, 50]]]])
    path = edited(split(half, 4, 0.03))
    assert {letter for letter in data_of(path) if letter.isalpha()} <= set("MmchvsZ")
    for corner in ((20, 50), (80, 50)):
        assert np.hypot(*(path[:, 0] - corner).T).min() < 0.2


def test_a_straight_side_before_a_bend_is_a_line() -> None:
    """A side of 10 px that would do as the beginning of the curve after it, for fewer numbers."""
    true = cubics_of(read_svg(b'<svg width="90" height="90"><path d="M20 60l-3-10q-2-20 20-20h30v30z"/></svg>').points)
    taken, kept = (edited(split(true, 2, 0.02), Fit(side=side)) for side in (0.0, 3.0))
    lines = [int(joins_of(path).lines.sum()) for path in (taken, kept)]
    assert lines == [3, 4]
    assert distance(kept, true) < Fit().tolerance


def test_tolerance_bounds_straying() -> None:
    rng = np.random.default_rng(3)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 14))
    blob = polygon(*(50 + 30 * np.stack([np.cos(angles), np.sin(angles)], 1) * rng.uniform(0.7, 1, (14, 1))).tolist())
    coarse, fine = (
        edited(blob, Fit(tolerance=t, straight=t, straying=s, side=0)) for t, s in ((2.0, 0.1), (0.1, 40.0))
    )
    assert len(coarse) < len(fine)
    assert distance(fine, blob) < 0.6 < distance(coarse, blob)


def test_a_point_has_no_shape() -> None:
    assert sampled(polygon((5, 5), (5.1, 5), (5.1, 5.1))) is None


def test_sharp_corners_are_no_smooth_nodes_and_rounded_ones_may_be() -> None:
    """A triangle's corners, and those of a rectangle rounded at a radius of 1.5 px."""
    sharp = sampled(polygon((20.3, 20.1), (90.2, 30.4), (40.1, 80.2)))
    assert sharp is not None and len(sharp.corners) == 3
    assert not np.isin(sharp.corners, sharp.places).any()
    rounded = sampled(np.asarray(rectangle_outline(20.0, 20.0, 60.0, 40.0, 1.5, 1.5)[0]))
    assert rounded is not None and len(rounded.corners) == 4
    assert np.isin(rounded.corners, rounded.places).all()
