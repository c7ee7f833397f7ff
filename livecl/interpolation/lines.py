# SPDX-License-Identifier: Apache-2.0
"""Align the centre lines of two stroked layers: equal numbers of lines and segments, directions of least motion.

A line is open or closed, with the cubics of its segments (m, 4, 2), px. Unlike outlines, lines may be reversed one by
one, and a closed one may be cut open, which is invisible where the line is smooth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from livecl.arrays import FloatArray
from livecl.geometry import bezier
from livecl.geometry.polylines import points_at
from livecl.interpolation.alignment import CHORDS, best_shift, center, chords, subdivide

#: Number of steps of equal length at which two lines are compared, and a closed one may be cut.
STEPS = 16
#: Length, px, to which a line without a match shrinks: long enough for its caps to have a direction.
SPECK = 0.01
#: Cost of an unmatched node, in shares of the length: nodes farther apart than twice this are not matched.
ALONE = 0.05
#: Least share of a segment on both sides of a cut: there may be corners at its ends.
MARGIN = 0.1


class StrokeLine(NamedTuple):
    """A line of a stroke: cubics (m, 4, 2), px, and whether it is open."""

    cubics: FloatArray
    is_open: bool


class _Way(NamedTuple):
    """Best match of a line with another: squared distance, px^2; whether it is reversed; the step of a cut, if any."""

    distance: float
    reverse: bool = False
    cut: int = 0


def align_lines(first: list[StrokeLine], second: list[StrokeLine]) -> tuple[list[StrokeLine], list[StrokeLine]]:
    """Align two non-empty lists of centre lines, without changing their shapes.

    Lines of similar places within their layers are matched. If one is open and one closed, the closed one is cut where
    that matches best. An unmatched line begins or ends as a speck on the nearest line of the other layer, which hides
    it.

    Returns
    -------
    first, second : list of StrokeLine
        Equal numbers of lines, with equal numbers of segments, both open or both closed.
    """
    offset = center([line.cubics for line in second]) - center([line.cubics for line in first])
    samples = [[_samples(line.cubics) for line in lines] for lines in (first, second)]
    ways = [
        [_best_way(a + offset, b, (line.is_open, other.is_open)) for b, other in zip(samples[1], second, strict=True)]
        for a, line in zip(samples[0], first, strict=True)
    ]
    rows, columns = linear_sum_assignment([[way.distance for way in row] for row in ways])
    partners = dict(zip(rows.tolist(), columns.tolist(), strict=True))
    pairs = [_paired(first[i], second[j], ways[i][j]) for i, j in partners.items()]
    pairs += [(line, _speck(line, second, offset)) for i, line in enumerate(first) if i not in partners]
    lone = set(range(len(second))) - set(partners.values())
    pairs += [(_speck(second[j], first, -offset), second[j]) for j in sorted(lone)]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def _best_way(a: FloatArray, b: FloatArray, is_open: tuple[bool, bool]) -> _Way:
    """Return how to reverse and cut b (or a, if only a is closed) to match the other best, by samples of both."""
    fixed, moving = (b, a) if is_open == (False, True) else (a, b)
    ways = []
    for cut in range(1 if all(is_open) else STEPS):
        turned = np.concatenate([moving[cut:-1], moving[: cut + 1]]) if cut else moving
        for reverse in (False, True):
            difference = fixed - (turned[::-1] if reverse else turned)
            ways.append(_Way(float(np.mean(np.sum(difference**2, axis=1))), reverse, cut))
    return min(ways, key=lambda way: way.distance)


def _paired(a: StrokeLine, b: StrokeLine, way: _Way) -> tuple[StrokeLine, StrokeLine]:
    """Return two lines with equal numbers of segments and corresponding starts."""
    one, other, is_open = a.cubics, b.cubics, a.is_open or b.is_open
    if is_open and not b.is_open:
        other = _cut(other, way.cut)
    elif is_open and not a.is_open:
        one = _cut(one, way.cut)
    if way.reverse:
        other = other[::-1, ::-1]
    if is_open:
        one, other = _with_same_nodes(one, other)
    else:
        count = max(len(one), len(other))
        one, other = subdivide(one, count), subdivide(other, count)
        other = np.roll(other, -best_shift(one, other)[0], axis=0)
    return StrokeLine(one, is_open), StrokeLine(other, is_open)


def _with_same_nodes(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two open lines with equal numbers of nodes, matched by their places along the lines.

    Nodes are matched in order, at the least sum of the differences of their places, as shares of the length, and of
    `ALONE` for each unmatched one. Those get a node on the other line, in proportion between the matched neighbours.
    """
    lengths = _lengths(a), _lengths(b)
    u, v = (own[CHORDS:-1:CHORDS] / max(own[-1], 1e-12) for own in lengths)
    least = np.add.outer(np.arange(len(u) + 1), np.arange(len(v) + 1)) * ALONE
    for i, j in np.ndindex(len(u), len(v)):
        paired = least[i, j] + abs(u[i] - v[j])
        least[i + 1, j + 1] = min(paired, least[i, j + 1] + ALONE, least[i + 1, j] + ALONE)
    i, j, pairs = len(u), len(v), [(len(u), len(v))]
    while i and j:
        if least[i, j] == least[i - 1, j - 1] + abs(u[i - 1] - v[j - 1]):
            i, j = i - 1, j - 1
            pairs.append((i, j))
        elif least[i, j] == least[i - 1, j] + ALONE:
            i -= 1
        else:
            j -= 1
    first, second = np.array([(-1, -1), *pairs[::-1]]).T
    on_a = np.interp(v, np.append(0, np.append(v, 1)[second[1:]]), np.append(0, np.append(u, 1)[first[1:]]))
    on_b = np.interp(u, np.append(0, np.append(u, 1)[first[1:]]), np.append(0, np.append(v, 1)[second[1:]]))
    alone = np.setdiff1d(np.arange(len(v)), second)
    in_a = np.concatenate([np.arange(1, len(a)), _parameters(on_a[alone], lengths[0])])
    in_b = np.concatenate([_parameters(on_b, lengths[1]), 1 + alone])
    in_b[first[1:-1]] = 1 + second[1:-1]
    return _split_at(a, in_a), _split_at(b, in_b)


def _parameters(places: FloatArray, lengths: FloatArray) -> FloatArray:
    """Return segment index plus parameter at places along a line, given as shares of its length."""
    return np.interp(places * lengths[-1], lengths, np.arange(len(lengths)) / CHORDS)


def _split_at(cubics: FloatArray, parameters: FloatArray) -> FloatArray:
    """Return a line with nodes at given parameters, which include all its inner nodes."""
    knots = np.sort(np.concatenate([[0.0, len(cubics)], parameters]))
    index = np.minimum(knots[:-1].astype(np.int64), len(cubics) - 1)
    return bezier.subsegment(cubics[index], knots[:-1] - index, knots[1:] - index)


def _cut(cubics: FloatArray, step: int) -> FloatArray:
    """Return a closed line cut at one of its steps, but not at a node."""
    lengths = _lengths(cubics)
    at = float(_parameters(np.array(step / STEPS), lengths))
    index = min(int(at), len(cubics) - 1)
    inner = np.clip(at - index, MARGIN, 1 - MARGIN)
    before, after = bezier.subsegment(cubics[index], np.array([0, inner]), np.array([inner, 1]))
    return np.concatenate([after[None], cubics[index + 1 :], cubics[:index], before[None]])


def _speck(line: StrokeLine, others: list[StrokeLine], offset: FloatArray) -> StrokeLine:
    """Return the speck of an unmatched line: as many segments along a short piece of the nearest line."""
    middle = _samples(line.cubics).mean(axis=0) + offset
    sampled = [bezier.evaluate(other.cubics, np.linspace(0.25, 0.75, 9)) for other in others]
    distances = [np.square(points - middle).sum(axis=-1) for points in sampled]
    nearest = min(range(len(others)), key=lambda index: float(distances[index].min()))
    segment, step = np.unravel_index(np.argmin(distances[nearest]), distances[nearest].shape)
    points = sampled[nearest][segment]
    place = points[step]
    along = points[min(step + 1, 8)] - points[max(step - 1, 0)]
    length = float(np.hypot(*along))
    piece = along / length * SPECK if length > 0 else np.array([SPECK, 0.0])
    count = len(line.cubics)
    there_and_back = 1 - np.abs(np.linspace(-1, 1, count + 1))
    knots = np.arange(count + 1) / count if line.is_open else there_and_back
    ends = place + (knots - 0.5)[:, None] * piece
    shares = np.arange(4)[:, None] / 3
    return StrokeLine(ends[:-1, None] + (ends[1:] - ends[:-1])[:, None] * shares, line.is_open)


def _samples(cubics: FloatArray) -> FloatArray:
    """Return points at equal steps along a line, both ends among them: (STEPS + 1, 2)."""
    lengths = _lengths(cubics)
    points = bezier.evaluate(cubics, np.linspace(0, 1, CHORDS + 1))
    course = np.concatenate([points[:, :-1].reshape(-1, 2), points[-1:, -1]])
    return points_at(np.linspace(0, lengths[-1], STEPS + 1), course, lengths)


def _lengths(cubics: FloatArray) -> FloatArray:
    """Return the length along a line up to each of its `CHORDS` steps a segment: (m CHORDS + 1,), px."""
    return np.concatenate([[0.0], np.cumsum(chords(cubics))])
