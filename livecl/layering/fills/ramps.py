# SPDX-License-Identifier: Apache-2.0
"""Gradient fill fitting: one colour, a linear or a radial gradient for pixels, by least squares and description length.

Prices are in squared error, summed over the pixels and colour channels. A fill is described by numbers: 4 for a colour;
4 for the line of a linear gradient or 6 for the ellipse of a radial one, and 5 for each stop. The fill of least squared
error plus price of its numbers is chosen.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.drawing.fills import KINDS, LINEAR, RADIAL, SOLID, Fills, place_of, stop_colors_at
from livecl.layering.fills.stops import STOP_NUMBERS, Pixels, Ramps, fit_ramp

#: Numbers of a layer of one colour and four segments, which together cost `Options.prune`.
LAYER_NUMBERS = 28
#: Numbers that describe the geometry of a fill, by kind; numbers of a colour.
GEOMETRY_NUMBERS, COLOR_NUMBERS = (0, 4, 6), 4
#: Pixels of the smallest picture in which the price of a number is a share of the picture: 240 x 240.
LEAST_PRICED = 57600
#: Most pixels used by a fit, and by the search for a geometry.
MAX_PIXELS, SEARCH_PIXELS = 4000, 400
#: Mean squared error of a channel at which a fit cannot improve: rounding to 8 bits (.29 of a level), with a margin.
NOISE = (0.45 / 255) ** 2
#: Centres tried along each axis for radial gradients; extent of the grid in sides of the region's box; smallest step of
#: the search for a centre, px.
CENTERS, REACH, SMALLEST_STEP = 5, 1.0, 0.1
#: Pixels used to compare the centres of the grid.
GRID_PIXELS = 100
#: Most rounds of a pattern search; relative decrease of the error below which a round counts as no progress.
SEARCH_ROUNDS, LEAST_PROGRESS = 60, 0.002
#: Directions of stretching tried for an ellipse.
STRETCHES = 8
#: Largest ratio of the axes of an ellipse.
MOST_STRETCHED = 6.0
#: A radial gradient is given up where the best start of its search has more than this multiple of the error that is of
#: interest. From the best start, the searches of 319 fits lowered the error by a factor of 1.1 (median), 4.7 (97 %).
HOPELESS = 8.0


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
) -> Paint:
    """Fit a fill to the straight RGBA (n, 4) wanted at pixel centres (n, 2), by least squared error plus price.

    `weights` (n,) weigh the squared errors, `price` is that of a number, and `kinds` are those of "solid", "linear" and
    "radial" allowed; solid always is. Radial gradients are searched for
    from those `near`, if there are any: a search takes a third of the time.

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
    best = _solid(pixels)
    enough = NOISE * 3 * pixels.weights.sum()
    near = [paint for paint in near if paint.kind == RADIAL]
    for kind, fit in ((LINEAR, _linear), (RADIAL, _radial)):
        # No gradient pays where the best fill costs less than its numbers alone, as it has two stops at least.
        least = price * (GEOMETRY_NUMBERS[kind] + 2 * STOP_NUMBERS)
        if KINDS[kind] not in kinds or best.error <= max(
            enough + price * (best.numbers - COLOR_NUMBERS), least - price * best.numbers
        ):
            continue
        room = best.error + price * best.numbers - least
        for found in fit(pixels, price, room, near):
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


def _linear(pixels: Pixels, price: float, _most: float, _near: Sequence[Paint]) -> list[Paint]:
    """Fit the best linear gradient."""
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
    angle = float(_pattern_searches(errors, start[None], np.array([0.2]), 0.01)[0, 0])
    direction = np.array([np.cos(angle), np.sin(angle)])
    t = offset @ direction
    if not t.max() > t.min():
        return []
    ends = center + t.min() * direction, center + t.max() * direction
    return [_painted(LINEAR, np.array([*ends, (0.0, 0.0)]), pixels, price)]


def _radial(pixels: Pixels, price: float, most: float, near: Sequence[Paint]) -> list[Paint]:
    """Fit the best radial gradient on circles, then on ellipses; none where an error of `most` is out of reach."""
    low, high = pixels.points.min(axis=0), pixels.points.max(axis=0)
    span, few = np.maximum(high - low, 1.0), pixels.thinned(SEARCH_PIXELS)
    grid = np.stack(np.meshgrid(*[np.linspace(-REACH, REACH, 2 * CENTERS - 1)] * 2), axis=-1).reshape(-1, 2) / 2
    centers, ramps = (low + high) / 2 + grid * span, Ramps(few)

    def errors(shapes: FloatArray) -> FloatArray:
        x, y = few.points.T[:, None] - shapes.T[:2, :, None]
        even_x, odd, even_y = (number[:, None] for number in _round(shapes))
        squares = np.square(even_x * x + odd * y)
        squares += np.square(odd * x + even_y * y)
        return ramps.errors(np.sqrt(squares, out=squares))

    steps, shapes = np.array([span[0] / 16, span[1] / 16, 0.2, 0.2]), []
    if near:
        tried = [np.concatenate([*_quadric(few), *(_shape(paint.geometry) for paint in near)])]
    else:
        shapes.append(_circle(few, centers, errors, span))
        tried = _stretched(few, shapes[0])
    starts, least = zip(*(_best(some, errors) for some in tried), strict=True)
    if min(least) > HOPELESS * most:
        return []
    shares = 4.0 if near else 1.0
    ellipses = _pattern_searches(errors, np.array(starts), steps / shares, 0.02 * shares)
    shapes.append(_best(ellipses, errors)[0])
    return [
        _painted(RADIAL, geometry, pixels, price)
        for shape in shapes
        if (geometry := _ellipse(shape, pixels.points)) is not None
    ]


def _circle(
    pixels: Pixels, centers: FloatArray, errors: Callable[[FloatArray], FloatArray], span: FloatArray
) -> FloatArray:
    """Return the best shape of a radial gradient on circles, from the best of some centres."""
    fewer = pixels.thinned(GRID_PIXELS)
    distances = np.linalg.norm(fewer.points - centers[:, None], axis=2)
    start = np.append(centers[np.argmin(Ramps(fewer).errors(distances))], (0.0, 0.0))
    steps = np.array([span[0] / 8, span[1] / 8, 0.0, 0.0])
    return np.asarray(_pattern_searches(errors, start[None], steps, SMALLEST_STEP / span.max())[0])


def _stretched(pixels: Pixels, circular: FloatArray) -> list[FloatArray]:
    """Return the starts of the searches for an ellipse: around the circle's centre, and around that of the pixels."""
    turns = np.linspace(0, 2 * np.pi, STRETCHES, endpoint=False)
    stretches = 0.4 * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    middle = pixels.points.mean(axis=0)
    starts = [np.column_stack([np.tile(c, (STRETCHES, 1)), stretches]) for c in (circular[:2], middle)]
    return [np.concatenate([starts[0], circular[None], *_quadric(pixels)]), starts[1]]


def _best(shapes: FloatArray, errors: Callable[[FloatArray], FloatArray]) -> tuple[FloatArray, float]:
    """Return the shape of least error, and the error."""
    found = errors(shapes)
    return np.asarray(shapes[np.argmin(found)]), float(found.min())


def _quadric(pixels: Pixels) -> list[FloatArray]:
    """Fit an ellipse to the level lines of the colours' quadratic regression, if these are ellipses.

    The colours are projected on their principal axis: s = q(p), q = (p - c)^T Q (p - c) + a constant.
    """
    middle = np.average(pixels.points, axis=0, weights=pixels.weights)
    x, y = (pixels.points - middle).T
    colors = pixels.colors - np.average(pixels.colors, axis=0, weights=pixels.weights)
    along = colors @ np.linalg.eigh((colors * pixels.weights[:, None]).T @ colors)[1][:, -1]
    terms = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1) * np.sqrt(pixels.weights)[:, None]
    c = np.linalg.lstsq(terms, along * np.sqrt(pixels.weights), rcond=None)[0]
    matrix = np.array([[c[3], c[4] / 2], [c[4] / 2, c[5]]])
    if not np.linalg.det(matrix) > 0:
        return []
    return [_shape_around(middle - np.linalg.solve(matrix, c[1:3]) / 2, matrix)[None]]


def _shape(geometry: FloatArray) -> FloatArray:
    """Return the shape (1, 4) of a radial gradient of a geometry (3, 2): the inverse of `_ellipse`."""
    turned = np.linalg.inv(geometry[1:] - geometry[0])
    return _shape_around(geometry[0], turned @ turned.T)[None]


def _shape_around(center: FloatArray, matrix: FloatArray) -> FloatArray:
    """Return the shape of the ellipses (p - center)^T Q (p - center), for a definite matrix Q (2, 2)."""
    values, vectors = np.linalg.eigh(matrix)
    root = vectors * (0.5 * np.log(np.abs(values))) @ vectors.T  # the logarithm of the matrix that makes it round
    return np.array([*center, (root[0, 0] - root[1, 1]) / 2, root[0, 1]])


def _round(shapes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the matrices ((xx, xy), (xy, yy)), (G,) each, that map ellipses (center, stretches a and b) to circles.

    Each is the exponential of [[a, b], [b, -a]], a parametrization without an angle and without a singularity at the
    circle.
    """
    a, b = shapes.T[2:]
    size = np.hypot(a, b)
    limited = np.minimum(size, np.log(MOST_STRETCHED) / 2)
    even, odd = np.cosh(limited), np.sinh(limited) / np.where(size > 0, size, 1)
    return even + odd * a, odd * b, even - odd * a


def _ellipse(shape: FloatArray, points: FloatArray) -> FloatArray | None:
    """Return the centre and the ends of the axes (3, 2) of an ellipse around all points."""
    xx, xy, yy = (float(number[0]) for number in _round(shape[None]))
    matrix = np.array([[xx, xy], [xy, yy]])
    radius = float(np.linalg.norm((points - shape[:2]) @ matrix, axis=1).max())
    if radius <= 0:
        return None
    values, vectors = np.linalg.eigh(np.linalg.inv(matrix))
    axes = radius * values[:, None] * vectors.T
    return np.array([shape[:2], shape[:2] + axes[0], shape[:2] + axes[1]])


def _pattern_searches(
    errors: Callable[[FloatArray], FloatArray], starts: FloatArray, steps: FloatArray, smallest: float
) -> FloatArray:
    """Minimize by pattern search (best step along a coordinate) from several starts (S, n).

    Steps are halved when none improves, down to a share `smallest` of the first.
    """
    moves = np.concatenate([np.diag(steps), -np.diag(steps)])[np.tile(steps > 0, 2)]
    best, least, shares = starts.copy(), errors(starts), np.ones(len(starts))
    under_way = np.arange(len(starts))
    for _ in range(SEARCH_ROUNDS):
        interruption.check()
        trials = best[under_way, None] + shares[under_way, None, None] * moves
        costs = errors(trials.reshape(-1, trials.shape[2])).reshape(len(under_way), -1)
        cheapest = costs.argmin(axis=1)
        for row, k in enumerate(under_way.tolist()):
            if costs[row, cheapest[row]] < (1 - LEAST_PROGRESS) * least[k]:
                best[k], least[k] = trials[row, cheapest[row]], costs[row, cheapest[row]]
            else:
                shares[k] /= 2
        under_way = under_way[shares[under_way] >= smallest]
        if not len(under_way):
            break
    return best
