# SPDX-License-Identifier: Apache-2.0
"""Bridge gaps in lines of one ink where another ink covers them, between ends that face each other."""

from __future__ import annotations

import itertools

import numpy as np
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.layering.strokes.lines import InkTrace
from livecl.layering.strokes.rules import RULES, StrokeRules

#: Cosine of the largest angle between the direction of a line's end and the way to the other end.
FACING = 0.9
#: Least share of the gap between two ends that ink covers.
COVERED = 0.7
#: Length of a line, in its widths, but at least `LEAST_REACH` px, along which the direction of its end is measured.
REACH, LEAST_REACH = 2.0, 4.0
#: Length of a line, in its widths, ignored at an end: the covering ink cuts it off at a slant.
CUT_OFF = 0.75
#: Largest gap: widths of the line, plus px.
FAR, FAR_MORE = 4.0, 24.0


def bridged(traces: list[InkTrace], covered: FloatArray, rules: StrokeRules = RULES) -> list[InkTrace]:
    """Bridge gaps between traces of one ink whose ends face each other beneath other inks.

    Inks cover a share `covered` (H, W) of each pixel; widths of joined lines differ by a factor of at most
    `same_width`.
    """
    traces = list(traces)
    while True:
        interruption.check()
        ends = [(index, at) for index, trace in enumerate(traces) if not trace.closed for at in (0, 1)]
        gaps = []
        for (i, one), (j, other) in itertools.combinations(ends, 2):
            ratio = traces[i].width / traces[j].width
            if max(ratio, 1 / ratio) <= rules.same_width:
                gap = _gap(_from_end(traces[i], one), _from_end(traces[j], other), traces[i].width, covered)
                if gap is not None and (i != j or traces[i].length > 4 * gap):
                    gaps.append((gap, i, j, one, other))
        if not gaps:
            return traces
        _, i, j, one, other = min(gaps)
        joined = _joined_traces(traces[i], traces[j], one, other) if i != j else _closed(traces[i])
        traces = [trace for index, trace in enumerate(traces) if index not in (i, j)] + [joined]


def _from_end(trace: InkTrace, at: int) -> FloatArray:
    """Return the points of a trace, starting at one end."""
    return trace.points if at == 0 else trace.points[::-1]


def _gap(first: FloatArray, second: FloatArray, width: float, covered: FloatArray) -> float | None:
    """Return the distance of two ends, each first of its points, that face each other; None if they do not."""
    across = second[0] - first[0]
    distance = float(np.hypot(*across))
    if not 0 < distance <= FAR * width + FAR_MORE:
        return None
    across /= distance
    if _direction(first, width) @ across < FACING or _direction(second, width) @ across > -FACING:
        return None
    count = max(3, int(distance * 2))
    points = first[0] + np.linspace(0, distance, count)[:, None] * across
    hidden = ndimage.map_coordinates(covered, points.T[::-1] - 0.5, order=1, mode="nearest") > 0.5
    return distance if hidden.mean() >= COVERED else None


def _direction(points: FloatArray, width: float) -> FloatArray:
    """Return the unit tangent of a line at its first point, pointing outwards."""
    points = _cut_off(points, width)
    away = np.hypot(*(points - points[0]).T)
    reach = max(REACH * width, LEAST_REACH)
    at = int(np.argmax(away > reach)) or len(points) - 1
    step = points[0] - points[at]
    return np.asarray(step / max(float(np.hypot(*step)), 1e-9))


def _cut_off(points: FloatArray, width: float) -> FloatArray:
    """Return a line without its points near the first one, if it is long enough."""
    away = np.hypot(*(points - points[0]).T)
    kept = points[int(np.argmax(away > CUT_OFF * width)) :]
    return kept if len(kept) > len(points) / 2 else points


def _joined_traces(first: InkTrace, second: InkTrace, one: int, other: int) -> InkTrace:
    """Join two traces at given ends, 0 or 1."""
    before = _cut_off(_from_end(first, one), first.width)[::-1]
    after = _cut_off(_from_end(second, other), second.width)
    points = np.concatenate([before, _between(before[-1], after[0]), after])
    return InkTrace(points, np.concatenate([first.radii, second.radii]), closed=False)


def _closed(trace: InkTrace) -> InkTrace:
    """Close a trace by joining its own ends."""
    points = _cut_off(_cut_off(trace.points, trace.width)[::-1], trace.width)
    return InkTrace(np.concatenate([points, _between(points[-1], points[0])]), trace.radii, closed=True)


def _between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return points between two, about one per px."""
    count = int(np.hypot(*(end - start)))
    return np.asarray(start + np.linspace(0, 1, count + 2)[1:-1, None] * (end - start))
