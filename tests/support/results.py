# SPDX-License-Identifier: Apache-2.0
"""Results made by hand, with the pictures that they stand for."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import Options, Rasterizer
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.image.errors import mse
from livecl.run.result import Result, Stage
from livecl.svg import quantize
from support import drawings, shapes

#: What a file or an SVG may be called to break a page.
NASTY = "</script><script>window.hacked=1</script><img src=x onerror=\"window.hacked=1\"> & 'b'"


def sample_drawing(background: Any = (0.9, 0.9, 0.8), names: tuple[str, ...] = ("", "", "")) -> Drawing:
    """Return a ring, a translucent circle on it and a rectangle on top, in stages 0, 1 and 1."""
    ring = [shapes.circle((120, 110), 70), drawings.reverse(shapes.circle((126, 118), 35))]
    layers = [
        (ring, (0.1, 0.4, 0.8, 1.0)),
        ([shapes.circle((80, 150), 55)], (0.9, 0.3, 0.1, 128 / 255)),
        ([drawings.rectangle(20, 30, 150, 60)], (0.2, 179 / 255, 0.2, 1.0)),
    ]
    return quantize(drawings.build(layers, (240, 200), background).replace(stages=[0, 1, 1], names=names))


def shaded_drawing() -> Drawing:
    """Return the sample drawing whose ring has a radial and whose rectangle has a linear gradient."""
    fills = [
        Fills.radial((120, 110), (190, 110), (120, 180), [(0.2, 0.6, 1, 1), (0, 0.2, 0.6, 1)]),
        Fills.solid(1),
        Fills.linear((20, 45), (150, 45), [(1, 204 / 255, 0, 1), (1, 0, 0, 102 / 255)]),
    ]
    return quantize(sample_drawing().replace(fills=concatenate_fills(fills)))


def result_of(drawing: Drawing, target: NDArray[Any], **changes: Any) -> Result:
    """Return a run whose stages drew the first layer, and then all of them, and the target that it had."""
    rasterizer = Rasterizer(drawing.size)
    counts = sorted({1, drawing.num_layers}) if drawing.num_layers else [0]
    stages = []
    for count in counts:
        part = drawing.layer_subset(np.arange(count))
        stages.append(Stage(part, mse(rasterizer.forward(part), target), 5, 0.25))
    result = Result(
        drawing=drawing,
        mse=stages[-1].mse,
        stages=tuple(stages),
        seconds=0.5,
        compile_seconds=0.125,
        device="a device",
        options=Options(iterations=5),
    )
    return dataclasses.replace(result, **changes)


def sample(background: Any = (0.9, 0.9, 0.8), **changes: Any) -> tuple[NDArray[np.float32], Result]:
    """Return a straight picture, and a result of which a corner differs from it."""
    drawing = sample_drawing(background, **changes)
    target = Rasterizer(drawing.size).forward(drawing)
    target[:20, :30, :3] *= 0.5
    result = result_of(drawing, target)
    if target.shape[2] == 4:
        target[..., :3] /= np.maximum(target[..., 3:], 1e-6)
        target = np.clip(target, 0, 1)
    return target, result
