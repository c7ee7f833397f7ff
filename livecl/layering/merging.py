# SPDX-License-Identifier: Apache-2.0
"""Neighbouring layers of one colour on one flat region of the picture made one: a path for each thing that is seen."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing, concatenate
from livecl.image.errors import visible_mse
from livecl.layering.candidates import SEGMENT_ERROR, fitted_outlines, layers_of
from livecl.layering.contributions import VISIBLE_SHARE, layer_alphas, visible_shares
from livecl.layering.neighbors import flat_regions, mergeable_pairs
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer

#: Most merges that are tried at a time.
MOST_TRIALS = 64
#: Of the outlines fitted to two layers together, one in so many is tried.
FIT_STEP = 4


@dataclasses.dataclass(frozen=True)
class Merged:
    """A drawing, and for each of its layers the number that it had before, or -1 for one made of two: (N,) int."""

    drawing: Drawing
    sources: NDArray[np.intp]


def merge_neighbors(
    drawing: Drawing,
    rasterizer: Rasterizer,
    target: NDArray[Any],
    options: Options,
    free: NDArray[np.bool_],
    tolerance: float,
    check: Callable[[], None] = lambda: None,
) -> Merged:
    """Merge `free` layers, (N,), as long as the mean squared error rises by at most `tolerance` for each.

    Two layers that touch, of the same colour (:func:`livecl.layering.neighbors.mergeable_pairs`), become one where
    most of what is visible of them lies in the same flat region of the picture. The new outline is that of both
    together, fitted anew, or simply both outlines, whichever does better for its number of segments, at the depth of
    either.

    `check` is called before each try; what it raises ends the merging.
    """
    sources = np.arange(drawing.num_layers)
    regions, error = flat_regions(target), visible_mse(rasterizer.forward(drawing), target)
    refused: set[tuple[int, int]] = set()
    trials = 0
    merged = True
    while merged and trials < MOST_TRIALS:
        merged = False
        alphas = layer_alphas(drawing, rasterizer)
        shares = visible_shares(alphas)
        for lower, upper in _pairs(drawing, shares, regions):
            old = int(sources[lower]), int(sources[upper])
            held = any(source >= 0 and not free[source] for source in old)
            if held or (-1 not in old and old in refused) or trials == MOST_TRIALS:
                continue
            check()
            trials += 1
            mask = np.maximum(alphas[lower], alphas[upper]) > VISIBLE_SHARE
            best, order, best_error = _best(drawing, lower, upper, mask, rasterizer, target, options)
            if best_error - error > tolerance:
                refused.add(old)
                continue
            drawing, error, merged = best, min(error, best_error), True
            sources = np.append(sources, -1)[order]
            break
    return Merged(drawing, sources)


def _pairs(drawing: Drawing, shares: NDArray[Any], regions: NDArray[Any]) -> list[tuple[int, int]]:
    """Return the pairs to merge, lower layer first, those of which the smaller part is smallest first."""
    areas = (shares > VISIBLE_SHARE).sum(axis=(1, 2))
    homes = [int(np.argmax(np.bincount(regions[share > VISIBLE_SHARE], minlength=1))) for share in shares]
    pairs = [(int(i), int(j)) for i, j in mergeable_pairs(drawing, shares) if homes[i] == homes[j]]
    return sorted(pairs, key=lambda pair: (min(areas[list(pair)]), pair))


def _best(
    drawing: Drawing,
    lower: int,
    upper: int,
    mask: NDArray[np.bool_],
    rasterizer: Rasterizer,
    target: NDArray[Any],
    options: Options,
) -> tuple[Drawing, NDArray[np.intp], float]:
    """Return the best drawing with two layers made one, its layers by their numbers before, and its error."""
    count = drawing.num_layers
    larger = max(lower, upper, key=lambda layer: int(np.diff(drawing.segment_offsets)[layer]))
    together = drawing.layer_subset([lower, upper])
    outlines = [
        [together.points[first:end] for first, end in pairwise(together.subpath_offsets)],
        *fitted_outlines(mask, options)[::FIT_STEP],
    ]
    found: list[tuple[float, int, Drawing, NDArray[np.intp], float]] = []
    for outline in outlines:
        new = layers_of([outline], drawing.size, drawing.colors[larger])
        new = new.replace(background=drawing.background, stages=drawing.stages[[lower]])
        both = concatenate(drawing, new)
        for depth in (lower, upper):
            order = np.arange(count)
            order[depth] = count
            order = order[order != (lower + upper - depth)]
            trial = both.layer_subset(order)
            error = visible_mse(rasterizer.forward(trial), target)
            found.append((error + SEGMENT_ERROR / target.size * trial.num_segments, len(found), trial, order, error))
    _, _, trial, order, error = min(found, key=lambda item: item[:2])
    return trial, order, error
