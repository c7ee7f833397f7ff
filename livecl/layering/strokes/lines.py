# SPDX-License-Identifier: Apache-2.0
"""Find the lines of an ink: trace its centre lines, of even width, and fit paths to them."""

from __future__ import annotations

import dataclasses
import functools
import itertools

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.geometry.ellipses import ellipse_through
from livecl.geometry.open_fitting import MIN_TURN, fit_line
from livecl.geometry.skeleton import CenterLine, center_lines
from livecl.layering.strokes.rules import RULES, StrokeRules
from livecl.layering.strokes.thick import thick_parts


@dataclasses.dataclass(frozen=True)
class Line:
    """A line of ink.

    Attributes
    ----------
    points : (s, 3, 2) float64
        Rows of its path; the last row of an open line is its end.
    closed : bool
        Whether the line is closed.
    width, length : float
        Width of the ink, and length along the path, px.
    ends : pair of (2,) float64
        Outward directions of the two ends.
    is_spot : bool
        Whether it is a dot, or hardly longer than wide.
    strength : float
        Coverage in the middle of the line: below 1 if it is paler than the ink.
    """

    points: FloatArray
    closed: bool
    width: float
    length: float
    ends: tuple[FloatArray, FloatArray]
    is_spot: bool = False
    strength: float = 1.0


@dataclasses.dataclass(frozen=True)
class InkTrace:
    """Centre line of ink: points (n, 2), px, their distances to the border, px, and whether it is closed."""

    points: FloatArray
    radii: FloatArray
    closed: bool

    @property
    def width(self) -> float:
        """Median width, px."""
        return 2 * float(np.median(self.radii))

    @property
    def length(self) -> float:
        """Arc length, px."""
        steps = np.diff(self.points, axis=0, append=self.points[:1] if self.closed else self.points[-1:])
        return float(np.hypot(*steps.T).sum())


def find_lines(coverage: FloatArray, rules: StrokeRules = RULES) -> list[Line]:
    """Find the lines of one ink from its coverage (H, W); shapes of uneven width are not lines."""
    traces, spots = find_traces(coverage, rules)
    return [fitted_line(trace, coverage, rules) for trace in traces] + spots


def find_traces(coverage: FloatArray, rules: StrokeRules = RULES) -> tuple[list[InkTrace], list[Line]]:
    """Find the centre lines of one ink from its coverage (H, W), the longest first, and its dots."""
    interruption.check()
    smooth = ndimage.gaussian_filter(coverage, rules.blur, mode="constant")  # no ink lies beyond the border
    half = np.maximum(ndimage.maximum_filter(smooth, 2 * rules.near + 1) / 2, rules.faint)
    finer = functools.partial(ndimage.zoom, zoom=rules.oversampling, order=1, grid_mode=True, mode="nearest")
    fine, border = (interruption.apart(functools.partial(finer, values)) for values in (smooth, half))
    shapes, num_shapes = ndimage.label(fine > border, np.ones((3, 3)))
    interruption.check()
    kept: list[CenterLine] = []
    usual = np.zeros(num_shapes + 1)  # half width of each shape's longest line
    for line in center_lines(fine > border):
        interruption.check()
        for part in _even_parts(_without_tails(line, rules), rules):
            column, row = part.points[len(part.points) // 2].astype(int)
            shape, radius = shapes[row, column], float(np.median(part.radii))
            uneven = float(np.std(part.radii[1:-1])) if len(part.radii) > 4 else 0.0
            slenderness = rules.branch if usual[shape] else rules.slenderness
            if part.length >= slenderness * 2 * radius and uneven <= rules.evenness * radius and len(part.points) > 1:
                usual[shape] = usual[shape] or radius
                kept.append(part)
    traces = [
        InkTrace(_smoothed(part, rules) / rules.oversampling, part.radii / rules.oversampling, part.closed)
        for part in kept
    ]
    interruption.check()
    boxes = ndimage.find_objects(shapes)
    interruption.check()
    blobs = [(shapes[box] == number, box) for number, box in enumerate(boxes, 1) if not usual[number]]
    spots = [
        _spot(blob, box, rules)
        for blob, box in [*blobs, *thick_parts(shapes, usual, kept, (rules.thick, rules.same_width, rules.drawn))]
    ]
    return [trace for trace in traces if len(trace.points) > 1], [spot for spot in spots if spot is not None]


def fitted_line(trace: InkTrace, coverage: FloatArray, rules: StrokeRules = RULES) -> Line:
    """Fit a path of the fewest segments to a trace of an ink with the given coverage (H, W)."""
    points, radius = trace.points, trace.width / 2
    if trace.closed:
        points = np.roll(points, -_straightest(points, 2.5 * radius), axis=0)
    oval = _oval(points, rules) if trace.closed else None
    rows = oval
    if rows is None:
        is_sharp = functools.partial(_is_sharp, coverage, radius, rules)
        rows = fit_line(points, rules.distance, max(2.0, 2.5 * radius), trace.closed, is_sharp)
    steps = points[0] - points[min(3, len(points) - 1)], points[-1] - points[-min(4, len(points))]
    ends = tuple(step / max(float(np.hypot(*step)), 1e-9) for step in steps)
    width, strength = _measured(points, radius, coverage, rules)
    if not 2 * radius / rules.trusted < width < 2 * radius * rules.trusted:
        width = 2 * radius
    return Line(rows, trace.closed, width, trace.length, (ends[0], ends[1]), strength=strength)


def _without_tails(line: CenterLine, rules: StrokeRules) -> CenterLine:
    """Cut the ends of a line that lead from its middle into a corner of its border; ends are measured on the ink."""
    inner = np.flatnonzero(line.radii >= rules.tail * np.median(line.radii))
    if line.closed or not len(inner):
        return line
    return CenterLine(line.points[inner[0] : inner[-1] + 1], line.radii[inner[0] : inner[-1] + 1], closed=False)


def _even_parts(line: CenterLine, rules: StrokeRules) -> list[CenterLine]:
    """Split a line where its width changes.

    A part is wider or narrower than the median, by more than the ratio of equal widths and by a pixel, and long enough
    to be a line by itself. A shorter wide part is bridged straight, beneath a dot or another line.
    """
    usual = float(np.median(line.radii))
    slack = rules.oversampling / 2
    wide = line.radii > max(rules.same_width * usual, usual + slack)
    level = np.where(wide, 1, np.where(line.radii < min(usual / rules.same_width, usual - slack), -1, 0))
    changes = np.flatnonzero(np.diff(level)) + 1
    if not len(changes):
        return [line]
    shift = int(changes[0]) if line.closed else 0
    points, radii, level = (np.roll(values, -shift, axis=0) for values in (line.points, line.radii, level))
    changes = np.flatnonzero(np.diff(level)) + 1
    runs = [(int(first), int(last)) for first, last in itertools.pairwise([0, *changes, len(level)]) if level[first]]
    least = {1: rules.slenderness, -1: rules.branch}
    long = [run for run in runs if run[1] - run[0] > 2 * least[level[run[0]]] * float(np.max(radii[slice(*run)]))]
    kept = np.ones(len(level), bool)
    for first, last in runs:
        if (first, last) not in long and level[first] > 0 and (line.closed or (first > 0 and last < len(level))):
            kept[first:last] = False
    places = sorted({0, len(level), *(place for run in long for place in run)})
    parts = [
        CenterLine(points[first:last][kept[first:last]], radii[first:last][kept[first:last]], line.closed and not long)
        for first, last in itertools.pairwise(places)
        if kept[first:last].sum() > 2
    ]
    return [even for part in parts for even in _even_parts(part, rules)] if len(parts) > 1 else parts


def _measured(points: FloatArray, radius: float, coverage: FloatArray, rules: StrokeRules) -> tuple[float, float]:
    """Return the width of a line, px, and its strength, the coverage in its middle, from coverage profiles across it.

    The width is the integral of the profile over the strength, a median along the line because other lines cross it.
    """
    steps = np.gradient(points, axis=0)
    normals = np.stack([-steps[:, 1], steps[:, 0]], axis=1) / np.maximum(np.hypot(*steps.T), 1e-9)[:, None]
    offsets = np.arange(-(radius + rules.margin), radius + rules.margin + 1e-9, rules.step)
    places = points[:, None] + offsets[:, None] * normals[:, None]
    across = ndimage.map_coordinates(coverage, places.reshape(-1, 2).T[::-1] - 0.5, order=1, mode="nearest")
    most = ndimage.map_coordinates(ndimage.maximum_filter(coverage, 3), points.T[::-1] - 0.5, order=0, mode="nearest")
    strength = max(float(np.quantile(most, rules.middle)), 1e-3)
    if strength > rules.full:
        strength = 1.0
    width = float(np.median(across.reshape(len(points), -1).sum(axis=1))) * rules.step / strength
    return width, strength


def _is_sharp(
    coverage: FloatArray, radius: float, rules: StrokeRules, tip: FloatArray, outwards: FloatArray, half: float
) -> bool:
    """Whether a line has a corner: its ink reaches as far beyond the tip as a pen that goes to the tip draws.

    Beyond the tip of a corner, a pen of radius r draws as far as r or, with a miter, farther. If it follows an arc of
    radius R, it draws as far as r - R (1 / c - 1), c the cosine of half the turn.
    """
    reach = radius * (1 - rules.rounding * (1 / max(half, 0.1) - 1)) - rules.distance
    places = tip + np.linspace(0, 1, 9)[:, None] * (max(reach, 0.0) * outwards)
    ink = ndimage.map_coordinates(coverage, places.T[::-1] - 0.5, order=1, mode="nearest")
    return bool(ink[-1] > ink.max() / 2 and ink[-1] > rules.faint / 2)


def _straightest(points: FloatArray, reach: float) -> int:
    """Return the middle of the longest part without bends of a closed line: a start far from corners.

    At a bend, the line turns by `MIN_TURN` within the reach, px.
    """
    step = float(np.hypot(*np.diff(points, axis=0, append=points[:1]).T).mean())
    count = max(1, min(len(points) // 4, round(reach / max(step, 1e-9))))
    before, after = points - np.roll(points, count, axis=0), np.roll(points, -count, axis=0) - points
    bends = np.flatnonzero(np.abs(np.angle((after @ [1, 1j]) * np.conj(before @ [1, 1j]))) > MIN_TURN)
    if not len(bends):
        return 0
    gaps = np.diff(bends, append=bends[0] + len(points))
    longest = int(np.argmax(gaps))
    return int(bends[longest] + gaps[longest] // 2) % len(points)


def _oval(points: FloatArray, rules: StrokeRules) -> FloatArray | None:
    """Return the rows of the ellipse along most of a closed line, (4, 3, 2): junctions pull the rest aside."""
    for _ in range(2):
        oval = ellipse_through(points) if len(points) > 5 else None
        if oval is None:
            return None
        misses = np.abs(oval.distances(points))
        near = misses <= np.quantile(misses, rules.clear)
        if misses[near].max() <= rules.distance:
            return oval.cubics()[:, :3]
        points = points[near]
    return None


def _spot(mask: NDArray[np.bool_], box: tuple[slice, slice], rules: StrokeRules) -> Line | None:
    """Return a shape, given within its box, as a dot or a short line with round ends; None if it is neither.

    A line of length l and radius r has area pi r^2 + 2 l r, and its variance along exceeds that across by that of l:
    l^2 / 12 for the middle part, and nearly so with the ends.
    """
    interruption.check()
    places = np.argwhere(mask)[:, ::-1] + 0.5
    if len(places) < rules.oversampling**2:
        return None
    center = places.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov((places - center).T))
    radius = 2 * np.sqrt(max(float(spread[0]), 0.0))
    length = max(0.0, (len(places) - np.pi * radius**2) / (2 * radius)) if radius else 0.0
    if length < radius / 2:
        radius, length = np.sqrt(len(places) / np.pi), 0.0
    half = axes[:, 1] * length / 2
    offsets = np.moveaxis(np.indices(mask.shape)[::-1], 0, 2) + 0.5 - center
    along = np.clip(offsets @ axes[:, 1], -length / 2, length / 2)
    capsule = np.hypot(*np.moveaxis(offsets - along[..., None] * axes[:, 1], 2, 0)) <= radius
    if (mask & capsule).sum() < rules.roundness * (mask | capsule).sum():
        return None
    origin = np.array([box[1].start, box[0].start])
    start, end = ((origin + center + side * half) / rules.oversampling for side in (-1, 1))
    rows = np.stack([np.stack([start, start + (end - start) / 3, end - (end - start) / 3]), np.stack([end] * 3)])
    return Line(
        rows, False, 2 * radius / rules.oversampling, length / rules.oversampling, (-axes[:, 1], axes[:, 1]), True
    )


def _smoothed(line: CenterLine, rules: StrokeRules) -> FloatArray:
    """Smooth the pixel steps of a centre line, at even steps; its ends stay."""
    sigma = rules.oversampling * max(rules.blur, 0.5)
    mode = "wrap" if line.closed else "nearest"
    points = ndimage.gaussian_filter1d(line.points, sigma, axis=0, mode=mode)
    if not line.closed:
        fade = np.minimum(np.arange(len(points)), np.arange(len(points))[::-1])[:, None] / (2 * sigma)
        share = np.clip(fade, 0, 1)
        points = share * points + (1 - share) * line.points
    return np.asarray(points[:: max(1, rules.oversampling // 2)])
