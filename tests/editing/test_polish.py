# SPDX-License-Identifier: Apache-2.0
"""Training of edited outlines: points and pens go where the picture has them, what it does not show stays."""

from __future__ import annotations

import numpy as np

from livecl.drawing import Drawing
from livecl.editing.polish import polished
from livecl.layering.context import Context
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg import read_svg


def drawing_of(elements: str) -> Drawing:
    return read_svg(f'<svg width="60" height="50"><g fill="#c33">{elements}</g></svg>'.encode())


def polished_to(true: Drawing, ours: Drawing, free: list[bool]) -> Drawing:
    rasterizer = Rasterizer(true.size)
    return polished(Context(rasterizer, rasterizer.forward(true), Options()), ours, np.array(free))


SHAPES = '<rect x="6" y="8" width="20" height="12"/><circle cx="42" cy="30" r="9" fill="#36c"/>'


def test_points_go_where_the_picture_has_them() -> None:
    true = drawing_of(SHAPES)
    ours = drawing_of(SHAPES.replace('x="6"', 'x="6.6"').replace('"20"', '"19"').replace('r="9"', 'r="8.5"'))
    found = polished_to(true, ours, [True, True])
    assert np.abs(found.points - true.points).max() < 0.02 < np.abs(ours.points - true.points).max()
    found = polished_to(true, ours, [False, True])
    assert np.array_equal(found.points[:4], ours.points[:4]) and not np.array_equal(found.points[4:], ours.points[4:])


def test_what_is_right_or_hidden_stays() -> None:
    true = drawing_of(SHAPES)
    assert np.array_equal(polished_to(true, true, [True, True]).points, true.points)
    hidden = '<circle cx="16" cy="14" r="4" fill="#fc0"/>'
    true, ours = (drawing_of(hidden + SHAPES.replace('r="9"', f'r="{radius}"')) for radius in (9, 8.5))
    found = polished_to(true, ours, [True, True, True])
    assert np.array_equal(found.points[:4], ours.points[:4])
    assert np.abs(found.points - true.points).max() < 0.02


def test_a_stroke_around_a_fill_follows_it_and_gets_its_width() -> None:
    ring = '<circle cx="30" cy="25" r="{}" stroke="black" stroke-width="{}"/>'
    true, ours = drawing_of(ring.format(14, 3)), drawing_of(ring.format(13.6, 2.4))
    found = polished_to(true, ours, [True, False])
    assert np.array_equal(found.points[:4], found.points[4:])
    assert np.abs(found.points - true.points).max() < 0.02 and abs(found.strokes.widths[1] - 3) < 0.02
