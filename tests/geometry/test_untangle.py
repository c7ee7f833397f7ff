# SPDX-License-Identifier: Apache-2.0
"""Outlines lose their loops, keep the larger part, and are otherwise left alone."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings, shapes

from livecl.geometry.bezier import evaluate, signed_area
from livecl.geometry.crossings import CROSSING_AREA, crossing_area
from livecl.geometry.untangle import Crossing, find_crossings, parted
from livecl.geometry.untangle import untangle as untangle_all

FloatArray = NDArray[np.float64]

# A cubic that crosses itself: its handles change sides. The crossing is at the parameters t and 1 - t, on the axis of
# symmetry x = 20, and what hangs above it is a drop.
LOOP = np.array([(4.0, 36.0), (92.0, -2.0), (-52.0, -2.0), (36.0, 36.0)])


def untangle(cubics: FloatArray) -> FloatArray:
    return untangle_all([cubics])[0]


def find_crossing(cubics: FloatArray) -> Crossing | None:
    return find_crossings([cubics])[0]


def _closed(path: FloatArray) -> FloatArray:
    return np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)


def _outline(*cubics: FloatArray) -> FloatArray:
    outline = np.stack(cubics)
    assert np.array_equal(outline[:, 3], np.roll(outline[:, 0], -1, axis=0))
    return outline


def _line(start: tuple[float, float], end: tuple[float, float]) -> FloatArray:
    a, b = np.array(start), np.array(end)
    return np.stack([a, a + (b - a) / 3, a + 2 * (b - a) / 3, b])


def _polygon_area(corners: FloatArray) -> float:
    x, y = corners.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def _meetings(corners: FloatArray) -> list[tuple[int, int, FloatArray]]:
    """Return the pairs of a closed polygon's sides that cross, and where."""
    start, step = corners, np.roll(corners, -1, axis=0) - corners
    found = []
    for i in range(len(corners) - 2):
        others = np.arange(i + 2, len(corners) - (i == 0))
        between = start[others] - start[i]
        cross = step[i, 0] * step[others, 1] - step[i, 1] * step[others, 0]
        s = (between[:, 0] * step[others, 1] - between[:, 1] * step[others, 0]) / cross
        t = (between[:, 0] * step[i, 1] - between[:, 1] * step[i, 0]) / cross
        hits = np.flatnonzero((s >= 0) & (s < 1) & (t >= 0) & (t < 1))
        found += [(i, int(others[k]), start[i] + s[k] * step[i]) for k in hits]
    return found


def _check(before: FloatArray, after: FloatArray) -> None:
    """Check what holds for any outline."""
    assert after.shape == before.shape
    assert np.isfinite(after).all()
    assert np.array_equal(after[:, 3], np.roll(after[:, 0], -1, axis=0)), "not closed"


@pytest.mark.parametrize(
    "path",
    [
        shapes.circle((20, 20), 9),
        shapes.circle((20, 20), 9, segments=9),
        drawings.reverse(drawings.blob(3, (20, 20), 12)),
        drawings.rectangle(3, 4, 20, 30),
        drawings.polygon([(0, 0), (20, 0), (20, 20), (10, 5)]),
        drawings.blob(1, (5, 5), 4, segments=1),
        drawings.polygon([(3, 3), (20, 20)]),  # there and back
        np.full((4, 3, 2), 7.0),  # a point
    ],
    ids=["circle", "nine segments", "blob", "rectangle", "concave", "one segment", "line", "point"],
)
def test_a_simple_outline_comes_back_as_it_is(path: FloatArray) -> None:
    cubics = _closed(path)
    before = cubics.copy()
    assert find_crossing(cubics) is None
    assert untangle(cubics) is cubics and np.array_equal(cubics, before)


def test_many_simple_outlines_come_back_as_they_are() -> None:
    for seed in range(60):
        cubics = _closed(drawings.blob(seed, (20, 20), 12, segments=2 + seed % 7))
        if crossing_area(cubics) == 0:
            assert untangle(cubics) is cubics


@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("reverse", [False, True])
def test_of_a_figure_eight_the_larger_half_is_left(turn: int, reverse: bool) -> None:
    # The sides cross in (10, 10): below lies a triangle of 20 x 10 / 2, above one of 10 x 5 / 2.
    path = np.roll(drawings.polygon([(0, 0), (20, 0), (5, 15), (15, 15)]), turn, axis=0)
    cubics = _closed(drawings.reverse(path) if reverse else path)
    after = untangle(cubics)
    _check(cubics, after)
    assert crossing_area(cubics) == pytest.approx(25, rel=1e-9) and crossing_area(after) == 0
    assert abs(signed_area(after)) == pytest.approx(100, rel=1e-9)
    assert np.hypot(*(after[:, 0] - (10, 10)).T).min() < 1e-9, "no anchor in the crossing"


@pytest.mark.parametrize("turn", range(4))
def test_an_outline_with_a_loop_larger_than_asked_for_is_left_as_it_is(turn: int) -> None:
    path = np.roll(drawings.polygon([(0, 0), (20, 0), (5, 15), (15, 15)]), turn, axis=0)  # a loop of 25 px^2
    eight, loop = _closed(path), _with_corner_loop()  # and one of 2 px^2
    kept, cut = untangle_all([eight, loop], largest=24.9)
    assert kept is eight and crossing_area(cut) == 0
    assert all(crossing_area(outline) == 0 for outline in untangle_all([eight, loop], largest=25.1))


def test_a_round_figure_eight() -> None:
    # Two discs of radius 10 and 6 that a line of no width would join; the strands cross between them.
    large, small = shapes.circle((12, 20), 10, segments=2), shapes.circle((30, 20), 6, segments=2)
    cubics = _closed(np.concatenate([large[[0, 1]], drawings.reverse(np.roll(small, 1, axis=0))]))
    assert crossing_area(cubics) > 100
    after = untangle(cubics)
    _check(cubics, after)
    assert crossing_area(after) <= CROSSING_AREA
    assert abs(signed_area(after)) == pytest.approx(np.pi * 100, rel=0.1)


def _with_corner_loop() -> FloatArray:
    """Return a square of 28 px whose sides cross in (30, 2) and go on around a triangle of 2 px^2."""
    return _closed(drawings.polygon([(2, 2), (32, 2), (30, 0), (30, 30), (2, 30)]))


def test_a_corner_loop_leaves_a_sharp_corner() -> None:
    cubics = _with_corner_loop()
    after = untangle(cubics)
    _check(cubics, after)
    assert crossing_area(cubics) == pytest.approx(2, rel=1e-9) and crossing_area(after) == 0
    assert signed_area(after) == pytest.approx(28 * 28, rel=1e-9)
    for corner in [(2, 2), (30, 2), (30, 30), (2, 30)]:
        assert np.hypot(*(after[:, 0] - corner).T).min() < 1e-9


def test_segments_far_from_a_corner_loop_stay_in_their_place() -> None:
    # Both of its other sides are: the loop took a segment, and a longer one was divided to make up for it.
    cubics = _with_corner_loop()
    after = untangle(cubics)
    unchanged = [k for k in (3, 4) if np.array_equal(after[k], cubics[k])]
    assert unchanged, "neither of the far segments is where it was"


@pytest.mark.parametrize("turn", range(4))
def test_strands_of_neighbouring_segments(turn: int) -> None:
    # The curves of two sides overshoot the corner and meet in an anchor beyond it.
    beyond = np.array([(2.0, 2.0), (12.0, 2.0), (30.0, 6.0), (33.0, -1.0)])
    back = np.array([(33.0, -1.0), (26.0, 2.0), (30.0, 20.0), (30.0, 30.0)])
    square = [beyond, back, _line((30.0, 30.0), (2.0, 30.0)), _line((2.0, 30.0), (2.0, 2.0))]
    cubics = np.roll(_outline(*square), turn, axis=0)
    crossing = find_crossing(cubics)
    assert crossing is not None and {crossing.first, crossing.second} == {turn % 4, (turn + 1) % 4}
    after = untangle(cubics)
    _check(cubics, after)
    assert crossing_area(cubics) > 1 and crossing_area(after) <= CROSSING_AREA
    for side in (2, 3):
        assert np.array_equal(after[(side + turn) % 4], cubics[(side + turn) % 4])
    # The parts run along the curves that they are parts of, up to where these meet.
    corner = after[(1 + turn) % 4, 0]
    for side, whole in ((0, beyond), (1, back)):
        dense = evaluate(whole, np.linspace(0, 1, 20001))
        for point in (corner, *evaluate(after[(side + turn) % 4], [0.3, 0.7])):
            assert np.hypot(*(dense - point).T).min() < 2e-3


@pytest.mark.parametrize("turn", range(4))
def test_a_loop_inside_one_segment_is_cut_off(turn: int) -> None:
    loop = LOOP * 0.2 + (16.0, -7.2)  # on the upper side of a triangle of 800 px^2
    start, end = (float(loop[0, 0]), 0.0), (float(loop[3, 0]), 0.0)
    loop[[0, 3]] = start, end
    right, left = _line((40.0, 0.0), (20.0, 40.0)), _line((20.0, 40.0), (0.0, 0.0))
    sides = [_line((0.0, 0.0), start), loop, _line(end, (40.0, 0.0)), right, left]
    cubics = np.roll(_outline(*sides), turn, axis=0)
    crossing = find_crossing(cubics)
    assert crossing is not None and crossing.first == crossing.second == (1 + turn) % 5
    assert crossing.t == pytest.approx(1 - crossing.u, abs=1e-9)
    after = untangle(cubics)
    _check(cubics, after)
    assert crossing_area(after) <= CROSSING_AREA
    for side in (0, 2, 3, 4):
        assert np.array_equal(after[(side + turn) % 5], cubics[(side + turn) % 5])
    joined = after[(1 + turn) % 5]
    assert np.array_equal(joined[[0, 3]], [start, end])
    # What is left is the triangle, and what the two arms of the loop, up to the crossing, add to it or take.
    arms = abs(float(evaluate(loop, [crossing.t])[0, 1])) * (end[0] - start[0])
    assert abs(abs(signed_area(after)) - 800) <= arms


@pytest.mark.parametrize("turn", range(2))
def test_a_loop_that_is_the_larger_part_is_what_is_left(turn: int) -> None:
    cubics = np.roll(_outline(LOOP, _line((36.0, 36.0), (4.0, 36.0))), turn, axis=0)
    crossing = find_crossing(cubics)
    assert crossing is not None and crossing.first == crossing.second == turn
    drop = _polygon_area(evaluate(LOOP, np.linspace(crossing.t, crossing.u, 4001)))
    rest = signed_area(cubics) - drop
    assert abs(drop) > abs(rest) > 10
    after = untangle(cubics)
    _check(cubics, after)
    assert crossing_area(after) <= CROSSING_AREA
    assert signed_area(after) == pytest.approx(drop, rel=1e-5)  # the drop's 4000 chords are off by less


def test_an_outline_that_winds_twice_keeps_its_outer_turn() -> None:
    # r = 6 - 12 cos(angle): a limaçon, whose inner loop, of radius 6 at most, turns the way the outer one does.
    angle = 2 * np.pi * np.arange(8) / 8 + 0.1
    step = angle[1] - angle[0]

    def at(angle: FloatArray) -> FloatArray:
        radius = 6 - 12 * np.cos(angle)
        return np.stack([30 + radius * np.cos(angle), 20 + radius * np.sin(angle)], axis=-1)

    def slope(angle: FloatArray) -> FloatArray:
        return (at(angle + 1e-5) - at(angle - 1e-5)) / 2e-5

    path = np.stack([at(angle), at(angle) + slope(angle) * step / 3, at(angle + step) - slope(angle + step) * step / 3])
    cubics = _closed(path.transpose(1, 0, 2))
    inner = crossing_area(cubics)
    after = untangle(cubics)
    _check(cubics, after)
    assert inner > 10 and crossing_area(after) <= CROSSING_AREA
    assert abs(signed_area(after)) == pytest.approx(abs(signed_area(cubics)) - inner, rel=1e-3)


def test_strands_that_cross_in_corners_of_their_polylines() -> None:
    # A symmetric eight, both of whose strands pass the centre at t = 1/2, where their lines end.
    for reach in (8, 12, 13, 14, 20):
        path = [[(-10, 0), (-10, -reach), (10, reach)], [(10, 0), (10, -reach), (-10, reach)]]
        cubics = _closed(np.array(path, dtype=np.float64))
        assert crossing_area(cubics) > 20
        assert crossing_area(untangle(cubics)) <= CROSSING_AREA, f"handles of {reach} px"


def test_strands_that_cross_in_an_anchor() -> None:
    cubics = _closed(drawings.polygon([(0, 0), (10, 10), (10, 0), (5, 5), (0, 10)]))
    assert crossing_area(cubics) == pytest.approx(25)
    assert crossing_area(untangle(cubics)) <= CROSSING_AREA


@pytest.mark.parametrize(
    ("kind", "segments"), [("tangle", 2), ("tangle", 4), ("tangle", 6), ("shaken", 4), ("shaken", 8)]
)
def test_random_outlines(kind: str, segments: int) -> None:
    # Of loops that the coarser lines of this module do not have, or whose strands run side by side, some may be left:
    # in one outline of fifty, and those small.
    left, tangled, count = [], 0, 50
    for seed in range(count):
        if kind == "tangle":
            path = drawings.tangle(seed, (40, 40), segments)
        else:
            path = drawings.blob(seed, (20, 20), 12, segments)
            path = path + 4 * np.random.default_rng(seed).normal(size=path.shape)
        cubics = _closed(path)
        after = untangle(cubics)
        _check(cubics, after)
        tangled += crossing_area(cubics) > CROSSING_AREA
        left.append(crossing_area(after))
        assert untangle(after) is after
    assert tangled >= count / 10
    assert np.mean(np.array(left) <= CROSSING_AREA) >= 0.98
    assert max(left) < 0.05


def test_of_a_single_crossing_the_larger_part_is_left() -> None:
    # Against the polygon of 150 corners, cut where two of its sides meet. A side of length l under a curvature k lacks
    # k l^3 / 12: of 150 sides of 1 px, as they are here about, and a mean curvature of 0.2, 2.5 px^2 of some hundreds.
    seen = 0
    for seed in range(100):
        cubics = _closed(drawings.tangle(seed, (40, 40), 3))
        corners = evaluate(cubics, np.arange(50) / 50).reshape(-1, 2)
        meetings = _meetings(corners)
        crossing = find_crossing(cubics)
        if len(meetings) != 1 or crossing is None or crossing.first == crossing.second:
            continue
        ((first, second, point),) = meetings
        parts = corners[first + 1 : second + 1], np.concatenate([corners[second + 1 :], corners[: first + 1]])
        areas = [_polygon_area(np.concatenate([part, point[None]])) for part in parts]
        after = untangle(cubics)
        _check(cubics, after)
        assert signed_area(after) == pytest.approx(max(areas, key=abs), abs=2.5)
        seen += 1
    assert seen >= 10


def test_the_same_outline_elsewhere_is_cut_alike() -> None:
    cubics = _closed(drawings.tangle(4, (40, 40), 4))
    after = untangle(cubics)
    assert not np.array_equal(after, cubics)
    shift = np.array((64.0, -32.0))
    np.testing.assert_allclose(untangle(cubics + shift), after + shift, atol=1e-6)


def test_many_outlines_at_once_are_each_alone() -> None:
    rng = np.random.default_rng(4)
    outlines = [_closed(rng.uniform(0, 30, size=(count, 3, 2))) for count in (1, 2, 5, 9, 3)]
    outlines.insert(2, _closed(shapes.circle((20, 20), 9)))
    together = untangle_all(outlines)
    assert together[2] is outlines[2]
    for outline, found in zip(outlines, together, strict=True):
        np.testing.assert_array_equal(found, untangle(outline))
    assert untangle_all([]) == []


@pytest.mark.parametrize(
    "corners", [[(0, 0), (30, 20), (30, 0), (0, 20)], [(0, 0), (40, 0), (40, 30), (10, 30), (10, -8), (0, 20)]]
)
def test_parts_wind_as_often_as_the_whole(corners: list[tuple[float, float]]) -> None:
    """A bow tie, and an outline that crosses itself twice: areas with the sign of the turn add up to the whole's."""
    start = np.array(corners, dtype=float)
    step = (np.roll(start, -1, axis=0) - start) / 3
    outline = np.stack([start, start + step, start + 2 * step, start + 3 * step], axis=1)
    parts = parted(outline)
    assert len(parts) > 1 and all(crossing_area(part) <= CROSSING_AREA for part in parts)
    assert sum(signed_area(part) for part in parts) == pytest.approx(signed_area(outline), abs=1e-6)
    for part in parts:
        np.testing.assert_array_equal(part[:, 3], np.roll(part[:, 0], -1, axis=0))
