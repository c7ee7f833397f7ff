# SPDX-License-Identifier: Apache-2.0
"""Combine drawings of one size into one on stacked canvases, and split its gradients."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import Int32Array
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import concatenate_fills
from livecl.drawing.strokes import concatenate_strokes
from livecl.rendering.fills import FillGradients
from livecl.rendering.gradients import Gradients


@dataclasses.dataclass(frozen=True, eq=False)
class Stack:
    """Several drawings of one size, all with a background or all without."""

    drawing: Drawing  # the layers of all drawings in their own coordinates, one drawing after the other
    layer_offsets: Int32Array  # (D + 1,), first layer of each drawing, and N at the end
    backgrounds: NDArray[np.float64]  # (D, 3), their backgrounds; empty if they have none
    stroked: NDArray[np.bool_]  # (D,), which of them have strokes

    @classmethod
    def of(cls, drawings: Sequence[Drawing]) -> Stack:
        """Combine drawings."""
        first = drawings[0]
        joined = Drawing(
            points=np.concatenate([drawing.points for drawing in drawings]),
            colors=np.concatenate([drawing.colors for drawing in drawings]),
            size=first.size,
            background=first.background,
            subpath_offsets=_stacked_offsets([drawing.subpath_offsets for drawing in drawings]),
            layer_offsets=_stacked_offsets([drawing.layer_offsets for drawing in drawings]),
            fills=concatenate_fills([drawing.fills for drawing in drawings]),
            strokes=concatenate_strokes([drawing.strokes for drawing in drawings]),
        )
        grounds = [np.zeros(3) if drawing.background is None else drawing.background for drawing in drawings]
        offsets = np.cumsum([0, *(drawing.num_layers for drawing in drawings)], dtype=np.int32)
        return cls(joined, offsets, np.array(grounds), np.array([drawing.strokes.any for drawing in drawings]))

    @property
    def count(self) -> int:
        """Number of drawings, D."""
        return len(self.stroked)

    @functools.cached_property
    def layer_drawings(self) -> Int32Array:
        """Drawing of each layer: (N,) int32."""
        return np.repeat(np.arange(self.count, dtype=np.int32), np.diff(self.layer_offsets))

    def split(self, gradients: Gradients) -> list[Gradients]:
        """Return the gradients of each drawing, as views of the combined arrays."""
        segments = self.drawing.segment_offsets[self.layer_offsets]
        stops = self.drawing.fills.stop_offsets[self.layer_offsets]
        grounds, fills, widths = gradients.background, gradients.fills, gradients.widths
        found = []
        for index in range(self.count):
            layer, segment, stop = (
                slice(*offsets[index : index + 2]) for offsets in (self.layer_offsets, segments, stops)
            )
            own_fills = None
            if fills is not None:
                own_fills = FillGradients(fills.geometry[layer], fills.stop_positions[stop], fills.stop_colors[stop])
            found.append(
                Gradients(
                    points=gradients.points[segment],
                    colors=gradients.colors[layer],
                    background=None if grounds is None else grounds.reshape(-1, 3)[index],
                    fills=own_fills,
                    widths=widths[layer] if widths is not None and self.stroked[index] else None,
                )
            )
        return found


def _stacked_offsets(offsets: Sequence[Int32Array]) -> Int32Array:
    """Return offsets into the concatenated members of several drawings."""
    begins = np.cumsum([0, *(part[-1] for part in offsets)])
    return np.concatenate([[0], *(begin + part[1:] for begin, part in zip(begins, offsets, strict=False))])
