# SPDX-License-Identifier: Apache-2.0
"""Least-squares cubics through runs of samples, with given tangents at smooth ends; many at a time.

With T, N the tangent and the normal at an end, its handle is A + a T + b N, and b is 0 at a smooth end: linear in a and
b for given parameters of the samples, which are then moved to the curve's nearest points, and so on (P. J. Schneider,
*An algorithm for automatically fitting digitized curves*, Graphics Gems, 1990; here with free ends, too).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.geometry.bezier import bernstein

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Samples of a run that a cubic is fitted to, rounds of moving their parameters, weight that holds b at 0.
SAMPLES, ROUNDS, HOLD = 14, 2, 1e6
#: Length of a handle along its tangent, as shares of the chord: at least, and at most.
SHORTEST, LONGEST = 0.01, 2.0


def runs_between(points: FloatArray, starts: IntArray, ends: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return SAMPLES + 1 points at equal steps of each run of a closed trace, and where they are, in samples.

    Parameters
    ----------
    points : (P, 2) float64
        The trace.
    starts, ends : (n,) int64
        First and last sample of each run, ends counted on past P.

    Returns
    -------
    (n, SAMPLES + 1, 2), (n, SAMPLES + 1) float64
    """
    at = starts[:, None] + (ends - starts)[:, None] * np.linspace(0, 1, SAMPLES + 1)
    whole = np.floor(at).astype(np.int64)
    share = (at - whole)[..., None]
    count = len(points)
    return points[whole % count] * (1 - share) + points[(whole + 1) % count] * share, at


def fit(
    runs: FloatArray, first: FloatArray, last: FloatArray, free: NDArray[np.bool_], weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Fit cubics to runs of points.

    Parameters
    ----------
    runs : (n, k, 2) float64
        Points of each run; its ends are the cubic's.
    first, last : (n, 2) float64
        Unit tangents, in the direction of travel.
    free : (n, 2) bool
        Whether the tangent at either end is free.
    weights : (n, k) float64
        How much each point counts.

    Returns
    -------
    cubics : (n, 4, 2) float64
    distances : (n, k) float64
        Of the points from the curve, px.
    """
    start, end = runs[:, :1], runs[:, -1:]
    chords = np.hypot(*(end - start)[:, 0].T)
    steps = np.hypot(*np.moveaxis(np.diff(runs, axis=1), -1, 0))
    t = np.concatenate([np.zeros((len(runs), 1)), np.cumsum(steps, axis=1)], axis=1)
    t /= np.maximum(t[:, -1:], 1e-12)
    lengths = np.maximum(steps.sum(axis=1), 1e-12)
    normal = np.array([[0.0, 1.0], [-1.0, 0.0]])
    axes = np.stack([first, first @ normal, -last, last @ normal], axis=1)  # (n, 4, 2)
    hold = np.zeros((len(runs), 4))
    hold[:, 1], hold[:, 3] = np.where(free, 0.0, HOLD).T
    shortest, longest = SHORTEST * chords, LONGEST * lengths
    cubics = np.empty((len(runs), 4, 2))
    for turn in range(ROUNDS):
        basis = bernstein(t)  # (n, k, 4)
        rest = runs - start * basis[..., :2].sum(-1)[..., None] - end * basis[..., 2:].sum(-1)[..., None]
        columns = basis[..., [1, 1, 2, 2]][..., None] * axes[:, None]  # (n, k, 4, 2)
        weighted = columns * weights[..., None, None]
        gram = np.einsum("nkad,nkbd->nab", weighted, columns)
        ridge = 1e-9 * np.trace(gram, axis1=1, axis2=2)[:, None] + 1e-12
        gram[:, range(4), range(4)] += hold + ridge
        solved = np.linalg.solve(gram, np.einsum("nkad,nkd->na", weighted, rest)[..., None])[..., 0]
        for along, side in ((0, 0), (2, 1)):
            clipped = np.clip(solved[:, along], shortest, longest)
            solved[:, along] = np.where(free[:, side], solved[:, along], clipped)
        cubics[:, 0], cubics[:, 3] = start[:, 0], end[:, 0]
        cubics[:, 1] = start[:, 0] + np.einsum("na,nad->nd", solved[:, :2], axes[:, :2])
        cubics[:, 2] = end[:, 0] + np.einsum("na,nad->nd", solved[:, 2:], axes[:, 2:])
        if turn < ROUNDS - 1:
            t = _nearer(cubics, runs, t)
    distances = _nearest(cubics, runs, t)
    return cubics, distances


def _nearer(cubics: FloatArray, runs: FloatArray, t: FloatArray) -> FloatArray:
    """Return parameters moved by a Gauss-Newton step towards the curve's nearest points."""
    misses = np.einsum("nkb,nbd->nkd", bernstein(t), cubics) - runs
    slopes = _slopes(cubics, t)
    moved = t - (misses * slopes).sum(-1) / np.maximum((slopes * slopes).sum(-1), 1e-12)
    moved = np.clip(moved, 0, 1)
    moved[:, 0], moved[:, -1] = 0, 1
    return np.maximum.accumulate(moved, axis=1)


def _slopes(cubics: FloatArray, t: FloatArray) -> FloatArray:
    u = 1 - t
    weights = np.stack([u * u, 2 * t * u, t * t], axis=-1)
    return 3 * np.einsum("nkb,nbd->nkd", weights, np.diff(cubics, axis=1))


def _nearest(cubics: FloatArray, runs: FloatArray, t: FloatArray) -> FloatArray:
    t = _nearer(cubics, runs, t)
    return np.asarray(np.linalg.norm(np.einsum("nkb,nbd->nkd", bernstein(t), cubics) - runs, axis=-1))
