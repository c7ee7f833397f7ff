# SPDX-License-Identifier: Apache-2.0
"""Gradient fill fitting: one colour, a linear or a radial gradient for pixels, by least squares and description length.

Prices are in squared error, summed over the pixels and colour channels. A fill is described by numbers: 4 for a colour;
4 for the line of a linear gradient or 6 for the ellipse of a radial one, and 5 for each stop. The fill of least squared
error plus price of its numbers is chosen.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.fills import KINDS, LINEAR, RADIAL, SOLID, Fills, place_of, stop_colors_at
from livecl.layering.fills.geometries import SEARCH_PIXELS, pattern_searches, radial_geometries
from livecl.layering.fills.stops import STOP_NUMBERS, Pixels, Ramps, fit_ramp

#: Numbers of a layer of one colour and four segments, which together cost `Options.prune`.
LAYER_NUMBERS = 28
#: Numbers that describe the geometry of a fill, by kind; numbers of a colour.
GEOMETRY_NUMBERS, COLOR_NUMBERS = (0, 4, 6), 4
#: Pixels of the smallest picture in which the price of a number is a share of the picture: 240 x 240.
LEAST_PRICED = 57600
#: Most pixels used by a fit.
MAX_PIXELS = 4000
#: Fits kept, by their pixels up to a shift and what else they depend on: those of a core are asked for several times,
#: when it is cut, compared with its parts and absorbed.
MOST_KNOWN = 256
_KNOWN: dict[bytes, Paint] = {}
#: Mean squared error of a channel at which a fit cannot improve: rounding to 8 bits (.29 of a level), with a margin.
NOISE = (0.45 / 255) ** 2


@dataclasses.dataclass(frozen=True)
class Shading:
    """Kinds of gradients that layers may have, "linear" and "radial", and the price of a number.

    The price is in mean squared error over all pixels and three channels.
    """

    kinds: tuple[str, ...]
    price: float

    def price_in(self, num_pixels: int) -> float:
        """Return the price of a number in a picture, as squared error summed over pixels and channels.

        In pictures of fewer than `LEAST_PRICED` pixels it is the price for that size: otherwise a single edge pixel
        would pay for a gradient.
        """
        return self.price * 3 * max(num_pixels, LEAST_PRICED)


@dataclasses.dataclass(frozen=True, eq=False)
class Paint:
    """Fill fitted to the pixels of one layer.

    Attributes
    ----------
    kind : int
        SOLID, LINEAR or RADIAL.
    color : (4,)
        The best single colour, straight RGBA.
    geometry : (3, 2)
        As in :class:`livecl.drawing.fills.Fills`; zeros if solid.
    positions, stops : (K,), (K, 4)
        Places and straight RGBA of the stops; none if solid.
    error : float
        Squared error that is left, weighted, over pixels and channels.
    over : tuple of Paint
        Translucent fills above it on the same outline, the lowest first: each a layer of its own.
    """

    kind: int
    color: FloatArray
    geometry: FloatArray
    positions: FloatArray
    stops: FloatArray
    error: float
    over: tuple[Paint, ...] = ()

    @property
    def numbers(self) -> int:
        """Count of the numbers that describe it, and the overlays above it."""
        own = GEOMETRY_NUMBERS[self.kind] + (STOP_NUMBERS * len(self.stops) or COLOR_NUMBERS)
        return own + sum(LAYER_NUMBERS - COLOR_NUMBERS + paint.numbers for paint in self.over)

    @property
    def solid(self) -> bool:
        """Whether it is a single colour."""
        return self.kind == SOLID and not self.over

    @property
    def fills(self) -> Fills:
        """The fill as that of one layer, without overlays."""
        if self.kind == SOLID:
            return Fills.solid(1)
        first, second, third = self.geometry
        if self.kind == LINEAR:
            return Fills.linear(first, second, self.stops, self.positions)
        return Fills.radial(first, second, third, self.stops, self.positions)

    def shifted(self, offset: FloatArray) -> Paint:
        """Return the fill translated by (2,), px."""
        geometry = self.geometry + offset * (np.arange(3) < GEOMETRY_NUMBERS[self.kind] // 2)[:, None]
        return dataclasses.replace(self, geometry=geometry, over=tuple(paint.shifted(offset) for paint in self.over))

    def at(self, points: FloatArray) -> FloatArray:
        """Evaluate the straight RGBA (n, 4) at points (n, 2), px; opaque if there are overlays."""
        if self.kind == SOLID:
            seen = np.broadcast_to(self.color, (len(points), 4))
        else:
            seen = stop_colors_at(self.positions, self.stops, place_of(self.kind, self.geometry, points))
        for paint in self.over:
            rgba = paint.at(points)
            seen = np.concatenate([seen[:, :3] + rgba[:, 3:] * (rgba[:, :3] - seen[:, :3]), seen[:, 3:]], axis=1)
        return seen


def fit_paint(
    points: FloatArray,
    colors: FloatArray,
    weights: FloatArray,
    price: float,
    kinds: Sequence[str] = KINDS,
    near: Sequence[Paint] = (),
    most: float = np.inf,
) -> Paint:
    """Fit a fill to the straight RGBA (n, 4) wanted at pixel centres (n, 2), by least squared error plus price.

    `weights` (n,) weigh the squared errors, `price` is that of a number, and `kinds` are those of "solid", "linear" and
    "radial" allowed; solid always is. Radial gradients are searched for from those `near`, if there are any, in a third
    of the time. Gradients that cost `most` or more need not be found.

    Notes
    -----
    Linear: of the regression c = m + B (p - mean p), the best B of rank 1 is that of the singular value decomposition
    of B S^(1/2), S being the covariance of the pixels; its row is the direction. Radial: centres of a grid, the best of
    which is moved and stretched to an ellipse by a pattern search. Either has a ramp through evenly placed knots, of
    which stops are left out while that costs less than they do.
    """
    step = -(-len(points) // MAX_PIXELS)
    interruption.check()
    pixels = Pixels(points[::step], colors[::step], weights[::step] * step)
    if near or most < np.inf or not kinds:
        return _fitted(pixels, price, kinds, near, most)
    corner = np.floor(pixels.points.min(axis=0))
    pixels = dataclasses.replace(pixels, points=pixels.points - corner)
    key = pixels.digest + repr((price, *kinds)).encode()
    paint = _KNOWN.get(key)
    if paint is None:
        if len(_KNOWN) >= MOST_KNOWN:
            _KNOWN.clear()
        paint = _KNOWN[key] = _fitted(pixels, price, kinds)
    return paint.shifted(corner)


def _fitted(
    pixels: Pixels, price: float, kinds: Sequence[str], near: Sequence[Paint] = (), most: float = np.inf
) -> Paint:
    best = _solid(pixels)
    enough = NOISE * 3 * pixels.weights.sum()
    for kind in (LINEAR, RADIAL):
        # No gradient pays where the best fill costs less than its numbers alone, as it has two stops at least.
        least = price * (GEOMETRY_NUMBERS[kind] + 2 * STOP_NUMBERS)
        room = min(most, best.error + price * best.numbers) - least
        if KINDS[kind] not in kinds or room <= 0 or best.error <= enough + price * (best.numbers - COLOR_NUMBERS):
            continue
        if kind == LINEAR:
            geometries = _linear(pixels)
        else:
            geometries = radial_geometries(pixels, room, [paint.geometry for paint in near if paint.kind == RADIAL])
        for found in (_painted(kind, geometry, pixels, price) for geometry in geometries):
            if found.error + price * found.numbers < best.error + price * best.numbers:
                best = found
    return best


def refit_paint(
    paint: Paint | None,
    points: FloatArray,
    colors: FloatArray,
    weights: FloatArray,
    price: float,
    kinds: Sequence[str] = KINDS,
) -> Paint:
    """Fit a fill to other pixels or weights than `paint` was: if that is radial, only near it, a fourth of the time."""
    if paint is None or paint.kind != RADIAL:
        return fit_paint(points, colors, weights, price, kinds)
    return fit_paint(points, colors, weights, price, (KINDS[RADIAL],), near=[paint])


def _solid(pixels: Pixels) -> Paint:
    color = np.clip(np.average(pixels.colors, axis=0, weights=pixels.weights), 0, 1)
    error = float(pixels.weights @ np.square(pixels.colors - color).sum(axis=1))
    return Paint(SOLID, color, np.zeros((3, 2)), np.zeros(0), np.zeros((0, 4)), error)


def _painted(kind: int, geometry: FloatArray, pixels: Pixels, price: float) -> Paint:
    """Fit the stops of a gradient of given geometry by least squares; return it and its error."""
    positions, stops = fit_ramp(place_of(kind, geometry, pixels.points), pixels, price)
    positions = np.clip(positions, 0, 1)
    paint = Paint(kind, stops.mean(axis=0), geometry, positions, stops, 0.0)
    error = float(pixels.weights @ np.square(pixels.colors - paint.at(pixels.points)).sum(axis=1))
    return dataclasses.replace(paint, color=_solid(pixels).color, error=error)


def _linear(pixels: Pixels) -> list[FloatArray]:
    """Search the geometry (3, 2) of the best linear gradient."""
    points, weights = pixels.points, pixels.weights
    center = np.average(points, axis=0, weights=weights)
    offset = points - center
    covariance = (offset * weights[:, None]).T @ offset / weights.sum()
    values, vectors = np.linalg.eigh(covariance)
    if values[0] <= 1e-6:
        return []
    root = vectors * np.sqrt(values)  # root @ root.T is the covariance
    middle = np.average(pixels.colors, axis=0, weights=weights)
    slopes = np.linalg.solve(covariance, (offset * weights[:, None]).T @ (pixels.colors - middle) / weights.sum())
    direction = np.array([1.0, 0.0])
    if slopes.any():
        direction = np.linalg.solve(root.T, np.linalg.svd(root.T @ slopes)[0][:, 0])

    few = pixels.thinned(SEARCH_PIXELS)

    ramps = Ramps(few)

    def errors(angles: FloatArray) -> FloatArray:
        return ramps.errors(np.stack([np.cos(angles[:, 0]), np.sin(angles[:, 0])], axis=1) @ (few.points - center).T)

    start = np.array([np.arctan2(direction[1], direction[0])])
    angle = float(pattern_searches(errors, start[None], np.array([0.2]), 0.01)[0, 0])
    direction = np.array([np.cos(angle), np.sin(angle)])
    t = offset @ direction
    if not t.max() > t.min():
        return []
    ends = center + t.min() * direction, center + t.max() * direction
    return [np.array([*ends, (0.0, 0.0)])]
