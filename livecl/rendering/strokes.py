# SPDX-License-Identifier: Apache-2.0
"""Strokes in the rasterizer: convert them to filled outlines, and map the gradients back.

Coverage and compositing support filled outlines only. The centre line of a stroked layer is flattened as any outline;
:mod:`livecl.geometry.strokes` turns its lines into polygons, which replace the layer, with the layer's paint.
Vertices are linear in the control points by the Bernstein weights b, v_k = sum_j b_j(t_k) P_j, so that the gradient of
control points is d_P_j = sum_k b_j(t_k) d_v_k.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, IntArray
from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import bernstein, pieces_for
from livecl.geometry.strokes import Pens, StrokeOutlines, outline_strokes
from livecl.rendering.gradients import Gradients


@dataclasses.dataclass(frozen=True)
class Filled:
    """A drawing with strokes replaced by filled outlines."""

    drawing: Drawing  # filled layers only; the lines of strokes' outlines are segments of one line each
    source: Drawing  # the original drawing
    _counts: NDArray[np.int32] | None = None  # lines of each segment of the source
    _rows: IntArray | None = None  # source segment of each segment, -1 for a stroke's outline
    _corners: IntArray | None = None  # segment of each corner of the outlines
    _outlines: StrokeOutlines | None = None
    _segments: IntArray | None = None  # source segment of each vertex of the centre lines
    _weights: FloatArray | None = None  # Bernstein weights of each vertex
    _layers: IntArray | None = None  # layer of each stroked subpath

    def pieces(self, pieces: ArrayLike | None) -> ArrayLike | None:
        """Return the numbers of lines of this drawing's segments from those of the source's, (M,) or None."""
        if self._rows is None or self._counts is None:
            return pieces
        counts = self._counts if pieces is None else np.asarray(pieces)
        return np.where(self._rows < 0, 1, counts[self._rows]).astype(np.int32)

    def pull_back(self, gradients: Gradients) -> Gradients:
        """Return the gradient with respect to the source."""
        if self._rows is None:
            return gradients
        assert self._corners is not None and self._outlines is not None and self._layers is not None
        assert self._segments is not None and self._weights is not None
        source = self.source
        points = np.zeros(source.points.shape)
        kept = self._rows >= 0
        points[self._rows[kept]] = gradients.points[kept]
        d_vertices, d_widths = self._outlines.pull_back(gradients.points[self._corners, 0])
        d_cubics = np.zeros((source.num_segments, 4, 2))
        np.add.at(d_cubics, self._segments, self._weights[:, :, None] * d_vertices[:, None])
        points += d_cubics[:, :3]
        points[source.next_segments, 0] += d_cubics[:, 3]
        widths = np.bincount(self._layers, d_widths, source.num_layers).astype(np.float64)
        return dataclasses.replace(gradients, points=points, widths=widths)


def filled(drawing: Drawing, pieces: ArrayLike | None, tolerance: float) -> Filled:
    """Outline the strokes of a drawing.

    Parameters
    ----------
    drawing : Drawing
        Any drawing; one without strokes is not changed.
    pieces : (M,) array_like of int, or None
        Number of lines of each segment; None chooses those of strokes by the tolerance.
    tolerance : float
        Largest distance between a curve, or the edge of its stroke, and its lines, px.

    Raises
    ------
    ValueError
        If `pieces` does not fit the drawing.
    """
    strokes = drawing.strokes
    if not strokes.any:
        return Filled(drawing, drawing)
    counts = stroke_pieces(drawing, tolerance) if pieces is None else np.asarray(pieces)
    if counts.shape != (drawing.num_segments,) or counts.dtype.kind not in "iu" or np.any(counts < 1):
        raise ValueError(f"pieces: wanted {drawing.num_segments} whole numbers of at least 1, one for each segment")
    subpath_layers = np.repeat(np.arange(drawing.num_layers), np.diff(drawing.layer_offsets))
    stroked = strokes.widths[subpath_layers] > 0
    subpath_of = np.repeat(np.arange(len(stroked)), np.diff(drawing.subpath_offsets))
    ends = (drawing.subpath_offsets[1:] - 1)[strokes.is_open]  # rows that are only an end, no segment
    steps = np.where(stroked[subpath_of], counts, 0)
    steps[ends] = 1
    segments = np.repeat(np.arange(drawing.num_segments), steps)
    number = np.arange(len(segments)) - np.repeat(np.cumsum(steps) - steps, steps)
    weights = bernstein(number / steps[segments])
    vertices = np.einsum("vk,vkd->vd", weights, drawing.cubics[segments])
    layers = subpath_layers[stroked]
    lengths = np.bincount(subpath_of, steps, len(stroked)).astype(np.int64)[stroked]
    outlines = outline_strokes(
        vertices,
        np.concatenate([[0], np.cumsum(lengths)]),
        Pens(strokes.widths[layers], strokes.caps[layers], strokes.joins[layers], strokes.miter_limits[layers]),
        closed=~strokes.is_open[stroked],
        smooth=number > 0,
        tolerance=tolerance,
    )
    return _replaced(
        Filled(drawing, drawing, counts, None, None, outlines, segments, weights, layers), stroked, subpath_of
    )


def stroke_pieces(drawing: Drawing, tolerance: float) -> NDArray[np.int32]:
    """Return the number of lines of each segment, (M,): for strokes, as many as the outer edge needs.

    An edge at the distance r from a curve turns as the curve does; lines with turns of theta stay within r (1 -
    cos(theta / 2)) of an arc of radius r. The turn of a cubic is at most that of its control polygon.
    """
    counts = pieces_for(drawing.cubics, tolerance)
    radii = drawing.strokes.widths[drawing.segment_layers] / 2
    if not radii.any():
        return counts
    legs = np.diff(drawing.cubics, axis=1)
    legs = np.where((np.abs(legs).sum(2) > 0)[..., None], legs, (drawing.cubics[:, 3] - drawing.cubics[:, 0])[:, None])
    angles = np.arctan2(legs[..., 1], legs[..., 0])
    turns = np.abs((np.diff(angles, axis=1) + np.pi) % (2 * np.pi) - np.pi).sum(axis=1)
    largest = 2 * np.arccos(np.clip(1 - tolerance / np.maximum(radii, tolerance), -1, 1))
    return np.where(radii > 0, np.maximum(counts, np.ceil(turns / largest)), counts).astype(np.int32)


def _replaced(start: Filled, stroked: NDArray[np.bool_], subpath_of: IntArray) -> Filled:
    """Replace the strokes by their polygons, given which subpaths are stroked and each segment's subpath."""
    drawing, outlines, layers = start.source, start._outlines, start._layers
    assert outlines is not None and layers is not None
    loops = np.repeat(np.arange(len(outlines.loop_strokes)), np.diff(outlines.loop_offsets))
    following = np.arange(1, len(outlines.points) + 1)
    following[outlines.loop_offsets[1:] - 1] = outlines.loop_offsets[:-1]
    lines = np.stack([outlines.points, outlines.points, outlines.points[following]], axis=1)
    rows = np.flatnonzero(~stroked[subpath_of])
    row_layers = np.concatenate([drawing.segment_layers[rows], layers[outlines.loop_strokes][loops]])
    order = np.argsort(row_layers, kind="stable")
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order))
    subpaths = np.concatenate([subpath_of[rows], len(stroked) + loops])[order]
    starts = np.flatnonzero(np.diff(subpaths, prepend=-1))
    counts = np.bincount(row_layers[order][starts], minlength=drawing.num_layers)
    plain = drawing.replace(
        points=np.concatenate([drawing.points[rows], lines])[order],
        subpath_offsets=np.append(starts, len(order)),
        layer_offsets=np.concatenate([[0], np.cumsum(counts)]),
        strokes=None,
    )
    sources = np.concatenate([rows, np.full(len(lines), -1)])[order]
    return dataclasses.replace(start, drawing=plain, _rows=sources, _corners=places[len(rows) :])
