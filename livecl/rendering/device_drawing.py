# SPDX-License-Identifier: Apache-2.0
"""A drawing on the device: its numbers, its outlines as lines, and the tiles that they may touch."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.canvas import layer_boxes
from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import pieces_for
from livecl.opencl.launcher import Launcher
from livecl.rendering.fills import pack_fills
from livecl.rendering.tiling import Grid, Spans, plan_spans

#: Pixels that boxes reach beyond the outline, so that rounding and edges exactly on a tile's border stay inside.
MARGIN = 0.125
#: Pixels that boxes are larger than needed when they are laid out anew, so that small steps keep the layout.
SLACK = 3.0
#: Turns (x_min, y_min, x_max, y_max) into numbers that all become smaller where bounds grow.
_OUTWARDS = np.array([1.0, 1.0, -1.0, -1.0])


class Use(NamedTuple):
    """Purpose of flattening: coverage or distances.

    Attributes
    ----------
    scope : "coverage" or "distance"
        Scope of the launcher that receives lines and spans.
    pieces : (M,) array_like of int, or None
        Lines for each segment; None chooses them by the tolerance.
    reach : float
        How far from the outlines pixels matter, px.
    """

    scope: Literal["coverage", "distance"]
    pieces: ArrayLike | None
    reach: float


@dataclasses.dataclass
class _Outlines:
    """Flattened outlines for one use."""

    reach: float
    pieces: Any = None
    num_lines: int = 0
    drawing: Drawing | None = None
    limits: NDArray[np.float64] | None = None  # (N, 4), times `_OUTWARDS`
    spans: Spans | None = None


class Scene:
    """The drawing on the device; what has not changed since it was last put there stays.

    Parameters
    ----------
    launcher : Launcher
        Where buffers live and kernels run.
    grid : Grid
        Strips and tiles of the canvas.
    tolerance : float
        Distance px between curve and lines where the caller does not say how many lines.
    max_tiles : int
        Tiles that are worked on at a time.
    """

    def __init__(self, launcher: Launcher, grid: Grid, tolerance: float, max_tiles: int) -> None:
        self.launcher = launcher
        self.grid = grid
        self.tolerance = tolerance
        self.max_tiles = max_tiles
        self.drawing: Drawing | None = None
        self._bounds: NDArray[np.float64] = np.zeros((0, 4))  # (N, 4), times `_OUTWARDS`
        self._outlines: dict[str, _Outlines] = {}
        launcher.set(width=grid.width, height=grid.height, num_strips=grid.num_strips, num_tiles=grid.num_tiles)
        launcher.set(num_columns=grid.num_columns)

    def load(self, drawing: Drawing) -> None:
        """Put the drawing's numbers on the device."""
        if drawing is self.drawing:
            return
        if drawing.size != (self.grid.height, self.grid.width):
            raise ValueError(f"drawing: size {drawing.size}, wanted {(self.grid.height, self.grid.width)}")
        run = self.launcher
        if self.drawing is None or not self.drawing.same_structure(drawing):
            self._outlines.clear()
            run.set(num_segments=drawing.num_segments, num_layers=drawing.num_layers)
            run.write("next_segments", drawing.next_segments)
            run.write("layer_segments", drawing.segment_offsets)
        self.drawing = drawing
        self._bounds = _OUTWARDS * layer_boxes(drawing)
        background = np.zeros(3) if drawing.background is None else drawing.background
        start, colors, packed = 0, drawing.colors, np.zeros(0)
        if drawing.fills.any_gradients:
            start, packed = 4 + drawing.colors.size + drawing.points.size, pack_fills(drawing.fills)
            colors = _with_least_opacities(drawing)
        run.write_reals("params", background, np.array([start]), colors.ravel(), drawing.points.ravel(), packed)

    def flatten(self, *uses: Use) -> list[Spans]:
        """Flatten the loaded drawing and return, for each use, the spans within reach of its layers' outlines."""
        assert self.drawing is not None
        stale = [use for use in uses if self._outdated(use)]
        if len(stale) == 2:
            self.launcher("flatten_both", 2 * self.drawing.num_segments)
        else:
            for use in stale:
                self.launcher("flatten_forward", self.drawing.num_segments, use.scope)
        return [self._place(use) for use in uses]

    def _outdated(self, use: Use) -> bool:
        """Return whether lines must be made for a use, after making room for them."""
        outlines = self._outlines.get(use.scope)
        if outlines is None or outlines.reach != use.reach:
            outlines = self._outlines[use.scope] = _Outlines(use.reach)
        if outlines.drawing is self.drawing and outlines.pieces is use.pieces:
            return False
        if outlines.pieces is None or outlines.pieces is not use.pieces:
            self._split(use.scope, outlines, use.pieces)
        outlines.drawing = self.drawing
        return True

    def num_lines(self, scope: str) -> int:
        """Return the number of lines that the drawing was flattened into."""
        return self._outlines[scope].num_lines

    def _split(self, scope: str, outlines: _Outlines, pieces: ArrayLike | None) -> None:
        drawing, run = self.drawing, self.launcher
        assert drawing is not None
        counts = pieces_for(drawing.cubics, self.tolerance) if pieces is None else np.asarray(pieces)
        if counts.shape != (drawing.num_segments,) or counts.dtype.kind not in "iu" or np.any(counts < 1):
            raise ValueError(f"pieces: wanted {drawing.num_segments} whole numbers of at least 1, one for each segment")
        line_offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        outlines.pieces, outlines.num_lines = pieces, int(line_offsets[-1])
        run.write(f"{scope}_line_offsets", line_offsets)
        run.write(f"{scope}_line_layers", np.repeat(drawing.segment_layers, counts))
        run.reserve_reals(f"{scope}_lines", 4 * outlines.num_lines)
        run.reserve_reals(f"{scope}_segment_bounds", 4 * drawing.num_segments)

    def _place(self, use: Use) -> Spans:
        """Lay out the spans, unless every layer is still inside the boxes laid out last."""
        outlines, margin = self._outlines[use.scope], use.reach + MARGIN
        if outlines.spans is not None and outlines.limits is not None and (self._bounds > outlines.limits).all():
            return outlines.spans
        boxes = self.grid.boxes(_OUTWARDS * self._bounds, margin + SLACK)
        outlines.limits = _OUTWARDS * self.grid.limits(boxes, margin)
        spans = outlines.spans = plan_spans(boxes, self.grid.num_strips, self.max_tiles)
        for name in ("spans", "strip_offsets", "layer_strips", "layer_spans"):
            self.launcher.write(f"{use.scope}_{name}", getattr(spans, name))
        return spans


def _with_least_opacities(drawing: Drawing) -> NDArray[np.float64]:
    """Return the colours, with the least opacity of a gradient's stops: where it is 1, nothing below shows."""
    colors, fills = drawing.colors.copy(), drawing.fills
    layers = fills.gradient_layers
    colors[layers, 3] = np.minimum.reduceat(fills.stop_colors[:, 3], fills.stop_offsets[layers])
    return colors
