# SPDX-License-Identifier: Apache-2.0
"""Facts of a run, as written by ``--json``: sizes, options, layers with their fills, stages."""

from __future__ import annotations

import collections
import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.colors import format_rgb
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import KINDS, SOLID
from livecl.run.recipe import Recipe
from livecl.run.result import Result
from livecl.svg.writer import layer_kinds
from livecl.version import __version__

#: Points of a fill, by its kind: none; both ends; the centre and the ends of two axes.
NUM_POINTS = (0, 2, 3)


def facts(result: Result, recipe: Recipe) -> dict[str, Any]:
    """Return the content of ``--json``: size, options, error, colours, layers (bottom first) and stages.

    `colors` has each colour and how many solid layers have it. A layer's `shape` is "circle", "ellipse", "rectangle",
    "path" or "stroke", of a width in px; `groups` are the names of those around it, the outermost first. Seconds are
    without compilation, which stands apart.
    """
    drawing = result.drawing
    height, width = drawing.size
    solid = drawing.colors[drawing.fills.kinds == SOLID]
    working_height, working_width = result.working_size or drawing.size
    return {
        "width": width,
        "height": height,
        "working_width": working_width,
        "working_height": working_height,
        "device": result.device,
        "version": __version__,
        "options": {**dataclasses.asdict(result.options), "schedule": list(recipe.stages), "seed": recipe.seed},
        "paths": drawing.num_layers,
        "mse": _known(result.mse),
        "stopped": result.stopped,
        "seconds": result.seconds,
        "compile_seconds": result.compile_seconds,
        "colors": dict(collections.Counter(format_rgb(rgba) for rgba in solid).most_common()),
        "layers": _layers(drawing, recipe.precision),
        "stages": [
            {"paths": stage.paths, "mse": _known(stage.mse), "iterations": stage.iterations, "seconds": stage.seconds}
            for stage in result.stages
        ],
    }


def _layers(drawing: Drawing, precision: int) -> list[dict[str, Any]]:
    """Return the facts of each layer, as an SVG of that precision, in decimals, has it."""
    nodes, subpaths = np.diff(drawing.segment_offsets), np.diff(drawing.layer_offsets)
    return [
        {
            "label": label,
            "groups": list(drawing.groups[layer]),
            "shape": shape,
            "fill": _fill(drawing, layer),
            "stroke_width": float(drawing.strokes.widths[layer]),
            "nodes": int(nodes[layer]),
            "subpaths": int(subpaths[layer]),
            "stage": int(drawing.stages[layer]) + 1,
        }
        for layer, (label, shape) in enumerate(zip(drawing.labels, layer_kinds(drawing, precision), strict=True))
    ]


def _fill(drawing: Drawing, layer: int) -> dict[str, Any]:
    """Return a layer's fill as the saved SVG has it: its kind, and a colour, or points, px, and stops."""
    fills = drawing.fills
    kind, own = int(fills.kinds[layer]), fills.stops(layer)
    if kind == SOLID:
        return {"kind": KINDS[kind], **_color(drawing.colors[layer])}
    return {
        "kind": KINDS[kind],
        "points": fills.geometry[layer, : NUM_POINTS[kind]].tolist(),
        "stops": [
            {"position": float(position), **_color(rgba)}
            for position, rgba in zip(fills.stop_positions[own], fills.stop_colors[own], strict=True)
        ],
    }


def _color(rgba: NDArray[np.float64]) -> dict[str, Any]:
    return {"color": format_rgb(rgba), "opacity": float(rgba[3])}


def _known(error: float) -> float | None:
    return None if math.isnan(error) else error
