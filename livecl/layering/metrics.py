# SPDX-License-Identifier: Apache-2.0
"""How close a picture is to its target, and how clean the layers of a drawing are.

Layers are judged by what they contribute to the picture: layer i's own share of a pixel's final colour is its alpha
there (opacity * coverage) times the transmittance, the product of (1 - alpha) of all layers above it. A pixel is
visible in a layer if that share exceeds one half, so in at most one.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.geometry import bezier
from livecl.geometry.crossings import CROSSING_AREA, crossing_area
from livecl.image.alpha import error_seen

if TYPE_CHECKING:
    from livecl.rendering.rasterizer import Rasterizer

#: Largest difference of neighbouring pixels, in every channel, within a flat region of a picture.
FLAT_DIFFERENCE = 0.05
#: Share of a pixel's final colour beyond which the pixel is visible in a layer.
VISIBLE_SHARE = 0.5
#: Share of a layer's visible pixels from which on it lies in one region.
ONE_REGION_SHARE = 0.85
#: A layer is needless if the mean squared error rises by less without it.
NEEDLESS_CHANGE = 1e-6
#: Largest difference, in every channel and in opacity, of colours that count as the same.
SAME_COLOR = 0.05
#: Pixels along a row or column from one visible pixel to that of a neighbouring layer: one mixed pixel may lie between.
NEIGHBOR_DISTANCE = 2
#: Opacities above it, but below 1, are nearly opaque.
NEARLY_OPAQUE = 0.9

FloatArray = NDArray[np.float64]
ShareArray = NDArray[np.float32]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]


def mse(image: ArrayLike, target: ArrayLike) -> float:
    """Return the mean over pixels and channels of the squared difference of two pictures (H, W, C) in [0, 1]."""
    image, target = _pair(image, target)
    return float(np.mean(np.square(image - target)))


def psnr(image: ArrayLike, target: ArrayLike) -> float:
    """Return the peak signal-to-noise ratio of two pictures (H, W, C) in [0, 1], dB; infinite where they are equal."""
    error = mse(image, target)
    return -10 * math.log10(error) if error > 0 else math.inf


def ssim(image: ArrayLike, target: ArrayLike) -> float:
    """Return the structural similarity of two pictures, scikit-image's, mean over pixels and channels.

    Parameters
    ----------
    image, target : (H, W, C) array_like
        In [0, 1]. The window is 7 px, or the largest odd number that fits into a smaller picture.

    Raises
    ------
    ValueError
        If the shapes differ, or a side is shorter than 3 px.
    """
    from skimage.metrics import structural_similarity

    image, target = _pair(image, target)
    side = min(image.shape[:2])
    if side < 3:
        raise ValueError(f"image: shape {image.shape}, wanted sides of at least 3 px")
    window = min(7, side - 1 + side % 2)
    similarity: Callable[..., Any] = structural_similarity
    return float(similarity(image, target, win_size=window, data_range=1.0, channel_axis=2))


def num_parameters(drawing: Drawing) -> int:
    """Return how many numbers describe the layers: two for each control point, four for each fill."""
    return drawing.points.size + drawing.colors.size


@dataclasses.dataclass(frozen=True, kw_only=True)
class LayerMeasures:
    """How many layers of a drawing have which property; see the functions of the same names.

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
        Layers that would be saved if neighbours of the same colour were one layer.
    nearly_opaque : int
        Layers of an opacity above 0.9 and below 1.
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
        The picture that it stands for, in [0, 1]; a drawing without background is judged over white by an RGB picture.
    rasterizer : Rasterizer, optional
        One of the drawing's size; made where not given.
    """
    if drawing.background is None and np.ndim(target) == 3 and np.shape(target)[2] == 3:
        drawing = drawing.replace(background=np.ones(3))
    target = _checked_target(drawing, target)
    alphas = layer_alphas(drawing, rasterizer)
    shares = visible_shares(alphas)
    in_region = region_shares(shares, flat_regions(target))
    return LayerMeasures(
        layers=drawing.num_layers,
        in_one_region=int(np.sum(in_region >= ONE_REGION_SHARE)),
        self_crossing=int(np.sum(self_crossing(drawing))),
        needless=int(np.sum(removal_changes(drawing, alphas, target) < NEEDLESS_CHANGE)),
        mergeable=num_mergeable(drawing.num_layers, mergeable_pairs(drawing, shares)),
        nearly_opaque=int(np.sum(nearly_opaque(drawing))),
    )


def layer_alphas(drawing: Drawing, rasterizer: Rasterizer | None = None) -> ShareArray:
    """Return opacity times coverage of each layer alone: (N, H, W)."""
    from livecl.rendering.rasterizer import Rasterizer

    if rasterizer is None:
        rasterizer = Rasterizer(drawing.size)
    alphas = rasterizer.coverages(drawing)
    alphas *= drawing.colors[:, 3, None, None].astype(np.float32)
    return alphas


def composited_colors(drawing: Drawing) -> tuple[FloatArray, FloatArray]:
    """Return what lies beneath all layers, (C,), and the colours of the layers' paints, (N, C), as they are composited.

    Over a background C is 3. Without one it is 4, premultiplied RGBA: nothing lies beneath, and a paint has alpha 1, as
    its opacity goes into the layer's alpha.
    """
    rgb = drawing.colors[:, :3]
    if drawing.background is not None:
        return drawing.background, rgb
    return np.zeros(4), np.concatenate([rgb, np.ones((drawing.num_layers, 1))], axis=1)


def visible_shares(alphas: ShareArray) -> ShareArray:
    """Return each layer's own share of the final colour, (N, H, W), from the layers' alphas, bottom first.

    ``share_i = alpha_i * prod_{j > i} (1 - alpha_j)``; what is left to 1 is the background's.
    """
    shares = np.empty_like(alphas)
    transmittance = np.ones(alphas.shape[1:], np.float32)
    for layer in reversed(range(len(alphas))):
        shares[layer] = alphas[layer] * transmittance
        transmittance *= 1 - alphas[layer]
    return shares


def flat_regions(target: ArrayLike, difference: float = FLAT_DIFFERENCE) -> IntArray:
    """Return the flat region of each pixel: (H, W), numbered from 0.

    Two of the four neighbours are in one region if they differ by at most `difference` in every channel; regions are
    the connected components. So a slow gradient is one region, and an anti-aliased edge falls into small ones.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    target = np.asarray(target, dtype=np.float64)
    index = np.arange(target.shape[0] * target.shape[1]).reshape(target.shape[:2])
    # Levels k/255 are stored rounded: half of the least difference between two of them is below any real one.
    limit = difference + 1e-6
    joined = [
        (first[near], second[near])
        for first, second, near in (
            (index[:, :-1], index[:, 1:], np.abs(np.diff(target, axis=1)).max(axis=2) <= limit),
            (index[:-1], index[1:], np.abs(np.diff(target, axis=0)).max(axis=2) <= limit),
        )
    ]
    first, second = (np.concatenate(ends) for ends in zip(*joined, strict=True))
    edges = coo_array((np.ones(len(first), bool), (first, second)), shape=(index.size, index.size))
    regions: IntArray = connected_components(edges, directed=False)[1].reshape(index.shape)
    return regions


def region_shares(shares: ShareArray, regions: IntArray) -> FloatArray:
    """Return the largest part of each layer's visible pixels that lies in one region: (N,); 0 where none is visible."""
    found = np.zeros(len(shares))
    for layer, share in enumerate(shares):
        counts = np.bincount(regions[share > VISIBLE_SHARE])
        if counts.size:
            found[layer] = counts.max() / counts.sum()
    return found


def removal_changes(drawing: Drawing, alphas: ShareArray, target: ArrayLike, seen: bool = False) -> FloatArray:
    """Return by how much the mean squared error rises if one layer is taken away: (N,).

    Without layer i the picture changes by ``share_i * (C_i - c_i)``, where ``C_i`` is the picture of the background and
    all layers below it, and ``c_i`` its colour. What rises is :func:`livecl.image.alpha.mse_seen` with `seen`.
    """
    target = _checked_target(drawing, target)
    shares = visible_shares(alphas)
    windows = [_window(drawing, layer) for layer in range(drawing.num_layers)]
    ground, colors = composited_colors(drawing)
    below = np.broadcast_to(ground, target.shape).copy()
    changes_of_image = []
    for layer, window in enumerate(windows):
        missing = below[window] - colors[layer]
        changes_of_image.append((shares[layer][window][..., None] * missing).astype(np.float32))
        below[window] -= alphas[layer][window][..., None] * missing
    error, size = below - target, target.size
    if seen:
        changes_of_image = [error_seen(change) for change in changes_of_image]
        error, size = error_seen(error), 3 * target[..., 0].size
    return np.array(
        [
            float(np.sum(change * (2 * error[window] + change))) / size
            for window, change in zip(windows, changes_of_image, strict=True)
        ]
    )


def mergeable_pairs(drawing: Drawing, shares: ShareArray) -> IntArray:
    """Return the pairs of neighbouring layers of the same colour: (K, 2), the lower layer first.

    Colours are the same if RGB and opacity differ by at most 0.05 each. Layers are neighbours if a visible pixel of one
    lies next to a visible pixel of the other in its row or column, or one pixel farther: between two layers that share
    an edge there may be a mixed pixel that is visible in neither.
    """
    owner = np.full(drawing.size, -1, np.int32)
    for layer, share in enumerate(shares):
        owner[share > VISIBLE_SHARE] = layer
    pairs = []
    for step in range(1, NEIGHBOR_DISTANCE + 1):
        for first, second in ((owner[:, :-step], owner[:, step:]), (owner[:-step], owner[step:])):
            differ = (first != second) & (first >= 0) & (second >= 0)
            pairs.append(np.stack([first[differ], second[differ]], axis=1))
    neighbors = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    difference = np.abs(drawing.colors[neighbors[:, 0]] - drawing.colors[neighbors[:, 1]])
    same: IntArray = neighbors[difference.max(axis=1, initial=0.0) <= SAME_COLOR + 1e-9]
    return same


def num_mergeable(num_layers: int, pairs: IntArray) -> int:
    """Return how many layers fewer there would be if each group joined by `pairs` (K, 2) were one layer."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not num_layers:
        return 0
    edges = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(num_layers, num_layers))
    return num_layers - int(connected_components(edges, directed=False)[0])


def nearly_opaque(drawing: Drawing) -> BoolArray:
    """Return which layers are not quite opaque: (N,), those of an opacity above 0.9 and below 1."""
    opacity = drawing.colors[:, 3]
    return (opacity > NEARLY_OPAQUE) & (opacity < 1)


def _window(drawing: Drawing, layer: int) -> tuple[slice, slice]:
    """Rows and columns of the pixels that a layer can cover."""
    first, end = drawing.segment_offsets[layer : layer + 2]
    height, width = drawing.size
    following = drawing.next_segments[first:end]
    hull = np.concatenate([drawing.points[first:end].reshape(-1, 2), drawing.points[following, 0]])
    x0, y0, x1, y1 = bezier.hull_bounds(hull)
    rows = slice(int(np.clip(np.floor(y0), 0, height)), int(np.clip(np.ceil(y1), 0, height)))
    return rows, slice(int(np.clip(np.floor(x0), 0, width)), int(np.clip(np.ceil(x1), 0, width)))


def _pair(image: ArrayLike, target: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    first, second = np.asarray(image, dtype=np.float64), np.asarray(target, dtype=np.float64)
    if first.shape != second.shape or first.ndim != 3:
        raise ValueError(f"image: shape {first.shape}, wanted the target's, {second.shape}, (H, W, C)")
    return first, second


def _checked_target(drawing: Drawing, target: ArrayLike) -> FloatArray:
    array = np.asarray(target, dtype=np.float64)
    wanted = (*drawing.size, 4 if drawing.background is None else 3)
    if array.shape != wanted:
        raise ValueError(f"target: shape {array.shape}, wanted {wanted}")
    return array


def self_crossing(drawing: Drawing, area: float = CROSSING_AREA) -> NDArray[np.bool_]:
    """Return which layers have a subpath that crosses itself: (N,) bool.

    Parameters
    ----------
    drawing : Drawing
        Any drawing. Two subpaths of a layer may cross each other: holes are made so.
    area : float
        Area of other winding, px^2, that counts as a crossing; see :func:`crossing_area`.
    """
    cubics, offsets = drawing.cubics, drawing.subpath_offsets
    crosses = [crossing_area(cubics[first:end]) > area for first, end in itertools.pairwise(offsets)]
    return np.array([any(crosses[first:end]) for first, end in itertools.pairwise(drawing.layer_offsets)], dtype=bool)
