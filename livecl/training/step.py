# SPDX-License-Identifier: Apache-2.0
"""One step of training: Adam on points, colours and widths, holding of locked layers, untangling, piece counts."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import signed_area
from livecl.geometry.untangle import untangle
from livecl.options import OPAQUE_FROM
from livecl.rendering.rasterizer import Gradients, Rasterizer
from livecl.training.adam import decayed, settling
from livecl.training.borders import Borders
from livecl.training.fills import hold_fills
from livecl.training.state import State
from livecl.training.ties import Ties

#: Steps between two updates of the numbers of lines of the segments.
PIECES_PERIOD = 10
#: Steps between two searches for outlines that cross themselves.
UNTANGLE_PERIOD = 25
#: Largest area of a loop, px^2, that is cut without comparing errors. Larger ones wait for the last step of a phase:
#: what they show changes until then.
SMALL_LOOP = 3.0
#: Least width of a trained stroke, px: a line of a tenth of its colour, which still has a gradient.
MIN_WIDTH = 0.1
#: Steps in which the learning rate decays by `Options.decay`.
DECAY_PERIOD = 500


def choose_pieces(state: State, rasterizer: Rasterizer) -> None:
    """Flatten finer where a segment has grown, and coarser where it has shrunk to a quarter."""
    needed = rasterizer.pieces(state.drawing)
    held = state.pieces
    if np.any(needed > held) or np.any(2 * needed < held):
        state.pieces = needed


def hold_still(state: State, gradients: Gradients) -> None:
    """Clear the gradients of fixed parameters, so that their moments stay 0: locked layers, hidden points, palettes."""
    if state.hidden is not None and len(state.hidden) == len(gradients.points):
        gradients.points[state.hidden] = 0
    if state.keeps_colors:
        gradients.colors[:, :3] = 0
    if state.locked.any():
        gradients.points[state.locked_segments] = 0
        gradients.colors[state.locked] = 0
        if gradients.widths is not None:
            gradients.widths[state.locked] = 0
        if gradients.fills is not None:
            hold_fills(state.drawing.fills, gradients.fills, state.locked)


def move(state: State, gradients: Gradients) -> None:
    """Take a step of Adam; colours stay within [0, 1]. On a small canvas, points take small steps."""
    options, drawing = state.options, state.drawing
    settled = settling(state.iteration / state.length, options.settle)

    def rate(base: float, ages: NDArray[np.int64]) -> ArrayLike:
        return base * settled * (1 if options.decay == 1 else decayed(ages, options.decay, DECAY_PERIOD))

    point_rate = options.learning_rate * min(1.0, max(drawing.size) / max(options.full_rate_side, 1.0))
    borders = Borders.of(drawing, state.locked)
    borders.gather(gradients.points)
    ties = Ties.of(drawing) if options.placement == "structure" else None
    if ties is not None:
        ties.gather(gradients.points)
    points = drawing.points + state.points.step(gradients.points, rate(point_rate, state.points.ages))
    if ties is not None:
        ties.restore(points)
    borders.restore(points)
    points[state.locked_segments] = drawing.points[state.locked_segments]  # undoes the rounding of ties
    color_rate = rate(options.color_learning_rate, state.colors.ages)
    colors = np.clip(drawing.colors + state.colors.step(gradients.colors, color_rate), 0, 1)
    if options.opacity == "opaque":
        colors[:, 3] = drawing.colors[:, 3]
    elif options.opacity == "snap" and 2 * state.iteration >= state.length:
        colors[(colors[:, 3] > OPAQUE_FROM) & ~state.locked, 3] = 1
    fills = None
    if gradients.fills is not None:
        fills = state.fills.step(
            drawing.fills,
            gradients.fills,
            functools.partial(rate, point_rate),
            functools.partial(rate, options.color_learning_rate),
        )
        _hold_opacities(state, fills.stop_colors)
    strokes = None
    if gradients.widths is not None:
        change = state.widths.step(gradients.widths[:, None], rate(point_rate, state.widths.ages))[:, 0]
        widths = np.maximum(drawing.strokes.widths + change, MIN_WIDTH)
        strokes = drawing.strokes.moved(np.where(drawing.strokes.widths > 0, widths, 0))
    background = drawing.background
    if options.background == "train" and background is not None and gradients.background is not None:
        change = state.background.step(gradients.background[None], options.color_learning_rate)
        background = np.clip(background + change[0], 0, 1)
    state.drawing = drawing.moved(points, colors, background, fills, strokes)


def _hold_opacities(state: State, stop_colors: NDArray[np.float64]) -> None:
    """Snap or hold the opacities of stops, as those of solid layers."""
    options, fills = state.options, state.drawing.fills
    if options.opacity == "opaque":
        stop_colors[:, 3] = fills.stop_colors[:, 3]
    elif options.opacity == "snap" and 2 * state.iteration >= state.length:
        stop_colors[(stop_colors[:, 3] > OPAQUE_FROM) & ~state.locked[fills.stop_layers], 3] = 1


def untangles_now(state: State) -> bool:
    """Whether to untangle: periodically in the second half of a stage, when paths have settled, and at its end."""
    iteration, length = state.iteration, state.length
    return iteration == length or (2 * iteration > length and iteration % UNTANGLE_PERIOD == 0)


def untangle_outlines(state: State, error: Callable[[Drawing], float] | None = None) -> None:
    """Cut the loops out of all filled outlines that are not locked; Adam starts anew for changed segments.

    A loop of more than `SMALL_LOOP` px^2 is kept if the `error` of the drawing would rise by more than `Options.prune`
    without it: it shows something, as beyond a neck whose two sides cross. Without an `error`, outlines with such loops
    are not changed.
    """
    drawing = state.drawing
    points, cubics = drawing.points.copy(), drawing.cubics
    free = ~state.locked_segments & (drawing.strokes.widths[drawing.segment_layers] == 0)
    free[Borders.of(drawing, state.locked).fills] = False
    runs = [subpath for subpath in drawing.subpaths() if free[subpath.start]]
    outlines = [cubics[run] for run in runs]
    large, all_cut = [], points.copy()
    untangled = untangle(outlines, SMALL_LOOP if error is None else np.inf)
    for run, before, outline in zip(runs, outlines, untangled, strict=True):
        if outline is before:
            continue
        all_cut[run] = outline[:, :3]
        if error is not None and abs(signed_area(outline) - signed_area(before)) > SMALL_LOOP:
            large.append(run)
        else:
            points[run] = outline[:, :3]
    if large and error is not None:
        points = _cut_where_nothing_shows(state, error, large, points, all_cut)
    moved = (points != drawing.points).any(axis=(1, 2))
    if moved.any():
        state.points.forget(moved)
        state.drawing = drawing.moved(points, drawing.colors, drawing.background)


def _cut_where_nothing_shows(
    state: State,
    error: Callable[[Drawing], float],
    large: list[slice],
    points: NDArray[np.float64],
    all_cut: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the points with the `large` loops cut, as in `all_cut`: all if the error allows, else one by one."""
    drawing, most = state.drawing, state.options.prune

    def error_of(moved: NDArray[np.float64]) -> float:
        return error(drawing.moved(moved, drawing.colors, drawing.background))

    if error_of(all_cut) - (before := error_of(points)) <= most:
        return all_cut
    for run in large:
        cut = points.copy()
        cut[run] = all_cut[run]
        after = error_of(cut)
        if after - before <= most:
            points, before = cut, after
    return points
