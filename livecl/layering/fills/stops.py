# SPDX-License-Identifier: Apache-2.0
"""Fit the stops of a gradient by least squares, adding stops while each lowers the cost."""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np

from livecl.arrays import FloatArray

#: Numbers that describe a stop: its offset and RGBA.
STOP_NUMBERS = 5
#: Knots of the ramp by which geometries are compared; bins in which pixels are summed.
KNOTS, BINS = 7, 96
#: Most stops of a gradient; offsets tried for a new one; rounds of refinement around the best.
MOST_STOPS, PLACES, REFINEMENTS = 6, 11, 3

#: Share of all weight with which a stop is held to the others.
LEAST_SHARE = 1e-6

_EVENLY = np.linspace(-1, 1, PLACES)


@dataclasses.dataclass(frozen=True, eq=False)
class Pixels:
    """Pixel centres (n, 2), straight RGBA (n, 4), and weights (n,)."""

    points: FloatArray
    colors: FloatArray
    weights: FloatArray

    @property
    def digest(self) -> bytes:
        """A number of 16 bytes, equal for equal pixels."""
        found = hashlib.blake2b(digest_size=16)
        for array in (self.points, self.colors, self.weights):
            found.update(array.tobytes())
        return found.digest()

    def thinned(self, most: int) -> Pixels:
        """Subsample about `most` of the pixels at even steps, keeping the total weight."""
        step = -(-len(self.points) // most)
        return Pixels(self.points[::step], self.colors[::step], self.weights[::step] * step)


def fit_ramp(t: FloatArray, pixels: Pixels, price: float) -> tuple[FloatArray, FloatArray]:
    """Fit the offsets and colours of the stops of a ramp over t, by least squares, adding stops where it pays.

    Fitted to pixels summed in bins of t; a new stop starts where it helps most, and its offset is refined from there.

    Notes
    -----
    Ramps with knots low < k_1 < ... < high are spanned by 1, t and (t - k_j)+. With Q an orthonormal basis of what is
    there already and R the residual of its fit, both times the roots of the weights, b = (t - p)+ lowers the squared
    error by |b_Q . R|^2 / |b_Q|^2, where b_Q is b without its projection on Q: no system is solved for a place tried.
    """
    low, high = float(t.min()), float(t.max())
    places, shares, colors = _binned(t, pixels)
    roots, least = np.sqrt(shares)[:, None], LEAST_SHARE * shares.sum()
    basis = np.linalg.qr(roots * np.stack([np.ones(len(places)), places - low], axis=1))[0]
    left = roots * (colors - shares @ colors / shares.sum())
    left -= basis @ (basis.T @ left)
    knots = np.array([low, high])
    while len(knots) < MOST_STOPS:
        center, width = (low + high) / 2, (high - low) / 2
        best, place = 0.0, center
        for _ in range(REFINEMENTS):
            tried = np.minimum(np.maximum(center + width * _EVENLY, low), high)
            bent = _bends(tried, places, roots, basis)
            # A hat at a knot p between a and b is (t - p)+ times (b - a) / ((p - a) (b - p)), but for functions that
            # are there: with it, a stop that no pixel is near keeps to the others.
            after = np.clip(np.searchsorted(knots, tried), 1, len(knots) - 1)
            before, behind = tried - knots[after - 1], knots[after] - tried
            height = before * behind / np.maximum(before + behind, 1e-12)
            norms = (bent * bent).sum(axis=1) + least * np.square(height)
            gains = np.square(bent @ left).sum(axis=1) / np.maximum(norms, 1e-12 * least)
            most = int(gains.argmax())
            if gains[most] > best:
                best, place, chosen = float(gains[most]), float(tried[most]), bent[most] / np.sqrt(norms[most])
            center, width = place, 2 * width / (PLACES - 1)
        if best <= STOP_NUMBERS * price:
            break
        knots, basis = np.sort(np.append(knots, place)), np.column_stack([basis, chosen])
        left -= np.outer(chosen, chosen @ left)
    return knots, np.clip(StopFit(pixels.weights, pixels.colors).stops(_hats(knots[None], t))[1][0], 0, 1)


def _bends(knots: FloatArray, places: FloatArray, roots: FloatArray, basis: FloatArray) -> FloatArray:
    """Return (t - p)+ for knots p (P,) at places t (m,), times the roots (m, 1), less its part in a basis: (P, m)."""
    bent = np.maximum(places - knots[:, None], 0) * roots[:, 0]
    bent -= (bent @ basis) @ basis.T
    return np.asarray(bent)


def _binned(t: FloatArray, pixels: Pixels) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sum the pixels in bins of t: mean offset, weight and mean colour of each bin that holds pixels."""
    low, high = float(t.min()), float(t.max())
    at = np.minimum(((t - low) * (BINS / max(high - low, 1e-12))).astype(np.int64), BINS - 1)
    shares = np.bincount(at, pixels.weights, BINS)
    used = shares > 0
    sums = np.stack([np.bincount(at, pixels.weights * c, BINS) for c in (t, *pixels.colors.T)], axis=1)
    means = sums[used] / shares[used, None]
    return means[:, 0], np.asarray(shares[used], dtype=np.float64), means[:, 1:]


def _hats(knots: FloatArray, places: FloatArray) -> FloatArray:
    """Evaluate the linear hat functions of stops at knots (G, K), at offsets (m,): (G, m, K)."""
    rise = np.empty((len(knots), len(places), knots.shape[1] + 1))  # of each piece, how much of it lies behind
    rise[..., 0], rise[..., -1] = 1, 0
    inner = rise[..., 1:-1]
    np.subtract(places[None, :, None], knots[:, None, :-1], out=inner)
    inner /= np.maximum(knots[:, 1:] - knots[:, :-1], 1e-12)[:, None]
    np.minimum(np.maximum(inner, 0, out=inner), 1, out=inner)
    return np.asarray(rise[..., :-1] - rise[..., 1:])


class Ramps:
    """Ramps of evenly spaced stops through the colours of some pixels, for one geometry or many."""

    def __init__(self, pixels: Pixels) -> None:
        weights, colors = pixels.weights, pixels.colors
        offset = colors - weights @ colors / weights.sum()
        self._weights = weights
        self._weighted = offset * weights[:, None]
        self._whole = float((self._weighted * offset).sum())
        self._least = 1e-6 * weights.sum() * np.eye(KNOTS)  # knots that no pixel is near keep to the middle

    def errors(self, t: FloatArray) -> FloatArray:
        """Return the residual squared error for offsets t (G, n) of the pixels: (G,)."""
        hats = _even_hats(t)
        gram = (hats * self._weights) @ hats.transpose(0, 2, 1) + self._least
        sums = hats @ self._weighted
        return np.asarray(self._whole - (np.linalg.solve(gram, sums) * sums).sum(axis=(1, 2)))


def _even_hats(t: FloatArray) -> FloatArray:
    """Evaluate the hat functions of evenly spaced stops at offsets t (G, n): (G, KNOTS, n)."""
    low, high = t.min(axis=1, keepdims=True), t.max(axis=1, keepdims=True)
    at = (t - low) * ((KNOTS - 1) / np.maximum(high - low, 1e-12))
    hats = at[:, None] - np.arange(KNOTS)[:, None]
    np.abs(hats, out=hats)
    np.subtract(1, hats, out=hats)
    return np.asarray(np.maximum(hats, 0, out=hats))


class StopFit:
    """Least-squares fit of stops to weighted colours (m, 4), for one ramp or many."""

    def __init__(self, weights: FloatArray, colors: FloatArray) -> None:
        self._weights, whole = weights, weights.sum()
        self._middle = weights @ colors / whole
        self._offset = colors - self._middle
        self._spread = weights @ np.square(self._offset).sum(axis=1)
        self._least = 1e-6 * whole  # knots that no pixel is near keep to the middle

    def stops(self, hats: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Solve for the colours (G, K, 4) of stops with hat functions (G, m, K); return the errors (G,) and colours."""
        turned = hats.transpose(0, 2, 1) * self._weights  # (G, K, m)
        gram = turned @ hats + self._least * np.eye(hats.shape[2])
        sums = turned @ self._offset
        stops = np.linalg.solve(gram, sums)
        return np.asarray(self._spread - (stops * sums).sum(axis=(1, 2))), self._middle + stops
