# SPDX-License-Identifier: Apache-2.0
"""Fit circles, ellipses and rectangles to the visible part of a traced outline, by least squares."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from livecl.arrays import FloatArray
from livecl.editing.trace import SampledOutline
from livecl.geometry import cyclic
from livecl.geometry.bezier import evaluate
from livecl.geometry.polylines import polygon_area
from livecl.svg.primitives import ANGLE_DECIMALS, Primitive, ellipse, rectangle

#: Distances of the visible part from a shape, px: root of the mean square of the nearest samples, and their share, as
#: corners are rounded in a trace; and largest. Of the 90 shapes of drawings with a known one it is .05 at most, of
#: outlines that are nearly shapes .063 and more.
ROOT_MEAN_SQUARE, NEAREST, FARTHEST = 0.06, 0.9, 0.75
#: Weight from which a sample counts as visible. Least standard deviation of visible samples across a shape, px;
#: distance along it from which their deviations are independent, px; largest resulting standard deviation of the
#: shape's outline, px: the visible part must determine the rest.
SEEN, NOISE, ALIKE, KNOWN = 0.5, 0.05, 2.0, 0.2
#: Radius up to which corners count as sharp, px; Gauss-Newton steps.
SHARP, STEPS = 1.5, 8
#: Relative decrease of the squared distances at or below which a step is the last.
CONVERGED = 1e-4


Distances: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]


@dataclasses.dataclass(frozen=True)
class _Candidate:
    """A shape fitted to visible samples: half its size, their distances from it, its standard deviation, px."""

    shape: Primitive | None
    size: float
    distances: FloatArray
    deviation: float

    def fits(self) -> bool:
        """Whether the shape is near enough to the samples, and determined by them."""
        if not (np.isfinite(self.distances).all() and self.size > 0):
            return False
        squares = np.sort(self.distances**2)[: int(NEAREST * len(self.distances))]
        return (
            float(np.sqrt(squares.mean())) <= ROOT_MEAN_SQUARE
            and np.abs(self.distances).max() <= FARTHEST
            and self.deviation <= KNOWN
        )


def fitted_shapes(trace: SampledOutline) -> list[Primitive]:
    """Fit shapes to the visible part of an outline; return those that match, fewest numbers first."""
    seen = trace.points[trace.weights >= SEEN]
    if len(seen) < 12:
        return []
    found = [one.shape for one in _candidates(seen, trace.points) if one.shape is not None and one.fits()]
    return sorted(found, key=lambda shape: len(shape.attributes))


def shape_within(points: FloatArray, farthest: float) -> Primitive | None:
    """Return the shape of fewest numbers that a whole outline, (n, 2) places, is within a distance, px, if any."""
    if len(points) < 12:
        return None
    near = [one.shape for one in _candidates(points, points) if np.abs(one.distances).max() <= farthest]
    return min((shape for shape in near if shape is not None), key=lambda shape: len(shape.attributes), default=None)


def _candidates(seen: FloatArray, whole: FloatArray) -> Iterator[_Candidate]:
    low, high = seen.min(axis=0), seen.max(axis=0)

    def candidate(measure: Distances, form: FloatArray, shape: Primitive | None, size: float) -> _Candidate:
        one = _Candidate(shape, size, measure(form, seen), 0.0)
        if shape is None or not one.fits():
            return dataclasses.replace(one, deviation=np.inf)
        return dataclasses.replace(one, deviation=_deviation(measure, form, seen, shape))

    def round_one(form: FloatArray, shape: Primitive | None) -> _Candidate:
        return candidate(_from_circle if len(form) == 3 else _from_ellipse, form, shape, float(form[2:4].min()))

    circle = _refined(_from_circle, _circle_start(seen), seen)
    yield round_one(circle, ellipse(circle[:2], (float(circle[2]), float(circle[2]))))
    start = np.concatenate([(low + high) / 2, np.maximum(high - low, 1e-3) / 2])
    upright = _refined(_from_ellipse, start, seen)
    yield round_one(upright, ellipse(upright[:2], (float(upright[2]), float(upright[3]))))
    turned = _refined(_from_ellipse, _turned_start(whole), seen)
    angle = round(float(np.degrees(turned[4])), ANGLE_DECIMALS)
    yield round_one(turned, ellipse(turned[:2], (float(turned[2]), float(turned[3])), angle))
    missing = float(np.prod(high - low)) - abs(polygon_area(whole))
    radius = np.sqrt(max(missing, 0.0) / (4 - np.pi))
    box = _refined(_from_rectangle, np.concatenate([low, high, [min(radius, (high - low).min() / 2)]]), seen)
    half = float((box[2:4] - box[:2]).min() / 2)
    yield candidate(_from_rectangle, box, rectangle(box[:2], box[2:4], float(np.clip(box[4], 0, max(half, 0)))), half)
    if box[4] < SHARP:
        yield candidate(_from_rectangle, box, rectangle(box[:2], box[2:4]), half)


def _deviation(measure: Distances, form: FloatArray, seen: FloatArray, shape: Primitive) -> float:
    """Return the largest standard deviation of a fitted shape's outline across it, px.

    With J the slopes of the distances of the n seen samples by the shape's k numbers, s^2 = NOISE^2 or what they miss
    on average, and one of m samples deviating on its own, the numbers have the covariance C = m s^2 (J^T J)^-1, and the
    outline the variance g^T C g where g are the slopes of its own distances.
    """
    rest = measure(form, seen)
    slopes = _slopes(measure, form, seen, rest)
    ends = cyclic.following(shape.points[:, :1])
    around = evaluate(np.concatenate([shape.points, ends], axis=1), np.linspace(0, 1, 8, endpoint=False)).reshape(-1, 2)
    own = _slopes(measure, form, around, measure(form, around))
    if not (np.isfinite(slopes).all() and np.isfinite(own).all()):
        return float(np.inf)
    alike = max(1.0, ALIKE * len(seen) / max(float(np.hypot(*(seen[1:] - seen[:-1]).T).sum()), 1e-9))
    noise = alike * max(NOISE**2, float(np.mean(rest**2)))
    gram = slopes.T @ slopes + 1e-9 * np.eye(len(form))
    return float(np.sqrt((own * np.linalg.solve(gram, own.T).T).sum(axis=1).max() * noise))


def _from_circle(shape: FloatArray, points: FloatArray) -> FloatArray:
    """Return the signed distances of points from a circle (x, y, radius), px."""
    return np.hypot(*(points - shape[:2]).T) - shape[2]


def _from_ellipse(shape: FloatArray, points: FloatArray) -> FloatArray:
    """Return the signed distances of points from an ellipse (x, y, radii, and an angle if turned), to first order.

    F / |grad F| with F the equation of the ellipse (P. D. Sampson, 1982).
    """
    rest = points - shape[:2]
    if len(shape) > 4:
        cosine, sine = np.cos(shape[4]), np.sin(shape[4])
        rest = rest @ np.array([[cosine, -sine], [sine, cosine]])
    scaled = rest / np.maximum(shape[2:4], 1e-6)
    slope = 2 * np.hypot(*(scaled / np.maximum(shape[2:4], 1e-6)).T)
    return np.asarray(((scaled**2).sum(axis=1) - 1) / np.maximum(slope, 1e-9))


def _from_rectangle(shape: FloatArray, points: FloatArray) -> FloatArray:
    """Return the signed distances of points from a rectangle (low corner, high corner, radius of its corners), px."""
    half = (shape[2:4] - shape[:2]) / 2
    radius = float(np.clip(shape[4], 0, max(half.min(), 0)))
    beyond = np.abs(points - (shape[:2] + shape[2:4]) / 2) - half + radius
    outside = np.hypot(*np.maximum(beyond, 0).T)
    return np.asarray(outside + np.minimum(beyond.max(axis=1), 0) - radius)


def _circle_start(points: FloatArray) -> FloatArray:
    """Fit the circle of least algebraic distance (I. Kasa, 1976)."""
    center = points.mean(axis=0)
    rest = points - center
    matrix = np.concatenate([rest, np.ones((len(rest), 1))], axis=1)
    a, b, c = np.linalg.lstsq(matrix, (rest**2).sum(axis=1), rcond=None)[0]
    return np.array([center[0] + a / 2, center[1] + b / 2, np.sqrt(max(c + (a * a + b * b) / 4, 1e-6))])


def _turned_start(points: FloatArray) -> FloatArray:
    """Return the ellipse with an outline's second moments: the variance of its samples is half of a radius squared."""
    center = points.mean(axis=0)
    values, vectors = np.linalg.eigh((points - center).T @ (points - center) / len(points))
    angle = np.arctan2(vectors[1, 1], vectors[0, 1])
    radii = np.sqrt(2 * np.maximum(values[::-1], 1e-6))
    return np.concatenate([center, radii, [angle]])


def _slopes(measure: Distances, form: FloatArray, points: FloatArray, rest: FloatArray) -> FloatArray:
    """Return the slopes of the distances of points (n, 2), which are `rest`, by the numbers of a form: (n, k)."""
    moved = form + 1e-4 * np.eye(len(form))
    return np.stack([measure(one, points) - rest for one in moved], axis=1) / 1e-4


def _refined(distances: Distances, shape: FloatArray, points: FloatArray) -> FloatArray:
    """Refine a shape to least squared distances by damped Gauss-Newton steps."""
    rest = distances(shape, points)
    damping = 1e-3
    for _ in range(STEPS):
        slopes = _slopes(distances, shape, points, rest)
        gram = slopes.T @ slopes
        gram[np.diag_indices(len(shape))] *= 1 + damping
        gram[np.diag_indices(len(shape))] += 1e-9
        step = np.linalg.solve(gram, slopes.T @ rest)
        tried = shape - step
        after = distances(tried, points)
        gain = float(rest @ rest) - float(after @ after)
        if gain > 0:
            shape, rest, damping = tried, after, damping / 10
            if gain <= CONVERGED * float(after @ after):
                break
        else:
            damping *= 10
    return shape
