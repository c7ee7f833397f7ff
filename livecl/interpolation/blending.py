# SPDX-License-Identifier: Apache-2.0
"""Interpolation of drawings: control points and fills of matched layers, blended linearly."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal, NamedTuple, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray
from livecl.drawing.assembly import stretched
from livecl.drawing.canvas import layer_boxes
from livecl.drawing.drawing import WANTED_DRAWING, Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.drawing.strokes import Strokes, concatenate_strokes
from livecl.errors import check_type
from livecl.geometry import bezier
from livecl.interpolation.alignment import CubicPaths, align
from livecl.interpolation.fills import mix_geometry, paired_fills
from livecl.interpolation.lines import StrokeLine, align_lines
from livecl.interpolation.matching import Match, match_layers

#: Transitions of layers without a match.
Lone = Literal["fade", "grow"]

#: Initial width of a stroke that grows, px.
THIN = 1e-3


class _Layer(NamedTuple):
    """Subpaths, closed or the segments of open lines; colour, straight RGBA; fill and pen, of one layer each."""

    outline: CubicPaths
    color: FloatArray
    fills: Fills
    strokes: Strokes

    def rows(self) -> list[FloatArray]:
        """Return the points of each subpath; the end of an open line is a separate row."""
        return [
            np.concatenate([cubics[:, :3], np.broadcast_to(cubics[-1:, 3:], (1, 3, 2))]) if is_open else cubics[:, :3]
            for cubics, is_open in zip(self.outline, self.strokes.is_open, strict=True)
        ]


@overload
def interpolate(a: Drawing, b: Drawing, t: float, *, match: Match = ..., lone: Lone = ...) -> Drawing: ...


@overload
def interpolate(
    a: Drawing, b: Drawing, t: Sequence[float], *, match: Match = ..., lone: Lone = ...
) -> list[Drawing]: ...


def interpolate(
    a: Drawing, b: Drawing, t: float | Sequence[float], *, match: Match = "order", lone: Lone = "fade"
) -> Drawing | list[Drawing]:
    """Interpolate between two drawings.

    Parameters
    ----------
    a, b : Drawing
        On canvases of one size, both with a background or both without.
    t : float or sequence of float
        Places between `a` (0) and `b` (1).
    match : "order" or "nearest"
        Matching of layers, see :func:`livecl.interpolation.matching.match_layers`: by place in paint order, or the most
        similar ones.
    lone : "fade" or "grow"
        How a layer without a match appears or disappears: by its opacity, or from and to a point in its middle (which
        leaves a hole if a large one disappears).

    Returns
    -------
    Drawing, or list of Drawing
        One for each `t`, all of the same structure (:meth:`Drawing.same_structure`); stages and names are those of `a`,
        or of `b` for layers without a match in `a`. At 0 and 1 they look like `a` and `b`, but may have more segments,
        and layers that are points or transparent.

    Raises
    ------
    ValueError
        If the canvases or an argument do not fit.

    Notes
    -----
    Points: ``p = (1 - t) p_a + t p_b``, after :func:`livecl.interpolation.alignment.align`. Colours are mixed
    premultiplied, see :func:`mix_colors`, also those of a gradient's stops; its geometry and offsets are mixed like
    points. Fills of different kinds: :func:`livecl.interpolation.fills.paired_fills`.

    Strokes: centre lines are matched by :func:`livecl.interpolation.lines.align_lines`, widths are mixed, and caps,
    joins and miter limits change half-way. A stroked layer and a filled one are never matched: one disappears as the
    other appears.

    Examples
    --------
    >>> from livecl.svg import read_svg
    >>> narrow = read_svg(b'<svg width="9" height="9"><rect width="2" height="9"/></svg>')
    >>> wide = read_svg(b'<svg width="9" height="9"><rect width="6" height="9"/></svg>')
    >>> [float(drawing.points[..., 0].max()) for drawing in interpolate(narrow, wide, [0, 0.5, 1])]
    [2.0, 4.0, 6.0]
    """
    places = np.atleast_1d(np.asarray(t, dtype=np.float64))
    if places.ndim != 1 or not np.all((places >= 0) & (places <= 1)):
        raise ValueError(f"t: got {t!r}, wanted a number from 0 to 1, or a sequence of them")
    start, end = correspond(a, b, match=match, lone=lone)
    drawings = [_between(start, end, float(place)) for place in places]
    return drawings[0] if np.ndim(t) == 0 else drawings


def correspond(a: Drawing, b: Drawing, *, match: Match = "order", lone: Lone = "fade") -> tuple[Drawing, Drawing]:
    """Return two drawings that look like those given, with corresponding layers, subpaths, segments and points.

    Arguments and errors are those of :func:`interpolate`, which blends the two.
    """
    for name, drawing in (("a", a), ("b", b)):
        check_type(name, drawing, Drawing, WANTED_DRAWING)
    if a.size != b.size:
        raise ValueError(
            f"b: canvas of {b.size} px, wanted that of a, {a.size}; livecl.interpolation.blending.fit_canvas scales it"
        )
    if (a.background is None) != (b.background is None):
        raise ValueError("b: one drawing has a background and the other has none; give both one, or neither")
    if lone not in get_args(Lone):
        raise ValueError(f"lone: got {lone!r}, wanted {' or '.join(map(repr, get_args(Lone)))}")
    pairs = match_layers(a, b, match)
    if not pairs:
        return a, a.moved(a.points, a.colors, b.background)
    layers = [_layer_ends(a, b, i, j, lone) for i, j in pairs]
    starts, ends = [layer[0] for layer in layers], [layer[1] for layer in layers]
    start = Drawing.from_outlines(
        [layer.rows() for layer in starts],
        [layer.color for layer in starts],
        a.size,
        a.background,
        stages=[b.stages[j] if i is None else a.stages[i] for i, j in pairs],
        names=[(a.names[i] if i is not None else "") or (b.names[j] if j is not None else "") for i, j in pairs],
        groups=[(() if i is None else a.groups[i]) or (() if j is None else b.groups[j]) for i, j in pairs],
        fills=concatenate_fills([layer.fills for layer in starts]),
        strokes=concatenate_strokes([layer.strokes for layer in starts]),
    )
    points = np.concatenate([rows for layer in ends for rows in layer.rows()])
    last = concatenate_fills([layer.fills for layer in ends])
    fills = start.fills.moved(last.geometry, last.stop_positions, last.stop_colors)
    pens = concatenate_strokes([layer.strokes for layer in ends])
    strokes = start.strokes.moved(pens.widths, pens)
    return start, start.moved(points, np.array([layer.color for layer in ends]), b.background, fills, strokes)


def mix_colors(a: ArrayLike, b: ArrayLike, t: float) -> FloatArray:
    """Mix straight colours (..., 4), linearly in premultiplied form, with weight `t` of the second.

    Returns
    -------
    (..., 4) float64
        Straight RGBA; exactly `a` at 0 and `b` at 1.

    Notes
    -----
    A layer of colour c and opacity o turns the colour C below it into o c + (1 - o) C. For fixed shapes this is the
    weighted mean of both end pictures exactly if o c and o are such means: so o = (1 - t) o_a + t o_b and
    c = ((1 - t) o_a c_a + t o_b c_b) / o. With w = t o_b / o that is (1 - w) c_a + w c_b, a mean weighted by opacity: a
    fading layer keeps its colour. If o = 0, w = t.
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    opacity = _mix(a[..., 3:], b[..., 3:], t)
    share = np.where(opacity > 0, t * b[..., 3:] / np.where(opacity > 0, opacity, 1), t)
    return np.concatenate([_mix(a[..., :3], b[..., :3], share), opacity], axis=-1)


def fit_canvas(drawing: Drawing, size: tuple[int, int]) -> Drawing:
    """Scale a drawing uniformly to fit into a canvas (height, width) px, and centre it."""
    scale = min(new / old for new, old in zip(size, drawing.size, strict=True))
    margin = [(new - scale * old) / 2 for new, old in zip(size, drawing.size, strict=True)]
    return stretched(drawing, scale, size, margin[::-1])


def collapsed(drawing: Drawing) -> Drawing:
    """Return the drawing with every layer collapsed to the middle of its box, so that none is visible."""
    boxes = layer_boxes(drawing)
    middles = (boxes[:, :2] + boxes[:, 2:]) / 2
    points = np.broadcast_to(middles[drawing.segment_layers][:, None], drawing.points.shape)
    return drawing.replace(points=points, strokes=_thin(drawing.strokes))


def _between(start: Drawing, end: Drawing, t: float) -> Drawing:
    """Mix two drawings of one structure."""
    background = start.background
    if background is not None and end.background is not None:
        background = _mix(background, end.background, t)
    first, last = start.fills, end.fills
    fills = first.moved(
        mix_geometry(first, last, t),
        _mix(first.stop_positions, last.stop_positions, t),
        mix_colors(first.stop_colors, last.stop_colors, t),
    )
    nearer = start.strokes if t < 0.5 else end.strokes
    strokes = start.strokes.moved(_mix(start.strokes.widths, end.strokes.widths, t), nearer)
    colors = mix_colors(start.colors, end.colors, t)
    return start.moved(_mix(start.points, end.points, t), colors, background, fills, strokes)


def _mix(a: FloatArray, b: FloatArray, t: float | FloatArray) -> FloatArray:
    """Return (1 - t) a + t b, exact at both ends and where they are equal."""
    return np.where(a == b, a, (1 - t) * a + t * b)


def _layer_ends(a: Drawing, b: Drawing, i: int | None, j: int | None, lone: Lone) -> tuple[_Layer, _Layer]:
    """Return a layer at both ends: a matched pair, or a single layer and its invisible form."""
    if i is not None and j is not None:
        return _pair(_layer(a, i), _layer(b, j))
    if i is not None:
        return _layer(a, i), _absent(_layer(a, i), lone)
    assert j is not None, "each pair has a layer"
    return _absent(_layer(b, j), lone), _layer(b, j)


def _pair(first: _Layer, second: _Layer) -> tuple[_Layer, _Layer]:
    """Return two layers, both filled or both stroked, with subpaths, segments and stops that correspond."""
    if first.strokes.any:
        lines = [
            [StrokeLine(cubics, bool(opened)) for cubics, opened in zip(own.outline, own.strokes.is_open, strict=True)]
            for own in (first, second)
        ]
        aligned = align_lines(*lines)
        outlines = [[line.cubics for line in own] for own in aligned]
        opened = np.array([line.is_open for line in aligned[0]])
    else:
        outlines = list(align(first.outline, second.outline))
        opened = np.zeros(len(outlines[0]), bool)
    fills = paired_fills(
        first.fills,
        second.fills,
        (first.color, second.color),
        (bezier.outline_bounds(outlines[0]), bezier.outline_bounds(outlines[1])),
    )
    ends = [
        _Layer(outline, own.color, fill, dataclasses.replace(own.strokes, is_open=opened))
        for own, outline, fill in zip((first, second), outlines, fills, strict=True)
    ]
    return ends[0], ends[1]


def _absent(layer: _Layer, lone: Lone) -> _Layer:
    """Return an invisible layer: collapsed to the middle of its box, or transparent."""
    if lone == "fade":
        clear = layer.fills.stop_colors * (1.0, 1.0, 1.0, 0.0)
        return layer._replace(color=np.append(layer.color[:3], 0.0), fills=layer.fills.with_numbers(stop_colors=clear))
    bounds = bezier.outline_bounds(layer.outline)
    middle = (bounds[:2] + bounds[2:]) / 2
    collapsed_paths = [np.broadcast_to(middle, subpath.shape) for subpath in layer.outline]
    return layer._replace(outline=collapsed_paths, strokes=_thin(layer.strokes))


def _thin(strokes: Strokes) -> Strokes:
    """Return strokes that are too thin to be visible."""
    return strokes.with_widths(np.where(strokes.widths > 0, THIN, 0.0)) if strokes.any else strokes


def _layer(drawing: Drawing, layer: int) -> _Layer:
    first, last = drawing.layer_offsets[layer : layer + 2]
    opened = drawing.strokes.is_open[first:last].tolist()
    outline = [
        drawing.cubics[rows][: -1 if is_open else None]
        for rows, is_open in zip(drawing.subpaths(layer), opened, strict=True)
    ]
    pen = drawing.strokes.subset([layer], np.arange(first, last))
    return _Layer(outline, drawing.colors[layer], drawing.fills.subset([layer]), pen)
