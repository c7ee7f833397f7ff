# SPDX-License-Identifier: Apache-2.0
"""Figures of the method: signed area, gradients, the distance weight, stages with their outlines."""

from __future__ import annotations

import io
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import livecl
from figures.strip import save_small, shown
from livecl.arrays import FloatArray
from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.geometry import bezier
from livecl.views.sheet import fitted_size

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
#: Dots per inch of the figures.
DPI = 96
_OUTLINE, _HANDLE, _ARROW = "#c02020", "#606060", "#1040c0"


def save_figure(file: Path, figure: Figure) -> None:
    """Write a figure of matplotlib as a small PNG."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=DPI)
    save_small(file, Image.open(stream))


def deposits(lines: FloatArray, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Return the deposits of lines (L, 4) in the pixels that they cross: area dy (1 - u) and height dy, each (H, W)."""
    area, height = np.zeros(size), np.zeros(size)
    for x0, y0, x1, y1 in lines:
        cuts = [0.0, 1.0]
        for start, end in ((x0, x1), (y0, y1)):
            borders = np.arange(np.ceil(min(start, end)), np.floor(max(start, end)) + 1)
            cuts += [(border - start) / (end - start) for border in borders if start != end]
        for s0, s1 in pairwise(sorted(cuts)):
            middle = (s0 + s1) / 2
            x, y, dy = x0 + middle * (x1 - x0), y0 + middle * (y1 - y0), (s1 - s0) * (y1 - y0)
            row, column = int(np.floor(y)), int(np.floor(x))
            area[row, column] += dy * (1 - (x - column))
            height[row, column] += dy
    return area, height


def coverage(file: Path) -> None:
    """One path on a canvas of few pixels: the terms of its lines, their running sum to the right, the coverage."""
    height, width = size = 8, 11
    points = np.array(
        [
            [[2.3, 4.1], [2.5, 6.6], [4.2, 6.4]],
            [[5.4, 6.9], [8.6, 8.0], [10.6, 4.2]],
            [[8.4, 2.2], [6.2, 0.2], [2.0, 1.0]],
        ]
    )
    drawing = Drawing(points=points, colors=[[1, 1, 1, 1]], size=size, background=(0, 0, 0))
    pieces = bezier.pieces_for(drawing.cubics, 0.02)
    vertices = np.concatenate(
        [bezier.evaluate(cubic, np.linspace(0, 1, n + 1)[:-1]) for cubic, n in zip(drawing.cubics, pieces, strict=True)]
    )
    area, heights = deposits(np.concatenate([vertices, np.roll(vertices, -1, axis=0)], axis=1), size)
    total = np.cumsum(heights, axis=1) - heights + area
    rendered = livecl.render(drawing)[..., 0]
    if np.abs(np.minimum(np.abs(total), 1) - rendered).max() > 1e-5:
        raise ValueError("the figure's coverage is not the kernel's")
    figure = Figure(figsize=(12, 3.4), layout="constrained")
    panels = (
        (area, "area: dy (1 − u) of the lines inside"),
        (np.cumsum(heights, axis=1) - heights, "dy of the pixels to the left"),
        (total, "A, their sum; coverage = min(|A|, 1)"),
    )
    closed = np.concatenate([vertices, vertices[:1]])
    for axes, (values, title) in zip(figure.subplots(1, len(panels)), panels, strict=True):
        axes.imshow(values, cmap="RdBu_r", vmin=-1.6, vmax=1.6, extent=(0, width, height, 0))
        for (row, column), value in np.ndenumerate(values):
            if abs(value) >= 0.005:
                axes.text(column + 0.5, row + 0.55, f"{value:.2f}", ha="center", va="center", fontsize=7)
        axes.plot(*closed.T, color=_OUTLINE, linewidth=1.2)
        axes.set(xticks=np.arange(width + 1), yticks=np.arange(height + 1), xticklabels=[], yticklabels=[])
        axes.grid(visible=True, color="#c8c8c8", linewidth=0.5)
        axes.tick_params(length=0)
        axes.set_title(title, fontsize=9)
    save_figure(file, figure)


def _outlines(axes: Any, drawing: Drawing) -> None:
    """Draw outlines, anchors, and handles with their arms."""
    for subpath in drawing.subpaths():
        line = np.concatenate([bezier.evaluate(cubic, np.linspace(0, 1, 25)) for cubic in drawing.cubics[subpath]])
        axes.plot(*line.T, color=_OUTLINE, linewidth=1)
    for a, b, c, d in drawing.cubics:
        for arm in ((a, b), (c, d)):
            axes.plot(*np.transpose(arm), color=_HANDLE, linewidth=0.5)
    anchors, handles = drawing.points[:, 0], drawing.points[:, 1:].reshape(-1, 2)
    axes.plot(*handles.T, "o", color=_HANDLE, markersize=2)
    axes.plot(*anchors.T, "s", color=_OUTLINE, markersize=3)


def gradients(file: Path) -> None:
    """The descent at control points, the distance weight, and the place after 60 steps, of a circle on the face."""
    target = livecl.read_image(EXAMPLES / "face.png")
    options = livecl.Options.paper(iterations=1, radius=45.0)
    state = livecl.vectorize(target, paths=1, options=options).drawing
    rasterizer = livecl.Rasterizer(state.size)
    weight = rasterizer.distance_weight(state)
    pieces = rasterizer.pieces(state)
    _, found = rasterizer.loss_and_gradients(state, target, weight, pieces, 1 / 3)
    trained = livecl.vectorize(target, paths=1, options=livecl.Options.paper(iterations=60, radius=45.0)).drawing
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    left.imshow(rasterizer.forward(state), extent=(0, 240, 240, 0))
    _outlines(left, state)
    points, steps = state.points.reshape(-1, 2), -found.points.reshape(-1, 2)
    steps = 30 * steps / np.hypot(*steps.T).max()
    left.quiver(*points.T, *steps.T, angles="xy", scale_units="xy", scale=1, color=_ARROW, width=0.007, zorder=5)
    left.set_title("−dL/dpoints of a circle of 45 px", fontsize=9)
    middle.imshow(weight, extent=(0, 240, 240, 0), cmap="Greys")
    middle.set_title("its distance weight, eq. (1)", fontsize=9)
    right.imshow(target, extent=(0, 240, 240, 0))
    _outlines(right, trained)
    right.set_title("over the picture, after 60 steps", fontsize=9)
    for axes in (left, middle, right):
        axes.set(xticks=[], yticks=[], xlim=(0, 240), ylim=(240, 0))
    save_figure(file, figure)


def stages(file: Path) -> None:
    """The stages of the logo: pictures above, outlines of their layers below."""
    target = livecl.read_image(EXAMPLES / "logo.png")
    options = livecl.Options(iterations=100, opacity="opaque", holes=False, revisions=4)
    result = livecl.vectorize(target, schedule=(1, 1, 1, 1, 2), options=options)
    figure = Figure(figsize=(9.6, 4.1), layout="constrained")
    rows = figure.subplots(2, len(result.stages))
    for stage, above, below in zip(result.stages, *rows, strict=True):
        above.imshow(shown(stage.drawing, 180))
        above.set_title(f"{stage.paths} path{'s' * (stage.paths > 1)}, MSE {stage.mse:.1e}", fontsize=8)
        faint = 1 - 0.25 * (1 - shown(stage.drawing, 180))
        below.imshow(faint)
        _outlines(below, scaled(stage.drawing, fitted_size(stage.drawing.size, 180)))
        for axes in (above, below):
            axes.set(xticks=[], yticks=[], xlim=(0, 180), ylim=(180, 0))
    save_figure(file, figure)


FIGURES = {"coverage": coverage, "gradients": gradients, "stages": stages}
