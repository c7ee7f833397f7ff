# SPDX-License-Identifier: Apache-2.0
"""Seams: faint lines where two abutting shapes are composited within a pixel (conflation artifacts).

A renderer composites shape by shape. Where the first covers a share f of a pixel with colour A, over the colour G, and
the second the rest with colour B, the pixel becomes

    (1 - f) B + f (f A + (1 - f) G) = (1 - f) B + f^2 A + f (1 - f) G,

a line of up to a quarter of G along an edge between A and B (conflation of coverage and opacity: Porter and Duff,
SIGGRAPH 1984, section 4).
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.layering.segmentation.labels import EIGHT_NEIGHBORS

#: Largest residual of a seam: rounding to 8 bits, once for each of two shapes and once for their colours.
SEAM_MISS = 1.5 / 255
#: Reach, px, within which cores count as beside a pixel; blends of three pixels lie between touching cores.
REACH = 2
#: Fewest connected unexplained pixels, and the least share of them that look like seams: where three shapes meet, one
#: to three do, and by chance a few of a thin line.
LEAST_PIXELS, LEAST_SHARE = 5, 0.5
#: Pixels times triples fitted at once.
CHUNK = 1 << 18
#: Shares tried before the best is refined; Gauss-Newton steps of the refinement.
SHARES, STEPS = np.linspace(0, 1, 17), 3


@dataclasses.dataclass(frozen=True)
class Seams:
    """Pixels (P,) as seams: whether each is one, its two cores, the first one's share, and the residual."""

    found: BoolArray
    first: IntArray
    second: IntArray
    share: FloatArray
    miss: FloatArray


def find_seams(
    image: FloatArray, labels: IntArray, colors: FloatArray, rows: IntArray, columns: IntArray, miss: float
) -> Seams:
    """Explain pixels (P,) of a noise-free picture as seams between two nearby cores.

    A seam lies between two colours that differ by more than `miss`: a faint line across one colour was drawn. The
    colour that shows through is that of a third core, which touches one of the two.
    """
    seams = Seams(np.zeros(len(rows), bool), *np.zeros((2, len(rows)), np.int64), *np.ones((2, len(rows))))
    if not len(rows):
        return seams
    touching = _touching(labels, len(colors))
    interruption.check()
    _, kinds = np.unique(np.round(colors * 255), axis=0, return_inverse=True)
    padded = np.pad(labels, REACH)
    offsets = np.arange(2 * REACH + 1)
    windows = padded[rows[:, None, None] + offsets[:, None], columns[:, None, None] + offsets].reshape(len(rows), -1)
    windows.sort(axis=1)
    windows[:, 1:][windows[:, 1:] == windows[:, :-1]] = 0
    windows.sort(axis=1)
    interruption.check()
    sides, group = np.unique(windows, axis=0, return_inverse=True)
    order = np.argsort(group.ravel(), kind="stable")
    ends = np.cumsum(np.bincount(group.ravel(), minlength=len(sides)))
    for near, own in zip(sides, np.split(order, ends[:-1]), strict=True):
        interruption.check()
        triples = _triples(near[near > 0], colors, kinds.ravel(), touching, miss)
        if not len(triples):
            continue
        for one in np.array_split(own, 1 + len(own) * len(triples) // CHUNK):
            shares, misses = _fitted(image[rows[one], columns[one]][:, None], *colors[triples.T])
            at = misses.argmin(axis=1)
            every = np.arange(len(one))
            seams.first[one], seams.second[one] = triples[at, 0], triples[at, 1]
            seams.share[one], seams.miss[one] = shares[every, at], misses[every, at]
            seams.found[one] = misses[every, at] <= SEAM_MISS
    return dataclasses.replace(seams, found=seams.found & _mostly(seams.found, rows, columns, labels.shape))


def _touching(labels: IntArray, count: int) -> BoolArray:
    """Return which cores touch, up to the blends between them: (K + 1, K + 1)."""
    touching = np.zeros((count, count), bool)
    for step in range(1, REACH + 2):
        interruption.check()
        for a, b in ((labels[step:], labels[:-step]), (labels[:, step:], labels[:, :-step])):
            touching[a, b] = touching[b, a] = True
    touching[0] = touching[:, 0] = False
    return touching


def _triples(near: IntArray, colors: FloatArray, kinds: IntArray, touching: BoolArray, miss: float) -> IntArray:
    """Return candidate triples of cores (T, 3) near a pixel: two sides, in order, and the colour showing through.

    Of several cores of one colour that may show through, the first is taken.
    """
    found = []
    for a, b in itertools.permutations(near.tolist(), 2):
        if np.abs(colors[a] - colors[b]).max() > miss:
            through = np.flatnonzero(touching[a] | touching[b])
            _, first = np.unique(kinds[through], return_index=True)
            found += [(a, b, g) for g in through[first].tolist() if kinds[g] not in (kinds[a], kinds[b])]
    return np.array(found, dtype=np.int64).reshape(-1, 3)


def _fitted(wanted: FloatArray, a: FloatArray, b: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fit the share (P, T) of the first of three colours (T, C) to pixels (P, 1, C); return shares and residuals."""
    one, square = g - b, a - g  # the pixel is b + f (g - b) + f^2 (a - g)
    least, share = np.full((len(wanted), len(a)), np.inf), np.zeros((len(wanted), len(a)))
    for tried in SHARES:
        away = np.square(wanted - (b + tried * one + tried**2 * square)).sum(axis=-1)
        share[away < least] = tried
        least = np.minimum(least, away)
    for _ in range(STEPS):
        left = wanted - b - share[..., None] * one - np.square(share)[..., None] * square
        slope = one + 2 * share[..., None] * square
        step = (left * slope).sum(axis=-1) / np.maximum(np.square(slope).sum(axis=-1), 1e-12)
        share = np.clip(share + step, 0, 1)
    left = wanted - b - share[..., None] * one - np.square(share)[..., None] * square
    return share, np.abs(left).max(axis=-1)


def _mostly(found: BoolArray, rows: IntArray, columns: IntArray, size: tuple[int, ...]) -> BoolArray:
    """Whether each pixel belongs to a large enough component of pixels of which most are seams."""
    seen = np.zeros(size, bool)
    seen[rows, columns] = True
    patch = ndimage.label(seen, EIGHT_NEIGHBORS)[0][rows, columns]
    count, seams = np.bincount(patch), np.bincount(patch, weights=found)
    return np.asarray(((count >= LEAST_PIXELS) & (seams >= LEAST_SHARE * count))[patch])
