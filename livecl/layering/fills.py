# SPDX-License-Identifier: Apache-2.0
"""Choice of fills: least squares of a colour, a linear or a radial gradient, and what a gradient gains."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import KINDS, RADIAL, SOLID, Fills, concatenate_fills
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas, visible_shares

#: Fall of the mean squared error over all pixels that a gradient must be worth: that of a path (`AUTO_PATH_GAIN`).
LEAST_GAIN = 1e-5
#: Share of a pixel's colour from which it is a layer's own, clear of antialiased edges, and fewest such pixels.
OWN_SHARE, LEAST_PIXELS = 0.95, 24
#: Most pixels that a fit looks at.
MAX_PIXELS = 4000
#: Centres tried along each axis for radial gradients, and rounds of a finer search about the best.
CENTERS, ROUNDS = 5, 4

FloatArray = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class FittedFill:
    """A fill found by least squares.

    Attributes
    ----------
    kind : int
        SOLID, LINEAR or RADIAL.
    fills : Fills or None
        Of one layer, opaque; None where it is solid.
    color : (3,)
        The best solid colour.
    error : float
        Weighted sum over pixels and channels of the squared difference.
    """

    kind: int
    fills: Fills | None
    color: FloatArray
    error: float


def best_fill(target: FloatArray, weight: FloatArray, kinds: Sequence[str] = KINDS) -> list[FittedFill]:
    """Return the best fill of each kind, by weighted least squares.

    Parameters
    ----------
    target : (H, W, 3)
        Colours wanted, in [0, 1] or about.
    weight : (H, W)
        Weight of each pixel's squared error; pixels of weight 0 are not looked at.
    kinds : sequence of str
        Which of "solid", "linear" and "radial".

    Notes
    -----
    Linear: of the regression c = m + B (p - mean p), the best B of rank 1 is that of the singular value decomposition
    of B S^(1/2), S being the covariance of the pixels; its row is the direction. Radial: the regression on (1, |p - c|)
    for centres c of a grid, made finer about the best one.
    """
    rows, columns = np.nonzero(weight)
    step = -(-len(rows) // MAX_PIXELS)
    rows, columns = rows[::step], columns[::step]
    points = np.column_stack([columns, rows]).astype(np.float64) + 0.5
    colors, shares = target[rows, columns].astype(np.float64), weight[rows, columns].astype(np.float64) * step
    mean = np.average(colors, axis=0, weights=shares)
    solid = FittedFill(SOLID, None, np.clip(mean, 0, 1), _error(colors, shares, np.clip(mean, 0, 1)))
    found = [solid] if "solid" in kinds else []
    if "linear" in kinds and (linear := _linear(points, colors, shares)) is not None:
        found.append(dataclasses.replace(linear, color=solid.color))
    if "radial" in kinds and (radial := _radial(points, colors, shares)) is not None:
        found.append(dataclasses.replace(radial, color=solid.color))
    return found


def _error(colors: FloatArray, shares: FloatArray, fitted: FloatArray) -> float:
    return float(shares @ np.square(colors - fitted).sum(axis=1))


def _ramp(places: FloatArray, colors: FloatArray, shares: FloatArray) -> tuple[FloatArray, float, float, float]:
    """Regress colours on places: two stops (2, 3) in [0, 1], the places of both, and the error."""
    low, high = float(places.min()), float(places.max())
    mean, middle = float(np.average(places, weights=shares)), np.average(colors, axis=0, weights=shares)
    offset = places - mean
    square = float(shares @ offset**2)
    slope = (shares * offset) @ (colors - middle) / square if square > 0 else np.zeros(3)
    stops = np.clip([middle + slope * (low - mean), middle + slope * (high - mean)], 0, 1)
    share = ((places - low) / (high - low) if high > low else np.zeros_like(places))[:, None]
    return stops, low, high, _error(colors, shares, stops[0] + share * (stops[1] - stops[0]))


def _opaque(stops: FloatArray) -> FloatArray:
    return np.column_stack([stops, np.ones(len(stops))])


def _linear(points: FloatArray, colors: FloatArray, shares: FloatArray) -> FittedFill | None:
    center = np.average(points, axis=0, weights=shares)
    offset = points - center
    covariance = (offset * shares[:, None]).T @ offset / shares.sum()
    values, vectors = np.linalg.eigh(covariance)
    if values[0] <= 1e-6:
        return None
    root = vectors * np.sqrt(values)  # root @ root.T is the covariance
    middle = np.average(colors, axis=0, weights=shares)
    slopes = np.linalg.solve(covariance, (offset * shares[:, None]).T @ (colors - middle) / shares.sum())  # (2, 3)
    if not slopes.any():
        return None
    direction = np.linalg.solve(root.T, np.linalg.svd(root.T @ slopes)[0][:, 0])
    direction /= np.linalg.norm(direction)
    stops, low, high, error = _ramp(offset @ direction, colors, shares)
    fills = Fills.linear(center + low * direction, center + high * direction, _opaque(stops))
    return FittedFill(1, fills, stops.mean(axis=0), error)


def _radial(points: FloatArray, colors: FloatArray, shares: FloatArray) -> FittedFill | None:
    low, high = points.min(axis=0), points.max(axis=0)
    span = np.maximum(high - low, 1.0)
    best, best_center, width = None, (low + high) / 2, span
    for _ in range(ROUNDS):
        middle = best_center
        for shift in np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, CENTERS)] * 2), axis=-1).reshape(-1, 2):
            center = middle + shift * width
            ramp = _ramp(np.linalg.norm(points - center, axis=1), colors, shares)
            if best is None or ramp[3] < best[3]:
                best, best_center = ramp, center
        width = width / 2
    if best is None or not best[2] > best[1]:
        return None
    stops, inner, radius, error = best
    ends = best_center + radius * np.eye(2)
    fills = Fills.radial(best_center, ends[0], ends[1], _opaque(stops), [inner / radius, 1.0])
    return FittedFill(RADIAL, fills, stops.mean(axis=0), error)


def shaded(context: Context, drawing: Drawing, kinds: Sequence[str], free: NDArray[np.bool_]) -> Drawing:
    """Return the drawing with gradients for those solid layers that they are worth it to.

    What a layer should be at a pixel is what it is and the rest of the error, over its share of the pixel's colour;
    looked at are pixels that are nearly its own.

    Parameters
    ----------
    context : Context
        The picture wanted.
    drawing : Drawing
        Any drawing.
    kinds : sequence of str
        Which of "linear" and "radial" may be taken.
    free : (N,) bool
        Layers that may change.
    """
    shares = visible_shares(layer_alphas(drawing, context.rasterizer))
    residual = (context.target - context.rasterizer.forward(drawing))[..., :3].astype(np.float64)
    parts = []
    for layer in range(drawing.num_layers):
        fills = drawing.fills.subset([layer])
        parts.append(fills)
        own = shares[layer] > OWN_SHARE
        if not free[layer] or fills.any_gradients or np.count_nonzero(own) < LEAST_PIXELS:
            continue
        wanted = drawing.colors[layer, :3] + residual
        solid, *gradients = best_fill(wanted, own.astype(np.float64), ["solid", *kinds])
        best = min(gradients, key=lambda fitted: fitted.error, default=solid)
        if best.fills is not None and (solid.error - best.error) / (3 * own.size) > LEAST_GAIN:
            stops = best.fills.stop_colors.copy()
            stops[:, 3] = drawing.colors[layer, 3]
            parts[-1] = best.fills.with_numbers(stop_colors=stops)
    return drawing.replace(fills=concatenate_fills(parts)) if parts else drawing
