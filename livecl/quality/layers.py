# SPDX-License-Identifier: Apache-2.0
"""Cleanness of a drawing's layers, from their contributions (livecl/layering/contributions.py)."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import BoolArray, Float32Array, FloatArray, Int32Array
from livecl.drawing.drawing import Drawing
from livecl.geometry.crossings import CROSSING_AREA, crossing_area
from livecl.layering.contributions import (
    VISIBLE_SHARE,
    checked_target,
    layer_alphas,
    removal_changes,
    visible_shares,
)
from livecl.layering.neighbors import flat_labels, mergeable_pairs
from livecl.options import OPAQUE_FROM
from livecl.rendering.rasterizer import Rasterizer

#: Least share of a layer's visible pixels in one region for it to lie in that region.
ONE_REGION_SHARE = 0.85
#: A layer is needless if the mean squared error rises by less without it.
NEEDLESS_CHANGE = 1e-6


def num_parameters(drawing: Drawing) -> int:
    """Count the parameters of all layers: two for each control point, four for each fill."""
    return drawing.points.size + drawing.colors.size


@dataclasses.dataclass(frozen=True, kw_only=True)
class LayerMeasures:
    """Counts of a drawing's layers by property; see the functions of the same names.

    Attributes
    ----------
    layers : int
        Layers in all.
    in_one_region : int
        Layers whose visible pixels lie, at least 85 % of them, in one flat region of the target. A layer without a
        visible pixel does not.
    self_crossing : int
        Layers with a subpath that crosses itself.
    needless : int
        Layers without which the mean squared error falls, or rises by less than 1e-6.
    mergeable : int
        Number of layers saved if neighbours of the same colour were one layer.
    nearly_opaque : int
        Layers with an opacity above 0.9 and below 1.
    """

    layers: int
    in_one_region: int
    self_crossing: int
    needless: int
    mergeable: int
    nearly_opaque: int


def measure_layers(drawing: Drawing, target: ArrayLike, rasterizer: Rasterizer | None = None) -> LayerMeasures:
    """Return all measures of a drawing's layers.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    target : (H, W, 3) array_like, or (H, W, 4) premultiplied for a drawing without background
        The picture, in [0, 1]; a drawing without background is composited over white for an RGB picture.
    rasterizer : Rasterizer, optional
        One of the drawing's size; by default a new one.
    """
    if drawing.background is None and np.ndim(target) == 3 and np.shape(target)[2] == 3:
        drawing = drawing.replace(background=np.ones(3))
    target = checked_target(drawing, target)
    alphas = layer_alphas(drawing, rasterizer)
    shares = visible_shares(alphas)
    in_region = region_shares(shares, flat_labels(target))
    return LayerMeasures(
        layers=drawing.num_layers,
        in_one_region=int(np.sum(in_region >= ONE_REGION_SHARE)),
        self_crossing=int(np.sum(self_crossing(drawing))),
        needless=int(np.sum(removal_changes(drawing, alphas, target) < NEEDLESS_CHANGE)),
        mergeable=num_mergeable(drawing.num_layers, mergeable_pairs(drawing, shares)),
        nearly_opaque=int(np.sum(nearly_opaque(drawing))),
    )


def region_shares(shares: Float32Array, regions: Int32Array) -> FloatArray:
    """Return the largest share of each layer's visible pixels in one region: (N,); 0 if none is visible."""
    found = np.zeros(len(shares))
    for layer, share in enumerate(shares):
        counts = np.bincount(regions[share > VISIBLE_SHARE])
        if counts.size:
            found[layer] = counts.max() / counts.sum()
    return found


def num_mergeable(num_layers: int, pairs: Int32Array) -> int:
    """Return the number of layers saved if each group connected by `pairs` (K, 2) were one layer."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not num_layers:
        return 0
    edges = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(num_layers, num_layers))
    return num_layers - int(connected_components(edges, directed=False)[0])


def nearly_opaque(drawing: Drawing) -> BoolArray:
    """Return which layers have an opacity above 0.9 and below 1: (N,)."""
    opacity = drawing.colors[:, 3]
    return (opacity > OPAQUE_FROM) & (opacity < 1)


def self_crossing(drawing: Drawing, area: float = CROSSING_AREA) -> BoolArray:
    """Return which layers have a subpath that crosses itself: (N,) bool.

    Parameters
    ----------
    drawing : Drawing
        Any drawing. Crossings between two subpaths of a layer do not count.
    area : float
        Least area of other winding of a crossing, px^2; see :func:`crossing_area`.
    """
    cubics, offsets = drawing.cubics, drawing.subpath_offsets
    crosses = [crossing_area(cubics[first:end]) > area for first, end in itertools.pairwise(offsets)]
    return np.array([any(crosses[first:end]) for first, end in itertools.pairwise(drawing.layer_offsets)], dtype=bool)
