# SPDX-License-Identifier: Apache-2.0
"""Drawings of the project's own whose shapes have a fill and an outline: badges, buttons, cartoon shapes."""

from __future__ import annotations

import numpy as np

from livecl.drawing import Drawing, Strokes
from support.line_art import arc, curve, polygon

SIZE = (160, 160)
INK, RED, BLUE, GREEN = (0.12, 0.1, 0.15), (0.85, 0.2, 0.15), (0.2, 0.4, 0.8), (0.25, 0.65, 0.35)
YELLOW, WHITE, SKIN, PALE = (0.98, 0.8, 0.2), (1.0, 1.0, 1.0), (0.96, 0.8, 0.68), (0.9, 0.93, 0.97)

Color = tuple[float, float, float]
#: A subpath, its fill, and colour and width of its outline; no outline where the width is 0.
Shape = tuple[np.ndarray, Color, Color, float]


def rounded(x: float, y: float, width: float, height: float, radius: float) -> np.ndarray:
    """A closed rectangle with round corners."""
    k = 0.5523 * radius
    right, low = x + width, y + height
    nodes = [
        ((x + radius, y), (right - radius, y)),
        ((right, y + radius), (right, low - radius)),
        ((right - radius, low), (x + radius, low)),
        ((x, low - radius), (x, y + radius)),
    ]
    ways = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    rows = []
    for side in range(4):
        start, end = (np.array(node, dtype=float) for node in nodes[side])
        turn, way, next_way = np.array(nodes[(side + 1) % 4][0], dtype=float), ways[side], ways[(side + 1) % 4]
        rows.append([start, start + (end - start) / 3, end - (end - start) / 3])
        rows.append([end, end + k * np.array(way), turn - k * np.array(next_way)])
    return np.array(rows, dtype=float)


def blob(*anchors: tuple[float, float]) -> np.ndarray:
    """A smooth closed curve through anchors (Catmull-Rom)."""
    on = np.array(anchors, dtype=float)
    tangents = (np.roll(on, -1, axis=0) - np.roll(on, 1, axis=0)) / 6
    after = np.roll(on, -1, axis=0)
    return np.stack([on, on + tangents, after - np.roll(tangents, -1, axis=0)], axis=1)


def outlined(*shapes: Shape, join: int = 0, background: Color = WHITE) -> Drawing:
    """Shapes in paint order, each a layer with a fill and one with the outline above it."""
    outlines, colors, widths = [], [], []
    for rows, fill, ink, width in shapes:
        for color, pen in ((fill, 0.0), (ink, width))[: 2 if width else 1]:
            outlines.append([rows])
            colors.append((*color, 1))
            widths.append(pen)
    return Drawing.from_outlines(
        outlines,
        colors,
        SIZE,
        background,
        strokes=Strokes(widths=widths, joins=join, is_open=np.zeros(len(outlines), bool)),
    )


def _star(radius: float, inner: float, count: int = 5) -> np.ndarray:
    angles = np.arange(2 * count) * np.pi / count - np.pi / 2
    radii = np.where(np.arange(2 * count) % 2, inner, radius)
    return polygon(*(80 + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)).tolist())[0]


def _disc(x: float, y: float, radius: float, squeeze: float = 1.0) -> np.ndarray:
    return arc(x, y, radius, squeeze=squeeze)[0]


_SHIELD = curve(
    (30, 30), (60, 34), (100, 34), (130, 30), (136, 90), (110, 130), (80, 144), (50, 130), (24, 90), (30, 30)
)[0]

DRAWINGS: dict[str, Drawing] = {
    "badge": outlined((_disc(80, 80, 58), BLUE, YELLOW, 8), (_star(34, 15), WHITE, WHITE, 0)),
    "ball": outlined((blob((30, 90), (55, 40), (110, 35), (135, 85), (95, 130), (45, 128)), GREEN, INK, 5), join=1),
    "button": outlined((rounded(20, 50, 120, 60, 14), PALE, BLUE, 4), (rounded(50, 74, 60, 12, 3), INK, INK, 0)),
    "cat": outlined(
        (polygon((38, 70), (45, 18), (76, 48))[0], YELLOW, INK, 4),
        (polygon((122, 70), (115, 18), (84, 48))[0], YELLOW, INK, 4),
        (_disc(80, 88, 52, 0.85), YELLOW, INK, 4),
        (_disc(60, 82, 6), INK, INK, 0),
        (_disc(100, 82, 6), INK, INK, 0),
        join=1,
    ),
    "cells": outlined(
        (polygon((20, 20), (80, 20), (80, 80), (20, 80))[0], RED, INK, 4),
        (polygon((80, 20), (140, 20), (140, 80), (80, 80))[0], BLUE, INK, 4),
        (polygon((20, 80), (80, 80), (80, 140), (20, 140))[0], GREEN, INK, 4),
        (polygon((80, 80), (140, 80), (140, 140), (80, 140))[0], YELLOW, INK, 4),
    ),
    "cloud": outlined(
        (_disc(48, 120, 20), SKIN, RED, 3), (_disc(112, 118, 24), PALE, BLUE, 3), (_star(52, 40, 7), GREEN, INK, 3)
    ),
    "hexagon": outlined(
        (polygon((80, 18), (134, 49), (134, 111), (80, 142), (26, 111), (26, 49))[0], RED, INK, 6),
        (_disc(80, 80, 24), WHITE, INK, 6),
    ),
    "jar": outlined((rounded(40, 40, 80, 100, 18), PALE, INK, 4), (rounded(50, 20, 60, 20, 4), RED, INK, 4), join=1),
    "plate": outlined((_disc(80, 80, 62), PALE, INK, 3), (_disc(80, 80, 40), PALE, INK, 3), background=(0.7, 0.8, 0.7)),
    "shield": outlined((_SHIELD[:3], BLUE, WHITE, 7), background=(0.2, 0.2, 0.25)),
    "sign": outlined(
        (polygon((80, 22), (146, 134), (14, 134))[0], YELLOW, RED, 12), (_disc(80, 100, 12), INK, INK, 0), join=1
    ),
    "star": outlined((_star(62, 28), YELLOW, INK, 5), join=0),
}
