# SPDX-License-Identifier: Apache-2.0
"""Place the layers that structure finds: outlines fitted to them, those that remove most error first.

What a stage adds depends on the picture and on how many layers there are already, and on nothing else, so that a run
can go on from any state.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import bernstein
from livecl.geometry.corners import noise_of
from livecl.geometry.tracing import trace
from livecl.layering.structure.flat import FlatRegions, flat_regions, flatness
from livecl.layering.structure.layers import Layer, find_layers

FloatArray = NDArray[np.float64]

#: Share of the pixels that regions of some size must explain for a picture to count as flat, and that size, px.
FLAT_SHARE, LARGE_REGION = 0.97, 16
#: Share of its pixels that flat cores must hold: else it is not looked at any further.
CORE_SHARE = 0.5
#: Largest share of neighbouring pixels that differ a little, as on slopes of shading.
MOST_SLOPES = 0.02
#: Most regions of a flat picture, for each of its 256 x 256 pixels.
MOST_REGIONS = 150
#: What a pixel's colour may miss and still count as explained.
EXPLAINED = 12 / 255
#: Share of the pixels within regions that the layers may show wrongly: a shape completed over what lies in front of it
#: hides that, and training does not bring much of it back. 26 of 30 icons have less than 0.01, the others 0.02 to 0.05,
#: which training mends; a logo of which a whole wave was hidden 0.22.
MAX_MISTAKEN = 0.1
#: Mean squared error that the layers may hold for which there are too few paths: as much as regions leave on faces at 8
#: paths, which paint several shapes with one path then.
MAX_LEFT_OUT = 5e-4
#: More layers than any picture has.
MAX_LAYERS = 1 << 30
#: Points at which a segment is looked at, and the share of a point from which on a control point decides on it.
SAMPLES, LEAST_SHARE = 9, 0.2
#: Squared error that a layer must remove, in channels of a pixel that are wholly wrong; or pixels that must show it.
LEAST_GAIN, LEAST_PIXELS = 3.0, 64


@dataclasses.dataclass(frozen=True, eq=False)
class NextLayers:
    """What a stage adds.

    Attributes
    ----------
    outlines : list of list of (s, 3, 2) float
        Closed paths of each of K new layers, px.
    colors : (K, C) float
        Their colours.
    order : (N + K,) int
        Paint order of the N old layers and the new ones.
    weight : (H, W) float32
        0 where layers will show that are not placed yet, 1 elsewhere.
    numbers : (N + K,) int
        Number of each layer of the drawing in the whole structure, in paint order.
    top : (H, W) int
        Layer that shows at each pixel in the whole structure, 1 for the lowest; 0 where the ground does.
    """

    outlines: list[list[FloatArray]]
    colors: FloatArray
    order: NDArray[np.intp]
    weight: NDArray[np.float32]
    numbers: NDArray[np.intp]
    top: NDArray[np.int64]

    def hidden_points(self, drawing: Drawing) -> NDArray[np.bool_]:
        """Return the control points (M, 3) of a drawing that no pixel decides on: their curves run below others there.

        A control point is seen where its share of a visible point of its curve (its Bernstein weight) is large enough.
        """
        lowest = ndimage.minimum_filter(self.top, footprint=ndimage.generate_binary_structure(2, 1))
        at = np.linspace(0, 1, SAMPLES)
        weights = bernstein(at)  # (SAMPLES, 4)
        samples = np.floor(weights @ drawing.cubics).astype(np.int64)
        height, width = self.top.shape
        rows, columns = np.clip(samples[..., 1], 0, height - 1), np.clip(samples[..., 0], 0, width - 1)
        shown = lowest[rows, columns] <= self.numbers[drawing.segment_layers][:, None] + 1  # (M, SAMPLES)
        seen = (shown[..., None] & (weights >= LEAST_SHARE)).any(axis=1)  # (M, 4)
        points = seen[:, :3].copy()
        points[drawing.next_segments, 0] |= seen[:, 3]
        return ~points


@dataclasses.dataclass(frozen=True, eq=False)
class _Structure:
    """Layers of a picture, the lowest first; their numbers by what they are worth; and which one shows, 0 for none.

    `gains` are the squared errors that they remove, `noise` is that of the points of their outlines, px.
    """

    layers: list[Layer]
    ranked: NDArray[np.intp]
    top: NDArray[np.int64]
    gains: FloatArray
    noise: float


def structured(target: NDArray[Any], background: NDArray[Any] | None, count: int = MAX_LAYERS) -> bool:
    """Whether flat regions explain a picture (H, W, C), and there is something beside its ground."""
    share, slopes, cores = flatness(target)
    most = MOST_REGIONS * max(1.0, target.shape[0] * target.shape[1] / 65536)
    if share < CORE_SHARE or slopes > MOST_SLOPES or cores > most:
        return False
    regions = _regions_of(*_frozen(target))
    large = regions.sizes[regions.labels] >= LARGE_REGION
    explained = float(np.mean(large & (regions.miss <= EXPLAINED)))
    if explained < FLAT_SHARE or len(regions.sizes) > most:
        return False
    ground = _ground(target, background)
    found = _structure_of(*_frozen(target), ground)
    if not len(found.ranked) or _mistaken(found, regions, ground) > MAX_MISTAKEN:
        return False
    left_out = found.gains[found.ranked[count:]].sum()
    return bool(left_out <= MAX_LEFT_OUT * target.shape[0] * target.shape[1] * target.shape[2])


def place_structure(
    target: NDArray[Any], drawing: Drawing, count: int, check: Callable[[], None] = lambda: None
) -> NextLayers | None:
    """Return the next layers of a flat picture, or None where they are all there.

    Parameters
    ----------
    target : (H, W, C) array
        RGB, or premultiplied RGBA where the drawing has no background.
    drawing : Drawing
        The layers that earlier calls have placed, in their paint order.
    count : int
        Layers wanted, at most.
    check : callable
        Called between outlines; what it raises ends the placement.
    """
    found = _structure_of(*_frozen(target), _ground(target, drawing.background))
    last = drawing.num_layers + count
    placed, new = found.ranked[: drawing.num_layers], found.ranked[drawing.num_layers : last]
    if not len(new) or len(placed) < drawing.num_layers:
        return None
    outlines = []
    for k in new:
        check()
        outlines.append(fitted_layer(found.layers[k], found.noise))
    order = np.argsort(np.concatenate([np.sort(placed), new]), kind="stable")
    missing = ndimage.binary_dilation(np.isin(found.top, found.ranked[last:] + 1), np.ones((5, 5)))
    colors = np.array([found.layers[k].color for k in new])
    numbers = np.sort(found.ranked[:last])
    return NextLayers(outlines, colors, order, (~missing).astype(np.float32), numbers, found.top)


def fitted_layer(layer: Layer, noise: float) -> list[FloatArray]:
    """Return the outlines of a layer as closed cubic paths (s, 3, 2); `noise` is that of its points, px."""
    return [trace(points, noise) for points in layer.outlines]


def _mistaken(found: _Structure, regions: FlatRegions, ground: tuple[float, ...]) -> float:
    """Return the share of the pixels within regions at which the layers, painted over each other, show another one."""
    inner = ndimage.minimum_filter(regions.labels, 3) == ndimage.maximum_filter(regions.labels, 3)
    colors = np.stack([np.array(ground), *(layer.color for layer in found.layers)])
    miss = np.abs(colors[found.top] - regions.colors[regions.labels]).max(axis=-1)
    return float(np.mean(miss[inner] > EXPLAINED)) if inner.any() else 0.0


def _ground(target: NDArray[Any], background: NDArray[Any] | None) -> tuple[float, ...]:
    """Return what shows where there are no layers, as a pixel of the target."""
    return (0.0,) * target.shape[2] if background is None else tuple(float(v) for v in background)


def _frozen(image: NDArray[Any]) -> tuple[bytes, tuple[int, ...]]:
    pixels = np.ascontiguousarray(image, dtype=np.float32)
    return pixels.tobytes(), pixels.shape


@functools.lru_cache(maxsize=2)
def _regions_of(data: bytes, shape: tuple[int, ...]) -> FlatRegions:
    return flat_regions(np.frombuffer(data, np.float32).reshape(shape))


@functools.lru_cache(maxsize=2)
def _structure_of(data: bytes, shape: tuple[int, ...], ground: tuple[float, ...]) -> _Structure:
    """Find the layers of a picture, and rank them by the error that each removes, the most first."""
    from skimage.draw import polygon2mask

    layers = find_layers(_regions_of(data, shape), np.array(ground))
    top, second = np.zeros((2, *shape[:2]), np.int64)
    for number, layer in enumerate(layers, start=1):
        mask = np.zeros(shape[:2], bool)
        for points in layer.outlines:
            mask ^= polygon2mask(shape[:2], points[:, ::-1] - 0.5)
        second[mask], top[mask] = top[mask], number
    colors = np.stack([np.array(ground), *(layer.color for layer in layers)])
    lost = np.square(colors[top] - colors[second]).sum(axis=-1)
    gains = np.bincount(top.ravel(), lost.ravel(), len(layers) + 1)[1:].astype(np.float64)
    shown = np.bincount(top.ravel(), minlength=len(layers) + 1)[1:]
    order = np.argsort(-gains, kind="stable")
    ranked = order[(gains[order] >= LEAST_GAIN) | (shown[order] >= LEAST_PIXELS)]
    noise = noise_of([points for layer in layers for points in layer.outlines])
    return _Structure(layers, ranked, top, gains, noise)
