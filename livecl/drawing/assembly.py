# SPDX-License-Identifier: Apache-2.0
"""Combine drawings: concatenate layers, replace outlines, scale the canvas; the empty drawing."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray
from livecl.drawing.drawing import WANTED_DRAWING, Drawing
from livecl.drawing.fills import MAX_COORDINATE, concatenate_fills
from livecl.drawing.strokes import concatenate_strokes
from livecl.errors import check_type

__all__ = ["concatenate", "empty_drawing", "stretched"]


def concatenate(below: Drawing, above: Drawing) -> Drawing:
    """Put the layers of one drawing above those of another.

    Parameters
    ----------
    below, above : Drawing
        On canvases of one size.

    Returns
    -------
    Drawing
        The layers of both, with canvas and background of `below`.

    Raises
    ------
    TypeError, ValueError
        If one is no drawing, or the canvases differ.
    """
    for name, drawing in (("below", below), ("above", above)):
        check_type(name, drawing, Drawing, WANTED_DRAWING)
    if above.size != below.size:
        raise ValueError(f"above: a canvas of {above.size} px, wanted that of below, {below.size}")
    return below.replace(
        points=np.concatenate([below.points, above.points]),
        colors=np.concatenate([below.colors, above.colors]),
        subpath_offsets=np.concatenate([below.subpath_offsets, above.subpath_offsets[1:] + below.num_segments]),
        layer_offsets=np.concatenate([below.layer_offsets, above.layer_offsets[1:] + below.layer_offsets[-1]]),
        stages=np.concatenate([below.stages, above.stages]),
        names=below.names + above.names,
        groups=below.groups + above.groups,
        fills=concatenate_fills([below.fills, above.fills]),
        strokes=concatenate_strokes([below.strokes, above.strokes]),
    )


def outlines_of(drawing: Drawing) -> list[list[FloatArray]]:
    """Return the subpaths (m, 3, 2) of each layer's outline, px."""
    return [[drawing.points[rows] for rows in drawing.subpaths(layer)] for layer in range(drawing.num_layers)]


def with_outlines(drawing: Drawing, outlines: Sequence[Sequence[FloatArray]], **fields: Any) -> Drawing:
    """Replace the outlines of a drawing's layers by subpaths (m, 3, 2), and other `fields`.

    Filled layers may get more or fewer subpaths; lines of strokes stay open or closed.
    """
    subpaths = [subpath for outline in outlines for subpath in outline]
    if "strokes" not in fields and drawing.strokes.any:
        strokes, offsets = drawing.strokes, drawing.layer_offsets
        opened = [
            strokes.is_open[slice(*offsets[layer : layer + 2])] if width else np.zeros(len(outline), bool)
            for layer, (width, outline) in enumerate(zip(strokes.widths, outlines, strict=True))
        ]
        fields["strokes"] = dataclasses.replace(strokes, is_open=np.concatenate(opened))
    return drawing.replace(
        points=np.concatenate(subpaths),
        subpath_offsets=np.cumsum([0, *map(len, subpaths)]),
        layer_offsets=np.cumsum([0, *map(len, outlines)]),
        **fields,
    )


def empty_drawing(size: tuple[int, int], background: ArrayLike | None = (1.0, 1.0, 1.0)) -> Drawing:
    """Return a drawing without layers."""
    return Drawing(
        points=np.zeros((0, 3, 2)),
        colors=np.zeros((0, 4)),
        size=size,
        background=background,
    )


def stretched(drawing: Drawing, factors: ArrayLike, size: tuple[int, int], offset: ArrayLike = (0.0, 0.0)) -> Drawing:
    """Scale and translate a drawing: each point (x, y) moves to ``factors * (x, y) + offset``.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    factors : (2,) or float array_like
        Factors of x and y. Widths of strokes are scaled by their geometric mean.
    size : (int, int)
        Height and width of the new canvas, px.
    offset : (2,) array_like
        Place of the old origin on the new canvas, px.
    """
    factors = np.broadcast_to(np.asarray(factors, dtype=np.float64), 2)
    points = np.clip(drawing.points * factors + np.asarray(offset), -MAX_COORDINATE, MAX_COORDINATE)
    strokes = drawing.strokes
    if strokes.any:
        strokes = strokes.with_widths(strokes.widths * np.sqrt(factors.prod()))
    return drawing.replace(points=points, size=size, fills=drawing.fills.stretched(factors, offset), strokes=strokes)


def scaled(drawing: Drawing, size: tuple[int, int]) -> Drawing:
    """Scale a drawing to a canvas of another size, (height, width) px."""
    if drawing.size == tuple(size):
        return drawing
    factors = np.array([size[1] / drawing.size[1], size[0] / drawing.size[0]])
    return stretched(drawing, factors, size)
