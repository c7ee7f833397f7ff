# SPDX-License-Identifier: Apache-2.0
"""Outlines made comparable: exact cuts, starts and directions, subpaths."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.drawings import blob, polygon, rectangle, reverse
from support.shapes import circle

from livecl.geometry import bezier
from livecl.interpolation import alignment

#: Rounding of three rounds of interpolation between numbers below 100: a few eps of 1e2.
ROUNDING = 1e-12


def cubics(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (m, 4, 2) of a path (m, 3, 2)."""
    return np.concatenate([path, np.roll(path, -1, axis=0)[:, :1]], axis=1)


def length(cubic: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(bezier.evaluate(cubic, np.linspace(0, 1, 2001)), axis=0), axis=1).sum())


def test_pieces_are_the_curve() -> None:
    cubic = cubics(blob(3, (50, 40), 30))[1]
    pieces = alignment.split(cubic, 3)
    # Each piece is B(s + (t - s) u); s and t are found from its ends, which lie on the curve.
    on_curve = bezier.evaluate(cubic, np.linspace(0, 1, 100001))
    for piece in pieces:
        for point in bezier.evaluate(piece, np.linspace(0, 1, 7)):
            # Points of the curve are at most 100 px / 1e5 apart: half of that from the nearest one.
            assert np.linalg.norm(on_curve - point, axis=1).min() < 1e-3
    np.testing.assert_array_equal(pieces[1:, 0], pieces[:-1, 3])
    np.testing.assert_array_equal(pieces[0, 0], cubic[0])
    np.testing.assert_array_equal(pieces[-1, 3], cubic[3])


def test_piece_is_exact_at_known_parameters() -> None:
    # A straight cubic with even handles runs at even speed, so a half is the half of its control polygon.
    line = np.array([(0.0, 0.0), (3.0, 6.0), (6.0, 12.0), (9.0, 18.0)])
    np.testing.assert_allclose(alignment.split(line, 3)[1], [(3, 6), (4, 8), (5, 10), (6, 12)], atol=ROUNDING)


def test_pieces_have_even_lengths() -> None:
    cubic = np.array([(0.0, 0.0), (0.0, 0.0), (90.0, 0.0), (90.0, 60.0)])
    lengths = [length(piece) for piece in alignment.split(cubic, 4)]
    # Chords of 1/32 shorten an arc by about (turn per chord)^2 / 24, here a turn of pi/2 in all: 1e-4, and the
    # interpolation along a chord errs by the change of speed within it, a few percent of a thirty-second.
    np.testing.assert_allclose(lengths, np.mean(lengths), rtol=1e-2)


def test_a_point_is_split() -> None:
    np.testing.assert_array_equal(alignment.split(np.full((4, 2), 7.0), 2), np.full((2, 4, 2), 7.0))


def test_longest_segments_are_cut() -> None:
    outline = cubics(rectangle(0, 0, 40, 10))
    cut = alignment.subdivide(outline, 6)
    np.testing.assert_allclose(cut[:, 0], [(0, 0), (20, 0), (40, 0), (40, 10), (20, 10), (0, 10)], atol=ROUNDING)
    np.testing.assert_array_equal(alignment.subdivide(outline, 4), outline)
    with pytest.raises(ValueError, match="count: got 3, wanted at least the 4"):
        alignment.subdivide(outline, 3)


@pytest.mark.parametrize("shift", range(5))
def test_shift_is_found(shift: int) -> None:
    outline = cubics(blob(8, (30, 30), 20, segments=5))
    moved = np.roll(outline + np.array((13.0, -4.0)), shift, axis=0)
    found, distance = alignment.best_shift(outline, moved)
    assert found == shift
    assert distance < ROUNDING


def test_best_shift_is_the_least() -> None:
    a, b = cubics(blob(1, (0, 0), 20, segments=7)), cubics(blob(2, (50, 9), 25, segments=7))
    distances = []
    for shift in range(7):
        moved = np.roll(b, -shift, axis=0)[:, :3]
        difference = (a[:, :3] - a[:, :3].mean(axis=(0, 1))) - (moved - moved.mean(axis=(0, 1)))
        distances.append(float(np.mean(np.sum(difference**2, axis=2))))
    found, distance = alignment.best_shift(a, b)
    assert found == int(np.argmin(distances))
    assert distance == pytest.approx(min(distances), rel=1e-12)


def test_reversed_outline_is_turned_back() -> None:
    path = polygon([(0, 0), (30, 2), (34, 20), (4, 26)])
    first, second = alignment.align([cubics(path)], [np.roll(cubics(reverse(path)), 2, axis=0)])
    np.testing.assert_allclose(second[0], first[0], atol=ROUNDING)


def test_counts_agree_and_nothing_moves() -> None:
    a, b = cubics(blob(1, (20, 20), 10, segments=3)), cubics(blob(2, (24, 22), 12, segments=8))
    (first,), (second,) = alignment.align([a], [b])
    assert len(first) == len(second) == 8
    assert bezier.signed_area(first) == pytest.approx(bezier.signed_area(a), rel=1e-12)
    assert abs(bezier.signed_area(second)) == pytest.approx(abs(bezier.signed_area(b)), rel=1e-12)


def test_holes_go_to_holes() -> None:
    ring = [cubics(circle((20, 20), 15)), cubics(reverse(circle((20, 20), 6)))]
    other = [cubics(circle((40, 20), 7)), cubics(reverse(circle((40, 20), 14)))]  # hole first, all turned
    first, second = alignment.align(ring, other)
    sizes = [[abs(bezier.signed_area(subpath)) for subpath in outline] for outline in (first, second)]
    assert np.argmax(sizes[0]) == np.argmax(sizes[1])
    for outline in (first, second):
        assert bezier.signed_area(outline[0]) * bezier.signed_area(outline[1]) < 0
    halfway = [(p + q) / 2 for p, q in zip(first, second, strict=True)]
    # The filled outline's and the hole's radii are means of those at the ends: 14.5 and 6.5. A circle of four cubics
    # encloses 1.0006 of a circle's area at most.
    area = abs(sum(bezier.signed_area(subpath) for subpath in halfway))
    assert area == pytest.approx(np.pi * (14.5**2 - 6.5**2), rel=2e-3)


def test_lone_hole_grows_where_it_lies() -> None:
    disc = [cubics(circle((20, 20), 15))]
    ring = [cubics(circle((60, 20), 15)), cubics(reverse(circle((64, 20), 6)))]
    first, second = alignment.align(disc, ring)
    assert len(first) == len(second) == 2
    np.testing.assert_allclose(first[1], np.broadcast_to((24.0, 20.0), (4, 4, 2)), atol=ROUNDING)
    first, second = alignment.align(ring, disc)
    np.testing.assert_allclose(second[1], np.broadcast_to((24.0, 20.0), (4, 4, 2)), atol=ROUNDING)


def test_hole_does_not_become_filled() -> None:
    ring = [cubics(circle((20, 20), 15)), cubics(reverse(circle((20, 20), 6)))]
    two = [cubics(circle((20, 20), 15)), cubics(circle((50, 20), 6))]
    first, second = alignment.align(ring, two)
    assert len(first) == 3
    for p, q in zip(first, second, strict=True):
        assert bezier.signed_area(p) * bezier.signed_area(q) >= 0
