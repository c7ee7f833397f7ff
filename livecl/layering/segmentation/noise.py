# SPDX-License-Identifier: Apache-2.0
"""Noise of a picture, and its flat regions seen through it: the few colours that most pixels scatter around.

A picture that was compressed (JPEG) or scanned has no equal neighbours. Its colours are the modes of the quiet pixels'
local means; every pixel belongs to one of them, by its colour and by its neighbours (a Potts model, relaxed by
iterated conditional modes: Besag 1986). So what noise scatters buys no regions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Immerkaer's mask (1996): blind to slopes; its response to white noise is 6 times the noise, here once.
_MASK = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]]) / 6
#: Range of colours within 5 x 5 pixels up to which they are looked at for noise.
QUIET = 40 / 255
#: Response from which on a pixel counts as noisy; least share of such pixels beside edges, where compression leaves
#: them, and their least root mean square. Of 30 drawings 0.05 at most are noisy there, as JPEG of quality 50 0.28 or
#: more; gradients at 8 bits have 0.35 of 255 at most, JPEG of quality 50 has 0.8 or more.
SOME, LEAST_SHARE, LEAST_NOISE = 0.3 / 255, 0.15, 0.5 / 255
#: Radius of one colour, and range of colours of quiet pixels: a constant, and for each unit of noise.
RADIUS, RADIUS_OF_NOISE = 6 / 255, 1.5
RANGE, RANGE_OF_NOISE = 8 / 255, 8.0
#: Share of the pixels that a colour must have, most colours, and width of a bin in which modes are sought.
LEAST_COLOR, MOST_COLORS, BIN = 4e-4, 48, 4 / 255
#: Deviation of a pixel from its colour, at least and for each unit of noise; what each of 8 neighbours weighs; rounds.
SPREAD, SPREAD_OF_NOISE, NEIGHBOR, ROUNDS = 4 / 255, 2.0, 0.7, 4
#: Window, px, over which noise cancels; mean from which on it is shading; share of the quiet pixels of a flat picture
#: that may have some: 15 drawings as JPEG of quality 50 have 0.08 at most, 6 of 8 shaded ones 0.19 to 0.7.
WINDOW, SHADE, MOST_SHADED = 7, 3.5 / 255, 0.13
#: How far from an edge its ringing is looked for, px: a block of JPEG has 8.
BESIDE = 4
#: The most that it counts as: beyond are colours of small shapes.
MOST_RINGING = 6 / 255
#: Cost from which on all colours of a pixel are as wrong: six deviations away.
MOST_COST = 18.0
#: What a pixel of a core may miss its colour by: a constant, and for each unit of noise.
MISS, MISS_OF_NOISE = 10 / 255, 3.0


def noise_level(image: FloatArray) -> float:
    """Estimate the noise of a picture (H, W, C): its root mean square in quiet places, 0 for a clean picture."""
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
    """Return cores of a noisy picture, None where it is not flat.

    Labels (H, W), 0 outside, colours (K + 1, C), and the noise, that beside edges included.
    """
    palette = _palette(image, noise)
    if palette is None:
        return None
    nearest = _relaxed(image, palette, noise)
    level, ringing = noise, _ringing(image, palette[nearest], nearest)
    interruption.check()
    if ringing > noise:
        noise = ringing
        palette = _told_apart(palette, RADIUS + RADIUS_OF_NOISE * noise)
        nearest = _relaxed(image, palette, noise)
    if _shaded(image - palette[nearest], nearest, quiet=_range(image) <= RANGE + RANGE_OF_NOISE * level):
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


def _shaded(left: FloatArray, nearest: IntArray, quiet: NDArray[np.bool_]) -> bool:
    """Whether the residual of one colour a pixel is no noise: its mean over neighbours of that colour is large."""
    sums, counts = np.zeros_like(left), np.ones(nearest.shape)
    for k in np.unique(nearest):
        interruption.check()
        inside = (nearest == k).astype(np.float64)
        window = (WINDOW, WINDOW, 1)
        sums += inside[..., None] * ndimage.uniform_filter(left * inside[..., None], window)
        counts += inside * (ndimage.uniform_filter(inside, WINDOW) - 1)
    means = np.abs(sums / np.maximum(counts, 1e-9)[..., None]).max(axis=-1)
    return bool(quiet.any() and np.mean(means[quiet] > SHADE) > MOST_SHADED)


def _ringing(image: FloatArray, shown: FloatArray, nearest: IntArray) -> float:
    """Return the noise beside edges, as compression leaves it there: root mean square."""
    edge = ndimage.maximum_filter(nearest, 3) != ndimage.minimum_filter(nearest, 3)
    near = ndimage.binary_dilation(edge, np.ones((3, 3)), iterations=BESIDE) & ~ndimage.binary_dilation(edge)
    if not near.any():
        return 0.0
    return min(float(np.quantile(np.abs(image - shown).max(axis=-1)[near], 0.9) / 2), MOST_RINGING)


def _range(image: FloatArray) -> FloatArray:
    """Range of the colours within 5 x 5 pixels, of any channel."""
    size = (5, 5, 1)
    return np.asarray((ndimage.maximum_filter(image, size) - ndimage.minimum_filter(image, size)).max(axis=-1))


def _palette(image: FloatArray, noise: float) -> FloatArray | None:
    """Return the colours (K, C) that quiet pixels scatter around, the most frequent first; None for too many."""
    quiet = _range(image) <= RANGE + RANGE_OF_NOISE * noise
    means = np.asarray(ndimage.uniform_filter(image, (5, 5, 1)))[quiet]
    radius, least = RADIUS + RADIUS_OF_NOISE * noise, LEAST_COLOR * image.shape[0] * image.shape[1]
    colors: list[FloatArray] = []
    while len(means) >= least:
        interruption.check()
        bins, first, counts = np.unique(
            np.floor(means / BIN + 0.5).astype(np.int64), axis=0, return_index=True, return_counts=True
        )
        del first
        center = bins[np.argmax(counts)] * BIN
        for _ in range(3):
            near = np.abs(means - center).max(axis=1) <= radius
            center = means[near].mean(axis=0) if near.any() else center
        near = np.abs(means - center).max(axis=1) <= radius
        if near.sum() < least:
            break
        if len(colors) == MOST_COLORS:
            return None
        colors.append(center)
        means = means[~near]
    return np.array(colors) if colors else None


def _told_apart(palette: FloatArray, radius: float) -> FloatArray:
    """Return the colours that lie farther than a radius from every more frequent one."""
    kept: list[FloatArray] = []
    for color in palette:
        if all(np.abs(color - other).max() > radius for other in kept):
            kept.append(color)
    return np.array(kept)


def _relaxed(image: FloatArray, palette: FloatArray, noise: float) -> IntArray:
    """Return the colour of each pixel: the nearest, unless its neighbours have another."""
    spread = SPREAD + SPREAD_OF_NOISE * noise
    cost = np.empty((len(palette), *image.shape[:2]))
    for k, color in enumerate(palette):
        interruption.check()
        cost[k] = np.minimum(np.square((image - color) / spread).sum(axis=-1) / 2, MOST_COST)
    nearest = cost.argmin(axis=0)
    for _ in range(ROUNDS):
        lower = cost.copy()
        interruption.check()
        for k in range(len(palette)):
            interruption.check()
            lower[k] -= 9 * NEIGHBOR * ndimage.uniform_filter((nearest == k).astype(np.float64), 3)
        changed = lower.argmin(axis=0)
        if np.array_equal(changed, nearest):
            break
        nearest = changed
    return np.asarray(nearest, dtype=np.int64)
