# SPDX-License-Identifier: Apache-2.0
"""Paper and inks of line art: their colours, and the share of each pixel that each ink covers.

The paper is the most frequent colour, which may change slowly over the picture, as light does on a photographed sheet;
inks are the colours farthest from it. A pixel between paper and ink is covered by ink by the share that its colour lies
between the two, which gives the border of a line to a fraction of a pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

FloatArray = NDArray[np.float64]

#: Standard deviation, px, of the Gaussian that takes noise out of the colours of inks.
BLUR = 0.5
#: Distance in RGB from the paper that is ink at least, and of two inks that are one.
CONTRAST, SAME_INK = 0.2, 0.25
#: Share by which pixels within ink may differ from their neighbours, and how many tell its colour.
EVEN, FEW = 0.15, 4
#: Standard deviation, px, of the Gaussian around a pixel within which the colours tell its ink.
NEAR = 0.7
#: Change of the paper's colour over the picture from which on it is taken out.
SHADING = 0.03
#: Rounds of least squares, each without the pixels that the one before finds to be no paper.
ROUNDS = 4


class Ink(NamedTuple):
    """Colour of an ink, and its share of each pixel (H, W)."""

    color: FloatArray
    coverage: FloatArray


def paper_of(target: FloatArray) -> FloatArray:
    """Return the most frequent colour: the median of the pixels in the fullest cell of a grid of colours."""
    pixels = target.reshape(-1, target.shape[2])
    cells = np.floor(np.clip(pixels, 0, 1) * 15.999).astype(np.int64) @ 16 ** np.arange(pixels.shape[1])
    values, counts = np.unique(cells, return_counts=True)
    return np.asarray(np.median(pixels[cells == values[np.argmax(counts)]], axis=0))


def without_shading(target: FloatArray, paper: FloatArray) -> FloatArray:
    """Return a picture (H, W, C) whose paper is of one colour: divided by a square polynomial of its shade.

    The polynomial is fitted to the pixels near the paper's colour, then to those near the polynomial; where it says
    that the paper changes by less than `SHADING`, or by more than light does, the picture stays as it is.
    """
    rows, columns = np.indices(target.shape[:2])
    y, x = 2 * rows.ravel() / max(rows.max(), 1) - 1, 2 * columns.ravel() / max(columns.max(), 1) - 1
    terms = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1)
    pixels = target.reshape(-1, target.shape[2])
    shade = np.broadcast_to(paper, pixels.shape)
    for _ in range(ROUNDS):
        near = np.abs(pixels - shade).max(axis=1) < CONTRAST / 2
        if near.mean() < 0.25:
            return target
        shade = terms @ np.linalg.lstsq(terms[near], pixels[near], rcond=None)[0]
    change = np.ptp(shade, axis=0).max()
    if change < SHADING or shade.min() < 0.25 * max(float(paper.min()), 1e-6):
        return target
    return np.clip(target * (paper / np.maximum(shade, 1e-3)).reshape(target.shape), 0, 1)


def inks_of(target: FloatArray, paper: FloatArray) -> list[Ink]:
    """Return the inks of a picture (H, W, C) on paper of a colour, the farthest from it first."""
    smooth = ndimage.gaussian_filter(target, (BLUR, BLUR, 0))
    away = np.linalg.norm(smooth - paper, axis=2)
    peaks = (away >= ndimage.maximum_filter(away, 3)) & (away > CONTRAST)
    inner = (ndimage.minimum_filter(away, 3) > (1 - EVEN) * away) & (away > CONTRAST)
    colors, filled = target[peaks], target[inner]
    inks: list[FloatArray] = []
    for color in colors[np.argsort(-away[peaks], kind="stable")]:
        if not any(_between(color, paper, ink) < SAME_INK for ink in inks):
            near = np.linalg.norm(colors - color, axis=1) < SAME_INK
            if near.sum() >= max(FEW, 0.01 * len(colors)):
                full = filled[np.linalg.norm(filled - color, axis=1) < SAME_INK]
                inks.append(np.median(full if len(full) >= FEW else colors[near], axis=0))
    if not inks:
        return []
    shares = np.stack(
        [np.clip((target - paper) @ (ink - paper) / ((ink - paper) @ (ink - paper)), 0, 1) for ink in inks]
    )
    misses = np.stack(
        [
            ndimage.gaussian_filter(np.square(target - paper - share[..., None] * (ink - paper)).sum(axis=2), NEAR)
            for ink, share in zip(inks, shares, strict=True)
        ]
    )
    nearest = np.argmin(misses, axis=0)
    return [Ink(ink, np.where(nearest == index, shares[index], 0.0)) for index, ink in enumerate(inks)]


def _between(color: FloatArray, paper: FloatArray, ink: FloatArray) -> float:
    """Return the distance of a colour from the line between paper and ink."""
    along = ink - paper
    share = np.clip((color - paper) @ along / (along @ along), 0, 1)
    return float(np.linalg.norm(color - paper - share * along))
