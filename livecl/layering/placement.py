# SPDX-License-Identifier: Apache-2.0
"""Placement of new paths: position, shape and colour.

`component` is the paper's component-wise path initialization, steps a-d. `region` takes the regions whose painting
would remove most error, judged by the coverage of the very path that would be added.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.layering.componentwise.candidates import initial_outline, paint_of, region_candidates
from livecl.layering.componentwise.components import Place, component_places
from livecl.layering.componentwise.painting import Painting
from livecl.layering.context import Context
from livecl.layering.contributions import composited_colors, layer_alphas
from livecl.layering.fills.choice import shading_of
from livecl.layering.stack import LayerStack
from livecl.options import Options

if TYPE_CHECKING:
    from livecl.layering.strokes.line_work import LineWork


@dataclasses.dataclass(frozen=True)
class Placement:
    """New layers, and their positions in the paint order.

    Attributes
    ----------
    drawing : Drawing
        Only the K new layers.
    order : (N + K,) int
        Paint order of all layers, bottom first: the N old layers by index, the new ones from N on.
    weight : (H, W) float32 or None
        0 where layers not placed yet will show, 1 elsewhere.
    hidden_points : callable or None
        Returns the control points (M, 3) of the drawing of all layers that stay fixed because other layers hide them.
    """

    drawing: Drawing
    order: NDArray[np.intp]
    weight: NDArray[np.float32] | None = None
    hidden_points: Callable[[Drawing], NDArray[np.bool_]] | None = None


def place_paths(
    context: Context,
    drawing: Drawing,
    count: int,
    rng: np.random.Generator,
    total: int | None = None,
    lines: LineWork | None = None,
) -> Placement:
    """Place up to `count` new layers where a drawing differs from the target, fewer if too few regions are worth one.

    Layers from regions may be inserted below existing ones; all others go on top. `total` limits the layers of the
    whole run; the default is those of the drawing plus `count`. With line work, the structure of the picture is placed
    around the strokes of the drawing.
    """
    target, options = context.target, context.options
    if options.placement == "structure":
        from livecl.layering.structure import place_structure  # loads SciPy

        total = drawing.num_layers + count if total is None else total
        asked = 0 if options.path_gain else total
        beside = None if lines is None else lines.beside(context, drawing)
        found = place_structure(target, drawing, count, total, shading_of(options), asked, beside)
        if found is None:
            return Placement(empty_drawing(drawing.size), np.arange(drawing.num_layers))
        rgba = np.array([paint_of(color) for color in found.colors])
        return Placement(
            Drawing.from_outlines(found.outlines, rgba, drawing.size, fills=found.fills),
            found.order,
            found.weight,
            found.hidden_points,
        )
    interruption.check()
    image = context.rasterizer.forward(drawing)
    interruption.check()
    if options.placement == "region":
        ground, colors = composited_colors(drawing, covered=True)
        follow = drawing.background is None and options.opacity != "opaque"
        stack = LayerStack(ground, layer_alphas(drawing, context.rasterizer), colors, image)
        interruption.check()
        painting = Painting(target, stack, follow)
        interruption.check()
        candidates = region_candidates(context, painting, count, rng)
        rgba = np.array([candidate.rgba for candidate in candidates]).reshape(-1, 4)
        if options.new_color == "random":
            rgba = rng.uniform(size=rgba.shape)
        outlines = [candidate.outline for candidate in candidates]
        return Placement(Drawing.from_outlines(outlines, rgba, drawing.size), stack.order)
    new = _scattered_paths(target, image, count, options, rng)
    return Placement(new, np.arange(drawing.num_layers + new.num_layers))


def _scattered_paths(
    target: NDArray[Any], image: NDArray[Any], count: int, options: Options, rng: np.random.Generator
) -> Drawing:
    """Place paths on the largest components, or at random."""
    size = target.shape[:2]
    if options.placement == "random":
        centers = rng.uniform(size=(count, 2)) * (size[1], size[0])
        places = [Place(center, np.floor(center[::-1]).astype(np.int64)) for center in centers]
    else:
        places = component_places(target, image, count, options)
    outlines = [initial_outline(place, size, options, rng) for place in places]
    if options.new_color == "random":
        colors = rng.uniform(size=(count, 4))
    else:
        colors = np.array([paint_of(target[tuple(place.pixel)]) for place in places])
    return Drawing.from_outlines(outlines, colors, (size[0], size[1]))
