# SPDX-License-Identifier: Apache-2.0
"""`Fills`: the fills of a drawing's layers, solid, linear or radial, in packed arrays."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, Int32Array
from livecl.drawing.checks import checked_floats, checked_integers

#: Kinds of fills.
SOLID, LINEAR, RADIAL = 0, 1, 2
KINDS = ("solid", "linear", "radial")
#: Largest coordinate accepted, px: beyond it float32 no longer resolves a sixteenth of a pixel.
MAX_COORDINATE = 1e6
#: Decimals of a stop's offset in SVG.
POSITION_DECIMALS = 4


@dataclasses.dataclass(frozen=True, eq=False, init=False)
class Fills:
    """Fills of N layers; the solid ones' colours are the drawing's.

    A gradient maps a number t to a colour: between stops, straight sRGB components and opacity are linear in t; beyond
    the first and the last one, they are constant (SVG's ``pad``). For a linear gradient with points p0, p1, and for a
    radial one with centre c and the ends e1, e2 of two axes, a pixel centre p has

        t = (p - p0) . (p1 - p0) / |p1 - p0|^2        t = |E^-1 (p - c)|,  E the matrix of columns e1 - c, e2 - c.

    If p0 = p1, or E has no inverse, everything has the last stop's colour, as in SVG. Of stops at the same t, the last
    one counts beyond it. The arrays are read-only copies.

    Parameters
    ----------
    kinds : (N,) array_like of int
        SOLID (0), LINEAR (1) or RADIAL (2) for each layer.
    geometry : (N, 3, 2) array_like
        Points (x, y), px, y down. Linear: p0, p1 and zeros. Radial: c, e1, e2. Solid: zeros.
    stop_offsets : (N + 1,) array_like of int
        Layer n has the stops ``stop_offsets[n]:stop_offsets[n + 1]``: at least two for a gradient, none if solid.
    stop_positions : (S,) array_like
        t of each stop, in [0, 1]; not decreasing within a layer.
    stop_colors : (S, 4) array_like
        Straight RGBA in [0, 1] of each stop.

    Raises
    ------
    ValueError
        If shapes, offsets or numbers do not fit together; the message names the argument.
    """

    kinds: Int32Array
    geometry: FloatArray
    stop_offsets: Int32Array
    stop_positions: FloatArray
    stop_colors: FloatArray

    def __init__(
        self,
        *,
        kinds: ArrayLike,
        geometry: ArrayLike,
        stop_offsets: ArrayLike,
        stop_positions: ArrayLike,
        stop_colors: ArrayLike,
    ) -> None:
        kinds = checked_integers("fills.kinds", kinds)
        if kinds.ndim != 1 or np.any((kinds < SOLID) | (kinds > RADIAL)):
            raise ValueError(f"fills.kinds: got {kinds}, wanted 0 (solid), 1 (linear) or 2 (radial) for each layer")
        num = len(kinds)
        geometry = checked_floats("fills.geometry", geometry, (num, 3, 2), -MAX_COORDINATE, MAX_COORDINATE)
        geometry[kinds == SOLID] = 0
        geometry[kinds == LINEAR, 2] = 0
        positions = checked_floats("fills.stop_positions", stop_positions, (-1,), 0.0, 1.0)
        colors = checked_floats("fills.stop_colors", stop_colors, (len(positions), 4), 0.0, 1.0)
        offsets = checked_integers("fills.stop_offsets", stop_offsets)
        if offsets.shape != (num + 1,) or offsets[0] != 0 or offsets[-1] != len(positions):
            raise ValueError(f"fills.stop_offsets: wanted {num + 1} offsets from 0 to {len(positions)}")
        counts = np.diff(offsets)
        if np.any(np.where(kinds == SOLID, counts != 0, counts < 2)):
            raise ValueError("fills.stop_offsets: wanted two or more stops for each gradient, and none for solid fills")
        inside = np.ones(max(len(positions) - 1, 0), bool)
        inside[offsets[(offsets > 0) & (offsets < len(positions))] - 1] = False
        if np.any(np.diff(positions)[inside] < 0):
            raise ValueError("fills.stop_positions: must not decrease within a layer")
        self._hold(kinds, geometry, offsets, positions, colors)

    def _hold(self, *arrays: NDArray[Any]) -> None:
        for field, array in zip(dataclasses.fields(self), arrays, strict=True):
            array.setflags(write=False)
            self.__dict__[field.name] = array

    @classmethod
    @functools.lru_cache(maxsize=256)
    def solid(cls, num_layers: int) -> Fills:
        """Return the fills of solid layers."""
        return cls(
            kinds=np.zeros(num_layers),
            geometry=np.zeros((num_layers, 3, 2)),
            stop_offsets=np.zeros(num_layers + 1),
            stop_positions=np.zeros(0),
            stop_colors=np.zeros((0, 4)),
        )

    @classmethod
    def linear(cls, p0: ArrayLike, p1: ArrayLike, colors: ArrayLike, positions: ArrayLike | None = None) -> Fills:
        """Return one layer's linear gradient from `p0` to `p1`, px; stops (K, 4), by default at even steps.

        Examples
        --------
        >>> fill = Fills.linear((0, 0), (8, 0), [(1, 0, 0, 1), (0, 0, 1, 1)])
        >>> fill.colors_at(0, np.array([(2.0, 5.0)])).tolist()
        [[0.75, 0.0, 0.25, 1.0]]
        """
        return cls._one(LINEAR, [p0, p1, (0.0, 0.0)], colors, positions)

    @classmethod
    def radial(
        cls, center: ArrayLike, end1: ArrayLike, end2: ArrayLike, colors: ArrayLike, positions: ArrayLike | None = None
    ) -> Fills:
        """Return one layer's radial gradient of an ellipse: centre and ends of two axes, px; stops as for `linear`."""
        return cls._one(RADIAL, [center, end1, end2], colors, positions)

    @classmethod
    def _one(cls, kind: int, points: list[ArrayLike], colors: ArrayLike, positions: ArrayLike | None) -> Fills:
        stops = np.asarray(colors, dtype=np.float64)
        return cls(
            kinds=[kind],
            geometry=np.asarray([points], dtype=np.float64),
            stop_offsets=[0, len(stops)],
            stop_positions=np.linspace(0, 1, len(stops)) if positions is None else positions,
            stop_colors=stops,
        )

    def __len__(self) -> int:
        """Return the number of layers, N."""
        return len(self.kinds)

    @functools.cached_property
    def any_gradients(self) -> bool:
        """Whether any layer is not solid."""
        return bool(self.kinds.any())

    @functools.cached_property
    def gradient_layers(self) -> NDArray[np.intp]:
        """Indices of the layers that are not solid, ascending: (K,)."""
        return np.flatnonzero(self.kinds)

    @functools.cached_property
    def stop_layers(self) -> Int32Array:
        """Layer of each stop: (S,)."""
        return np.repeat(np.arange(len(self), dtype=np.int32), np.diff(self.stop_offsets))

    @functools.cached_property
    def stop_ranks(self) -> Int32Array:
        """Number of each stop within its layer: (S,)."""
        return np.arange(len(self.stop_layers), dtype=np.int32) - self.stop_offsets[self.stop_layers]

    @functools.cached_property
    def end_stops(self) -> tuple[Int32Array, Int32Array]:
        """First and last stop of each gradient: (K,) both."""
        return self.stop_offsets[self.gradient_layers], self.stop_offsets[self.gradient_layers + 1] - 1

    def stops(self, layer: int) -> slice:
        """Return the slice of `stop_positions` and `stop_colors` of a layer."""
        return slice(int(self.stop_offsets[layer]), int(self.stop_offsets[layer + 1]))

    def opacity(self, layer: int) -> float | None:
        """Return the opacity of a layer's gradient if it is uniform, else None."""
        alphas = self.stop_colors[self.stops(layer), 3]
        return float(alphas[0]) if (alphas == alphas[0]).all() else None

    def colors_at(self, layer: int, points: FloatArray) -> FloatArray:
        """Return the straight RGBA (n, 4) of a layer's gradient at points (n, 2), px."""
        own = self.stops(layer)
        t = place_of(int(self.kinds[layer]), self.geometry[layer], points)
        return stop_colors_at(self.stop_positions[own], self.stop_colors[own], t)

    def moved(self, geometry: FloatArray, stop_positions: FloatArray, stop_colors: FloatArray) -> Fills:
        """Return fills of the same kinds with other numbers, unchecked, for inner loops.

        The arrays are not copied; the caller must not change them afterwards.
        """
        fills = object.__new__(Fills)
        fills.__dict__.update(self.__dict__, geometry=geometry, stop_positions=stop_positions, stop_colors=stop_colors)
        return fills

    def subset(self, layers: ArrayLike) -> Fills:
        """Return the fills of some layers, by index (K,)."""
        layers = np.asarray(layers, dtype=np.int64)
        counts = np.diff(self.stop_offsets)[layers]
        stops = self.stop_rows(layers)
        return Fills(
            kinds=self.kinds[layers],
            geometry=self.geometry[layers],
            stop_offsets=np.concatenate([[0], np.cumsum(counts)]),
            stop_positions=self.stop_positions[stops],
            stop_colors=self.stop_colors[stops],
        )

    def stop_rows(self, layers: ArrayLike) -> NDArray[np.int64]:
        """Return the indices of the stops of some layers (K,), in their order."""
        rows = [np.arange(self.stop_offsets[n], self.stop_offsets[n + 1]) for n in np.asarray(layers, dtype=np.int64)]
        return np.concatenate([np.zeros(0, np.int64), *rows])

    def stretched(self, factors: ArrayLike, offset: ArrayLike = (0.0, 0.0)) -> Fills:
        """Return the fills on a stretched canvas, where each point (x, y) moves to ``factors * (x, y) + offset``.

        So do ends of axes, and the lines of equal colour of a linear gradient; but these are then no longer
        perpendicular to p1 - p0: the row g for which t = g . (p - p0) becomes g / factors, and p1 becomes p0 + g /
        |g|^2.
        """
        factors, offset = np.broadcast_to(factors, 2), np.asarray(offset)
        geometry = np.where(self.kinds[:, None, None] == SOLID, self.geometry, self.geometry * factors + offset)
        linear = self.kinds == LINEAR
        if linear.any() and factors[0] != factors[1]:
            along = self.geometry[linear, 1] - self.geometry[linear, 0]
            square = (along**2).sum(axis=1, keepdims=True)
            row = along / np.where(square > 0, square, 1) / factors
            square = (row**2).sum(axis=1, keepdims=True)
            geometry[linear, 1] = geometry[linear, 0] + row / np.where(square > 0, square, 1)
        return self.with_numbers(geometry=np.clip(geometry, -MAX_COORDINATE, MAX_COORDINATE))

    def quantized(self, precision: int) -> Fills:
        """Return the fills as in a saved SVG: geometry rounded to `precision` decimals, stops to 8 bits."""
        return self.with_numbers(
            geometry=np.round(self.geometry, precision) + 0.0,
            stop_positions=np.round(self.stop_positions, POSITION_DECIMALS),
            stop_colors=np.round(self.stop_colors * 255) / 255,
        )

    def with_numbers(self, **changes: Any) -> Fills:
        """Return a copy with other geometry, stop positions or stop colours, checked."""
        return dataclasses.replace(self, **changes) if self.any_gradients else self

    def mean_colors(self) -> FloatArray:
        """Return the straight RGBA of each gradient, averaged premultiplied over t in [0, 1]: (K, 4).

        It represents a gradient where a single colour is needed. A is 1 only if all stops are opaque.
        """
        if not self.any_gradients:
            return np.zeros((0, 4))
        t, rgb, alphas = self.stop_positions, self.stop_colors[:, :3], self.stop_colors[:, 3]
        first, last = self.end_stops
        # Trapezoidal rule over the stops, extended to 0 and 1; exact except for products of slopes. Solid layers have
        # no stops, so each gradient's begin where those of the one before end.
        halves = (t[1:] - t[:-1]) / 2
        halves[first[1:] - 1] = 0
        weights = np.zeros(len(t))
        weights[:-1] += halves
        weights[1:] += halves
        weights[first] += t[first]
        weights[last] += 1 - t[last]
        weighted = weights * alphas
        mean, plain = np.add.reduceat(weighted, first)[:, None], np.add.reduceat(weights[:, None] * rgb, first)
        colors = np.add.reduceat(weighted[:, None] * rgb, first)
        colors = np.where(mean > 0, colors / np.where(mean > 0, mean, 1), plain)
        opaque = np.minimum.reduceat(alphas, first)[:, None] == 1
        return np.clip(np.concatenate([colors, np.where(opaque, 1.0, np.minimum(mean, 1 - 1e-9))], axis=1), 0, 1)


def place_of(kind: int, geometry: FloatArray, points: FloatArray) -> FloatArray:
    """Return t at points (n, 2), px, of a gradient of a geometry (3, 2), not clamped to [0, 1].

    A degenerate one has 2 everywhere, beyond all stops.
    """
    offset = points - geometry[0]
    if kind == LINEAR:
        along = geometry[1] - geometry[0]
        square = float(along @ along)
        return np.asarray(offset @ along / square) if square > 0 else np.full(len(points), 2.0)
    (a, c), (b, d) = geometry[1:] - geometry[0]
    determinant = a * d - b * c
    if not determinant:
        return np.full(len(points), 2.0)
    across = offset @ (np.array([[d, -c], [-b, a]]) / determinant)
    across *= across
    return np.asarray(np.sqrt(across[:, 0] + across[:, 1]))


def stop_colors_at(positions: FloatArray, colors: FloatArray, t: FloatArray) -> FloatArray:
    """Return the straight RGBA (n, 4) at t (n,) of stops at positions (K,) with colours (K, 4)."""
    piece = np.clip(np.searchsorted(positions, t, side="right"), 1, len(positions) - 1) - 1
    widths, changes = np.diff(positions), np.diff(colors, axis=0)
    share = np.clip((t - positions[piece]) / np.where(widths > 0, widths, 1)[piece], 0, 1)
    if not (widths > 0).all():
        share = np.where(widths[piece] > 0, share, t >= positions[piece + 1])
    found = changes.take(piece, axis=0)
    found *= share[:, None]
    found += colors.take(piece, axis=0)
    return np.asarray(found)


def concatenate_fills(parts: Sequence[Fills]) -> Fills:
    """Concatenate the fills of the layers of several drawings."""
    starts = itertools.accumulate((len(part.stop_positions) for part in parts), initial=0)
    return Fills(
        kinds=np.concatenate([part.kinds for part in parts]),
        geometry=np.concatenate([part.geometry for part in parts]),
        stop_offsets=np.concatenate(
            [[0], *(start + part.stop_offsets[1:] for start, part in zip(starts, parts, strict=False))]
        ),
        stop_positions=np.concatenate([part.stop_positions for part in parts]),
        stop_colors=np.concatenate([part.stop_colors for part in parts]),
    )


def checked_fills(fills: Fills | None, num_layers: int) -> Fills:
    """Return fills that fit a number of layers; None and all solid fills fit any."""
    if fills is None:
        return Fills.solid(num_layers)
    if not isinstance(fills, Fills):
        raise ValueError(f"fills: got {type(fills).__name__}, wanted livecl.drawing.Fills")
    if len(fills) != num_layers:
        if not fills.any_gradients:
            return Fills.solid(num_layers)
        raise ValueError(f"fills: got those of {len(fills)} layers, wanted {num_layers}")
    return fills
