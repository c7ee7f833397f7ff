# SPDX-License-Identifier: Apache-2.0
"""Line work: choose the strokes of a flat picture that are cheaper than the shapes they replace.

A structure explains a flat picture by shapes, and strokes explain some of it again: shapes visible only where strokes
are become needless. Strokes are accepted where the numbers saved are worth the added error, at the common price of a
number (`SEGMENT_ERROR` for six).
"""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, IntArray
from livecl.drawing.assembly import concatenate
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import concatenate_fills
from livecl.image.errors import visible_error
from livecl.layering.componentwise.candidates import SEGMENT_ERROR, paint_of
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas
from livecl.layering.fills.choice import shading_of
from livecl.layering.slack import edge_offset
from livecl.layering.strokes.finding import find_line_art
from livecl.layering.strokes.thinning import COLOR_NUMBERS, LEFT, numbers_of_all
from livecl.layering.structure.finding import structure_of
from livecl.layering.structure.placing import Beside, fitted_layer, outline_noise
from livecl.layering.structure.ranking import INSIDE, Structure, painted

#: Least shares that remain after training of the error added by strokes, and after redrawing of their numbers: strokes
#: that would cost more even so are not trained.
HOPE, REDRAWN = 0.02, 0.5
#: Numbers of a border of a filled shape, which shares its outline: width and colour.
BORDER_NUMBERS = 1 + COLOR_NUMBERS


class Explanation(NamedTuple):
    """Description of a picture by a drawing: its numbers and its squared error."""

    numbers: float
    error: float

    @property
    def price(self) -> float:
        """Total price, as squared error."""
        return self.numbers * SEGMENT_ERROR / 6 + self.error


def _explanation(context: Context, drawing: Drawing, around: float = 0.0) -> Explanation:
    return Explanation(numbers_of_all(drawing) + around, context.priced_error(drawing))


@dataclasses.dataclass(frozen=True, eq=False)
class LineWork:
    """Strokes of a picture, and the layers of its structure needed beside them.

    Attributes
    ----------
    found : Structure
        Structure of the picture.
    strokes : Drawing
        The strokes, bottom first.
    kept : (N,) bool
        Layers of the structure needed beside the strokes.
    plain : Explanation
        Explanation of the picture by the structure alone.
    around : float
        Numbers that can be saved by drawing omitted layers as borders.
    """

    found: Structure
    strokes: Drawing
    kept: BoolArray
    plain: Explanation
    around: float = 0.0

    def beside(self, context: Context, drawing: Drawing) -> Beside:
        """Return the depths of a drawing's strokes, trained or redrawn, in the structure."""
        strokes = drawing.layer_subset(drawing.strokes.stroked_layers)
        return Beside(self.kept, _depths(context, self.found, self.kept, strokes))

    def worthwhile(self, context: Context, drawing: Drawing) -> bool:
        """Whether a trained drawing with the strokes is no more expensive than the untrained structure alone."""
        return _explanation(context, drawing, self.around).price <= self.plain.price


def line_work(context: Context, background: NDArray[Any] | None, total: int) -> LineWork:
    """Choose the strokes that explain a flat picture more cheaply than layers of its structure, `total` at most.

    Greedy, from the cheaper of all strokes and none: each stroke is added or removed if that lowers the price. Pixel
    art has no strokes, as its outlines are exact.
    """
    found = _structure(context, background, total)
    strokes = _without_dots(find_line_art(context, background).strokes)
    worthwhile = np.isin(np.arange(len(found.layers)), found.ranked)
    if found.exact or not strokes.num_layers:
        return LineWork(found, strokes.layer_subset(np.zeros(0, np.int64)), worthwhile, Explanation(0, 0))
    return _Choice(context, found, strokes, worthwhile).best()


def edge_offset_of(context: Context, background: NDArray[Any] | None, total: int) -> float:
    """Return the distance, px, that the edges of a flat picture may lie off, from the outlines of its structure."""
    layers = _structure(context, background, total).layers
    return edge_offset([points for layer in layers if not (layer.exact or layer.over) for points in layer.outlines])


def _structure(context: Context, background: NDArray[Any] | None, total: int) -> Structure:
    asked = 0 if context.options.path_gain else total
    return structure_of(context.target, background, total, shading_of(context.options), asked)


def _without_dots(strokes: Drawing) -> Drawing:
    """Remove layers that consist of dots, strokes no longer than wide: these are discs."""
    sizes = [float(np.ptp(strokes.points[rows], axis=(0, 1)).max()) for rows in strokes.subpaths()]
    longest = np.maximum.reduceat(sizes, strokes.layer_offsets[:-1]) if sizes else np.zeros(0)
    return strokes.layer_subset(np.flatnonzero(longest > strokes.strokes.widths))


def _depths(context: Context, found: Structure, kept: BoolArray, strokes: Drawing) -> IntArray:
    """Return the number of layers of a structure below each of some strokes (K,), given which layers (N,) are kept.

    A stroke is visible where the top layer lies below it. Its depth is the one at which it removes most error; of
    depths that differ by less than the price of a segment, the highest. Borders of regions do not count, as untrained
    strokes miss them, and of what they miss else a part remains.
    """
    top, target = _top(found, kept), np.asarray(context.target, dtype=np.float64)
    shown = painted(found.regions, found.layers, found.ground, top)
    error = np.square(visible_error(target - shown)).sum(axis=-1)
    depths, inner = [], _inner(found)
    for alpha, color in zip(layer_alphas(strokes, context.rasterizer), strokes.colors, strict=True):
        paint = np.append(color[:3], 1.0)[: target.shape[2]]
        drawn = shown + alpha[..., None] * (paint - shown)
        removed = LEFT * inner * (error - np.square(visible_error(target - drawn)).sum(axis=-1))
        gains = np.cumsum(np.bincount(top.ravel(), removed.ravel(), len(found.layers) + 1))
        depths.append(int(np.flatnonzero(gains >= gains.max() - SEGMENT_ERROR)[-1]))
    return np.array(depths, dtype=np.int64)


def _inner(found: Structure) -> BoolArray:
    """Return the pixels (H, W) that are not at borders between regions."""
    labels = found.regions.labels
    return np.asarray(ndimage.minimum_filter(labels, 3) == ndimage.maximum_filter(labels, 3))


def _top(found: Structure, kept: BoolArray) -> IntArray:
    """Return the index of the top layer at each pixel among those kept, 1 for the lowest: (H, W)."""
    top = np.zeros(found.top.shape, np.int64)
    for layer in np.flatnonzero(kept).tolist():
        if not found.layers[layer].over:
            top[found.masks[layer]] = layer + 1
    return top


class _Choice:
    """Explanations of a picture by its structure (N layers) and a subset of its strokes (K layers)."""

    def __init__(self, context: Context, found: Structure, strokes: Drawing, worthwhile: BoolArray) -> None:
        self._context, self._found, self._strokes, self._worthwhile = context, found, strokes, worthwhile
        self._alphas = layer_alphas(strokes, context.rasterizer)
        noise, layers = outline_noise(found), np.flatnonzero(worthwhile).tolist()
        self._fills = Drawing.from_outlines(
            [fitted_layer(found.layers[k], *noise) for k in layers],
            np.array([paint_of(found.layers[k].color) for k in layers]).reshape(-1, 4),
            strokes.size,
            strokes.background,
            fills=concatenate_fills([found.fills_of(k) for k in layers]),
        )
        self._numbers = np.zeros(len(found.layers))
        for place, k in enumerate(layers):
            self._numbers[k] = numbers_of_all(self._fills.layer_subset([place]))
        self._inner = _inner(found)

    def best(self) -> LineWork:
        """Return the cheapest choice found by greedy search."""
        count = self._strokes.num_layers
        nothing = np.zeros(count, bool)
        plain = self._explained(nothing, self._needed(nothing))
        taken, least = nothing, plain.price
        for changes in [~nothing, *(np.eye(count, dtype=bool) if count > 1 else ())]:
            interruption.check()
            hoped = self._hoped(taken ^ changes, plain)
            if hoped < least:
                taken, least = taken ^ changes, hoped
        kept = self._needed(taken)
        strokes = self._strokes.layer_subset(np.flatnonzero(taken))
        return LineWork(self._found, strokes, kept, plain, self._saved_around(kept))

    def _hoped(self, taken: BoolArray, plain: Explanation) -> float:
        """Return a lower bound of the price with some strokes, (K,) bool, after training and redrawing."""
        found = self._explained(taken, self._needed(taken))
        strokes = numbers_of_all(self._strokes.layer_subset(np.flatnonzero(taken)))
        rise = max(found.error - plain.error, 0.0)
        return found.price - (1 - HOPE) * rise - (1 - REDRAWN) * strokes * SEGMENT_ERROR / 6

    def _needed(self, taken: BoolArray) -> BoolArray:
        """Return the layers of the structure, (N,) bool, needed beside some strokes, (K,) bool."""
        kept = self._worthwhile.copy()
        if taken.any():
            strokes = self._strokes.layer_subset(np.flatnonzero(taken))
            self._leave_out(kept, self._alphas[taken], _depths(self._context, self._found, kept, strokes))
        return kept

    def _explained(self, taken: BoolArray, kept: BoolArray) -> Explanation:
        """Evaluate the explanation by some strokes, (K,) bool, and layers of the structure, (N,) bool."""
        fills = self._fills.layer_subset(np.flatnonzero(kept[self._worthwhile]))
        strokes = self._strokes.layer_subset(np.flatnonzero(taken))
        depths = _depths(self._context, self._found, kept, strokes)
        order = np.argsort(np.concatenate([np.flatnonzero(kept) + 0.5, depths]), kind="stable")
        drawing = concatenate(fills, strokes).layer_subset(order)
        return _explanation(self._context, drawing, self._saved_around(kept))

    def _saved_around(self, kept: BoolArray) -> float:
        """Return the numbers saved by drawing omitted layers as borders of the layers they surround."""
        return sum(float(self._numbers[layer]) - BORDER_NUMBERS for layer in self._around(kept))

    def _around(self, kept: BoolArray) -> list[int]:
        """Return the omitted layers that surround a kept one, as its border."""
        masks = self._found.masks
        return [
            layer
            for layer in np.flatnonzero(self._worthwhile & ~kept).tolist()
            if any(
                np.count_nonzero(masks[layer] & masks[k]) > INSIDE * np.count_nonzero(masks[k])
                for k in np.flatnonzero(kept[layer + 1 :]) + layer + 1
            )
        ]

    def _leave_out(self, kept: BoolArray, alphas: NDArray[np.floating], depths: IntArray) -> None:
        """Omit layers, of (N,) bool, whose visible part beside strokes is worth less than their numbers.

        Pixels at borders between regions do not count, as borders are known only to a pixel. Layers visible only behind
        omitted ones are omitted as well.
        """
        changed = True
        while changed:
            changed = False
            for layer in np.flatnonzero(kept).tolist():
                interruption.check()
                if LEFT * self._lost(layer, kept, alphas, depths) < self._numbers[layer] * SEGMENT_ERROR / 6:
                    kept[layer], changed = False, True

    def _lost(self, layer: int, kept: BoolArray, alphas: NDArray[np.floating], depths: IntArray) -> float:
        """Return the squared change of the picture visible beside strokes if a layer is omitted."""
        found, less = self._found, kept.copy()
        less[layer] = False
        before, after = _top(found, kept), _top(found, less)
        seen = (before != after) & self._inner
        bare = np.ones(np.count_nonzero(seen))
        for alpha, depth in zip(alphas, depths, strict=True):
            bare *= 1 - alpha[seen] * (depth > layer)
        own, below = (painted(found.regions, found.layers, found.ground, top)[seen] for top in (before, after))
        return float(np.square(visible_error(bare[:, None] * (own - below))).sum())
