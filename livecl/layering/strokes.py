# SPDX-License-Identifier: Apache-2.0
"""Find strokes: lines of ink on paper as centre lines with a width.

The paper is the most frequent colour; inks are the colours farthest from it. A pixel between paper and ink is covered
by ink by the share that its colour lies between them, which gives the border of a line to a fraction of a pixel.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing.assembly import concatenate, empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.drawing.strokes import Strokes
from livecl.geometry.ellipses import ellipse_through
from livecl.geometry.open_fitting import MIN_TURN, fit_line
from livecl.geometry.skeleton import CenterLine, center_lines
from livecl.geometry.strokes import BUTT, MITER, ROUND
from livecl.layering.context import Context

FloatArray = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class StrokeRules:
    """What counts as a stroke.

    Attributes
    ----------
    oversampling : int
        Points of a pixel, in each direction, at which the border of ink is looked for.
    blur : float
        Standard deviation, px, of the Gaussian that takes noise and the steps of pixels out of coverage and lines.
    contrast : float
        Distance in RGB from the paper that is ink at least; lines fainter than it are not seen.
    same_ink : float
        Distance in RGB of two inks that are one.
    slenderness, branch : float
        Lengths in widths from which on a line is a stroke: by itself, and as a part of a shape that has other lines.
    roundness : float
        Share of a spot and a dot, or a short line with round ends, that is in both: from it on they are the same.
    clear : float
        Share of a closed line that must lie on an ellipse which takes its place.
    widest : float
        Width of a line in widths of the picture (the shorter side), at most, with the option `strokes` auto.
    dot : float
        Diameter of a dot in widths of the widest line, at most, with the option `strokes` auto; larger ones are discs.
    evenness : float
        Largest share by which a line's width may vary (standard deviation over mean).
    same_width : float
        Largest ratio of two widths that are one.
    distance : float
        Largest distance, px, between the middle of ink and a fitted line.
    explained : float
        Share of the ink that strokes must explain for a picture to be line art, with the option `strokes` auto.
    """

    oversampling: int = 3
    blur: float = 0.5
    contrast: float = 0.2
    same_ink: float = 0.25
    slenderness: float = 2.5
    branch: float = 1.0
    roundness: float = 0.85
    clear: float = 0.85
    widest: float = 0.1
    dot: float = 2.5
    evenness: float = 0.3
    same_width: float = 1.3
    distance: float = 0.35
    explained: float = 0.8


RULES = StrokeRules()


@dataclasses.dataclass(frozen=True)
class Line:
    """A line of ink.

    Attributes
    ----------
    points : (s, 3, 2) float64
        Rows of its path; the last one of an open line is its end.
    closed : bool
        Whether its end is its beginning.
    width, length : float
        Of the ink and along the path, px.
    ends : pair of (2,) float64
        Directions in which the ends leave the line.
    is_spot : bool
        Whether it is a dot, or hardly longer than wide.
    """

    points: FloatArray
    closed: bool
    width: float
    length: float
    ends: tuple[FloatArray, FloatArray]
    is_spot: bool = False


def find_strokes(context: Context, background: NDArray[Any] | None, rules: StrokeRules = RULES) -> Drawing:
    """Return the strokes of a picture of line art as layers; none where it is something else.

    Parameters
    ----------
    context : Context
        Picture, rasterizer and options.
    background : (3,) array or None
        Ground of the drawing.
    rules : StrokeRules
        What counts as a stroke.

    Returns
    -------
    Drawing
        A layer for each ink and width that meet, the longest lines first.
    """
    target = np.asarray(context.target, dtype=np.float64)
    size = (target.shape[0], target.shape[1])
    nothing = empty_drawing(size, background)
    paper = _paper(target)
    ground = np.zeros(target.shape[2]) if background is None else np.asarray(background, dtype=np.float64)
    if np.abs(paper - ground).max() > rules.contrast:  # the paper would need a layer of its own
        return nothing
    found, total, explained = nothing, 0.0, 0.0
    inks = _inks(target, paper, rules)
    all_lines = []
    for _, coverage in inks:
        context.check()
        all_lines.append(lines_of(coverage, rules))
    most_wide = most_dot = np.inf
    if context.options.strokes != "only":
        most_wide = rules.widest * min(size)
        widths = [line.width for lines in all_lines for line in lines if not line.is_spot and line.width <= most_wide]
        most_dot = rules.dot * max(widths, default=0.0)
    for (ink, coverage), some in zip(inks, all_lines, strict=True):
        lines = [line for line in some if line.width <= (most_dot if line.is_spot else most_wide)]
        total += float(coverage[coverage > 0.1].sum())
        color = np.append(ink, 1.0) if len(ink) == 3 else np.append(ink[:3] / max(float(ink[3]), 1e-6), ink[3])
        for group in _groups(lines, rules):
            layer, cover = best_pen(context, group, np.clip(color, 0, 1), coverage, nothing)
            found = concatenate(found, layer)
            explained += float(np.minimum(cover, coverage).sum())
    wanted = 0.0 if context.options.strokes == "only" else rules.explained
    return found if total > 0 and explained >= wanted * total else nothing


def _paper(target: FloatArray) -> FloatArray:
    """Return the most frequent colour: the median of the pixels in the fullest cell of a grid of colours."""
    pixels = target.reshape(-1, target.shape[2])
    cells = np.floor(np.clip(pixels, 0, 1) * 15.999).astype(np.int64) @ 16 ** np.arange(pixels.shape[1])
    values, counts = np.unique(cells, return_counts=True)
    return np.asarray(np.median(pixels[cells == values[np.argmax(counts)]], axis=0))


def _inks(target: FloatArray, paper: FloatArray, rules: StrokeRules) -> list[tuple[FloatArray, FloatArray]]:
    """Return each ink's colour and coverage (H, W)."""
    smooth = ndimage.gaussian_filter(target, (rules.blur, rules.blur, 0))
    away = np.linalg.norm(smooth - paper, axis=2)
    peaks = (away >= ndimage.maximum_filter(away, 3)) & (away > rules.contrast)
    colors = target[peaks]
    inks: list[FloatArray] = []
    for color in colors[np.argsort(-away[peaks], kind="stable")]:
        if not any(_between(color, paper, ink) < rules.same_ink for ink in inks):
            near = np.linalg.norm(colors - color, axis=1) < rules.same_ink
            if near.sum() >= max(4, 0.01 * len(colors)):
                inks.append(np.median(colors[near], axis=0))
    if not inks:
        return []
    shares = np.stack(
        [np.clip((target - paper) @ (ink - paper) / ((ink - paper) @ (ink - paper)), 0, 1) for ink in inks]
    )
    misses = np.stack(
        [
            np.linalg.norm(target - paper - share[..., None] * (ink - paper), axis=2)
            for ink, share in zip(inks, shares, strict=True)
        ]
    )
    nearest = np.argmin(misses, axis=0)
    return [(ink, np.where(nearest == index, shares[index], 0.0)) for index, ink in enumerate(inks)]


def _between(color: FloatArray, paper: FloatArray, ink: FloatArray) -> float:
    """Return the distance of a colour from the line between paper and ink."""
    along = ink - paper
    share = np.clip((color - paper) @ along / (along @ along), 0, 1)
    return float(np.linalg.norm(color - paper - share * along))


def lines_of(coverage: FloatArray, rules: StrokeRules) -> list[Line]:
    """Return the lines of one ink, without uneven shapes."""
    smooth = ndimage.gaussian_filter(coverage, rules.blur)
    fine = ndimage.zoom(smooth, rules.oversampling, order=1, grid_mode=True, mode="nearest") > 0.5
    shapes, num_shapes = ndimage.label(fine, np.ones((3, 3)))
    lines, drawn = [], np.zeros(num_shapes + 1, bool)  # shapes with a line: the longest come first
    for line in center_lines(fine):
        column, row = line.points[len(line.points) // 2].astype(int)
        radius = float(np.median(line.radii)) / rules.oversampling
        uneven = float(np.std(line.radii[1:-1])) if len(line.radii) > 4 else 0.0
        length = line.length / rules.oversampling
        slenderness = rules.branch if drawn[shapes[row, column]] else rules.slenderness
        if length < slenderness * 2 * radius or uneven > rules.evenness * radius * rules.oversampling:
            continue
        points = _smoothed(line, rules) / rules.oversampling
        if len(points) < 2:
            continue
        if line.closed:
            points = np.roll(points, -_straightest(points, 2.5 * radius), axis=0)
        drawn[shapes[row, column]] = True
        oval = _oval(points, rules) if line.closed else None
        rows = fit_line(points, rules.distance, max(2.0, 2.5 * radius), line.closed) if oval is None else oval
        steps = points[0] - points[min(3, len(points) - 1)], points[-1] - points[-min(4, len(points))]
        ends = tuple(step / max(float(np.hypot(*step)), 1e-9) for step in steps)
        lines.append(Line(rows, line.closed, 2 * radius, length, (ends[0], ends[1])))
    boxes = ndimage.find_objects(shapes)
    spots = [_spot(shapes[box] == number, box, rules) for number, box in enumerate(boxes, 1) if not drawn[number]]
    return lines + [spot for spot in spots if spot is not None]


def _straightest(points: FloatArray, reach: float) -> int:
    """Return the middle of the longest part of a closed line without a bend: a place to begin, far from corners.

    A bend is where the line turns by MIN_TURN within the reach, px.
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
    """Return the rows of the ellipse along most of a closed line, (4, 3, 2): junctions draw the rest aside."""
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
    """Return the dot, or the short line with round ends, that a shape is, given within its box; None where it is none.

    Of a line of length l and radius r, the area is pi r^2 + 2 l r, and the variance along it exceeds the one across by
    that of l: l^2 / 12 for the middle part, nearly so with the ends.
    """
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
    """Return the points of a centre line at even steps without the steps of pixels; its ends stay."""
    sigma = rules.oversampling * max(rules.blur, 0.5)
    mode = "wrap" if line.closed else "nearest"
    points = ndimage.gaussian_filter1d(line.points, sigma, axis=0, mode=mode)
    if not line.closed:
        fade = np.minimum(np.arange(len(points)), np.arange(len(points))[::-1])[:, None] / (2 * sigma)
        share = np.clip(fade, 0, 1)
        points = share * points + (1 - share) * line.points
    return np.asarray(points[:: max(1, rules.oversampling // 2)])


def _groups(lines: list[Line], rules: StrokeRules) -> list[list[Line]]:
    """Return lines of one width together, the widest first."""
    groups: list[list[Line]] = []
    for line in sorted(lines, key=lambda line: -line.width):
        if groups and groups[-1][0].width <= rules.same_width * line.width:
            groups[-1].append(line)
        else:
            groups.append([line])
    return groups


def best_pen(
    context: Context, lines: list[Line], color: FloatArray, coverage: FloatArray, canvas: Drawing
) -> tuple[Drawing, FloatArray]:
    """Return lines as a layer, with the caps and joins that cover the ink best, and what they cover (H, W)."""
    width = float(np.average([line.width for line in lines], weights=[line.length + line.width for line in lines]))
    options = []
    for cap, join in ((ROUND, ROUND), (BUTT, MITER), (ROUND, MITER)):
        rows = [_extended(line, width / 2 if cap == BUTT else 0.0) for line in lines]
        layer = Drawing.from_outlines(
            [rows],
            color,
            canvas.size,
            canvas.background,
            strokes=Strokes(
                widths=[width], caps=cap, joins=join, is_open=np.array([not line.closed for line in lines])
            ),
        )
        cover = context.rasterizer.coverages(layer)[0].astype(np.float64)
        options.append((float(np.square(cover - coverage).sum()), layer, cover))
    _, layer, cover = min(options, key=lambda option: option[0])
    return layer, cover


def _extended(line: Line, by: float) -> FloatArray:
    """Return a line's rows, its ends moved outwards."""
    if line.closed or not by:
        return line.points
    rows = line.points.copy()
    rows[0, 0] += by * line.ends[0]
    rows[-1] += by * line.ends[1]
    return rows
