# SPDX-License-Identifier: Apache-2.0
"""Inks of line art: their colours, and the coverage of each pixel by each ink.

The paper is the most frequent colour, which may vary slowly over the picture, like the light on a photographed sheet;
inks are the colours farthest from it. The coverage of a pixel is the position of its colour between paper and ink,
which gives the border of a line to a fraction of a pixel.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray


@dataclasses.dataclass(frozen=True, kw_only=True)
class InkRules:
    """Thresholds for inks; distances are those of RGB in [0, 1].

    Values: chosen by hand on line drawings; with them, and no others, the errors of docs/strokes.md were measured.
    """

    blur: float = 0.5  # standard deviation, px, of the Gaussian that removes noise from the colours of inks
    contrast: float = 0.2  # least distance of an ink from the paper
    same_ink: float = 0.25  # largest distance between two colours of one ink
    even: float = 0.15  # largest share by which pixels within ink differ from their neighbours
    few: int = 4  # fewest pixels that determine an ink's colour
    near: float = 0.7  # standard deviation, px, of the Gaussian window in which a pixel's ink is decided


INKS = InkRules()


class Ink(NamedTuple):
    """Colour of an ink, and its coverage (H, W)."""

    color: FloatArray
    coverage: FloatArray


def inks_of(target: FloatArray, paper: FloatArray) -> list[Ink]:
    """Return the inks of a picture (H, W, C), the farthest from the paper's colour first."""
    smooth = ndimage.gaussian_filter(target, (INKS.blur, INKS.blur, 0))
    away = np.linalg.norm(smooth - paper, axis=2)
    peaks = (away >= ndimage.maximum_filter(away, 3)) & (away > INKS.contrast)
    inner = (ndimage.minimum_filter(away, 3) > (1 - INKS.even) * away) & (away > INKS.contrast)
    colors, filled = target[peaks][np.argsort(-away[peaks], kind="stable")], target[inner]
    inks: list[FloatArray] = []
    known = np.zeros(len(colors), bool)  # colours between the paper and an ink
    for k, color in enumerate(colors):
        if known[k]:
            continue
        interruption.check()
        near = np.linalg.norm(colors - color, axis=1) < INKS.same_ink
        if near.sum() >= max(INKS.few, 0.01 * len(colors)):
            full = filled[np.linalg.norm(filled - color, axis=1) < INKS.same_ink]
            inks.append(np.median(full if len(full) >= INKS.few else colors[near], axis=0))
            known |= _between(colors, paper, inks[-1]) < INKS.same_ink
    if not inks:
        return []
    shares, misses = [], []
    for ink in inks:
        interruption.check()
        way = ink - paper
        share = np.clip((target - paper) @ way / (way @ way), 0, 1)
        missed = np.square(target - paper - share[..., None] * way).sum(axis=2)
        shares.append(share)
        misses.append(ndimage.gaussian_filter(missed, INKS.near))
    nearest = np.argmin(misses, axis=0)
    return [Ink(ink, np.where(nearest == index, shares[index], 0.0)) for index, ink in enumerate(inks)]


def _between(colors: FloatArray, paper: FloatArray, ink: FloatArray) -> FloatArray:
    """Return the distance of each colour, (n, C), from the segment between paper and ink: (n,)."""
    along = ink - paper
    shares = np.clip((colors - paper) @ along / (along @ along), 0, 1)
    return np.asarray(np.linalg.norm(colors - paper - shares[:, None] * along, axis=1))
