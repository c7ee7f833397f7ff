# SPDX-License-Identifier: Apache-2.0
"""Fit closed cubic paths to a polyline, with anchors at corners and where curves change.

Anchors lie on the polyline. The two handles between two anchors are the least-squares fit to the polyline between them,
parametrized by its length: a linear problem, as a cubic is linear in its control points. The anchors of least error are
found for all numbers of segments at once by dynamic programming: the best path with k segments up to a point is the
best with k - 1 up to some earlier point and one segment more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.geometry import cyclic
from livecl.geometry.bezier import bernstein
from livecl.geometry.polylines import evenly

#: Candidate places of anchors on the polyline: largest and least number (more if more segments are requested), and
#: distance, px.
PLACES, LEAST_PLACES, SPACING = 64, 24, 2.0
#: Number of points at which a segment is compared with the polyline, and of the polyline's points for each place.
POINTS, FINE = 24, 4


def fit_outlines(polyline: FloatArray, most: int) -> list[FloatArray]:
    """Return the closed paths of 1, 2, ... `most` segments that follow a closed polyline (P, 2) px best.

    Returns
    -------
    list of (s, 3, 2) float64
        The path of s segments is at index s - 1; it runs the way the polyline does.
    """
    length = float(np.hypot(*(cyclic.following(polyline) - polyline).T).sum())
    places = max(most, int(np.clip(np.ceil(length / SPACING), LEAST_PLACES, PLACES)))
    points = evenly(polyline, places * FINE)
    errors, handles = _segment_fits(points, places)
    first = _corner(errors)
    return [_path(points, handles, anchors) for anchors in _best_places(errors, first, most)]


def _segment_fits(points: FloatArray, places: int) -> tuple[FloatArray, FloatArray]:
    """Fit a cubic from every place to every other.

    Returns
    -------
    errors : (places, places) float64
        Sum of squared distances, by first place and length in places less one, in units of one place's length.
    handles : (places, places, 2, 2) float64
        The two handles, px.
    """
    weights = bernstein(np.linspace(0, 1, POINTS + 1))
    inner, ends = weights[:, 1:3], weights[:, [0, 3]]
    solve = np.linalg.pinv(inner)
    errors, handles = np.empty((places, places)), np.empty((places, places, 2, 2))
    starts = FINE * np.arange(places)
    twice = np.tile(points @ (1, 1j), 2)  # a complex number is looked up in one go
    steps = cyclic.following(twice) - twice
    for length in range(1, places + 1):
        along = np.linspace(0, FINE * length, POINTS + 1)
        whole = along.astype(np.int64)
        at = whole[:, None] + starts
        runs = twice.take(at, mode="wrap") + (along - whole)[:, None] * steps.take(at, mode="wrap")
        rest = runs.view(np.float64)  # (POINTS + 1, 2 places), x and y of one place after the other
        rest = rest - ends @ rest[[0, -1]]
        fit = solve @ rest
        misses = inner @ fit - rest
        handles[:, length - 1] = fit.reshape(2, places, 2).transpose(1, 0, 2)
        errors[:, length - 1] = length / POINTS * np.square(misses).sum(axis=0).reshape(places, 2).sum(axis=1)
    return errors, handles


def _corner(errors: FloatArray) -> int:
    """Return the place where a short segment across it fits worst: it is always an anchor."""
    length = len(errors) // 12
    return int((np.argmax(errors[:, length - 1]) + length // 2) % len(errors))


def _best_places(errors: FloatArray, first: int, most: int) -> list[NDArray[np.int64]]:
    """Return the anchors' places of the best paths of 1, 2, ... `most` segments, `first` being one of them."""
    count = len(errors)
    ends, lengths = np.arange(count + 1)[:, None], np.arange(1, count + 1)
    starts = ends - lengths  # by end, counted from `first`, and length
    cost = np.where(starts >= 0, errors[(first + starts) % count, lengths - 1], np.inf)
    best = np.where(ends[:, 0] == 0, 0.0, np.inf)
    before: list[NDArray[np.int64]] = []
    found = []
    for _ in range(most):
        totals = best[np.maximum(starts, 0)] + cost
        chosen = np.argmin(totals, axis=1)
        best = np.take_along_axis(totals, chosen[:, None], axis=1)[:, 0]
        before.append(ends[:, 0] - lengths[chosen])
        places = [count]
        for step in reversed(before):
            places.append(int(step[places[-1]]))
        found.append(first + np.array(places[:0:-1], dtype=np.int64))
    return found


def _path(points: FloatArray, handles: FloatArray, places: NDArray[np.int64]) -> FloatArray:
    count = len(handles)
    lengths = np.diff(places, append=places[0] + count)
    anchors = points[FINE * places % len(points)]
    return np.concatenate([anchors[:, None], handles[places % count, lengths - 1]], axis=1)
