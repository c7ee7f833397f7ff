# SPDX-License-Identifier: Apache-2.0
"""Noise of a picture, and its segmentation into flat regions: the few colours that most pixels scatter around.

A compressed (JPEG) or scanned picture has no equal neighbours. Its colours are the modes of the local means of quiet
pixels; every pixel is assigned to one of them, by its own colour and its neighbours' (a Potts model, relaxed by
iterated conditional modes: Besag 1986). So noise adds no regions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray, IntArray

#: Immerkaer's mask (1996): insensitive to slopes; normalized so that its response to white noise is the noise.
_MASK = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]]) / 6
#: Largest range of colour in 5 x 5 pixels within which noise is measured.
QUIET = 40 / 255
#: Response from which a pixel counts as noisy; least share of noisy pixels beside edges, where compression leaves them,
#: and their least root mean square. Of 30 drawings at most 0.05 are noisy there, as JPEG of quality 50 at least 0.28;
#: gradients at 8 bits have at most 0.35 of 255, JPEG of quality 50 at least 0.8.
SOME, LEAST_SHARE, LEAST_NOISE = 0.3 / 255, 0.15, 0.5 / 255
#: Radius of one colour, and range of colour of quiet pixels: a constant, and per unit of noise.
RADIUS, RADIUS_OF_NOISE = 6 / 255, 1.5
RANGE, RANGE_OF_NOISE = 8 / 255, 8.0
#: Least share of pixels of a colour; most colours; bin width of the mode search.
LEAST_COLOR, MOST_COLORS, BIN = 4e-4, 48, 4 / 255
#: Deviation of a pixel from its colour, a constant and per unit of noise; weight of each of 8 neighbours; rounds.
SPREAD, SPREAD_OF_NOISE, NEIGHBOR, ROUNDS = 4 / 255, 2.0, 0.7, 4
#: Window, px, over which noise averages out; mean residual from which it is shading; largest share of the quiet pixels
#: of a flat picture with such residuals: 15 drawings as JPEG of quality 50 have at most 0.08, 6 of 8 shaded ones 0.19
#: to 0.7.
WINDOW, SHADE, MOST_SHADED = 7, 3.5 / 255, 0.13
#: The same share with each pixel's nearest colour, before neighbours are asked, from which the picture is shaded: of
#: 324 noisy and compressed drawings, flat ones have at most 0.21, photographs at least 0.28.
SURELY_SHADED = 0.26
#: Distance from an edge, px, within which ringing is measured: a block of JPEG has 8.
BESIDE = 4
#: Upper limit of the ringing: above it are colours of small shapes.
MOST_RINGING = 6 / 255
#: Cost from which all colours are equally wrong for a pixel: six deviations.
MOST_COST = 18.0
#: Largest residual of a pixel of a core: a constant, and per unit of noise.
MISS, MISS_OF_NOISE = 10 / 255, 3.0


def noise_level(image: FloatArray) -> float:
    """Estimate the noise of a picture (H, W, C): root mean square in quiet areas, 0 for a clean picture."""
    if min(image.shape[:2]) < 5:
        return 0.0
    quiet = _range(image) <= QUIET
    interruption.check()
    beside = quiet & ndimage.binary_dilation(~quiet, np.ones((3, 3)), iterations=BESIDE)
    response = np.stack([ndimage.convolve(channel, _MASK, mode="nearest") for channel in np.moveaxis(image, -1, 0)])
    some = quiet & (np.abs(response).max(axis=0) > SOME)
    looked_at = beside if beside.any() else quiet
    if not some.any() or np.mean(some[looked_at]) < LEAST_SHARE:
        return 0.0
    level = float(np.sqrt(np.mean(response[:, some] ** 2)))
    return level if level >= LEAST_NOISE else 0.0


def noisy_cores(image: FloatArray, noise: float) -> tuple[IntArray, FloatArray, float] | None:
    """Find the cores of a noisy picture; None if it is not flat.

    Returns labels (H, W), 0 outside, colours (K + 1, C), and the noise, including that beside edges.
    """
    palette = _palette(image, noise)
    if palette is None:
        return None
    quiet = _range(image) <= RANGE + RANGE_OF_NOISE * noise
    nearest = _nearest(image, palette)
    if _shaded_share(image - palette[nearest], nearest, quiet) > SURELY_SHADED:
        return None
    interruption.check()
    nearest = _relaxed(image, palette, noise)
    ringing = _ringing(image, palette[nearest], nearest)
    interruption.check()
    if ringing > noise:
        noise = ringing
        palette = _told_apart(palette, RADIUS + RADIUS_OF_NOISE * noise)
        nearest = _relaxed(image, palette, noise)
    if _shaded_share(image - palette[nearest], nearest, quiet) > MOST_SHADED:
        return None
    labels = np.zeros(image.shape[:2], np.int64)
    colors = [np.zeros(image.shape[2])]
    for k, color in enumerate(palette):
        interruption.check()
        alike = (nearest == k) & (np.abs(image - color).max(axis=-1) <= MISS + MISS_OF_NOISE * noise)
        inside = ndimage.binary_opening(np.pad(alike, 1, mode="edge"), np.ones((3, 3)))[1:-1, 1:-1]
        parts, count = ndimage.label(inside)
        labels[inside] = parts[inside] + len(colors) - 1
        colors += [color] * count
    return labels, np.array(colors), noise


def _nearest(image: FloatArray, palette: FloatArray) -> IntArray:
    """Return the index of the nearest colour to each pixel."""
    least, nearest = np.full(image.shape[:2], np.inf), np.zeros(image.shape[:2], np.int64)
    for k, color in enumerate(palette):
        interruption.check()
        away = np.square(image - color).sum(axis=-1)
        nearer = away < least
        least[nearer], nearest[nearer] = away[nearer], k
    return nearest


def _shaded_share(left: FloatArray, nearest: IntArray, quiet: NDArray[np.bool_]) -> float:
    """Return the share of quiet pixels whose residual is shading, not noise: its local mean is large."""
    sums, counts = np.zeros_like(left), np.ones(nearest.shape)
    for k in np.unique(nearest):
        interruption.check()
        inside = (nearest == k).astype(np.float64)
        window = (WINDOW, WINDOW, 1)
        sums += inside[..., None] * ndimage.uniform_filter(left * inside[..., None], window)
        counts += inside * (ndimage.uniform_filter(inside, WINDOW) - 1)
    means = np.abs(sums / np.maximum(counts, 1e-9)[..., None]).max(axis=-1)
    return float(np.mean(means[quiet] > SHADE)) if quiet.any() else 0.0


def _ringing(image: FloatArray, shown: FloatArray, nearest: IntArray) -> float:
    """Estimate the ringing of compression beside edges: root mean square."""
    edge = ndimage.maximum_filter(nearest, 3) != ndimage.minimum_filter(nearest, 3)
    near = ndimage.binary_dilation(edge, np.ones((3, 3)), iterations=BESIDE) & ~ndimage.binary_dilation(edge)
    if not near.any():
        return 0.0
    return min(float(np.quantile(np.abs(image - shown).max(axis=-1)[near], 0.9) / 2), MOST_RINGING)


def _range(image: FloatArray) -> FloatArray:
    """Return the largest range of colour over the channels in 5 x 5 pixels."""
    size = (5, 5, 1)
    return np.asarray((ndimage.maximum_filter(image, size) - ndimage.minimum_filter(image, size)).max(axis=-1))


def _palette(image: FloatArray, noise: float) -> FloatArray | None:
    """Return the colours (K, C) that quiet pixels scatter around, the most frequent first; None if too many."""
    quiet = _range(image) <= RANGE + RANGE_OF_NOISE * noise
    means = np.asarray(ndimage.uniform_filter(image, (5, 5, 1)))[quiet]
    rows = np.floor(means / BIN + 0.5).astype(np.int64)
    sides = rows.max(axis=0, initial=0) + 1
    bins = np.ravel_multi_index(tuple(rows.T), tuple(sides)) if len(rows) else np.zeros(0, np.int64)
    radius, least = RADIUS + RADIUS_OF_NOISE * noise, LEAST_COLOR * image.shape[0] * image.shape[1]
    colors: list[FloatArray] = []
    while len(means) >= least:
        interruption.check()
        found, counts = np.unique(bins, return_counts=True)
        center = np.array(np.unravel_index(found[np.argmax(counts)], tuple(sides))) * BIN
        for _ in range(3):
            interruption.check()
            near = np.abs(means - center).max(axis=1) <= radius
            center = means[near].mean(axis=0) if near.any() else center
        near = np.abs(means - center).max(axis=1) <= radius
        if near.sum() < least:
            break
        if len(colors) == MOST_COLORS:
            return None
        colors.append(center)
        means, bins = means[~near], bins[~near]
    return np.array(colors) if colors else None


def _told_apart(palette: FloatArray, radius: float) -> FloatArray:
    """Remove colours within a radius of a more frequent one."""
    kept: list[FloatArray] = []
    for color in palette:
        if all(np.abs(color - other).max() > radius for other in kept):
            kept.append(color)
    return np.array(kept)


def _relaxed(image: FloatArray, palette: FloatArray, noise: float) -> IntArray:
    """Return the index of each pixel's colour: the nearest, regularized by its neighbours."""
    spread = SPREAD + SPREAD_OF_NOISE * noise
    costs = [np.minimum(np.square((image - color) / spread).sum(axis=-1) / 2, MOST_COST) for color in _asking(palette)]
    nearest = _least(costs)
    for _ in range(ROUNDS):
        lower = (
            cost - 9 * NEIGHBOR * ndimage.uniform_filter((nearest == k).astype(np.float64), 3)
            for k, cost in enumerate(costs)
        )
        changed = _least(lower)
        if np.array_equal(changed, nearest):
            break
        nearest = changed
    return nearest


def _least(costs: Iterable[FloatArray]) -> IntArray:
    """Return the index of the least of some arrays at each pixel (H, W), the first of equal ones."""
    every = iter(costs)
    least = next(every)
    found = np.zeros(least.shape, np.int64)
    for k, cost in enumerate(_asking(every), start=1):
        lower = cost < least
        found[lower], least = k, np.minimum(cost, least)
    return found


def _asking(items: Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Yield items, and look before each whether to go on."""
    for item in items:
        interruption.check()
        yield item
