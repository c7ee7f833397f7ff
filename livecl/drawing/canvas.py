# SPDX-License-Identifier: Apache-2.0
"""Bounding boxes of layers, and checks of canvases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing


def layer_boxes(drawing: Drawing) -> NDArray[np.float64]:
    """Return the bounding box (x_min, y_min, x_max, y_max) of each layer's control points: (N, 4), px."""
    if not drawing.num_layers:
        return np.zeros((0, 4))
    starts, points = 3 * drawing.segment_offsets[:-1], drawing.points.reshape(-1, 2)
    return np.concatenate([np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)], axis=1)


def check_canvases(drawings: Sequence[Drawing]) -> None:
    """Raise ValueError unless there are drawings, all on canvases of one size."""
    if not drawings:
        raise ValueError("drawings: got none, wanted at least one")
    for index, drawing in enumerate(drawings):
        if drawing.size != drawings[0].size:
            raise ValueError(f"drawings: {index} has a canvas of {drawing.size} px, wanted {drawings[0].size} as 0 has")
