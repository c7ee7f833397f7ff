# SPDX-License-Identifier: Apache-2.0
"""Interpolation of fills: convert two to the same kind and number of stops, without changing their look; mix them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.drawing.fills import LINEAR, MAX_COORDINATE, RADIAL, SOLID, Fills

#: Half axis, px, across its direction, of the radial gradient that represents a linear one. At y px from the middle
#: line and x px from the centre, its lines of equal colour are off by less than (r y / FAR)^2 / 2x, with r the other
#: half axis: 0.06 px for r and y of 1500 and 1000, and x of 500.
FAR = 2e5


def paired_fills(
    a: Fills, b: Fills, colors: tuple[FloatArray, FloatArray], boxes: tuple[FloatArray, FloatArray]
) -> tuple[Fills, Fills]:
    """Return the fills of two layers as fills of one kind with the same number of stops, looking as before.

    A solid fill becomes a gradient like the other, with all stops of its colour. A linear gradient paired with a radial
    one becomes the radial gradient of a long ellipse. Of linear gradients in opposite directions one is reversed. If
    the numbers of stops differ, each gets stops where the other has one.

    Parameters
    ----------
    a, b : Fills
        Of one layer each.
    colors : two of (4,)
        Straight RGBA of the layers, used if they are solid.
    boxes : two of (4,)
        Bounding box (x0, y0, x1, y1) of each layer, px.
    """
    kinds = int(a.kinds[0]), int(b.kinds[0])
    if kinds == (SOLID, SOLID):
        return a, b
    if kinds[0] == SOLID:
        return _in_one_color(b, colors[0]), b
    if kinds[1] == SOLID:
        return a, _in_one_color(a, colors[1])
    if kinds == (LINEAR, LINEAR):
        along = [fills.geometry[0, 1] - fills.geometry[0, 0] for fills in (a, b)]
        return _with_same_stops(a, _turned(b) if along[0] @ along[1] < 0 else b)
    first, second = (
        _upright(fills) if kind == RADIAL else _as_radial(fills, box)
        for fills, kind, box in zip((a, b), kinds, boxes, strict=True)
    )
    return _with_same_stops(first, second)


def mix_geometry(a: Fills, b: Fills, t: float) -> FloatArray:
    """Mix the points of fills of the same kinds, of :func:`paired_fills`: (N, 3, 2).

    Points are mixed linearly. If one of two ellipses represents a linear gradient, the inverse E^-1 of the matrix of
    axes is mixed instead, so that ``t = |E^-1 (p - c)|`` of a pixel changes evenly.
    """
    geometry = np.where(a.geometry == b.geometry, a.geometry, (1 - t) * a.geometry + t * b.geometry)
    axes = [fills.geometry[:, 1:] - fills.geometry[:, :1] for fills in (a, b)]
    long = [np.linalg.norm(own, axis=2).max(axis=1) >= FAR / 2 for own in axes]
    for layer in np.flatnonzero((a.kinds == RADIAL) & (long[0] != long[1])).tolist():
        inverse = (1 - t) * np.linalg.inv(axes[0][layer]) + t * np.linalg.inv(axes[1][layer])
        geometry[layer, 1:] = geometry[layer, 0] + np.linalg.inv(inverse)
    return np.clip(geometry, -MAX_COORDINATE, MAX_COORDINATE)


def _in_one_color(fills: Fills, rgba: FloatArray) -> Fills:
    return fills.with_numbers(stop_colors=np.tile(rgba, (len(fills.stop_colors), 1)))


def _turned(fills: Fills) -> Fills:
    """Return a linear gradient with its ends exchanged."""
    return Fills.linear(
        fills.geometry[0, 1], fills.geometry[0, 0], fills.stop_colors[::-1], 1 - fills.stop_positions[::-1]
    )


def _upright(fills: Fills) -> Fills:
    """Return an equal radial gradient whose axes are a symmetric positive matrix, so that mixtures are invertible.

    t = |E^-1 q| depends on E E^T only; its square root is such a matrix.
    """
    axes = (fills.geometry[0, 1:] - fills.geometry[0, 0]).T
    vectors, lengths, _ = np.linalg.svd(axes)
    lengths = np.maximum(lengths, 1e-6)
    return _radial(fills, fills.geometry[0, 0], (vectors * lengths) @ vectors.T, fills.stop_positions)


def _as_radial(fills: Fills, box: FloatArray) -> Fills:
    """Return the radial gradient of a long ellipse that looks like a linear gradient within a box (x0, y0, x1, y1).

    Its centre lies on the line of the gradient, before the box by the box's extent, so that t increases all over it.
    """
    start, end = fills.geometry[0, :2]
    length = float(np.linalg.norm(end - start))
    if not length:
        return _radial(fills, start, np.eye(2) * 1e-6, fills.stop_positions)
    along = (end - start) / length
    corners = np.array([(x, y) for x in box[::2] for y in box[1::2]]) - start
    places = corners @ along
    extent = max(length, float(np.ptp(corners, axis=0).max()))
    before = min(0.0, float(places.min())) - extent
    # The middle line passes through the box, where the ellipse differs least from a straight band.
    across = np.array([-along[1], along[0]])
    aside = float((corners @ across).mean()) * across
    radius = length - before
    axes = radius * np.outer(along, along) + FAR * np.outer(across, across)
    positions = (fills.stop_positions * length - before) / radius
    return _radial(fills, start + before * along + aside, axes, np.clip(positions, 0, 1))


def _radial(fills: Fills, center: FloatArray, axes: FloatArray, positions: FloatArray) -> Fills:
    """Return a radial gradient with the columns of a matrix as axes, and the stops' colours of another."""
    return Fills.radial(center, center + axes[:, 0], center + axes[:, 1], fills.stop_colors, positions)


def _with_same_stops(a: Fills, b: Fills) -> tuple[Fills, Fills]:
    """Return gradients with equal numbers of stops; if they differ, each gets stops where only the other has one."""
    if len(a.stop_positions) == len(b.stop_positions):
        return a, b
    places = np.union1d(a.stop_positions, b.stop_positions)
    counts = np.max([[np.count_nonzero(fills.stop_positions == place) for place in places] for fills in (a, b)], axis=0)
    first, second = (_with_stops(fills, places, counts) for fills in (a, b))
    return first, second


def _with_stops(fills: Fills, places: FloatArray, counts: NDArray[np.int64]) -> Fills:
    """Return a gradient with `counts` stops at each of `places`, keeping its colours and its own stops."""
    rows = []
    for place, count in zip(places.tolist(), counts.tolist(), strict=True):
        own = fills.stop_colors[fills.stop_positions == place]
        if not len(own):
            own = _color_at(fills, place)[None]
        rows += [*own, *[own[-1]] * (count - len(own))]
    return Fills(
        kinds=fills.kinds,
        geometry=fills.geometry,
        stop_offsets=[0, len(rows)],
        stop_positions=np.repeat(places, counts),
        stop_colors=rows,
    )


def _color_at(fills: Fills, place: float) -> FloatArray:
    """Return the straight RGBA between stops: (4,)."""
    return np.array([np.interp(place, fills.stop_positions, channel) for channel in fills.stop_colors.T])
