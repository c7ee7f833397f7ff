# SPDX-License-Identifier: Apache-2.0
"""Measures in the report: area, gain and size of each layer, and difference images."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import Float32Array
from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.image.errors import mse
from livecl.image.resizing import working_size
from livecl.layering.contributions import layer_alphas, removal_changes, visible_shares
from livecl.views.report.markup import png_uri

if TYPE_CHECKING:
    from livecl.rendering.rasterizer import Rasterizer

#: Side of a square, px: pictures of a larger area are reduced to it for the page and its measures; and the largest
#: number of the layers' alphas together (256 MB): pictures of many layers are reduced further.
SIDE, MAX_ALPHAS = 512, 1 << 26
#: Amplification of the difference picture, a power of two: share of its pixels that must not be saturated, and maximum.
UNSATURATED, MAX_GAIN = 0.99, 64
#: Its colour, on any background.
_DIFFERENCE_INK = (214, 66, 48)


_ELEMENT = re.compile(r"<(path|circle|ellipse|rect)\b(?! id=\"background\")[^>]*?(?:/>|>.*?</\1>)", flags=re.DOTALL)


@dataclasses.dataclass(frozen=True, kw_only=True)
class LayerFacts:
    """Measures of a layer."""

    area: float  # visible pixels: the sum of its share in each pixel's colour, see :func:`visible_shares`
    area_share: float  # the same as a share of the canvas, 0 to 1
    removed: float  # rise of the mean squared error without it
    #: Rise of the mean squared error if a gradient were the best single colour, of its mean opacity; None for solid
    #: layers.
    gradient: float | None
    num_bytes: int  # length of its element in the saved SVG
    num_nodes: int  # anchors of its outline


def layer_facts(drawing: Drawing, svg: str, target: Float32Array, rasterizer: Rasterizer) -> list[LayerFacts]:
    """Measure each layer of a drawing.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    svg : str
        The drawing as saved.
    target : (H, W, 3) or (H, W, 4) float32
        Target, see :func:`livecl.image.background.target_over`; it may be smaller than the canvas.
    rasterizer : Rasterizer
        One of the target's size.
    """
    if not drawing.num_layers:
        return []
    smaller = scaled(drawing, (target.shape[0], target.shape[1]))
    alphas = layer_alphas(smaller, rasterizer)
    removed = _removed(smaller, alphas, target, rasterizer)
    visible = visible_shares(alphas)
    gradients = gradient_gains(smaller, visible, target, rasterizer)
    shares = visible.mean(axis=(1, 2), dtype=np.float64)
    elements = [match[0] for match in _ELEMENT.finditer(svg)]
    area = drawing.size[0] * drawing.size[1]
    return [
        LayerFacts(
            area=float(share) * area,
            area_share=float(share),
            removed=float(change),
            gradient=gradients.get(layer),
            num_bytes=len(element.encode()),
            num_nodes=int(nodes),
        )
        for layer, (share, change, element, nodes) in enumerate(
            zip(shares, removed, elements, np.diff(drawing.segment_offsets), strict=True)
        )
    ]


def _removed(drawing: Drawing, alphas: Float32Array, target: Float32Array, rasterizer: Rasterizer) -> list[float]:
    """Return the rise of the mean squared error without each layer, gradients included."""
    if not drawing.fills.any_gradients:
        return removal_changes(drawing, alphas, target).tolist()
    error = mse(rasterizer.forward(drawing), target)
    every = np.arange(drawing.num_layers)
    return [mse(rasterizer.forward(drawing.layer_subset(every != k)), target) - error for k in every]


def gradient_gains(
    drawing: Drawing, visible: Float32Array, target: Float32Array, rasterizer: Rasterizer
) -> dict[int, float]:
    """Return the rise of the mean squared error if each gradient were the best single colour, by layer.

    With the layer in black, of its mean opacity, the picture is B; with s its share of a pixel's colour
    (`visible`, (N, H, W)), in colour c it is B + s c, and the best c is ``sum s (T - B) / sum s^2``.
    """
    error = mse(rasterizer.forward(drawing), target)
    gains = {}
    for layer in drawing.fills.gradient_layers.tolist():
        black = rasterizer.forward(with_solid(drawing, layer, np.zeros(3)))
        share, missing = visible[layer].astype(np.float64), (target - black)[..., :3].astype(np.float64)
        color = np.clip(np.tensordot(share, missing) / max(float(np.sum(share**2)), 1e-12), 0, 1)
        solid = rasterizer.forward(with_solid(drawing, layer, color))
        gains[layer] = mse(solid, target) - error
    return gains


def with_solid(drawing: Drawing, layer: int, rgb: NDArray[np.float64]) -> Drawing:
    """Return the drawing with one layer in one colour, RGB in [0, 1], of its mean opacity."""
    colors = drawing.colors.copy()
    colors[layer, :3] = rgb
    fills = [Fills.solid(1) if k == layer else drawing.fills.subset([k]) for k in range(drawing.num_layers)]
    return drawing.replace(colors=colors, fills=concatenate_fills(fills))


def page_size(drawing: Drawing) -> tuple[int, int]:
    """Return height and width, px, of the page's pictures, at which layers are measured."""
    size = working_size(drawing.size, SIDE)
    excess = size[0] * size[1] * drawing.num_layers / MAX_ALPHAS
    return size if excess <= 1 else working_size(size, max(1, int(math.sqrt(size[0] * size[1] / excess))))


def differences(errors: list[Float32Array]) -> tuple[list[str], int]:
    """Return difference images of drawings and target, as ``data:`` addresses, and their amplification.

    A pixel's opacity is the root mean square of the error's channels.
    """
    sizes = [np.sqrt(np.mean(np.square(error, dtype=np.float64), axis=2)) for error in errors]
    level = float(np.quantile(sizes[-1], UNSATURATED))
    gain = MAX_GAIN if level <= 0 else 2 ** int(np.clip(math.floor(-math.log2(level)), 0, math.log2(MAX_GAIN)))
    ink = np.array([(*_DIFFERENCE_INK, alpha) for alpha in range(256)], np.uint8)
    indices = [np.rint(np.clip(gain * size, 0, 1) * 255).astype(np.uint8) for size in sizes]
    return [png_uri(index, ink) for index in indices], gain
