# SPDX-License-Identifier: Apache-2.0
"""Geometry of gradients: searches for the circle or ellipse of a radial one, by the error of a ramp along it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.layering.fills.stops import Pixels, Ramps

#: Most pixels used by the search for a geometry.
SEARCH_PIXELS = 400
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


def radial_geometries(pixels: Pixels, most: float, near: Sequence[FloatArray]) -> list[FloatArray]:
    """Search the geometries (3, 2) of radial gradients: the best circle, then the best ellipse.

    None are found where an error of `most` is out of reach. With geometries `near`, only ellipses near these are
    searched for.
    """
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
        tried = [np.concatenate([*_quadric(few), *(_shape(geometry) for geometry in near)])]
    else:
        shapes.append(_circle(few, centers, errors, span))
        tried = _stretched(few, shapes[0])
    starts, least = zip(*(_best(some, errors) for some in tried), strict=True)
    if min(least) > HOPELESS * most:
        return []
    shares = 4.0 if near else 1.0
    ellipses = pattern_searches(errors, np.array(starts), steps / shares, 0.02 * shares)
    shapes.append(_best(ellipses, errors)[0])
    found = [_ellipse(shape, pixels.points) for shape in shapes]
    return [geometry for geometry in found if geometry is not None]


def _circle(
    pixels: Pixels, centers: FloatArray, errors: Callable[[FloatArray], FloatArray], span: FloatArray
) -> FloatArray:
    """Return the best shape of a radial gradient on circles, from the best of some centres."""
    fewer = pixels.thinned(GRID_PIXELS)
    distances = np.linalg.norm(fewer.points - centers[:, None], axis=2)
    start = np.append(centers[np.argmin(Ramps(fewer).errors(distances))], (0.0, 0.0))
    steps = np.array([span[0] / 8, span[1] / 8, 0.0, 0.0])
    return np.asarray(pattern_searches(errors, start[None], steps, SMALLEST_STEP / span.max())[0])


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


def pattern_searches(
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
