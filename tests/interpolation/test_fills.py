# SPDX-License-Identifier: Apache-2.0
"""Fills between two: all pairs of kinds look as they are at both ends, and go evenly in between."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from support.drawings import blob, build
from support.shapes import circle

import livecl
from livecl.drawing.assembly import concatenate
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import LINEAR, RADIAL, SOLID, Fills
from livecl.interpolation.blending import interpolate

SIZE = (80, 120)
ENDS = ([0.9, 0.2, 0.1, 1.0], [0.1, 0.6, 0.9, 1.0])
#: Largest difference of two pictures that look the same: half a step of 8 bits.
HALF_LEVEL = 0.5 / 255


def fill_of(kind: int, seed: int = 0, stops: int = 2) -> Fills:
    rng = np.random.default_rng(seed)
    colors = np.column_stack([rng.uniform(0, 1, (stops, 3)), np.ones(stops)])
    if kind == LINEAR:
        return Fills.linear(rng.uniform(0, 40, 2), rng.uniform(40, 80, 2), colors)
    if kind == RADIAL:
        return Fills.radial((60, 40), rng.uniform(70, 100, 2), rng.uniform((20, 60), (60, 80)), colors)
    return Fills.solid(1)


def disc(fills: Fills, seed: int = 0) -> Drawing:
    color = (*np.random.default_rng(seed + 7).uniform(0, 1, 3), 1.0)
    return build([([circle((60, 40), 30)], color)], SIZE, background=(1, 1, 1)).replace(fills=fills)


def shown(drawing: Drawing) -> NDArray[np.float32]:
    return livecl.render(drawing)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kinds", list(itertools.product((SOLID, LINEAR, RADIAL), repeat=2)))
def test_ends_look_the_same(kinds: tuple[int, int], seed: int) -> None:
    a, b = disc(fill_of(kinds[0], seed), seed), disc(fill_of(kinds[1], seed + 100, 2 + seed % 3), seed + 1)
    first, middle, last = interpolate(a, b, [0.0, 0.5, 1.0])
    assert first.same_structure(middle) and first.same_structure(last)
    assert np.abs(shown(first) - shown(a)).max() < HALF_LEVEL
    assert np.abs(shown(last) - shown(b)).max() < HALF_LEVEL
    # What lies between is unlike both, wherever these differ.
    apart = np.abs(shown(a) - shown(b)).max()
    assert np.abs(shown(middle) - shown(a)).max() > apart / 8
    assert np.abs(shown(middle) - shown(b)).max() > apart / 8


def test_solid_to_gradient_is_a_crossfade() -> None:
    a, b = disc(Fills.solid(1)), disc(fill_of(LINEAR, 3, 3))
    middle = interpolate(a, b, 0.25)
    np.testing.assert_allclose(shown(middle), 0.75 * shown(a) + 0.25 * shown(b), atol=1e-6)


def test_stops_where_only_the_other_has_one() -> None:
    two = Fills.linear((30, 0), (90, 0), ENDS)
    three = Fills.linear((30, 0), (90, 0), [ENDS[0], ENDS[0], ENDS[1]], [0, 0.4, 1])
    middle = interpolate(disc(two), disc(three), 0.5)
    assert middle.fills.stop_positions.tolist() == [0, 0.4, 1]
    np.testing.assert_allclose(shown(middle), (shown(disc(two)) + shown(disc(three))) / 2, atol=1e-6)


def test_hard_edges_stay() -> None:
    edge = Fills.linear((30, 0), (90, 0), [ENDS[0], ENDS[0], ENDS[1], ENDS[1]], [0, 0.5, 0.5, 1])
    smooth = Fills.linear((30, 0), (90, 0), ENDS)
    for a, b in ((edge, smooth), (smooth, edge)):
        first, last = interpolate(disc(a), disc(b), [0.0, 1.0])
        assert np.abs(shown(first) - shown(disc(a))).max() < 1e-5
        assert np.abs(shown(last) - shown(disc(b))).max() < 1e-5


def test_opposite_directions_do_not_collapse() -> None:
    a = disc(Fills.linear((30, 40), (90, 40), ENDS))
    b = disc(Fills.linear((90, 40), (30, 40), ENDS[::-1]))
    np.testing.assert_allclose(shown(interpolate(a, b, 0.5)), shown(a), atol=1e-6)


def test_turned_ellipses_do_not_collapse() -> None:
    a = disc(Fills.radial((60, 40), (90, 40), (60, 60), ENDS))
    b = disc(Fills.radial((60, 40), (30, 40), (60, 60), ENDS))  # the same ellipse
    np.testing.assert_allclose(shown(interpolate(a, b, 0.5)), shown(a), atol=1e-5)


def test_gradient_goes_with_its_shape() -> None:
    a = disc(fill_of(RADIAL, 2))
    step = np.array([12.0, 0.0])
    b = a.replace(points=a.points + step, fills=a.fills.stretched(1.0, step))
    np.testing.assert_allclose(shown(interpolate(a, b, 0.5))[:, 6:], shown(a)[:, :-6], atol=1e-5)


def test_linear_to_radial_goes_evenly() -> None:
    a, b = disc(fill_of(LINEAR, 1)), disc(fill_of(RADIAL, 2))
    frames = [shown(drawing) for drawing in interpolate(a, b, np.linspace(0, 1, 11).tolist())]
    steps = [float(np.mean(np.abs(after - before))) for before, after in itertools.pairwise(frames)]
    assert max(steps) < 2 * float(np.mean(steps))


@pytest.mark.parametrize("lone", ["fade", "grow"])
def test_gradients_without_a_partner(lone: str) -> None:
    ground = build([([blob(1, np.array([20.0, 20.0]), 10, 4)], (0.0, 0.0, 0.0, 1.0))], SIZE, background=(1, 1, 1))
    both = concatenate(ground, disc(fill_of(RADIAL, 4)))
    first, last = interpolate(ground, both, [0.0, 1.0], lone=lone)
    assert np.abs(shown(first) - shown(ground)).max() < 1.2e-3
    assert np.abs(shown(last) - shown(both)).max() < 1.2e-3
