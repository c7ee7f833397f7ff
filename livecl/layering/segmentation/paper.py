# SPDX-License-Identifier: Apache-2.0
"""Paper under uneven light: its colour, the light taken out, and the flat regions that lie beneath light and noise.

A photographed or scanned sheet is a flat picture times slowly varying light, plus noise. Divided by the light it is
segmented like any noisy flat picture; its regions then have the fills of the picture as it is.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.layering.segmentation.flat import noisy_regions
from livecl.layering.segmentation.noise import noise_level
from livecl.layering.segmentation.smooth import SmoothRegions


@dataclasses.dataclass(frozen=True, kw_only=True)
class PaperRules:
    """Thresholds for paper; distances are those of colours in [0, 1].

    Values: chosen by hand on line drawings; with them, and no others, the errors of docs/strokes.md were measured.
    """

    near: float = 0.1  # largest distance of paper from the light fitted to it
    least: float = 0.25  # least share of the pixels that is paper, and least brightness of the light beside the paper's
    shading: float = 0.03  # least change of the paper's colour over the picture that is corrected
    rounds: int = 4  # rounds of least squares, each without the pixels that the last one finds to be no paper


PAPER = PaperRules()


def paper_of(target: FloatArray) -> FloatArray:
    """Return the colour of the paper, the most frequent one: the median of the fullest bin of a colour histogram."""
    pixels = target.reshape(-1, target.shape[2])
    cells = np.floor(np.clip(pixels, 0, 1) * 15.999).astype(np.int64) @ 16 ** np.arange(pixels.shape[1])
    values, counts = np.unique(cells, return_counts=True)
    return np.asarray(np.median(pixels[cells == values[np.argmax(counts)]], axis=0))


def without_shading(target: FloatArray, paper: FloatArray) -> FloatArray:
    """Correct uneven lighting: divide a picture (H, W, C) by a quadratic polynomial fitted to its paper.

    The polynomial is fitted to the pixels near the paper's colour, then to those near the polynomial. If the paper
    varies by less than `PAPER.shading`, or by more than lighting does, the same picture is returned.
    """
    rows, columns = np.indices(target.shape[:2])
    y, x = 2 * rows.ravel() / max(rows.max(), 1) - 1, 2 * columns.ravel() / max(columns.max(), 1) - 1
    terms = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1)
    pixels = target.reshape(-1, target.shape[2])
    shade = np.broadcast_to(paper, pixels.shape)
    for _ in range(PAPER.rounds):
        interruption.check()
        near = np.abs(pixels - shade).max(axis=1) < PAPER.near
        if near.mean() < PAPER.least:
            return target
        # The normal equations: six terms within [-1, 1] are well conditioned, and need no copy of the pixels.
        some = terms[near]
        shade = terms @ np.linalg.solve(some.T @ some + 1e-9 * np.eye(6), some.T @ pixels[near])
    change = np.ptp(shade, axis=0).max()
    if change < PAPER.shading or shade.min() < PAPER.least * max(float(paper.min()), 1e-6):
        return target
    return np.clip(target * (paper / np.maximum(shade, 1e-3)).reshape(target.shape), 0, 1)


def lit_regions(image: NDArray[np.floating], price: float, kinds: tuple[str, ...]) -> SmoothRegions | None:
    """Segment a noisy picture (H, W, C) that is flat but for the light on it; None if it is none.

    A picture without noise is none, though it may seem to have some once the steps of its slopes are stretched.
    """
    pixels: FloatArray = np.asarray(image, dtype=np.float64)
    if not noise_level(pixels):
        return None
    even = without_shading(pixels, paper_of(pixels))
    flat = None if even is pixels else noisy_regions(even)
    if flat is None:
        return None
    return SmoothRegions(**vars(flat), image=pixels, price=price, kinds=kinds, inner=flat.share == 1)
