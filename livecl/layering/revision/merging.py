# SPDX-License-Identifier: Apache-2.0
"""Merging: join neighbouring layers of one colour that lie on one flat region of the picture."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import FloatArray, Window
from livecl.drawing.assembly import concatenate
from livecl.drawing.drawing import Drawing
from livecl.image.errors import visible_error
from livecl.layering.componentwise.candidates import SEGMENT_ERROR, fitted_outlines
from livecl.layering.context import Context
from livecl.layering.contributions import (
    VISIBLE_SHARE,
    composited_colors,
    in_window,
    layer_alphas,
    opacity_at_pixels,
    visible_shares,
)
from livecl.layering.neighbors import flat_labels, mergeable_pairs
from livecl.layering.stack import window_of

#: Most merges tried at a time, which bounds the time for pictures of very many layers.
MAX_TRIALS = 64
#: Step through the outlines fitted to the union of two layers: trying every fourth takes a quarter of the time.
FIT_STEP = 4


@dataclasses.dataclass(frozen=True)
class _Paint:
    """Several layers composited into one: premultiplied colour (h, w, C), and transmittance (h, w)."""

    color: NDArray[Any]
    transmittance: NDArray[Any]

    def over(self, ground: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(self.color + self.transmittance[..., None] * ground)


@dataclasses.dataclass(frozen=True)
class _Merge:
    """Layer that replaces two: a drawing of it alone, its alpha (H, W), its depth, and the rise of the error."""

    layer: Drawing
    alpha: NDArray[Any]
    depth: int
    change: float


@dataclasses.dataclass(frozen=True)
class Merged:
    """A drawing after merging, and the former index of each layer, -1 for a merged one: (N,) int."""

    drawing: Drawing
    sources: NDArray[np.intp]


def can_merge(drawing: Drawing) -> bool:
    """Whether a drawing can be merged: it has filled layers only, no strokes."""
    return not drawing.strokes.any


def merge_neighbors(context: Context, drawing: Drawing, free: NDArray[np.bool_], tolerance: float) -> Merged:
    """Merge `free` layers, (N,), while the total rise of the mean squared error stays within `tolerance`.

    Two neighbouring layers of the same colour (:func:`livecl.layering.neighbors.mergeable_pairs`) merge if most of
    their visible pixels lie in the same flat region of the picture. The new outline is fitted to their union, or
    consists of both outlines, whichever does better for its number of segments, at the depth of either.
    """
    sources = np.arange(drawing.num_layers)
    regions, risen = flat_labels(context.target), 0.0
    alphas = layer_alphas(drawing, context.rasterizer)
    refused: set[tuple[int, int]] = set()
    trials = 0
    merged = True
    while merged and trials < MAX_TRIALS:
        merged = False
        for lower, upper in _pairs(drawing, visible_shares(alphas), regions):
            old = int(sources[lower]), int(sources[upper])
            held = any(source >= 0 and not free[source] for source in old)
            if held or (-1 not in old and old in refused) or trials == MAX_TRIALS:
                continue
            interruption.check()
            trials += 1
            best = _best(context, drawing, alphas, (lower, upper))
            if risen + best.change > tolerance:
                refused.add(old)
                continue
            risen = max(0.0, risen + best.change)
            order = np.arange(drawing.num_layers)
            order[best.depth] = drawing.num_layers
            order = order[order != lower + upper - best.depth]
            drawing = concatenate(drawing, best.layer).layer_subset(order)
            alphas = np.concatenate([alphas, best.alpha[None]])[order]
            sources = np.append(sources, -1)[order]
            merged = True
            break
    return Merged(drawing, sources)


def _pairs(drawing: Drawing, shares: NDArray[Any], regions: NDArray[Any]) -> list[tuple[int, int]]:
    """Return the pairs to merge, lower layer first, ordered by the area of their smaller part."""
    areas = (shares > VISIBLE_SHARE).sum(axis=(1, 2))
    homes = []
    for share in shares:
        interruption.check()
        homes.append(int(np.argmax(np.bincount(regions[share > VISIBLE_SHARE], minlength=1))))
    pairs = [(int(i), int(j)) for i, j in mergeable_pairs(drawing, shares) if homes[i] == homes[j]]
    return sorted(pairs, key=lambda pair: (min(areas[list(pair)]), pair))


def _best(context: Context, drawing: Drawing, alphas: NDArray[Any], pair: tuple[int, int]) -> _Merge:
    """Return the best layer to replace two, by the error and the number of segments.

    Unchanged layers are composited once: those below the two are one ground, those between and those above are one
    paint each, of colour P and transmittance T, showing P + T C over the colour C. Each merge is composited from these,
    within the window of change.
    """
    (lower, upper), target = pair, context.target
    larger = max(pair, key=lambda layer: float(alphas[layer].sum()))
    mask = np.maximum(alphas[lower], alphas[upper]) > VISIBLE_SHARE
    both = [drawing.points[subpath] for layer in pair for subpath in drawing.subpaths(layer)]
    outlines = [both, *fitted_outlines(mask, context.options)[::FIT_STEP]]
    fill, fills = drawing.colors[larger], drawing.fills.subset([larger])
    candidates = Drawing.from_outlines(outlines, (0, 0, 0, 1), drawing.size)
    opacity = opacity_at_pixels(drawing, larger)
    covered = opacity * context.rasterizer.coverages(candidates)
    window = window_of(np.maximum.reduce([alphas[lower], alphas[upper], *covered]))
    ground, colors = composited_colors(drawing)
    ranges = range(lower), range(lower + 1, upper), range(upper + 1, drawing.num_layers)
    below, between, above = (_together(alphas, colors, layers, window) for layers in ranges)

    def squared_error(*paints: _Paint) -> float:
        image: NDArray[Any] = below.over(np.broadcast_to(ground, target[window].shape))
        for paint in (*paints, above):
            image = paint.over(image)
        return float(np.square(visible_error(image - target[window]), dtype=np.float64).sum())

    before = squared_error(_paint(alphas, colors, lower, window), between, _paint(alphas, colors, upper, window))
    found: list[tuple[float, _Merge]] = []
    for outline, alpha in zip(outlines, covered, strict=True):
        interruption.check()
        paint = _Paint(alpha[window][..., None] * in_window(colors[larger], window), 1 - alpha[window])
        layer = Drawing.from_outlines(
            [outline], fill, drawing.size, drawing.background, drawing.stages[[lower]], fills=fills
        )
        for depth, paints in ((lower, (paint, between)), (upper, (between, paint))):
            change = (squared_error(*paints) - before) / (3 * target[..., 0].size)
            price = SEGMENT_ERROR / target.size * layer.num_segments
            found.append((change + price, _Merge(layer, alpha, depth, change)))
    return min(found, key=lambda item: item[0])[1]


def _paint(alphas: NDArray[Any], colors: list[FloatArray], layer: int, window: Window) -> _Paint:
    alpha = alphas[layer][window]
    return _Paint(alpha[..., None] * in_window(colors[layer], window), 1 - alpha)


def _together(alphas: NDArray[Any], colors: list[FloatArray], layers: range, window: Window) -> _Paint:
    """Composite layers, bottom to top, within a window: return P and T, which show P + T C over C."""
    shape = alphas[0][window].shape
    paint = _Paint(np.zeros((*shape, colors[0].shape[-1])), np.ones(shape))
    for layer in layers:
        interruption.check()
        if alphas[layer][window].any():
            own = _paint(alphas, colors, layer, window)
            paint = _Paint(own.over(paint.color), own.transmittance * paint.transmittance)
    return paint
