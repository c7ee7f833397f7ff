# SPDX-License-Identifier: Apache-2.0
"""Merge a shape and the ring around it into one outline with a fill and a stroke, if that is cheaper.

A shape with an outline is found as two shapes, a larger one beneath a smaller one. If the visible part of the larger
one is a ring of even width, both become one outline, along the middle of the ring, with a fill and a stroke. Each
number that this saves may cost some error, as everywhere (`SEGMENT_ERROR`, of six numbers).
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.assembly import outlines_of, with_outlines
from livecl.drawing.borders import border_pairs
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID
from livecl.drawing.strokes import Strokes
from livecl.editing.polish import polished
from livecl.geometry import bezier, cyclic
from livecl.geometry.offsetting import offset_outline
from livecl.geometry.outlines import Outline, reversed_path
from livecl.geometry.strokes import MITER, ROUND
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas, visible_shares
from livecl.layering.strokes.thinning import worth


@dataclasses.dataclass(frozen=True, kw_only=True)
class RingRules:
    """Thresholds that define a ring of even width around a shape.

    Values: chosen by hand; with them, and no others, the drawings of docs/strokes.md, "Outlines around fills", were
    measured.
    """

    along: float = 1.5  # sampling step, px, along an outline
    step: float = 0.25  # sampling step, px, across the ring
    edge: float = 1.5  # distance, px, within which an edge blurs the visible part
    seen: float = 0.5  # least visible share of a pixel of a ring
    shown: float = 0.5  # least share of the outline beside which the ring is visible
    even: float = 0.75  # least share of that with the usual width
    slack: float = 0.5  # largest deviation from the usual width, px ...
    share: float = 0.15  # ... or as a share of it
    widest: float = 0.12  # largest width, as a share of the picture's shorter side
    blunt: tuple[float, ...] = (0.0, 0.4)  # lengths, in widths, of segments left out in turn: ends of cut-off corners
    hope: float = 0.02  # least share of the error added by strokes that remains after training
    inside: float = 0.97  # share of a layer's area within another one from which it counts as inside


RINGS = RingRules()


def bordered(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> tuple[Drawing, NDArray[np.intp]]:
    """Turn rings around fills into strokes; return the drawing and the source of each of its layers.

    Parameters
    ----------
    context : Context
        Picture, rasterizer and options.
    drawing : Drawing
        Any drawing; the same object is returned where no outline is cheaper as a stroke.
    free : (N,) bool
        Layers that may change.
    """
    sources = np.arange(drawing.num_layers)
    layer = drawing.num_layers - 2
    while layer >= 0:
        interruption.check()
        change = _with_strokes(context, drawing, layer, free[sources])
        if change is not None:
            drawing, kept = change
            sources = sources[kept]
        layer -= 1
    return drawing, sources


def _with_strokes(
    context: Context, drawing: Drawing, ring: int, free: NDArray[np.bool_]
) -> tuple[Drawing, NDArray[np.intp]] | None:
    """Make a layer the stroke of the layers inside it; return the drawing and each layer's source.

    None if the layer is no such ring, or if the result costs more.
    """
    plain = free & (drawing.strokes.widths == 0) & (drawing.colors[:, 3] == 1)
    plain[border_pairs(drawing)] = False
    if not plain[ring] or drawing.fills.kinds[ring] != SOLID or not plain[ring + 1 :].any():
        return None
    alphas = layer_alphas(drawing, context.rasterizer)
    inner = []
    for layer in range(ring + 1, drawing.num_layers):
        interruption.check()
        own = alphas[layer].astype(np.float64)
        if plain[layer] and (own * alphas[ring]).sum() > RINGS.inside * own.sum() > 0:
            inner.append(layer)
    if not inner:
        return None
    seen = visible_shares(alphas)[ring].astype(np.float64)
    widths = {}
    for layer in inner:
        interruption.check()
        width = _ring_width(drawing, layer, seen, alphas[layer].astype(np.float64))
        if width is not None:
            widths[layer] = width
    fills = list(widths)
    if not fills:
        return None
    best: tuple[float, Drawing, NDArray[np.intp]] | None = None
    for outlines, join in itertools.product(_center_lines(drawing, ring, fills, widths), (MITER, ROUND)):
        changed, kept = _stroked(drawing, ring, outlines, widths, join)
        error = context.visible_mse(changed)
        if best is None or error < best[0]:
            best = error, changed, kept
    before = context.visible_mse(drawing)
    if best is None or RINGS.hope * (best[0] - before) >= worth(drawing, best[1]):
        return None
    _, changed, kept = best
    moved = np.zeros(changed.num_layers, bool)
    moved[[int(np.flatnonzero(kept == layer)[0]) for layer in fills]] = True
    changed = polished(context, changed, moved)
    return (changed, kept) if context.visible_mse(changed) - before < worth(drawing, changed) else None


def _ring_width(drawing: Drawing, layer: int, seen: FloatArray, inside: FloatArray) -> float | None:
    """Return the usual width, px, of a ring around a layer, given its visible share (H, W); None if uneven.

    The width is that of the ring's visible part along the normals of the layer's outline.
    """
    cubics = np.concatenate([drawing.cubics[rows] for rows in drawing.subpaths(layer)])
    places, normals = _samples(cubics)
    beside = [_at(inside, places + side * RINGS.edge * normals).mean() for side in (1, -1)]
    if beside[1] < beside[0]:
        normals = -normals
    reach = RINGS.widest * min(drawing.size)
    offsets = np.arange(-RINGS.edge, reach + 2 * RINGS.edge, RINGS.step)
    along = _at(seen, places[:, None] + offsets[:, None] * normals[:, None])  # (P, K)
    shown = along[:, (offsets > 0) & (offsets <= RINGS.edge)].max(axis=1) > RINGS.seen
    if shown.mean() < RINGS.shown:
        return None
    away = along[shown]
    peak = np.argmax(away * (offsets <= RINGS.edge), axis=1)
    after = (np.arange(len(offsets)) > peak[:, None]) & (away < RINGS.seen)
    end = np.where(after.any(axis=1), after.argmax(axis=1), len(offsets))
    counted = np.arange(len(offsets)) <= (end + round(RINGS.edge / RINGS.step))[:, None]
    widths = (away * counted).sum(axis=1) * RINGS.step
    usual = float(np.median(widths))
    even = np.abs(widths - usual) <= max(RINGS.slack, RINGS.share * usual)
    return usual if even.mean() >= RINGS.even and 0 < usual <= reach else None


def _samples(cubics: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sample cubics (m, 4, 2) at nearly even steps: points (P, 2), and the unit normals there."""
    lengths = np.abs(np.diff(cubics, axis=1)).sum(axis=(1, 2))
    counts = np.maximum(1, np.rint(lengths / RINGS.along).astype(np.int64))
    rows = np.repeat(np.arange(len(cubics)), counts)
    t = (np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[rows]
    places = np.einsum("pk,pkd->pd", bezier.bernstein(t), cubics[rows])
    ways = bezier.derivative(cubics[rows], t)
    ways = ways / np.maximum(np.hypot(*ways.T), 1e-9)[:, None]
    return places, np.stack([ways[:, 1], -ways[:, 0]], axis=1)


def _at(image: FloatArray, places: FloatArray) -> FloatArray:
    """Interpolate a picture (H, W) at places (..., 2), px, extended beyond its border."""
    found = ndimage.map_coordinates(image, places.reshape(-1, 2).T[::-1] - 0.5, order=1, mode="nearest")
    return np.asarray(found).reshape(places.shape[:-1])


def _center_lines(
    drawing: Drawing, ring: int, fills: list[int], widths: dict[int, float]
) -> Iterator[dict[int, Outline]]:
    """Yield outlines in the middle of a ring around layers: out of theirs, out of the ring's own, and between both."""
    every = outlines_of(drawing)
    inner = {layer: every[layer] for layer in fills}
    for blunt in RINGS.blunt:
        found = {layer: _offset(inner[layer], widths[layer] / 2, blunt * widths[layer]) for layer in fills}
        if all(outline is not None for outline in found.values()):
            yield {layer: outline for layer, outline in found.items() if outline is not None}
    if len(fills) != 1 or len(inner[fills[0]]) != 1 or len(drawing.subpaths(ring)) != 1:
        return
    outer = [drawing.points[drawing.subpaths(ring)[0]]]
    for blunt in RINGS.blunt:
        smaller = _offset(outer, -widths[fills[0]] / 2, blunt * widths[fills[0]])
        if smaller is not None:
            yield {fills[0]: smaller}
    both = _between(inner[fills[0]][0], outer[0])
    if both is not None:
        yield {fills[0]: [both]}


def _offset(outline: Outline, distance: float, shortest: float) -> Outline | None:
    """Return an outline at a distance outwards, px, without its segments below the `shortest`, px; None for nothing.

    Holes turn the other way round.
    """
    areas = [bezier.signed_area(np.concatenate([part, cyclic.following(part)[:, :1]], axis=1)) for part in outline]
    outwards = distance * np.sign(areas[int(np.argmax(np.abs(areas)))])
    found = [offset_outline(part, outwards, shortest) for part in outline]
    return None if any(part is None for part in found) else [part for part in found if part is not None]


def _between(inner: FloatArray, outer: FloatArray) -> FloatArray | None:
    """Return the mean of two closed subpaths of as many segments, (m, 3, 2), from their nearest anchors on."""
    if len(inner) != len(outer):
        return None
    ways = outer, reversed_path(outer)
    every = [np.roll(way, -shift, axis=0) for way in ways for shift in range(len(outer))]
    nearest = min(every, key=lambda rows: float(np.square(rows - inner).sum()))
    return np.asarray((inner + nearest) / 2)


def _stroked(
    drawing: Drawing, ring: int, outlines: dict[int, Outline], widths: dict[int, float], join: int
) -> tuple[Drawing, NDArray[np.intp]]:
    """Return a drawing without a layer, whose colour becomes the stroke of others, and each layer's source."""
    order = [
        number
        for layer in range(drawing.num_layers)
        if layer != ring
        for number in ((layer, layer) if layer in outlines else (layer,))
    ]
    kept = np.array(order, dtype=np.intp)
    is_stroke = np.append(False, kept[1:] == kept[:-1])
    old = drawing.strokes
    every = outlines_of(drawing)
    shapes = [outlines.get(layer, every[layer]) for layer in order]
    is_open = [old.is_open[slice(*drawing.layer_offsets[layer : layer + 2])] for layer in order]
    is_open = [
        np.zeros(len(shape), bool) if layer in outlines else own
        for layer, own, shape in zip(order, is_open, shapes, strict=True)
    ]
    filled = drawing.layer_subset(kept)
    colors = np.where(is_stroke[:, None], drawing.colors[ring], filled.colors)
    pens = Strokes(
        widths=np.where(is_stroke, [widths.get(layer, 0.0) for layer in order], old.widths[kept]),
        caps=np.where(is_stroke, 0, old.caps[kept]),
        joins=np.where(is_stroke, join, old.joins[kept]),
        miter_limits=np.where(is_stroke, 4.0, old.miter_limits[kept]),
        is_open=np.concatenate(is_open),
    )
    return (
        with_outlines(
            filled, shapes, colors=colors, strokes=pens, fills=drawing.fills.subset(np.where(is_stroke, ring, kept))
        ),
        kept,
    )
