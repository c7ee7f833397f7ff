# SPDX-License-Identifier: Apache-2.0
"""Whole-shape scores: overlap of a drawing's things with those of the true drawing, from which the picture was made.

A *thing* is a connected part of a single layer, parts hidden by other layers included.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.rendering.rasterizer import Rasterizer

#: Least coverage of a thing's pixels, number of pixels of the smallest thing, and least covered share of a thing that
#: counts as hidden.
INSIDE, SMALLEST, HIDDEN_SHARE = 0.5, 4, 0.01
#: Largest difference of matched things' colours, in any channel.
COLOR_DIFFERENCE = 0.08
#: Least overlap of a thing that counts as found, and of a match.
FOUND, MISSED = 0.9, 0.5


@dataclasses.dataclass(frozen=True)
class Things:
    """Connected parts of layers.

    Attributes
    ----------
    masks : (K, H, W) bool
        Pixels of each thing, hidden ones included.
    colors : (K, 3) float
        Straight RGB.
    layers : (K,) int
        Layer of each, 0 at the bottom.
    hidden : (K,) float
        Share of each thing's pixels that other layers cover.
    """

    masks: NDArray[np.bool_]
    colors: NDArray[np.float64]
    layers: NDArray[np.intp]
    hidden: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.masks)


def things_of(coverages: NDArray[Any], colors: NDArray[Any]) -> Things:
    """Return the things of layers, from coverages (N, H, W) and colours, (N, 3) or straight (N, 4)."""
    from skimage.measure import label

    inside = np.asarray(coverages) >= INSIDE
    above = np.zeros(inside.shape[1:], bool)
    masks, layers, hidden = [], [], []
    for layer in range(len(inside) - 1, -1, -1):
        labels = label(inside[layer], connectivity=2)
        sizes = np.bincount(labels.ravel())
        for k in range(1, len(sizes)):
            if sizes[k] >= SMALLEST:
                mask = labels == k
                masks.append(mask)
                layers.append(layer)
                hidden.append(np.count_nonzero(mask & above) / sizes[k])
        above |= inside[layer]
    order = np.arange(len(masks))[::-1]
    size = inside.shape[1:]
    return Things(
        np.array(masks).reshape(-1, *size)[order],
        np.asarray(colors, dtype=np.float64)[np.array(layers, int)[order], :3].reshape(-1, 3),
        np.array(layers, np.intp)[order],
        np.array(hidden, np.float64)[order],
    )


def things_of_drawing(
    drawing: Drawing, size: tuple[int, int] | None = None, rasterizer: Rasterizer | None = None
) -> Things:
    """Return the things of a drawing; a gradient has its mean colour within the thing.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    size : (int, int), optional
        Height and width, px, of the canvas to which it is stretched first.
    rasterizer : Rasterizer, optional
        One of that size; by default a new one.
    """
    drawing = drawing if size is None else scaled(drawing, size)
    rasterizer = Rasterizer(drawing.size) if rasterizer is None else rasterizer
    things = things_of(rasterizer.coverages(drawing), drawing.colors)
    shaded = set(drawing.fills.gradient_layers.tolist())
    for thing in np.flatnonzero([layer in shaded for layer in things.layers.tolist()]):
        alone = drawing.layer_subset([things.layers[thing]]).replace(background=None)
        premultiplied = rasterizer.forward(alone)[things.masks[thing]].sum(axis=0, dtype=np.float64)
        things.colors[thing] = premultiplied[:3] / max(premultiplied[3], np.finfo(np.float32).tiny)
    return things


def overlaps(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the intersection over union of all pairs of masks (K, H, W) and (L, H, W): (K, L)."""
    first = a.reshape(len(a), -1).astype(np.float32)
    second = b.reshape(len(b), -1).astype(np.float32)
    common = first @ second.T
    union = first.sum(1)[:, None] + second.sum(1)[None, :] - common
    return np.asarray(common / np.maximum(union, 1), dtype=np.float64)


def match_things(true: Things, ours: Things) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Match things one to one for the largest total overlap (Hungarian): overlap and index (K,); 0, -1 if unmatched."""
    from scipy.optimize import linear_sum_assignment

    scores, partner = np.zeros(len(true)), np.full(len(true), -1, np.intp)
    if len(true) and len(ours):
        near = np.abs(true.colors[:, None] - ours.colors[None]).max(axis=2) <= COLOR_DIFFERENCE
        table = overlaps(true.masks, ours.masks) * near
        rows, columns = linear_sum_assignment(-table)
        good = table[rows, columns] > 0
        scores[rows[good]] = table[rows, columns][good]
        partner[rows[good]] = columns[good]
    return scores, partner


@dataclasses.dataclass(frozen=True, kw_only=True)
class ThingScores:
    """Agreement of a drawing with a true one, thing by thing.

    Attributes
    ----------
    things, drawn : int
        Things of the true drawing, and of the other one.
    overlap : float
        Mean overlap of the true things with their matches, 0 for those unmatched; 0 without things.
    found : int
        True things with an overlap of at least .9.
    hidden : int
        True things of which others cover at least a hundredth.
    hidden_overlap : float
        Mean overlap of these; 0 without any.
    missed, extra : int
        True things, and things of the other drawing, without a match of overlap .5.
    """

    things: int
    drawn: int
    overlap: float
    found: int
    hidden: int
    hidden_overlap: float
    missed: int
    extra: int


def score_things(true: Things, drawn: Things) -> ThingScores:
    """Score the things of a drawing by those of the true one, as :func:`match_things` pairs them."""
    scores, _ = match_things(true, drawn)
    hidden = true.hidden >= HIDDEN_SHARE
    partners = int(np.count_nonzero(scores >= MISSED))
    return ThingScores(
        things=len(true),
        drawn=len(drawn),
        overlap=float(scores.mean()) if len(true) else 0.0,
        found=int(np.count_nonzero(scores >= FOUND)),
        hidden=int(np.count_nonzero(hidden)),
        hidden_overlap=float(scores[hidden].mean()) if hidden.any() else 0.0,
        missed=len(true) - partners,
        extra=len(drawn) - partners,
    )


def score_drawing(true: Drawing, drawing: Drawing) -> ThingScores:
    """Score a drawing's whole shapes by those of the drawing that its picture was made from.

    Parameters
    ----------
    true : Drawing
        The original drawing, as of :func:`livecl.read_svg`; it is stretched to `drawing`'s canvas.
    drawing : Drawing
        Drawing made from the picture alone.

    References
    ----------
    H. W. Kuhn: *The Hungarian method for the assignment problem*. Naval Research Logistics Quarterly 2, 1955.
    """
    rasterizer = Rasterizer(drawing.size)
    return score_things(
        things_of_drawing(true, drawing.size, rasterizer), things_of_drawing(drawing, rasterizer=rasterizer)
    )
