# SPDX-License-Identifier: Apache-2.0
"""Place the layers that structure finds: outlines fitted to them, those that remove most error first.

What a stage adds depends on the picture and on how many layers there are already, and on nothing else, so that a run
can go on from any state.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.geometry.bezier import bernstein
from livecl.geometry.corners import noise_of
from livecl.geometry.outlines import polygon_path
from livecl.geometry.tracing import traced_path
from livecl.layering.fills.ramps import Shading
from livecl.layering.structure.finding import found_structure, structure_of
from livecl.layering.structure.layers import Layer
from livecl.layering.structure.ranking import Structure

FloatArray = NDArray[np.float64]

#: Points of an outline that are averaged to find its noise at longer waves: JPEG has blocks of 8 px, half a wave is 4.
WIDTHS = (2, 4)
#: Mean squared error, of layers that are not worth their price each, from which on these show too much to be left out:
#: regions show it by fewer, larger ones.
MAX_LEFT_OUT = 5e-4
#: Points at which a segment is looked at, and the share of a point from which on a control point decides on it.
SAMPLES, LEAST_SHARE = 9, 0.2


@dataclasses.dataclass(frozen=True, eq=False)
class Beside:
    """Strokes in a structure.

    Attributes
    ----------
    kept : (N,) bool
        Layers of the structure that are needed beside the strokes.
    depths : (K,) int
        How many layers of the structure lie below each stroke.
    """

    kept: NDArray[np.bool_]
    depths: NDArray[np.int64]


@dataclasses.dataclass(frozen=True, eq=False)
class NextLayers:
    """What a stage adds.

    Attributes
    ----------
    outlines : list of list of (s, 3, 2) float
        Closed paths of each of K new layers, px.
    colors : (K, C) float
        Their colours.
    fills : Fills
        Their fills.
    order : (N + K,) int
        Paint order of the N old layers and the new ones.
    weight : (H, W) float32
        0 where layers show that are not placed yet, or for which there are no paths, 1 elsewhere.
    numbers : (N + K,) int
        Number of each layer of the drawing in the whole structure, in paint order; that after the last for strokes.
    top : (H, W) int
        Layer that shows at each pixel in the whole structure, 1 for the lowest; 0 where the ground does.
    exact : bool
        Whether the outlines are the picture's own, as of pixel art.
    """

    outlines: list[list[FloatArray]]
    colors: FloatArray
    fills: Fills
    order: NDArray[np.intp]
    weight: NDArray[np.float32]
    numbers: NDArray[np.intp]
    top: NDArray[np.int64]
    exact: bool = False

    def hidden_points(self, drawing: Drawing) -> NDArray[np.bool_]:
        """Return the control points (M, 3) of a drawing of these layers that stay: no pixel decides on them."""
        if self.exact:
            return np.ones((drawing.num_segments, 3), bool)
        return hidden_points(drawing, self.numbers, self.top)


def hidden_points(drawing: Drawing, numbers: NDArray[np.intp], top: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return the control points (M, 3) of a drawing that no pixel decides on: their curves run below others there.

    A control point is seen where its share of a visible point of its curve (its Bernstein weight) is large enough.

    Parameters
    ----------
    drawing : Drawing
        Layers, with their `numbers` (N,) in paint order.
    top : (H, W) int
        Number of the layer that shows at each pixel, and 1 more; 0 where none does.
    """
    lowest = ndimage.minimum_filter(top, footprint=ndimage.generate_binary_structure(2, 1))
    at = np.linspace(0, 1, SAMPLES)
    weights = bernstein(at)  # (SAMPLES, 4)
    samples = np.floor(weights @ drawing.cubics).astype(np.int64)
    height, width = top.shape
    rows, columns = np.clip(samples[..., 1], 0, height - 1), np.clip(samples[..., 0], 0, width - 1)
    shown = lowest[rows, columns] <= numbers[drawing.segment_layers][:, None] + 1  # (M, SAMPLES)
    seen = (shown[..., None] & (weights >= LEAST_SHARE)).any(axis=1)  # (M, 4)
    points = seen[:, :3].copy()
    points[drawing.next_segments, 0] |= seen[:, 3]
    return ~points


def structure_kind(
    target: NDArray[Any],
    background: NDArray[Any] | None,
    count: int,
    shading: Shading | None,
    asked: int = 0,
    least: float = 0.0,
) -> Literal["shapes", "cells"] | None:
    """Return whether shapes of one fill each explain a picture (H, W, C), or cells of pixel art; None if neither.

    `count` layers show about all of them, and so do those that lower the mean squared error by `least` each: what
    these leave out would show what lies below. Arguments as of
    :func:`livecl.layering.structure.finding.found_structure`.
    """
    found = found_structure(target, background, count, shading, asked)
    if found is None or _left_out(found, least) > MAX_LEFT_OUT:
        return None
    return "cells" if found.exact else "shapes"


def _left_out(found: Structure, least: float) -> float:
    """Return the mean squared error of layers that are worth less than that each: they will be left out."""
    size = 3 * found.top.size
    return float(found.gains[found.gains < least * size].sum() / size)


def place_structure(
    target: NDArray[Any],
    drawing: Drawing,
    count: int,
    total: int,
    shading: Shading | None = None,
    asked: int = 0,
    beside: Beside | None = None,
) -> NextLayers | None:
    """Return the next layers, `count` at most, of a picture of flat or shaded regions, or None where all are there.

    The target is as in :func:`livecl.layering.structure.finding.found_structure`, and so are `shading` and `asked`. The
    drawing's filled layers are those that earlier calls have placed, `total` those of the whole run, at most. Its
    strokes are none of the structure's layers: `beside` says which of these are needed beside them.
    """
    found = structure_of(target, drawing.background, total, shading, asked)
    ranked = found.ranked if beside is None else found.ranked[beside.kept[found.ranked]]
    stroked = drawing.strokes.widths > 0
    num_placed = int(np.sum(~stroked))
    last = num_placed + count
    placed, new = ranked[:num_placed], ranked[num_placed:last]
    if not len(new):
        return None
    noise = outline_noise(found)
    outlines = []
    for k in new:
        interruption.check()
        outlines.append(fitted_layer(found.layers[k], *noise))
    depths = np.zeros(drawing.num_layers)
    depths[~stroked] = np.sort(placed) + 0.5
    depths[stroked] = len(found.layers) if beside is None else beside.depths
    order = np.argsort(np.concatenate([depths, new + 0.5]), kind="stable")
    missing = found.shows(ranked[last:])
    if found.left_out is not None:
        missing |= found.left_out
    missing = ndimage.binary_dilation(missing, np.ones((5, 5)))
    colors = np.array([found.layers[k].color for k in new])
    numbers = np.concatenate([np.where(stroked, len(found.layers), depths), new]).astype(np.intp)[order]
    fills = concatenate_fills([found.fills_of(k) for k in new])
    return NextLayers(outlines, colors, fills, order, (~missing).astype(np.float32), numbers, found.top, found.exact)


def outline_noise(found: Structure) -> tuple[float, float]:
    """Return the noise of the outlines of a structure, standard deviation of their points, px; and that at long waves.

    The second is that of a noisy picture, at the waves at which it is largest; and not less than the coverages of
    borders tell, which err by the picture's noise over the contrast of the two sides.
    """
    polylines = [points for layer in found.layers if not (layer.exact or layer.over) for points in layer.outlines]
    noise, waves = noise_of(polylines), 0.0
    if found.regions.noise:
        waves = max(*(noise_of(polylines, width) for width in WIDTHS), found.regions.border_noise)
    return noise, waves


def fitted_layer(layer: Layer, noise: float, waves: float = 0.0) -> list[FloatArray]:
    """Return the outlines of a layer as closed cubic paths (s, 3, 2); its noise is that of its points, px."""
    if layer.exact:
        return [polygon_path(points) for points in layer.outlines]
    return [traced_path(points, noise, waves=waves) for points in layer.outlines]
