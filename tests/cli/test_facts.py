# SPDX-License-Identifier: Apache-2.0
"""Facts of a run as JSON: layers with their fills."""

from __future__ import annotations

import json

import numpy as np
from support.results import result_of, shaded_drawing

from livecl import Rasterizer
from livecl.cli.facts import facts
from livecl.drawing.strokes import Strokes
from livecl.run.recipe import Recipe


def test_fills_are_kinds_points_and_stops() -> None:
    strokes = Strokes(widths=[0, 6, 0], is_open=[False] * 4)
    drawing = shaded_drawing().replace(strokes=strokes)
    result = result_of(drawing, Rasterizer(drawing.size).forward(drawing))
    said = json.loads(json.dumps(facts(result, Recipe(schedule=(3,), options=result.options))))
    fills = [layer["fill"] for layer in said["layers"]]
    assert [fill["kind"] for fill in fills] == ["radial", "solid", "linear"]
    assert fills[0]["points"] == [[120, 110], [190, 110], [120, 180]]
    assert fills[1] == {"kind": "solid", "color": "#e64c1a", "opacity": 128 / 255}
    assert fills[2]["points"] == [[20, 45], [150, 45]]
    assert fills[2]["stops"] == [
        {"position": 0, "color": "#ffcc00", "opacity": 1},
        {"position": 1, "color": "#ff0000", "opacity": 0.4},
    ]
    assert [layer["stroke_width"] for layer in said["layers"]] == [0, 6, 0]
    assert said["layers"][2]["label"] == drawing.labels[2]
    assert np.isfinite(said["mse"])
