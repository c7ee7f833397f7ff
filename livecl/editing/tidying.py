# SPDX-License-Identifier: Apache-2.0
"""Tidy an outline, keeping its nodes: make nearly straight segments lines, and nearly smooth joins smooth."""

from __future__ import annotations

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.editing.constraints import Joins, Slack
from livecl.editing.outline import ROUNDS
from livecl.geometry import bezier, cyclic
from livecl.geometry.least_path import SAMPLES, SHARES, Tangents, fit_curves

#: Tolerances within which segments become lines and joins smooth.
NEARLY = Slack(straight=0.33, along=1 / 3, level=0.3, tilt=0.06, turn=0.4)


def tidied(subpath: FloatArray, tolerance: float) -> FloatArray:
    """Tidy a closed subpath (m, 3, 2): make nearly straight segments lines, and nearly smooth joins smooth.

    Anchors between two lines that are nearly one are left out. Curves beside smooth joins are fitted to what they were;
    joins at which that would move them by more than a tolerance, px, stay as they are.
    """
    subpath = _without_bends(subpath)
    joins = _joins_of(subpath)
    count = len(subpath)
    tidy = subpath.copy()
    curved = np.flatnonzero(~joins.lines)
    after = (curved + 1) % count
    old = np.concatenate([subpath, cyclic.following(subpath[:, :1])], axis=1)[curved]
    runs = bezier.evaluate(old, SHARES) @ (1, 1j)
    directions = joins.directions(subpath) @ (1, 1j)
    while joins.smooth.any() and len(curved):
        interruption.check()
        free = ~np.stack([joins.smooth[curved], joins.smooth[after]], axis=1)
        tangents = Tangents(directions[curved], directions[after], free)
        fitted, distances = fit_curves(runs, np.ones((len(runs), SAMPLES)), tangents, ROUNDS)
        changed = ~free.all(axis=1)
        far = (distances.max(axis=1) > tolerance) & changed
        tidy[curved[changed], 1:] = np.stack([fitted.real, fitted.imag], axis=-1)[changed]
        if not far.any():
            break
        turns = np.where(free, -1.0, joins.turns[np.stack([curved, after], axis=1)])[far]
        joins.smooth[np.where(turns[:, 0] > turns[:, 1], curved[far], after[far])] = False
        tidy = subpath.copy()
    joins.hold(tidy)
    return tidy


def _without_bends(subpath: FloatArray) -> FloatArray:
    """Remove the anchors between nearly collinear lines from a closed subpath."""
    while len(subpath) > 2:
        interruption.check()
        lines = _joins_of(subpath).lines
        before, after = cyclic.preceding(subpath[:, 0]), cyclic.following(subpath[:, 0])
        chord, rest = after - before, subpath[:, 0] - before
        length = np.maximum(np.hypot(*chord.T), 1e-12)
        share = (chord * rest).sum(axis=1) / length**2
        off = np.abs(bezier.cross(chord, rest)) / length
        off[~(lines & cyclic.preceding(lines) & (share > 0) & (share < 1))] = np.inf
        k = int(np.argmin(off))
        if off[k] > NEARLY.straight:
            break
        subpath = subpath.copy()
        subpath[k - 1, 1:] = before[k] + chord[k] * np.array([[1.0], [2.0]]) / 3
        subpath = np.delete(subpath, k, axis=0)
    return subpath


def _joins_of(subpath: FloatArray) -> Joins:
    count = len(subpath)
    return Joins(subpath, cyclic.following(np.arange(count)), np.ones(count, bool), NEARLY)
