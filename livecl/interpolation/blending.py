# SPDX-License-Identifier: Apache-2.0
"""Interpolation of drawings: control points and fills of matched layers, blended linearly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias, get_args, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.assembly import stretched
from livecl.drawing.canvas import layer_boxes
from livecl.drawing.drawing import WANTED_DRAWING, Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.errors import check_type
from livecl.geometry import bezier
from livecl.interpolation.alignment import CubicPaths, align
from livecl.interpolation.fills import mix_geometry, paired_fills
from livecl.interpolation.matching import Match, match_layers

#: Transitions of layers without a partner.
Lone = Literal["fade", "grow"]

FloatArray = NDArray[np.float64]
#: Outline, colour, straight RGBA, and fill.
_Layer: TypeAlias = tuple[CubicPaths, FloatArray, Fills]


@overload
def interpolate(a: Drawing, b: Drawing, t: float, *, match: Match = ..., lone: Lone = ...) -> Drawing: ...


@overload
def interpolate(
    a: Drawing, b: Drawing, t: Sequence[float], *, match: Match = ..., lone: Lone = ...
) -> list[Drawing]: ...


def interpolate(
    a: Drawing, b: Drawing, t: float | Sequence[float], *, match: Match = "order", lone: Lone = "fade"
) -> Drawing | list[Drawing]:
    """Return drawings between two.

    Parameters
    ----------
    a, b : Drawing
        On canvases of one size, both with a background or both without.
    t : float or sequence of float
        Places between `a` (0) and `b` (1).
    match : "order" or "nearest"
        Which layers belong together, see :func:`livecl.interpolation.matching.match_layers`: those of the same place
        in paint order, or those that are alike.
    lone : "fade" or "grow"
        How a layer without a partner comes or goes: by its opacity, or from and to a point in its middle (which leaves
        a hole where a large one goes).

    Returns
    -------
    Drawing, or list of Drawing
        One for each `t`, all of the same structure (:meth:`Drawing.same_structure`); stages and names are those of `a`,
        of `b` where `a` has none. At 0 and 1 they look as `a` and
        `b`, but may have more segments, and layers that are points or transparent.

    Raises
    ------
    ValueError
        If the canvases or an argument do not fit.

    Notes
    -----
    Points: ``p = (1 - t) p_a + t p_b``, after :func:`livecl.interpolation.alignment.align`. Colours are mixed
    premultiplied, see :func:`mix_colors`, and so are those of a gradient's stops, whose points and places are mixed
    like points. Fills of different kinds: :func:`livecl.interpolation.fills.paired_fills`.
    """
    places = np.atleast_1d(np.asarray(t, dtype=np.float64))
    if places.ndim != 1 or not np.all((places >= 0) & (places <= 1)):
        raise ValueError(f"t: got {t!r}, wanted a number from 0 to 1, or a sequence of them")
    start, end = correspond(a, b, match=match, lone=lone)
    drawings = [_between(start, end, float(place)) for place in places]
    return drawings[0] if np.ndim(t) == 0 else drawings


def correspond(a: Drawing, b: Drawing, *, match: Match = "order", lone: Lone = "fade") -> tuple[Drawing, Drawing]:
    """Return two drawings that look as those given, in which layers, subpaths, segments and points correspond.

    Arguments and errors are those of :func:`interpolate`; of each point and colour, it goes from that of the first
    drawing returned to that of the second.
    """
    for name, drawing in (("a", a), ("b", b)):
        check_type(name, drawing, Drawing, WANTED_DRAWING)
        if drawing.strokes.any:
            raise ValueError(f"{name}: has stroked layers, and only filled ones are interpolated")
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
        [[subpath[:, :3] for subpath in outline] for outline, _, _ in starts],
        [color for _, color, _ in starts],
        a.size,
        a.background,
        stages=[b.stages[j] if i is None else a.stages[i] for i, j in pairs],
        names=[(a.names[i] if i is not None else "") or (b.names[j] if j is not None else "") for i, j in pairs],
        fills=concatenate_fills([fills for _, _, fills in starts]),
    )
    start = start.replace(
        groups=[(() if i is None else a.groups[i]) or (() if j is None else b.groups[j]) for i, j in pairs]
    )
    points = np.concatenate([subpath[:, :3] for outline, _, _ in ends for subpath in outline])
    last = concatenate_fills([fills for _, _, fills in ends])
    fills = start.fills.moved(last.geometry, last.stop_positions, last.stop_colors)
    return start, start.moved(points, np.array([color for _, color, _ in ends]), b.background, fills)


def mix_colors(a: ArrayLike, b: ArrayLike, t: float) -> FloatArray:
    """Mix straight colours so that premultiplied ones are mixed linearly.

    Parameters
    ----------
    a, b : (..., 4) array_like
        Straight RGBA in [0, 1].
    t : float
        Share of `b`, from 0 to 1.

    Returns
    -------
    (..., 4) float64
        Straight RGBA; exactly `a` at 0 and `b` at 1.

    Notes
    -----
    A layer of colour c and opacity o makes o c + (1 - o) C out of the colour C below it. For fixed shapes this is the
    mean of its two end pictures, (1 - t) and t of each, exactly if o c and o are such means: so
    o = (1 - t) o_a + t o_b and c = ((1 - t) o_a c_a + t o_b c_b) / o. With w = t o_b / o that is (1 - w) c_a + w c_b,
    a mean weighted by opacity: a fading layer keeps its colour. Where o = 0, w = t.
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    opacity = _mix(a[..., 3:], b[..., 3:], t)
    share = np.where(opacity > 0, t * b[..., 3:] / np.where(opacity > 0, opacity, 1), t)
    return np.concatenate([_mix(a[..., :3], b[..., :3], share), opacity], axis=-1)


def fit_canvas(drawing: Drawing, size: tuple[int, int]) -> Drawing:
    """Return a drawing scaled evenly, as large as it fits, into the middle of a canvas of another size.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    size : (int, int)
        Height and width of the canvas wanted, px.
    """
    scale = min(new / old for new, old in zip(size, drawing.size, strict=True))
    margin = [(new - scale * old) / 2 for new, old in zip(size, drawing.size, strict=True)]
    return stretched(drawing, scale, size, margin[::-1])


def collapsed(drawing: Drawing) -> Drawing:
    """Return the drawing with every layer collapsed to the middle of its box, so that nothing is visible."""
    boxes = layer_boxes(drawing)
    middles = (boxes[:, :2] + boxes[:, 2:]) / 2
    points = np.broadcast_to(middles[drawing.segment_layers][:, None], drawing.points.shape)
    return drawing.replace(points=points)


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
    return start.moved(_mix(start.points, end.points, t), mix_colors(start.colors, end.colors, t), background, fills)


def _mix(a: FloatArray, b: FloatArray, t: float | FloatArray) -> FloatArray:
    """Return (1 - t) a + t b, exact at both ends and where they are equal."""
    return np.where(a == b, a, (1 - t) * a + t * b)


def _layer_ends(a: Drawing, b: Drawing, i: int | None, j: int | None, lone: Lone) -> tuple[_Layer, _Layer]:
    """Return a layer's outline and fill at both ends: those of a pair, or of one layer and its absence."""
    if i is not None and j is not None:
        first, second = align(_outline(a, i), _outline(b, j))
        fills = paired_fills(
            a.fills.subset([i]), b.fills.subset([j]), (a.colors[i], b.colors[j]), (_box(first), _box(second))
        )
        return (first, a.colors[i], fills[0]), (second, b.colors[j], fills[1])
    if i is not None:
        going = (_outline(a, i), a.colors[i], a.fills.subset([i]))
        return going, _absent(going, lone)
    assert j is not None, "each pair has a layer"
    coming = (_outline(b, j), b.colors[j], b.fills.subset([j]))
    return _absent(coming, lone), coming


def _absent(layer: _Layer, lone: Lone) -> _Layer:
    """Return an invisible layer: collapsed to the middle of its box, or transparent."""
    outline, color, fills = layer
    if lone == "fade":
        clear = fills.stop_colors * (1.0, 1.0, 1.0, 0.0)
        return outline, np.append(color[:3], 0.0), fills.with_numbers(stop_colors=clear)
    bounds = _box(outline)
    middle = (bounds[:2] + bounds[2:]) / 2
    return [np.broadcast_to(middle, subpath.shape) for subpath in outline], color, fills


def _box(outline: CubicPaths) -> FloatArray:
    """Return the box of an outline's control points: (x0, y0, x1, y1), px."""
    return bezier.hull_bounds(np.concatenate(outline).reshape(-1, 2))


def _outline(drawing: Drawing, layer: int) -> CubicPaths:
    return [drawing.cubics[subpath] for subpath in drawing.subpaths(layer)]
