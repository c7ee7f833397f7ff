# SPDX-License-Identifier: Apache-2.0
"""Facts of a run as JSON: layers with their fills."""

from __future__ import annotations

import json

import numpy as np
from support import drawings, shapes
from support.results import result_of, shaded_drawing

from livecl import Rasterizer, read_svg
from livecl.cli.facts import facts
from livecl.drawing import Strokes, concatenate
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


def test_shapes_groups_and_colours() -> None:
    red, blue = (1, 0, 0, 1), (0, 0, 1, 1)
    layers = [([shapes.circle((30, 30), 20)], red), ([drawings.rectangle(25, 25, 35, 32)], blue)]
    layers += [([drawings.polygon([(50, 5), (59, 5), (55, 20)])], red), ([shapes.circle((50, 50), 5)], blue)]
    drawing = drawings.build(layers, (60, 60)).replace(
        groups=[["face"], ["face", "mouth"], [], []], strokes=Strokes(widths=[0, 0, 0, 2], is_open=[False] * 4)
    )
    namespace = 'xmlns="http://www.w3.org/2000/svg"'
    oval = read_svg(f'<svg {namespace} width="60" height="60"><ellipse rx="20" ry="9"/></svg>'.encode())
    whole = concatenate(drawing, oval)
    said = facts(result_of(whole, np.ones((60, 60, 3))), Recipe())
    assert [layer["shape"] for layer in said["layers"]] == ["circle", "rectangle", "path", "stroke", "ellipse"]
    assert [layer["groups"] for layer in said["layers"]] == [["face"], ["face", "mouth"], [], [], []]
    assert [layer["nodes"] for layer in said["layers"]] == np.diff(whole.segment_offsets).tolist()
    assert said["colors"] == {"#ff0000": 2, "#0000ff": 2, "#000000": 1}
