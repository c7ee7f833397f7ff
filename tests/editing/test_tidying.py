# SPDX-License-Identifier: Apache-2.0
"""Tidied outlines: nearly straight segments become lines, nearly smooth joins smooth, corners stay."""

from __future__ import annotations

import numpy as np

from livecl.editing.constraints import Joins
from livecl.editing.tidying import tidied
from livecl.geometry import bezier
from livecl.svg import read_svg


def outline(data: str) -> np.ndarray:
    return read_svg(f'<svg width="120" height="90"><path d="{data}"/></svg>'.encode()).points


def joins_of(points: np.ndarray) -> Joins:
    return Joins(points, np.roll(np.arange(len(points)), -1), np.ones(len(points), bool))


def distances(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the distances of places of an outline from another one, px."""
    places, dense = (
        bezier.evaluate(np.concatenate([p, np.roll(p[:, :1], -1, axis=0)], axis=1), np.linspace(0, 1, num))
        for p, num in ((points, 20), (others, 400))
    )
    return np.hypot(*np.moveaxis(places.reshape(-1, 1, 2) - dense.reshape(1, -1, 2), -1, 0)).min(axis=1)


#: A tab: three sides, and a rounded top of two quarters.
TAB = "M20 80v-40c0-11 9-20 20-20h20c11 0 20 9 20 20v40z"


def test_a_shape_that_strays_gets_its_lines_and_smooth_joins_back() -> None:
    true = outline(TAB)
    strayed = true + np.random.default_rng(1).normal(0, 0.06, true.shape)
    assert not joins_of(strayed).lines.any() and not joins_of(strayed).smooth.any()
    tidy = tidied(strayed, 0.4)
    np.testing.assert_array_equal(joins_of(tidy).lines, joins_of(true).lines)
    np.testing.assert_array_equal(joins_of(tidy).smooth, joins_of(true).smooth)
    steps = np.abs(np.roll(tidy[:, 0], -1, axis=0) - tidy[:, 0])[joins_of(tidy).lines]
    assert steps.min(axis=1).max() == 0  # level and plumb
    assert np.abs(tidy[:, 0] - true[:, 0]).max() < 0.15
    assert distances(tidy, true).max() < 0.15


def test_corners_stay_and_so_do_curves_that_would_move_too_far() -> None:
    """A join that turns by 16 degrees between long handles: smooth only where the tolerance allows for it."""
    bent = outline("M20 60c0-30 20-40 40-40c20 6 40 20 40 40c-20 10-60 10-80 0")
    turned = [joins_of(tidied(bent, tolerance)).smooth for tolerance in (0.05, 0.3, 2.0)]
    np.testing.assert_array_equal(turned, [[False] * 3, [False] * 3, [False, True, False]])
    gaps = distances(tidied(bent, 2.0), bent)
    assert 0.2 < gaps.max() < 2.0
    np.testing.assert_array_equal(tidied(bent, 0.05), bent)


def test_a_line_in_pieces_is_one() -> None:
    assert len(tidied(outline("M20 20l30.1 .05l29.9-.05v40h-25l-.1.03h-34.9z"), 0.2)) == 4


def test_a_join_that_turns_by_30_degrees_is_a_corner() -> None:
    bent = outline("M20 60c0-30 20-40 40-40c20 11.5 40 20 40 40c-20 10-60 10-80 0")
    assert not joins_of(tidied(bent, 5.0)).smooth.any()


def test_a_spike_stays() -> None:
    assert len(tidied(outline("M20 20h-10h30v20h-20z"), 0.2)) == 5


def test_short_slanted_lines_are_not_made_level() -> None:
    """By .2 px on 2 px, a tenth; on 20 px that is a hundredth, and level."""
    corners = tidied(outline("M20 20l20 .2v19.8l-2 .2-18-10z"), 0.2)[:, 0]
    np.testing.assert_allclose(corners[:, 1], [20.1, 20.1, 40, 40.2, 30.2], atol=1e-9)


def test_lines_that_rise_by_half_a_pixel_are_not_made_level() -> None:
    np.testing.assert_allclose(tidied(outline("M20 20l20 .5v19.5h-20z"), 0.2)[:, 0, 1], [20, 20.5, 40, 40], atol=1e-9)


def test_a_bend_between_two_lines_is_no_smooth_join() -> None:
    joins = joins_of(outline("M20 20h20h20v40h-40z"))
    assert joins.lines.all() and not joins.smooth.any()
