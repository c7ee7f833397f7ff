# SPDX-License-Identifier: Apache-2.0
"""Layout and sizes of the buffers on the device: the host's side of kernels/common.h, distance.h and fill.h."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import Int32Array
from livecl.drawing.drawing import Drawing
from livecl.rendering.fills import record_reals
from livecl.rendering.tiling import TILE, Grid, Spans

#: Sizes in numbers: of the head of `params`, and of a drawing's part there and in `result`; of a colour; of a segment's
#: points; of its cubic.
HEAD, COLOR, POINTS, CUBIC = 4, 4, 6, 8
#: Numbers of a line (x0, y0, x1, y1) and of the bounds of a segment's lines.
LINE = 4


def pack_tables(drawing: Drawing, line_counts: Int32Array, spans: Spans) -> Int32Array:
    """Pack the tables of spans, segments and lines into one array: `Tables` of common.h.

    `line_counts` (M,) are the numbers of lines of the segments.
    """
    tables = (
        spans.layer_strips.ravel(),
        spans.layer_spans,
        spans.strip_offsets,
        drawing.segment_offsets,
        drawing.next_segments,
        np.concatenate([[0], np.cumsum(line_counts)]),
        np.repeat(drawing.segment_layers, line_counts),
    )
    head = 5 + len(tables)
    begins = head + spans.spans.size + np.cumsum([0, *map(len, tables[:-1])])
    counts = [drawing.num_layers, drawing.num_segments, int(line_counts.sum()), len(spans.spans), spans.num_tiles]
    return np.concatenate([counts, begins, spans.spans.ravel(), *tables]).astype(np.int32)


@dataclasses.dataclass(frozen=True)
class Sizes:
    """Sizes of a drawing's buffers, bytes."""

    grid: Grid  # strips and tiles of the canvas, or canvases
    real: int  # bytes of a number
    #: Of the drawing.
    num_layers: int
    num_segments: int
    record: int  # numbers of a record of a layer's fill, see kernels/fill.h; 0 if all layers are solid

    @classmethod
    def of(cls, drawing: Drawing, grid: Grid, real: int) -> Sizes:
        """Return the sizes for a drawing."""
        record = record_reals(drawing.fills) if drawing.fills.any_gradients else 0
        return cls(grid, real, drawing.num_layers, drawing.num_segments, record)

    def planes(self, count: int) -> int:
        """Return the bytes of images with `count` channels altogether."""
        return self.real * count * self.grid.num_strips * self.grid.num_tiles * self._tile

    def lines(self, num_lines: int) -> int:
        """Return the bytes of flattened outlines."""
        return self.real * LINE * (self.num_segments + num_lines)

    def cells(self, spans: Spans) -> int:
        """Return the bytes of `cells`: area, scratch and state of each tile."""
        return spans.num_tiles * (2 * self.real * self._tile + 4)

    def distances(self, spans: Spans) -> int:
        """Return the bytes of `distances`: closeness and near of each tile, sums of spans, factors of layers."""
        sums = self.real * (len(spans.spans) + self.num_layers)
        return spans.num_tiles * (self.real * self._tile + 4) + sums

    def backward(self, spans: Spans, num_lines: int) -> dict[str, int]:
        """Return the bytes of the buffers of a gradient, by name."""
        canvas = COLOR * self.grid.num_strips * self.grid.num_tiles
        return {
            "d_tiles": self.real * (spans.num_tiles * (COLOR + self.record) + canvas),
            "d_lines": self.real * LINE * num_lines,
            "result": self.real * self.num_results,
        }

    @property
    def num_results(self) -> int:
        """Count of numbers in `result`."""
        return HEAD * self.grid.count + (COLOR + self.record) * self.num_layers + CUBIC * self.num_segments

    def split_result(self, result: NDArray[Any]) -> tuple[NDArray[Any], ...]:
        """Split `result`: d_colors (N, 4), d_cubics (M, 4, 2), losses and d_background (count, 4), records."""
        colors = COLOR * self.num_layers
        cubics = colors + CUBIC * self.num_segments
        heads = cubics + HEAD * self.grid.count
        return (
            result[:colors].reshape(-1, COLOR),
            result[colors:cubics].reshape(-1, 4, 2),
            result[cubics:heads].reshape(-1, HEAD),
            result[heads:].reshape(self.num_layers, self.record),
        )

    @property
    def _tile(self) -> int:
        """Pixels of a tile."""
        return TILE * self.grid.lanes
