# SPDX-License-Identifier: Apache-2.0
"""Distance weight, eq. (1): d' = ReLU(tau - d) / sum, averaged over the layers within tau of some pixel centre."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from reference.coverage import lines_of
from reference.flatten import flatten

FloatArray = NDArray[np.float64]


def distance(outlines: Sequence[FloatArray], size: tuple[int, int]) -> FloatArray:
    """Return the unsigned distance from each pixel's centre to the nearest of closed polylines: (H, W), px."""
    start, end = lines_of(outlines)
    centre = np.stack(np.meshgrid(np.arange(size[1]) + 0.5, np.arange(size[0]) + 0.5), axis=-1)[:, :, None]
    along = end - start
    length_squared = np.sum(along * along, axis=-1)
    share = np.sum((centre - start) * along, axis=-1) / np.where(length_squared > 0, length_squared, 1.0)
    foot = start + np.clip(share, 0, 1)[..., None] * along
    return np.sqrt(np.min(np.sum((centre - foot) ** 2, axis=-1), axis=-1))


def distance_weight(drawing: Drawing, tau: float, pieces: ArrayLike) -> FloatArray:
    """Return d', averaged over the layers that have any: (H, W), of sum 1 unless no layer has."""
    layers = [np.maximum(tau - distance(outlines, drawing.size), 0.0) for outlines in flatten(drawing, pieces)]
    normalized = [layer / layer.sum() for layer in layers if layer.any()]
    return np.mean(normalized, axis=0) if normalized else np.zeros(drawing.size)
