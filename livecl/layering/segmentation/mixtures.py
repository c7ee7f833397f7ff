# SPDX-License-Identifier: Apache-2.0
"""Mixtures: explain pixels of anti-aliased borders by the two nearby cores that mix to their colour.

Where no two do, the pixel may be a seam: the faint line that a renderer leaves between abutting shapes.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.layering.segmentation.seams import find_seams

#: Number of nearest cores considered, and the residual that a px of distance counts for.
NEAR, DISTANCE_MISS = 4, 1 / 255
#: Share of pixels explained by no two colours above which a picture is not flat: no seams are sought.
MOST_UNEXPLAINED = 0.05
_OFFSETS = sorted(
    ((y, x) for y in range(-2, 3) for x in range(-2, 3) if (y, x) != (0, 0)), key=lambda o: (o[0] ** 2 + o[1] ** 2, o)
)


@dataclasses.dataclass(frozen=True)
class Mixture:
    """Pixels outside cores: positions (P,), the two cores, the share of the first, and the residual."""

    rows: IntArray
    columns: IntArray
    first: IntArray
    second: IntArray
    share: FloatArray
    miss: FloatArray


def explain(image: FloatArray, labels: IntArray, colors: FloatArray | None) -> Mixture:
    """Explain each pixel outside the cores as the best mixture of two nearby cores.

    Cores have colours (K + 1, C), or, if None, those of their pixels nearest to it.
    """
    rows, columns = np.nonzero(labels == 0)
    padded = np.pad(labels, 2)
    near, distance = np.zeros((len(rows), NEAR), np.int64), np.zeros((len(rows), NEAR))
    seen = np.zeros((len(rows), NEAR, image.shape[2]))
    count = np.zeros(len(rows), np.int64)
    for dy, dx in _OFFSETS:
        interruption.check()
        core = padded[rows + 2 + dy, columns + 2 + dx]
        new = np.flatnonzero((core > 0) & (count < NEAR) & ~(near == core[:, None]).any(axis=1))
        near[new, count[new]], distance[new, count[new]] = core[new], np.hypot(dy, dx)
        seen[new, count[new]] = image[rows[new] + dy, columns[new] + dx] if colors is None else colors[core[new]]
        count[new] += 1
    wanted = image[rows, columns]
    first, second = np.zeros((2, len(rows)), np.int64)
    share, miss, best = np.ones(len(rows)), np.full(len(rows), np.inf), np.full(len(rows), np.inf)
    for i in range(NEAR):
        for j in range(i, NEAR):
            interruption.check()
            here = np.flatnonzero((near[:, i] > 0) & (near[:, j] > 0))
            if not len(here):
                continue
            a, b = seen[here, i], seen[here, j]
            difference = a - b
            square = np.square(difference).sum(axis=1)
            part = ((wanted[here] - b) * difference).sum(axis=1) / np.maximum(square, 1e-12)
            part = np.where(square > 0, np.clip(part, 0, 1), 1.0)
            left = np.abs(wanted[here] - b - part[:, None] * difference).max(axis=1)
            score = left + DISTANCE_MISS * (distance[here, i] + distance[here, j])
            better = score < best[here]
            at = here[better]
            first[at], second[at], share[at] = near[at, i], near[at, j], part[better]
            best[at], miss[at] = score[better], left[better]
    return Mixture(rows, columns, first, second, share, miss)


def with_seams(image: FloatArray, labels: IntArray, colors: FloatArray, mixture: Mixture, miss: float) -> Mixture:
    """Explain pixels that no mixture of two colours explains as seams."""
    missed = np.flatnonzero(mixture.miss > miss)
    if len(missed) > MOST_UNEXPLAINED * labels.size:
        return mixture
    seams = find_seams(image, labels, colors, mixture.rows[missed], mixture.columns[missed], miss)
    changed = {name: getattr(mixture, name).copy() for name in ("first", "second", "share", "miss")}
    for name, values in changed.items():
        values[missed[seams.found]] = getattr(seams, name)[seams.found]
    return dataclasses.replace(mixture, **changed)
