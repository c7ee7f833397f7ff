# SPDX-License-Identifier: Apache-2.0
"""Measures in the report: area, gain and size of each layer, and difference images."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.image.resizing import scaled, working_size
from livecl.layering.contributions import layer_alphas, removal_changes, visible_shares
from livecl.views.report.markup import png_uri

if TYPE_CHECKING:
    from livecl.rendering.rasterizer import Rasterizer

#: Side, px, of the square whose area larger pictures are reduced to for the page and its measures; and the most numbers
#: that the layers' alphas may have together (256 MB), for which pictures of many layers are reduced further.
SIDE, MAX_ALPHAS = 512, 1 << 26
#: The difference picture is amplified so that this share of its pixels stays below the brightest; by a power of two.
UNSATURATED, MAX_GAIN = 0.99, 64
#: Its ink, on whatever the page's colour is.
_DIFFERENCE_INK = (214, 66, 48)

FloatArray = NDArray[np.float32]


@dataclasses.dataclass(frozen=True, kw_only=True)
class LayerFacts:
    """Measures of a layer.

    Attributes
    ----------
    area : float
        Pixels that are seen of it: the sum of its share in each pixel's colour, see :func:`visible_shares`.
    area_share : float
        The same as a share of the canvas, 0 to 1.
    removed : float
        By how much the mean squared error would rise without it.
    num_bytes : int
        Length of its ``<path>`` element in the saved SVG.
    num_nodes : int
        Anchors of its outline, one a segment.
    """

    area: float
    area_share: float
    removed: float
    num_bytes: int
    num_nodes: int


def layer_facts(drawing: Drawing, svg: str, target: FloatArray, rasterizer: Rasterizer) -> list[LayerFacts]:
    """Measure each layer of a drawing.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    svg : str
        The drawing as it is saved.
    target : (H, W, 3) or (H, W, 4) float32
        Target of its render, see :func:`livecl.image.background.target_over`; it may have fewer pixels than the
        canvas.
    rasterizer : Rasterizer
        One of the target's size.
    """
    if not drawing.num_layers:
        return []
    smaller = scaled(drawing, (target.shape[0], target.shape[1]))
    alphas = layer_alphas(smaller, rasterizer)
    removed = removal_changes(smaller, alphas, target)
    shares = visible_shares(alphas).mean(axis=(1, 2), dtype=np.float64)
    elements = re.findall(r"<path\b[^>]*?(?:/>|>.*?</path>)", svg, flags=re.DOTALL)
    area = drawing.size[0] * drawing.size[1]
    return [
        LayerFacts(
            area=float(share) * area,
            area_share=float(share),
            removed=float(change),
            num_bytes=len(element.encode()),
            num_nodes=int(nodes),
        )
        for share, change, element, nodes in zip(
            shares, removed, elements, np.diff(drawing.segment_offsets), strict=True
        )
    ]


def page_size(drawing: Drawing) -> tuple[int, int]:
    """Return height and width, px, that pictures have in the page and layers are measured at."""
    size = working_size(drawing.size, SIDE)
    excess = size[0] * size[1] * drawing.num_layers / MAX_ALPHAS
    return size if excess <= 1 else working_size(size, max(1, int(math.sqrt(size[0] * size[1] / excess))))


def differences(errors: list[FloatArray]) -> tuple[list[str], int]:
    """Return difference images of drawings and target, as ``data:`` addresses, and their amplification.

    A pixel's ink is the root mean square of the error's channels.
    """
    sizes = [np.sqrt(np.mean(np.square(error, dtype=np.float64), axis=2)) for error in errors]
    level = float(np.quantile(sizes[-1], UNSATURATED))
    gain = MAX_GAIN if level <= 0 else 2 ** int(np.clip(math.floor(-math.log2(level)), 0, math.log2(MAX_GAIN)))
    ink = np.array([(*_DIFFERENCE_INK, alpha) for alpha in range(256)], np.uint8)
    indices = [np.rint(np.clip(gain * size, 0, 1) * 255).astype(np.uint8) for size in sizes]
    return [png_uri(index, ink) for index in indices], gain
