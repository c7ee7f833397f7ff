# SPDX-License-Identifier: Apache-2.0
"""Place the layers of a structure: fit their outlines, and add those that remove most error first.

The layers added by a stage depend only on the picture and on the number of layers present, so that a run can resume
from any state.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray
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

#: Points of an outline averaged to measure its noise at longer wavelengths: JPEG has blocks of 8 px, half a wave is 4.
WIDTHS = (2, 4)
#: Mean squared error of the layers not worth their price above which too much would be omitted: component-wise
#: placement then shows it by fewer, larger regions.
MAX_LEFT_OUT = 5e-4
#: Samples of a segment; Bernstein weight from which a control point determines a sample.
SAMPLES, LEAST_SHARE = 9, 0.2


@dataclasses.dataclass(frozen=True, eq=False)
class Beside:
    """Position of strokes in a structure.

    Attributes
    ----------
    kept : (N,) bool
        Layers of the structure needed beside the strokes.
    depths : (K,) int
        Number of layers of the structure below each stroke.
    """

    kept: NDArray[np.bool_]
    depths: NDArray[np.int64]


@dataclasses.dataclass(frozen=True, eq=False)
class NextLayers:
    """The layers added by a stage.

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
        0 where layers show that are not placed yet, or that have no paths, 1 elsewhere.
    numbers : (N + K,) int
        Index of each layer of the drawing in the whole structure, in paint order; strokes have the index after the
        last.
    top : (H, W) int
        Top layer at each pixel in the whole structure, 1 for the lowest; 0 for the ground.
    exact : bool
        Whether the outlines are exact, as of pixel art.
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
        """Return the control points (M, 3) of a drawing of these layers that no pixel constrains: they stay fixed."""
        if self.exact:
            return np.ones((drawing.num_segments, 3), bool)
        return hidden_points(drawing, self.numbers, self.top)


def hidden_points(drawing: Drawing, numbers: NDArray[np.intp], top: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return the control points (M, 3) of a drawing that no pixel constrains, on curves hidden by other layers.

    A control point is visible if its Bernstein weight at a visible point of its curve is large enough.

    Parameters
    ----------
    drawing : Drawing
        Layers, with their `numbers` (N,) in paint order.
    top : (H, W) int
        Index of the top layer at each pixel, plus 1; 0 if there is none.
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
    """Return whether shapes of one fill each, or cells of pixel art, explain a picture (H, W, C); None if neither.

    `count` layers must show almost all of them, and so must those that lower the mean squared error by at least `least`
    each: where layers are omitted, those below would show. Arguments as of
    :func:`livecl.layering.structure.finding.found_structure`.
    """
    found = found_structure(target, background, count, shading, asked)
    if found is None or _left_out(found, least) > MAX_LEFT_OUT:
        return None
    return "cells" if found.exact else "shapes"


def _left_out(found: Structure, least: float) -> float:
    """Return the mean squared error of the layers worth less than `least` each, which will be omitted."""
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
    """Return the next layers of a flat or shaded picture, `count` at most; None if all are placed.

    Target, `shading` and `asked` are as in :func:`livecl.layering.structure.finding.found_structure`. The drawing's
    filled layers are those placed by earlier calls, `total` the most layers of the whole run. Its strokes are not
    layers of the structure: `beside` tells which of these are needed beside the strokes.
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
    """Return the noise of a structure's outlines, standard deviation of their points, px, and that at long wavelengths.

    The second is 0 for a clean picture. For a noisy one it is the largest over several wavelengths, and at least the
    noise of the borders' coverages: the picture's noise over the contrast of the two sides.
    """
    polylines = [points for layer in found.layers if not (layer.exact or layer.over) for points in layer.outlines]
    noise, waves = noise_of(polylines), 0.0
    if found.regions.noise:
        waves = max(*(noise_of(polylines, width) for width in WIDTHS), found.regions.border_noise)
    return noise, waves


def fitted_layer(layer: Layer, noise: float, waves: float = 0.0) -> list[FloatArray]:
    """Fit closed cubic paths (s, 3, 2) to a layer's outlines, given the noise of their points, px."""
    if layer.exact:
        return [polygon_path(points) for points in layer.outlines]
    return [traced_path(points, noise, waves=waves) for points in layer.outlines]
