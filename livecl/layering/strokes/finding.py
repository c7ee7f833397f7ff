# SPDX-License-Identifier: Apache-2.0
"""Find strokes: lines of ink on paper as layers with centre lines, a width, caps and joins."""

from __future__ import annotations

import functools
import itertools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.assembly import concatenate, empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.drawing.strokes import Strokes
from livecl.geometry.strokes import BUTT, MITER, ROUND
from livecl.layering.context import Context
from livecl.layering.segmentation.paper import paper_of, without_shading
from livecl.layering.strokes.bridges import bridged
from livecl.layering.strokes.ends import REACH, lengthened, with_flat_ends
from livecl.layering.strokes.fitting import fitted_to_ink
from livecl.layering.strokes.inks import INKS, inks_of
from livecl.layering.strokes.lines import Line, find_traces, fitted_line
from livecl.layering.strokes.rules import RULES, StrokeRules

#: Coverage from which ink counts when strokes are evaluated.
FAINT = 0.1
#: Margin, px, of the paper's layer around the canvas.
SHEET_MARGIN = 2.0


class LineArt(NamedTuple):
    """Strokes found in a picture.

    Attributes
    ----------
    strokes : Drawing
        The strokes, bottom first.
    explained : float
        Overlap (IoU) of the strokes with the ink.
    paper : Drawing
        The paper as a layer that covers the canvas; no layers if it is even and of the background's colour.
    """

    strokes: Drawing
    explained: float
    paper: Drawing


def kept_strokes(context: Context, found: LineArt, rules: StrokeRules = RULES) -> Drawing:
    """Return the strokes of a picture that is line art, or of which strokes alone are wanted; else no layers."""
    whole = context.options.strokes == "only" or found.explained >= rules.explained
    return found.strokes if whole else empty_drawing(found.strokes.size, found.strokes.background)


def find_line_art(context: Context, background: NDArray[Any] | None, rules: StrokeRules = RULES) -> LineArt:
    """Find the strokes of a picture, and how much of its ink they explain."""
    target = np.asarray(context.target, dtype=np.float64)
    size = (target.shape[0], target.shape[1])
    nothing = empty_drawing(size, background)
    paper = paper_of(target)
    ground = np.zeros(target.shape[2]) if background is None else np.asarray(background, dtype=np.float64)
    if np.abs(paper - ground).max() > INKS.contrast:  # inks would be measured against another ground
        return LineArt(nothing, 0.0, nothing)
    even = without_shading(target, paper)
    inks = inks_of(even, paper)
    all_lines = []
    covered = np.max([np.zeros(size), *(ink.coverage for ink in inks)], axis=0)
    for ink in inks:
        interruption.check()
        traces, spots = find_traces(ink.coverage, rules)
        if len(inks) > 1:
            traces = bridged(traces, covered, rules)
        all_lines.append([fitted_line(trace, ink.coverage, rules) for trace in traces] + spots)
    most_wide = most_dot = np.inf
    if context.options.strokes != "only":
        most_wide = rules.widest * min(size)
        widths = [line.width for lines in all_lines for line in lines if not line.is_spot and line.width <= most_wide]
        most_dot = rules.dot * max(widths, default=0.0)
    layers, right, either = [], 0.0, 0.0
    for ink, some in zip(inks, all_lines, strict=True):
        lines = [line for line in some if line.width <= (most_dot if line.is_spot else most_wide)]
        groups = _groups(lines, rules)
        if not groups:
            either += float(ink.coverage[ink.coverage > FAINT].sum())
            continue
        strengths = np.array([_strength(group) for group in groups])
        pens = [
            best_pen(
                context, group, _straight_rgba(paper + strength * (ink.color - paper)), ink.coverage / strength, nothing
            )
            for group, strength in zip(groups, strengths, strict=True)
        ]
        seen = 1 - np.max([np.zeros(size), *(other.coverage for other in inks if other is not ink)], axis=0)
        own = fitted_to_ink(context.rasterizer, functools.reduce(concatenate, pens), ink.coverage, strengths, seen)
        layers.append(own)
        drawn = np.max(strengths[:, None, None] * context.rasterizer.coverages(own), axis=0)
        right += float(np.minimum(drawn, ink.coverage)[ink.coverage > FAINT].sum())
        either += float(np.maximum(drawn, ink.coverage)[(ink.coverage > FAINT) | (drawn > FAINT)].sum())
    differs = even is not target or bool(np.abs(paper - ground).max() > rules.paper)
    sheet = _sheet(paper, nothing) if differs else nothing
    if not layers:
        return LineArt(nothing, 0.0, sheet)
    found = functools.reduce(concatenate, layers)
    order = _paint_order(context.rasterizer.coverages(found), found.colors, target)
    return LineArt(found.layer_subset(order), right / max(either, 1e-9), sheet)


def _sheet(color: FloatArray, canvas: Drawing) -> Drawing:
    """Return a layer of the paper's colour that covers the canvas, and more, so that no pixel moves its outline."""
    (height, width), beyond = canvas.size, SHEET_MARGIN
    x, y = np.array([-beyond, width + beyond]), np.array([-beyond, height + beyond])
    corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    steps = np.roll(corners, -1, axis=0) - corners
    rows = np.stack([corners, corners + steps / 3, corners + 2 * steps / 3], axis=1)
    return Drawing.from_outlines([[rows]], _straight_rgba(color), canvas.size, canvas.background)


def _strength(lines: list[Line]) -> float:
    """Return the mean coverage of ink in the middle of lines, weighted by length."""
    return float(np.average([line.strength for line in lines], weights=[line.length + line.width for line in lines]))


def _straight_rgba(color: FloatArray) -> FloatArray:
    """Convert a pixel's colour, RGB or premultiplied RGBA, to straight RGBA."""
    if len(color) == 3:
        return np.append(np.clip(color, 0, 1), 1.0)
    return np.clip(np.append(color[:3] / max(float(color[3]), 1e-6), color[3]), 0, 1)


def _paint_order(coverages: NDArray[Any], colors: FloatArray, target: FloatArray) -> list[int]:
    """Return the paint order of layers, bottom first, from the colours where they overlap.

    The evidence for one layer above another is by how much the pixels covered by both are nearer to its colour. The
    next layer is always the one with least evidence against it.
    """
    count = len(coverages)
    errors = [np.square(target[..., :3] - color[:3]).sum(axis=2) for color in colors]
    above = np.zeros((count, count))
    for i, j in itertools.combinations(range(count), 2):
        interruption.check()
        shared = np.minimum(coverages[i], coverages[j])
        evidence = float((shared * (errors[j] - errors[i])).sum())
        above[i, j], above[j, i] = max(evidence, 0.0), max(-evidence, 0.0)
    order: list[int] = []
    while len(order) < count:
        left = [index for index in range(count) if index not in order]
        order.append(min(left, key=lambda index: above[index, left].sum()))
    return order


def _groups(lines: list[Line], rules: StrokeRules) -> list[list[Line]]:
    """Group lines of one width and strength, the widest first.

    Long lines, whose width is known well, join a group if the widths differ by a factor of less than `one_width`; short
    ones join the nearest group within `same_width`.
    """
    groups: list[list[Line]] = []
    for line in sorted(lines, key=lambda line: -line.length / max(line.width, 1e-6)):
        slack = rules.one_width if line.length > rules.long * line.width else rules.same_width
        ratios = [abs(np.log(group[0].width / line.width)) for group in groups]
        shades = [abs(np.log(group[0].strength / line.strength)) for group in groups]
        near = [
            (ratio, index)
            for index, (ratio, shade) in enumerate(zip(ratios, shades, strict=True))
            if ratio <= np.log(slack) and (shade <= np.log(rules.same_shade) or line.is_spot)
        ]
        if near:
            groups[min(near)[1]].append(line)
        else:
            groups.append([line])
    return sorted(groups, key=lambda group: -group[0].width)


def best_pen(context: Context, lines: list[Line], color: FloatArray, coverage: FloatArray, canvas: Drawing) -> Drawing:
    """Return lines as a layer, with the caps and joins that match the ink best."""
    width = float(np.average([line.width for line in lines], weights=[line.length + line.width for line in lines]))
    is_open = np.array([not line.closed for line in lines])
    flat = with_flat_ends([line.points for line in lines], is_open, width, coverage)
    options = []
    for cap, join in ((ROUND, ROUND), (BUTT, MITER), (ROUND, MITER)):
        interruption.check()
        layer = Drawing.from_outlines(
            [lengthened(flat, is_open, width, -width * REACH[cap])],
            color,
            canvas.size,
            canvas.background,
            strokes=Strokes(widths=[width], caps=cap, joins=join, is_open=is_open),
        )
        cover = context.rasterizer.coverages(layer)[0].astype(np.float64)
        options.append((float(np.square(cover - coverage).sum()), layer))
    return min(options, key=lambda option: option[0])[1]
