# SPDX-License-Identifier: Apache-2.0
"""A drawing on the device: its parameters, its outlines as lines, and the tiles that they may touch."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import Int32Array
from livecl.drawing.canvas import layer_boxes
from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import pieces_for
from livecl.opencl.launcher import Launcher
from livecl.rendering.fills import pack_fills
from livecl.rendering.layout import HEAD, pack_tables
from livecl.rendering.stacks import Stack
from livecl.rendering.tiling import Grid, Spans, plan_spans

#: Margin of boxes around the outline, px, so that rounding and edges exactly on a tile's border stay inside.
MARGIN = 0.125
#: Extra margin of boxes when they are laid out anew, px, so that small steps keep the layout.
SLACK = 3.0
#: Factors that turn (x_min, y_min, x_max, y_max) into numbers that all decrease when bounds grow.
_OUTWARDS = np.array([1.0, 1.0, -1.0, -1.0])


class Use(NamedTuple):
    """Purpose of flattening: coverage or distances."""

    scope: Literal["coverage", "distance"]  # scope of the launcher that receives lines and tables
    pieces: ArrayLike | None  # (M,), number of lines of each segment; None chooses it by the tolerance
    reach: float  # largest distance of relevant pixels from the outlines, px


@dataclasses.dataclass
class _Outlines:
    """Flattened outlines for one use."""

    reach: float
    pieces: Any = None
    line_counts: Int32Array | None = None  # (M,)
    drawing: Drawing | None = None  # whose lines are on the device
    placed: Placed | None = None
    limits: NDArray[np.float64] | None = None  # (N, 4), times `_OUTWARDS`
    spans: Spans | None = None


class Placed(NamedTuple):
    """Layout of a drawing for one use: its spans, and the total number of its lines."""

    spans: Spans
    num_lines: int


class Scene:
    """The drawing on the device; unchanged parts are not copied or computed again.

    Parameters
    ----------
    launcher : Launcher
        Buffers and kernels of the device.
    grid : Grid
        Strips and tiles of the canvas, or canvases.
    tolerance : float
        Flattening tolerance, px, if the caller gives no numbers of lines.
    max_tiles : int
        Number of tiles processed at a time.
    """

    def __init__(self, launcher: Launcher, grid: Grid, tolerance: float, max_tiles: int) -> None:
        self.launcher = launcher
        self.grid = grid
        self.tolerance = tolerance
        self.max_tiles = max_tiles
        self.drawing: Drawing | None = None
        self._bounds: NDArray[np.float64] = np.zeros((0, 4))  # (N, 4), times `_OUTWARDS`
        self._outlines: dict[str, _Outlines] = {}
        self._stack: Stack | None = None

    def load(self, drawing: Drawing, stack: Stack | None = None) -> bool:
        """Copy the drawing's parameters to the device; return whether its structure differs from the one before.

        With a stack, it is the stack's combined drawing, and the layers lie on as many canvases.
        """
        if drawing.size != (self.grid.height, self.grid.width):
            raise ValueError(f"drawing: size {drawing.size}, wanted {(self.grid.height, self.grid.width)}")
        changed = self.drawing is None or not self.drawing.same_structure(drawing)
        if changed:
            self._outlines.clear()
        self.drawing, self._stack = drawing, stack
        self._bounds = _OUTWARDS * layer_boxes(drawing)
        backgrounds = np.zeros((self.grid.count, HEAD))
        if drawing.background is not None:
            backgrounds[:, :3] = drawing.background if stack is None else stack.backgrounds
        head, colors, packed = np.zeros(HEAD), drawing.colors, np.zeros(0)
        if drawing.fills.any_gradients:
            head[0], packed = HEAD + colors.size + drawing.points.size + backgrounds.size, pack_fills(drawing.fills)
            colors = _with_least_opacities(drawing)
        numbers = head, colors.ravel(), drawing.points.ravel(), backgrounds.ravel(), packed
        self.launcher.write_reals("params", *numbers)
        return changed

    def place(self, *uses: Use) -> list[Placed]:
        """Lay out, for each use, the lines and the spans within reach of the loaded drawing's outlines.

        As long as a layout is valid, the same object is returned.
        """
        return [self._place(use) for use in uses]

    def flatten(self, *uses: Use) -> None:
        """Flatten the loaded drawing for each use whose lines are outdated."""
        assert self.drawing is not None
        stale = [use for use in uses if self._outlines[use.scope].drawing is not self.drawing]
        if len(stale) == 2:
            self.launcher("flatten_both", 2 * self.drawing.num_segments)
        else:
            for use in stale:
                self.launcher("flatten_forward", self.drawing.num_segments, use.scope)
        for use in stale:
            self._outlines[use.scope].drawing = self.drawing

    def _place(self, use: Use) -> Placed:
        outlines, drawing = self._outlines.get(use.scope), self.drawing
        assert drawing is not None
        if outlines is None or outlines.reach != use.reach:
            outlines = self._outlines[use.scope] = _Outlines(use.reach)
        moved = self._split(outlines, use.pieces)
        moved |= self._plan(outlines)
        if moved or outlines.placed is None:
            assert outlines.line_counts is not None and outlines.spans is not None
            self.launcher.write(f"{use.scope}_tables", pack_tables(drawing, outlines.line_counts, outlines.spans))
            outlines.placed = Placed(outlines.spans, int(outlines.line_counts.sum()))
        return outlines.placed

    def _split(self, outlines: _Outlines, pieces: ArrayLike | None) -> bool:
        """Set the number of lines of each segment; return whether the numbers may have changed."""
        drawing = self.drawing
        assert drawing is not None
        if outlines.pieces is pieces and (pieces is not None or outlines.drawing is drawing):
            return False
        counts = pieces_for(drawing.cubics, self.tolerance) if pieces is None else np.array(pieces)
        if counts.shape != (drawing.num_segments,) or counts.dtype.kind not in "iu" or np.any(counts < 1):
            raise ValueError(f"pieces: wanted {drawing.num_segments} whole numbers of at least 1, one for each segment")
        outlines.pieces, outlines.line_counts, outlines.drawing = pieces, counts, None
        return True

    def _plan(self, outlines: _Outlines) -> bool:
        """Lay out the spans anew unless every layer is still inside its last box; return whether it was done."""
        margin = outlines.reach + MARGIN
        if outlines.spans is not None and outlines.limits is not None and (self._bounds > outlines.limits).all():
            return False
        boxes = self.grid.boxes(_OUTWARDS * self._bounds, margin + SLACK)
        outlines.limits = _OUTWARDS * self.grid.limits(boxes, margin)
        if self._stack is not None:
            boxes[:, 1::2] += self.grid.period * self._stack.layer_drawings[:, None]
        outlines.spans = plan_spans(boxes, self.grid, self.max_tiles)
        return True


def _with_least_opacities(drawing: Drawing) -> NDArray[np.float64]:
    """Return the colours, with a gradient's least opacity as its layer's: if it is 1, the layer is opaque."""
    colors, fills = drawing.colors.copy(), drawing.fills
    layers = fills.gradient_layers
    colors[layers, 3] = np.minimum.reduceat(fills.stop_colors[:, 3], fills.stop_offsets[layers])
    return colors
