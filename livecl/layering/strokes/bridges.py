# SPDX-License-Identifier: Apache-2.0
"""Join lines of one ink where another ink covers them: ends that face each other across what lies between."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.layering.strokes.lines import RULES, InkTrace, StrokeRules

FloatArray = NDArray[np.float64]

#: Cosine between the direction in which a line ends and that to the other end, at least.
FACING = 0.9
#: Share of the way between two ends that ink covers, at least.
COVERED = 0.7
#: Length of a line, in its widths and px, along which the direction of its end is measured.
REACH, LEAST_REACH = 2.0, 4.0
#: Length of a line, in its widths, that is left out at an end: what covers it cuts it off aslant.
CUT_OFF = 0.75
#: Distance of two ends in widths of the line and px more, within which they are looked at.
FAR, FAR_MORE = 4.0, 24.0


def bridged(traces: list[InkTrace], covered: FloatArray, rules: StrokeRules = RULES) -> list[InkTrace]:
    """Return traces of one ink, joined where their ends face each other beneath other inks.

    Inks cover a share `covered` (H, W) of each pixel; lines that may be one differ by `same_width` of the rules at
    most.
    """
    traces = list(traces)
    while True:
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
    """Return the points of a trace, one end first."""
    return trace.points if at == 0 else trace.points[::-1]


def _gap(first: FloatArray, second: FloatArray, width: float, covered: FloatArray) -> float | None:
    """Return the distance of two ends, each first of its points, that face each other; None where they do not."""
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
    """Return the unit direction in which a line leaves by its first point."""
    points = _cut_off(points, width)
    away = np.hypot(*(points - points[0]).T)
    reach = max(REACH * width, LEAST_REACH)
    at = int(np.argmax(away > reach)) or len(points) - 1
    step = points[0] - points[at]
    return np.asarray(step / max(float(np.hypot(*step)), 1e-9))


def _cut_off(points: FloatArray, width: float) -> FloatArray:
    """Return the points of a line without those near the first, if it is long enough."""
    away = np.hypot(*(points - points[0]).T)
    kept = points[int(np.argmax(away > CUT_OFF * width)) :]
    return kept if len(kept) > len(points) / 2 else points


def _joined_traces(first: InkTrace, second: InkTrace, one: int, other: int) -> InkTrace:
    """Return the line of two whose ends, by 0 and 1, are one place."""
    before = _cut_off(_from_end(first, one), first.width)[::-1]
    after = _cut_off(_from_end(second, other), second.width)
    points = np.concatenate([before, _between(before[-1], after[0]), after])
    return InkTrace(points, np.concatenate([first.radii, second.radii]), closed=False)


def _closed(trace: InkTrace) -> InkTrace:
    """Return a line that ends where it begins."""
    points = _cut_off(_cut_off(trace.points, trace.width)[::-1], trace.width)
    return InkTrace(np.concatenate([points, _between(points[-1], points[0])]), trace.radii, closed=True)


def _between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return points between two, about one a pixel."""
    count = int(np.hypot(*(end - start)))
    return np.asarray(start + np.linspace(0, 1, count + 2)[1:-1, None] * (end - start))
