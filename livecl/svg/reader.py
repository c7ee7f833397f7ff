# SPDX-License-Identifier: Apache-2.0
"""SVG to `Drawing`: this project's own files exactly, others as far as a drawing can represent them.

Unsupported features are named in one warning.
"""

from __future__ import annotations

import math
import os
import warnings

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing import KINDS, Drawing, Fills, Strokes
from livecl.drawing.strokes import DEFAULT_MITER_LIMIT, MAX_WIDTH
from livecl.errors import SvgError, readable
from livecl.geometry import bezier
from livecl.svg.document import parse_document, read_document
from livecl.svg.groups import told_apart
from livecl.svg.layer import ReadLayer
from livecl.svg.outline_data import MAX_PRECISION
from livecl.svg.walker import Walker

#: Excess of a side of the canvas over whole pixels that adds no pixel, px: converted units round that much.
NO_PIXEL = 1e-3


def read_svg(source: str | os.PathLike[str] | bytes) -> Drawing:
    """Read an SVG of filled and stroked paths.

    Lines, quadratics, arcs and basic shapes become cubics; transforms are applied; a group's opacity goes into its
    layers'; open subpaths of fills are closed; even-odd fills become equal nonzero ones where possible; gradients keep
    their stops (a focal point off the centre is approximated); a canvas of a fractional size is rounded up. A shape
    that is filled and stroked becomes two layers; dashes become separate open paths, and a stroke that a transform
    stretches unevenly becomes its outline. Unsupported features (text, images, patterns, clips, ...) are named, with
    counts, in one :class:`UserWarning`. A drawing saved by :func:`livecl.svg.save_svg` is read back equal.

    Parameters
    ----------
    source : path or bytes
        An SVG file, or its content.

    Returns
    -------
    Drawing
        A layer for each shape, bottom first. Layers and groups (except those of stages) have their Inkscape label,
        title or id as name. The background is a rectangle ``id="background"`` that covers the canvas below all layers,
        or None.

    Raises
    ------
    SvgError
        If the file cannot be read, is cut off, too large or nested too deep, refers to entities or other files, states
        no size, or holds a path without data or with numbers that are not finite.

    Examples
    --------
    >>> red = read_svg(b'<svg width="9" height="9"><rect width="4" height="9" fill="red"/></svg>')
    >>> red.size, red.labels
    ((9, 9), ('red rectangle left',))
    """
    name, data = read_document(source)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # overflows are not finite, and refused later
            walker = Walker(parse_document(data))
            drawing = _drawing(walker.layers, walker.size)
    except ValueError as error:
        raise SvgError(f"{name}: {readable(str(error))}") from error
    if walker.left_out:
        warnings.warn(f"{name}: not representable as filled and stroked paths: {walker.left_out}", stacklevel=2)
    return drawing


def _drawing(layers: list[ReadLayer], size: tuple[float, float]) -> Drawing:
    """Return layers as a drawing; ValueError if its coordinates or sides are too large."""
    background = None
    width, height = size
    if layers and _is_background(layers[0], size):
        background = np.array(layers[0].color[:3])
        layers = layers[1:]
    return Drawing.from_outlines(
        # Relative coordinates have been added up: rounded, they equal the file's; 0.0 turns -0 into 0.
        [[np.round(rows, MAX_PRECISION) + 0.0 for rows in _rows(layer)] for layer in layers],
        np.array([layer.color for layer in layers]).reshape(-1, 4),
        (max(1, math.ceil(height - NO_PIXEL)), max(1, math.ceil(width - NO_PIXEL))),
        background,
        stages=np.array([layer.stage for layer in layers], dtype=np.int32),
        names=[layer.name for layer in layers],
        fills=_fills(layers),
        strokes=_strokes(layers),
        groups=told_apart([layer.groups for layer in layers]),
    )


def _rows(layer: ReadLayer) -> list[FloatArray]:
    """Return the points (n, 3, 2) of each subpath; an open one's end is a row of its own."""
    if layer.is_open is None:
        return [subpath[:, :3] for subpath in layer.outline]
    return [
        np.concatenate([subpath[:, :3], np.broadcast_to(subpath[-1:, 3:], (1, 3, 2))]) if is_open else subpath[:, :3]
        for subpath, is_open in zip(layer.outline, layer.is_open, strict=True)
    ]


def _strokes(layers: list[ReadLayer]) -> Strokes | None:
    """Return the strokes of layers, widths rounded as coordinates are; None if there are none."""
    pens = [layer.pen for layer in layers]
    if not any(pens):
        return None
    unit = 10.0**-MAX_PRECISION
    return Strokes(
        widths=[0 if pen is None else min(max(round(pen.width, MAX_PRECISION), unit), MAX_WIDTH) for pen in pens],
        caps=[0 if pen is None else pen.cap for pen in pens],
        joins=[0 if pen is None else pen.join for pen in pens],
        miter_limits=[DEFAULT_MITER_LIMIT if pen is None else pen.miter_limit for pen in pens],
        is_open=np.concatenate([layer.is_open or np.zeros(len(layer.outline), bool) for layer in layers]).astype(bool),
    )


def _fills(layers: list[ReadLayer]) -> Fills:
    """Return the fills of layers, their geometry rounded as coordinates are."""
    geometry = np.zeros((len(layers), 3, 2))
    for points, layer in zip(geometry, layers, strict=True):
        if layer.gradient is not None:
            points[: len(layer.gradient.points)] = np.round(layer.gradient.points, MAX_PRECISION) + 0.0
    stops = [np.zeros((0, 5)) if layer.gradient is None else layer.gradient.stops for layer in layers]
    packed = np.concatenate([np.zeros((0, 5)), *stops])
    return Fills(
        kinds=[0 if layer.gradient is None else KINDS.index(layer.gradient.kind) for layer in layers],
        geometry=geometry,
        stop_offsets=np.cumsum([0, *map(len, stops)]),
        stop_positions=packed[:, 0],
        stop_colors=packed[:, 1:],
    )


def _is_background(layer: ReadLayer, size: tuple[float, float]) -> bool:
    if layer.identifier != "background" or layer.gradient is not None or layer.color[3] < 1 or len(layer.outline) != 1:
        return False
    x0, y0, x1, y1 = layer.bounds
    covers = max(x0, y0) <= NO_PIXEL and x1 >= size[0] - NO_PIXEL and y1 >= size[1] - NO_PIXEL
    box_area = float((x1 - x0) * (y1 - y0))
    return bool(covers) and abs(bezier.signed_area(layer.outline[0])) >= box_area * (1 - 1e-9)
