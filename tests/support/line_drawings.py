# SPDX-License-Identifier: Apache-2.0
"""Ten line drawings of other kinds with known centre lines, and what pens, lenses and paper do to them.

`line_art` has those that the constants of line finding were chosen on; these were drawn afterwards.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.drawing import Drawing
from support.line_art import BLACK, BLUE, RED, Subpath, arc, curve, drawing, line, polygon

SIZE = (240, 240)
GREEN, GRAY = (0.1, 0.5, 0.2), (0.35, 0.35, 0.4)
_drawing = functools.partial(drawing, size=SIZE)


def _smooth(*points: tuple[float, float], closed: bool = False) -> Subpath:
    """Return a curve through points, with tangents along the neighbours' chord (Catmull and Rom)."""
    on = np.array(points, dtype=float)
    around = np.concatenate([on[-1:], on, on[:1]] if closed else [2 * on[:1] - on[1:2], on, 2 * on[-1:] - on[-2:-1]])
    tangents = (around[2:] - around[:-2]) / 6
    following, after = np.roll(on, -1, axis=0), np.roll(tangents, -1, axis=0)
    rows = np.stack([on, on + tangents, following - after], axis=1)
    if not closed:
        rows[-1] = on[-1]
    return rows, not closed


def _box(x: float, y: float, width: float, height: float) -> Subpath:
    return polygon((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def _arrow(*points: tuple[float, float], size: float = 8) -> list[Subpath]:
    """Return a polyline with a head at its end."""
    (x, y), (u, v) = points[-1], points[-2]
    angle = math.atan2(y - v, x - u)
    sides = [(x - size * math.cos(angle + turn), y - size * math.sin(angle + turn)) for turn in (0.6, -0.6)]
    return [line(*points), line(sides[0], (x, y), sides[1])]


def _note(x: float, y: float, up: bool = True) -> tuple[Subpath, Subpath]:
    """Return a note's head, a short thick line, and its stem."""
    side, end = (5.5, -42) if up else (-5.5, 42)
    return line((x - 2, y + 1), (x + 2, y - 1)), line((x + side, y), (x + side, y + end))


def _zigzag(x: float, y: float, length: float) -> list[tuple[float, float]]:
    """Return the corners of a resistor's sign along x."""
    steps = np.linspace(0, length, 7)
    heights = [0, -8, 8, -8, 8, -8, 0]
    return [(x + float(step), y + height) for step, height in zip(steps, heights, strict=True)]


def _spokes(x: float, y: float, radius: float, count: int) -> list[Subpath]:
    angles = np.arange(count) * math.pi / count + 0.2
    ends = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return [line((x - u, y - v), (x + u, y + v)) for u, v in ends.tolist()]


_NOTES = [_note(76, 76), _note(112, 64), _note(148, 86), _note(184, 58, up=False), _note(96, 168), _note(150, 152)]
_STAVES = [line((12, y + 11 * k), (228, y + 11 * k)) for y in (46, 138) for k in range(5)]

DRAWINGS: dict[str, Drawing] = {
    "signature": _drawing(
        (
            BLUE,
            4,
            [
                _smooth(
                    (30, 150), (58, 60), (72, 52), (66, 90), (50, 160), (88, 118), (104, 104), (98, 140), (124, 124)
                ),
                _smooth((124, 124), (136, 108), (140, 136), (158, 112), (164, 138), (186, 108), (208, 122)),
                _smooth((40, 182), (120, 168), (214, 176)),
            ],
        )
    ),
    "floor plan": _drawing(
        (
            BLACK,
            7,
            [
                line((40, 30), (210, 30), (210, 200), (140, 200)),
                line((105, 200), (30, 200), (30, 30), (40, 30)),
                line((120, 30), (120, 75)),
                line((120, 110), (120, 130), (210, 130)),
            ],
        ),
        (
            GRAY,
            2.5,
            [line((105, 200), (105, 165)), arc(105, 200, 35, -0.25, 0), _box(150, 45, 40, 25), arc(70, 100, 20)],
        ),
        (GRAY, 2.5, [line((30, 70), (60, 70)), line((140, 160), (190, 160), (190, 180))]),
        cap=0,
        join=0,
    ),
    "flow chart": _drawing(
        (
            BLACK,
            3,
            [_box(80, 15, 80, 34), polygon((120, 75), (165, 105), (120, 135), (75, 105)), _box(15, 175, 80, 40)],
        ),
        (BLACK, 3, [_smooth((150, 195), (185, 172), (220, 195), (185, 218), closed=True)]),
        (
            BLACK,
            3,
            [
                *_arrow((120, 49), (120, 73)),
                *_arrow((75, 105), (55, 105), (55, 173)),
                *_arrow((165, 105), (185, 105), (185, 171)),
                *_arrow((95, 195), (148, 195)),
            ],
        ),
        join=0,
    ),
    "music": _drawing(
        (BLACK, 1.8, [*_STAVES, line((228, 46), (228, 182)), line((12, 46), (12, 182))]),
        (BLACK, 2.4, [stem for _, stem in _NOTES]),
        (BLACK, 9, [head for head, _ in _NOTES]),
        (
            BLACK,
            2.6,
            [
                _smooth(
                    (34, 82), (26, 70), (36, 62), (44, 76), (32, 90), (22, 72), (40, 46), (38, 30), (32, 44), (38, 104)
                )
            ],
        ),
        cap=1,
    ),
    "circuit": _drawing(
        (
            BLACK,
            3,
            [
                line((30, 95), (30, 40), (60, 40), *_zigzag(60, 40, 48), (160, 40), (210, 40), (210, 90)),
                line((30, 113), (30, 200), (98, 200)),
                line((112, 200), (210, 200), (210, 130)),
                line((14, 95), (46, 95)),
                line((20, 113), (40, 113)),
                line((98, 184), (98, 216)),
                line((112, 184), (112, 216)),
                arc(210, 110, 20),
                line((196, 96), (224, 124)),
                line((224, 96), (196, 124)),
                line((135, 40), (135, 200)),
            ],
        ),
        (BLACK, 8, [line((135, 40), (135, 40)), line((135, 200), (135, 200))]),
        join=0,
    ),
    "map": _drawing(
        (RED, 6, [_smooth((15, 60), (70, 80), (110, 60), (170, 90), (225, 70))]),
        (BLUE, 6, [_smooth((60, 225), (80, 160), (140, 140), (150, 90), (190, 20))]),
        (GREEN, 6, [line((20, 130), (90, 130), (150, 190), (225, 190))]),
        (BLACK, 3, [arc(110, 60, 9), arc(150, 190, 9), arc(80, 160, 9)]),
        (GRAY, 1.8, [line((15, 20), (100, 30), (225, 160)), line((30, 225), (40, 100), (15, 20))]),
    ),
    "handwriting": _drawing(
        (
            BLACK,
            3.5,
            [
                _smooth((20, 110), (48, 70), (50, 40), (38, 44), (38, 112), (52, 82), (66, 84), (64, 112), (78, 104)),
                _smooth((78, 104), (96, 92), (92, 80), (80, 92), (88, 114), (112, 102)),
                _smooth((112, 102), (126, 60), (122, 38), (114, 60), (118, 112), (136, 102)),
                _smooth((136, 102), (148, 60), (144, 38), (136, 60), (140, 112), (158, 96)),
                _smooth((178, 84), (162, 82), (160, 112), (180, 110), (182, 84), (196, 86), (210, 78)),
                line((60, 150), (60, 205)),
                line((40, 150), (82, 150)),
                _smooth((92, 178), (108, 178), (106, 160), (90, 172), (94, 204), (116, 196)),
                line((128, 166), (152, 205)),
                line((152, 166), (128, 205)),
                line((178, 140), (176, 196), (190, 204)),
                line((164, 166), (192, 164)),
            ],
        )
    ),
    "plant": _drawing(
        (GREEN, 4, [_smooth((120, 225), (116, 160), (126, 100), (120, 30))]),
        (
            GREEN,
            3,
            [
                curve((117, 180), (90, 170), (60, 140), (55, 100), (90, 115), (115, 150), (117, 180)),
                curve((119, 140), (150, 130), (180, 100), (190, 62), (150, 75), (128, 110), (119, 140)),
                curve((124, 95), (105, 85), (88, 62), (84, 35), (105, 45), (122, 70), (124, 95)),
            ],
        ),
        (GRAY, 1.8, [line((117, 180), (70, 118)), line((119, 140), (176, 76)), line((124, 95), (94, 50))]),
    ),
    "cat": _drawing(
        (
            BLACK,
            4,
            [
                line((70, 75), (62, 28), (98, 52)),
                line((142, 52), (178, 28), (170, 75)),
                _smooth((70, 75), (60, 105), (82, 142), (120, 154), (158, 142), (180, 105), (170, 75)),
                curve((98, 52), (112, 47), (128, 47), (142, 52)),
                curve((82, 142), (60, 165), (58, 195), (62, 222)),
                curve((158, 142), (180, 165), (182, 195), (178, 222)),
                _smooth((178, 210), (206, 212), (222, 186), (206, 168), (212, 150)),
            ],
        ),
        (GREEN, 3, [arc(98, 92, 9, squeeze=0.8), arc(142, 92, 9, squeeze=0.8)]),
        (RED, 3, [polygon((112, 112), (128, 112), (120, 122))]),
        (
            BLACK,
            2,
            [
                curve((120, 122), (120, 134), (106, 136), (102, 130)),
                curve((120, 122), (120, 134), (134, 136), (138, 130)),
            ],
        ),
        (
            GRAY,
            1.6,
            [
                line((100, 118), (48, 108)),
                line((100, 122), (50, 130)),
                line((140, 118), (192, 108)),
                line((140, 122), (190, 130)),
            ],
        ),
    ),
    "bicycle": _drawing(
        (BLACK, 5, [arc(58, 160, 42), arc(182, 160, 42)]),
        (
            RED,
            4,
            [
                polygon((58, 160), (88, 95), (118, 160)),
                line((88, 95), (160, 90), (118, 160)),
                line((182, 160), (156, 72)),
                line((84, 86), (90, 100)),
            ],
        ),
        (
            BLACK,
            4,
            [
                line((70, 84), (98, 84)),
                curve((140, 66), (152, 74), (160, 72), (172, 64), (178, 58), (168, 50), (160, 54)),
            ],
        ),
        (GRAY, 1.6, [*_spokes(58, 160, 38, 5), *_spokes(182, 160, 38, 5)]),
    ),
}


def disturbed(image: NDArray[np.float32], kind: str) -> NDArray[np.float32]:
    """Return a picture as it is ("clean"), under noise of 10/255, blurred by 1 px, or photographed on shaded paper.

    Paper: light falls off from 1 to .85 from corner to corner, with noise of 4/255.
    """
    rng = np.random.default_rng(0)
    rows, columns = np.indices(image.shape[:2])
    shade = 1 - 0.15 * (rows + columns)[..., None] / (image.shape[0] + image.shape[1])
    changed = {
        "clean": lambda: image,
        "noise": lambda: image + rng.normal(0, 10 / 255, image.shape),
        "blur": lambda: ndimage.gaussian_filter(image, (1, 1, 0)),
        "paper": lambda: image * shade + rng.normal(0, 4 / 255, image.shape),
    }[kind]()
    return np.clip(changed, 0, 1).astype(np.float32)
