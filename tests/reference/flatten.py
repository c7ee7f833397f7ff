# SPDX-License-Identifier: Apache-2.0
"""Flatten: cubic segments to closed polylines, at equal steps of t.

A segment of n pieces gives the n vertices at t = 0, 1/n, ..., (n-1)/n; the next segment's first vertex ends it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing

FloatArray = NDArray[np.float64]


def weights(num_pieces: int) -> FloatArray:
    """Return what each control point weighs in each vertex, by de Casteljau's scheme: (num_pieces, 4)."""
    t = (np.arange(num_pieces) / num_pieces)[:, None, None]
    level = np.broadcast_to(np.eye(4), (num_pieces, 4, 4))
    for _ in range(3):
        level = level[:, :-1] + t * (level[:, 1:] - level[:, :-1])
    return level[:, 0]


def flatten(drawing: Drawing, pieces: ArrayLike) -> list[list[FloatArray]]:
    """Return the vertices (V, 2) of each subpath of each layer, px."""
    pieces = np.asarray(pieces)
    cubics = drawing.cubics
    layers = []
    for layer in range(drawing.num_layers):
        outlines = []
        for subpath in range(drawing.layer_offsets[layer], drawing.layer_offsets[layer + 1]):
            segments = range(drawing.subpath_offsets[subpath], drawing.subpath_offsets[subpath + 1])
            outlines.append(np.concatenate([_evaluate(cubics[m], int(pieces[m])) for m in segments]))
        layers.append(outlines)
    return layers


def flatten_backward(drawing: Drawing, pieces: ArrayLike, d_vertices: FloatArray) -> FloatArray:
    """Return d_points (M, 3, 2) from d_vertices (V, 2), all vertices in the drawing's order.

    A vertex is sum_k w_k(t) P_k, so d_P_k is the sum over vertices of w_k(t) d_vertex; a segment's fourth control point
    is the next segment's anchor.
    """
    pieces = np.asarray(pieces)
    d_points = np.zeros_like(drawing.points)
    first = 0
    for m, following in enumerate(drawing.next_segments):
        d_controls = weights(int(pieces[m])).T @ d_vertices[first : first + pieces[m]]
        d_points[m] += d_controls[:3]
        d_points[following, 0] += d_controls[3]
        first += int(pieces[m])
    return d_points


def _evaluate(cubic: FloatArray, num_pieces: int) -> FloatArray:
    t = (np.arange(num_pieces) / num_pieces)[:, None, None]
    level = np.broadcast_to(cubic, (num_pieces, 4, 2))
    for _ in range(3):
        level = level[:, :-1] + t * (level[:, 1:] - level[:, :-1])
    return level[:, 0]
