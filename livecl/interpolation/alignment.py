# SPDX-License-Identifier: Apache-2.0
"""Align two outlines: equal numbers of segments, start points and directions of least motion.

An outline is a list of closed subpaths, each (m, 4, 2): the cubics of its segments, px. Nothing here changes the area
filled under the nonzero rule: segments are cut without moving the curve, subpaths get another start, and an outline's
subpaths are only reversed all together.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from livecl.arrays import FloatArray
from livecl.geometry import bezier

#: Number of chords for measuring a segment's length.
CHORDS = 32
#: Squared distance of subpaths that must not be matched, px^2: larger than any on a canvas.
_NEVER = 1e15

#: Closed subpaths of a layer, each (m, 4, 2) px: all four control points of its segments.
CubicPaths: TypeAlias = list[FloatArray]


def split(cubic: ArrayLike, count: int) -> FloatArray:
    """Cut a cubic (4, 2) into `count` pieces of equal arc length.

    Returns
    -------
    (count, 4, 2) float64
        The pieces in order; each begins exactly where the one before it ends.

    Notes
    -----
    The pieces are exact; their lengths are equal as measured by `CHORDS` chords.
    """
    cubic = np.asarray(cubic, dtype=np.float64)
    parameters = np.linspace(0, 1, CHORDS + 1)
    lengths = np.concatenate([[0.0], np.cumsum(chords(cubic[None])[0])])
    knots = np.linspace(0, 1, count + 1)
    if lengths[-1] > 0:
        knots[1:-1] = np.interp(knots[1:-1] * lengths[-1], lengths, parameters)
    return bezier.subsegment(cubic, knots[:-1], knots[1:])


def subdivide(cubics: ArrayLike, count: int) -> FloatArray:
    """Cut a closed subpath (m, 4, 2) into `count` segments, m or more, the longest ones first, without moving it.

    Raises ValueError if there are more segments than wanted already.
    """
    cubics = np.asarray(cubics, dtype=np.float64)
    if count < len(cubics):
        raise ValueError(f"count: got {count}, wanted at least the {len(cubics)} segments that there are")
    lengths = chords(cubics).sum(axis=1).tolist()
    pieces = [1] * len(cubics)
    longest = [(-length, index) for index, length in enumerate(lengths)]
    heapq.heapify(longest)
    for _ in range(count - len(cubics)):
        index = longest[0][1]
        pieces[index] += 1
        heapq.heapreplace(longest, (-lengths[index] / pieces[index], index))
    return np.concatenate([split(cubic, n) if n > 1 else cubic[None] for cubic, n in zip(cubics, pieces, strict=True)])


def best_shift(fixed: ArrayLike, moving: ArrayLike) -> tuple[int, float]:
    """Find the start segment of a closed subpath for which it best matches another one of as many segments.

    Parameters
    ----------
    fixed, moving : (m, 4, 2) array_like
        Segments, px.

    Returns
    -------
    shift : int
        Segment of `moving` that corresponds to the first of `fixed`.
    distance : float
        Mean squared distance of their control points, px^2, each relative to its subpath's mean.

    Notes
    -----
    With the points as complex numbers a_ij, b_ij (segment i, j = 0, 1, 2) about their means, sum |a_ij - b_(i+k)j|^2 is
    sum |a|^2 + sum |b|^2 - 2 Re sum conj(a_ij) b_(i+k)j: the last sum is a circular correlation over i, computed for
    all k at once by FFT. The means are those of all control points, which no shift or reversal changes; so subtracting
    them gives the least sum over all translations as well.
    """
    a, b = _about_mean(fixed), _about_mean(moving)
    correlation = np.fft.ifft((np.fft.fft(a, axis=0).conj() * np.fft.fft(b, axis=0)).sum(axis=1)).real
    shift = int(np.argmax(correlation))
    difference = a - np.roll(b, -shift, axis=0)
    return shift, float(np.mean(np.abs(difference) ** 2))


def align(first: Sequence[ArrayLike], second: Sequence[ArrayLike]) -> tuple[CubicPaths, CubicPaths]:
    """Return two outlines with subpaths, segments and points that correspond.

    Subpaths of similar places within their outlines are matched, never a hole with a filled one; an unmatched subpath
    corresponds to a point in the other outline, from which it grows or to which it shrinks. All of `second` is reversed
    if that brings it nearer.

    Parameters
    ----------
    first, second : sequence of (m, 4, 2) array_like
        Outlines of one or more closed subpaths, px.

    Returns
    -------
    first, second : list of (m, 4, 2) float64
        Outlines with equal numbers of subpaths and of segments in each, of unchanged shape.
    """
    a = [np.asarray(subpath, dtype=np.float64) for subpath in first]
    b = [np.asarray(subpath, dtype=np.float64) for subpath in second]
    turned = [subpath[::-1, ::-1] for subpath in b]
    straight = _matched(a, b)
    reverse = _matched(a, turned)
    b, pairs = (b, straight[0]) if straight[1] <= reverse[1] else (turned, reverse[0])
    shift = center(b) - center(a)
    aligned = []
    for i, j in pairs:
        if i is None and j is not None:
            aligned.append((_collapsed(b[j], _mean(b[j]) - shift), b[j]))
        elif j is None and i is not None:
            aligned.append((a[i], _collapsed(a[i], _mean(a[i]) + shift)))
        elif i is not None and j is not None:
            aligned.append(_aligned_subpaths(a[i], b[j])[:2])
    return [pair[0] for pair in aligned], [pair[1] for pair in aligned]


def _matched(a: CubicPaths, b: CubicPaths) -> tuple[list[tuple[int | None, int | None]], float]:
    """Pair the subpaths of two outlines in their present directions; return the pairs and their cost, px^2."""
    distances = np.empty((len(a), len(b)))
    alone = len(a) == len(b) == 1
    shift = center(b) - center(a)
    for i, j in np.ndindex(distances.shape):
        alike = alone or bezier.signed_area(a[i]) * bezier.signed_area(b[j]) >= 0
        offset = _mean(b[j]) - _mean(a[i]) - shift
        distances[i, j] = _aligned_subpaths(a[i], b[j])[2] + offset @ offset if alike else _NEVER
    pairs: list[tuple[int | None, int | None]] = []
    for i, j in zip(*linear_sum_assignment(distances), strict=True):
        if distances[i, j] < _NEVER:
            pairs.append((int(i), int(j)))
    cost = sum(float(distances[i, j]) for i, j in pairs if i is not None and j is not None)
    for outline, side in ((a, 0), (b, 1)):
        for index in sorted(set(range(len(outline))) - {pair[side] for pair in pairs}):
            pairs.append((index, None) if side == 0 else (None, index))
            cost += float(np.mean(np.abs(_about_mean(outline[index])) ** 2))
    return pairs, cost


def _aligned_subpaths(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Give two subpaths equal numbers of segments and the second the best start; return them and their distance."""
    count = max(len(a), len(b))
    a, b = subdivide(a, count), subdivide(b, count)
    shift, distance = best_shift(a, b)
    return a, np.roll(b, -shift, axis=0), distance


def _collapsed(subpath: FloatArray, point: FloatArray) -> FloatArray:
    return np.broadcast_to(point, subpath.shape).copy()


def _mean(subpath: FloatArray) -> FloatArray:
    mean: FloatArray = subpath[:, :3].mean(axis=(0, 1))
    return mean


def center(outline: CubicPaths) -> FloatArray:
    """Return the centre of the control points' bounding box, which does not depend on small holes: (2,), px."""
    bounds = bezier.outline_bounds(outline)
    return (bounds[:2] + bounds[2:]) / 2


def _about_mean(cubics: ArrayLike) -> NDArray[np.complex128]:
    """Return the control points (m, 3) as complex numbers relative to their mean."""
    points = np.asarray(cubics, dtype=np.float64)[:, :3]
    numbers: NDArray[np.complex128] = points[..., 0] + 1j * points[..., 1]
    return numbers - numbers.mean()


def chords(cubics: FloatArray) -> FloatArray:
    """Return the lengths of the `CHORDS` chords at even parameters of each cubic: (m, CHORDS), px."""
    points = bezier.evaluate(cubics, np.linspace(0, 1, CHORDS + 1))
    lengths: FloatArray = np.linalg.norm(np.diff(points, axis=-2), axis=-1)
    return lengths
