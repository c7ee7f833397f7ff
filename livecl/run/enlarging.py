# SPDX-License-Identifier: Apache-2.0
"""Drawings on the picture's own canvas, after a run on a smaller one."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from livecl.drawing.drawing import Drawing
from livecl.image.resizing import scaled
from livecl.svg.outline_data import MAX_PRECISION
from livecl.svg.writer import primitives, quantize


def enlarged_drawing(drawing: Drawing, size: tuple[int, int], start: Drawing | None, lock: Sequence[int]) -> Drawing:
    """Return a drawing on the picture's canvas, the locked layers of `start` with the very points that they have there.

    Scaled down, rounded and scaled up again, these would differ from them.
    """
    enlarged = scaled(drawing, size)
    if enlarged is drawing:
        return enlarged
    points = enlarged.points.copy()
    factors = np.array(size[::-1]) / drawing.size[::-1]
    for layer, shape in primitives(drawing, MAX_PRECISION).items():  # the two factors differ a little
        larger = shape.scaled(factors)
        own = slice(*drawing.segment_offsets[layer : layer + 2])
        if larger is not None and larger.points.shape == points[own].shape:
            points[own] = larger.points
    if start is None:
        return enlarged.replace(points=points)
    smaller = quantize(scaled(start, drawing.size))
    for layer in lock:
        own = slice(*smaller.segment_offsets[layer : layer + 2])
        for first, end in itertools.pairwise(drawing.segment_offsets):
            if np.array_equal(drawing.points[first:end], smaller.points[own]):
                points[first:end] = start.points[own]
    return enlarged.replace(points=points)
