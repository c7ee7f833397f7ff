# SPDX-License-Identifier: Apache-2.0
"""Drawings that the rasterizer's tests share, with the builders of `support.shapes`.

`CASES` are drawings with generic coordinates, one for each branch of the rasterizer, on which every derivative exists;
`BORDER_CASES` have edges exactly on pixel borders (or pixels that become full just there), where only the two one-sided
ones do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from support.shapes import (
    BLUE,
    BLUE_GLASS,
    GREEN,
    GREEN_GLASS,
    RED,
    RED_GLASS,
    Case,
    Layer,
    blob,
    build,
    many_layers,
    polygon,
    random_colors,
    rectangle,
    reverse,
    straight,
    tangle,
    varied_pieces,
)


def _case_opaque() -> Case:
    layers = [([blob(1, (9, 8), 6)], RED), ([blob(2, (13, 12), 5)], GREEN), ([blob(3, (8, 13), 5)], BLUE)]
    return varied_pieces(build(layers, (20, 21), (0.3, 0.6, 0.8)))


def _case_translucent() -> Case:
    layers = [
        ([blob(4, (9, 8), 6)], RED_GLASS),
        ([blob(5, (12, 11), 6)], GREEN_GLASS),
        ([blob(6, (8, 12), 6)], BLUE_GLASS),
    ]
    return varied_pieces(build(layers, (20, 21)))


def _case_rgba() -> Case:
    layers = [([blob(7, (9, 8), 6)], RED_GLASS), ([blob(8, (12, 11), 6)], GREEN), ([blob(9, (8, 12), 6)], BLUE_GLASS)]
    return varied_pieces(build(layers, (19, 18), None))


def _case_winding_two() -> Case:
    turns = 4 * np.pi * np.arange(12) / 12
    reach = np.where(np.arange(12) < 6, 7.3, 4.1)
    loop = np.array((10.2, 9.7)) + reach[:, None] * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    return varied_pieces(build([([loop.reshape(4, 3, 2)], RED_GLASS), ([blob(10, (12, 6), 4)], BLUE_GLASS)], (20, 20)))


def _case_opposite_windings() -> Case:
    eight = polygon([(3.3, 3.1), (16.2, 15.4), (16.8, 2.7), (2.6, 14.3)])
    return varied_pieces(build([([eight], GREEN_GLASS), ([blob(11, (5, 9), 4)], RED)], (18, 20)))


def _case_saturated() -> Case:
    layers = [([blob(12, (9, 9), 7), blob(13, (10, 10), 3), blob(14, (14, 12), 4)], RED_GLASS)]
    return varied_pieces(build(layers, (20, 20), (0.2, 0.9, 0.5)))


def _case_holes() -> Case:
    ring = [blob(15, (10, 9), 8), reverse(blob(16, (8, 9), 3)), reverse(blob(17, (14, 10), 2))]
    return varied_pieces(build([([blob(18, (6, 6), 4)], BLUE), (ring, RED_GLASS)], (20, 21)))


def _case_one_to_nine_segments() -> Case:
    colors = random_colors(19, 9)
    layers: list[Layer] = [
        ([blob(20 + s, (3.5 + 3 * ((s - 1) % 3) * 2, 4 + 6 * ((s - 1) // 3)), 4, segments=s)], tuple(colors[s - 1]))
        for s in range(1, 10)
    ]
    return varied_pieces(build(layers, (20, 19)), most=4)


def _case_axis_parallel() -> Case:
    layers = [([rectangle(2.3, 3.6, 11.7, 12.2)], RED_GLASS), ([reverse(rectangle(5.4, 5.5, 14.1, 14.9))], BLUE_GLASS)]
    return varied_pieces(build(layers, (17, 16)), most=4)


def _case_zero_length() -> Case:
    twice = np.array([(3.2, 2.4), (3.2, 2.4), (12.6, 4.3), (12.6, 4.3), (12.6, 4.3), (7.1, 11.8)])
    return varied_pieces(build([([polygon(twice)], RED_GLASS), ([blob(30, (9, 9), 4)], BLUE_GLASS)], (15, 16)), most=3)


def _case_across_borders() -> Case:
    centers = [(0.5, 9.2), (18.6, 8.4), (9.3, 0.6), (8.7, 17.4), (0.4, 0.7), (18.3, 17.7)]
    colors = random_colors(31, len(centers))
    return varied_pieces(
        build([([blob(32 + i, center, 4)], tuple(colors[i])) for i, center in enumerate(centers)], (18, 19)), most=6
    )


def _case_outside() -> Case:
    outside = [(-9.0, 7.3), (26.0, 8.1), (8.2, -9.0), (7.7, 24.0), (-8.0, -8.0)]
    colors = random_colors(38, len(outside) + 2)
    layers: list[Layer] = [([blob(39 + i, center, 5)], tuple(colors[i])) for i, center in enumerate(outside)]
    around = blob(44, (8, 8), 40)
    return varied_pieces(
        build([([around], tuple(colors[5])), *layers, ([blob(45, (7, 9), 5)], tuple(colors[6]))], (16, 17)), most=5
    )


def _case_point_like() -> Case:
    point, flat = np.tile((7.3, 6.2), (4, 3, 1)), polygon([(3.3, 3.1), (11.9, 9.4)])
    return varied_pieces(
        build([([blob(46, (7, 7), 5)], RED_GLASS), ([point], GREEN), ([flat], BLUE)], (14, 15)), most=4
    )


def _case_tangles() -> Case:
    size = (17, 22)
    layers = [([tangle(47, size, 4, 3)], RED_GLASS), ([tangle(48, size, 3, 6), tangle(49, size, 2)], BLUE_GLASS)]
    return varied_pieces(build(layers, size))


def _case_slivers() -> Case:
    layers = [
        ([polygon([(1.3, 2.21), (18.7, 2.84), (18.9, 3.12)])], RED_GLASS),
        ([polygon([(4.16, 1.2), (4.83, 14.7), (4.41, 14.9)])], GREEN_GLASS),
        ([polygon([(1.2, 13.4), (18.1, 1.3), (18.2, 1.5)])], BLUE_GLASS),
    ]
    return varied_pieces(build(layers, (16, 20)), most=5)


def _case_hidden_below_opaque() -> Case:
    over_all = polygon([(-30.2, -20.3), (60.4, -25.6), (61.7, 55.3), (-28.9, 57.1)])
    layers = [
        ([blob(50, (9, 9), 7)], RED),
        ([over_all], GREEN),
        ([blob(51, (11, 8), 5)], BLUE),
        ([blob(52, (6, 9), 4)], RED_GLASS),
    ]
    return varied_pieces(build(layers, (18, 20), (0.1, 0.2, 0.9)), most=5)


def _case_transparent_layer() -> Case:
    layers = [([blob(53, (7, 8), 5)], BLUE_GLASS), ([blob(54, (8, 7), 5)], (0.9, 0.8, 0.1, 0.0))]
    return varied_pieces(build(layers, (14, 15)))


def _on_canvas(size: tuple[int, int], seed: int) -> Callable[[], Case]:
    def case() -> Case:
        height, width = size
        colors = random_colors(seed, 3)
        paths = [
            blob(seed, (0.4 * width, 0.6 * height), 0.6 * max(size)),
            tangle(seed, size, 3, 2),
            tangle(seed + 1, size),
        ]
        return varied_pieces(
            build([([path], tuple(color)) for path, color in zip(paths, colors, strict=True)], size), most=5
        )

    return case


CASES: dict[str, Callable[[], Case]] = {
    "opaque": _case_opaque,
    "translucent": _case_translucent,
    "rgba": _case_rgba,
    "winding 2": _case_winding_two,
    "opposite windings": _case_opposite_windings,
    "saturated": _case_saturated,
    "holes": _case_holes,
    "1 to 9 segments": _case_one_to_nine_segments,
    "axis-parallel": _case_axis_parallel,
    "zero-length lines": _case_zero_length,
    "across the canvas's borders": _case_across_borders,
    "outside and around": _case_outside,
    "point-like": _case_point_like,
    "tangles": _case_tangles,
    "slivers": _case_slivers,
    "hidden below opaque": _case_hidden_below_opaque,
    "transparent layer": _case_transparent_layer,
    "13x7": _on_canvas((13, 7), 60),
    "7x13": _on_canvas((7, 13), 63),
    "1x1": _on_canvas((1, 1), 66),
    "1x41": _on_canvas((1, 41), 69),
    "41x1": _on_canvas((41, 1), 72),
    "8x8": _on_canvas((8, 8), 75),
    "33x50": _on_canvas((33, 50), 78),
}


def _border(layers: Sequence[Layer], size: tuple[int, int] = (20, 20), pieces: int = 1) -> Callable[[], Case]:
    return lambda: straight(build(layers, size, (0.2, 0.7, 0.4)), pieces)


_SQUARE, _SQUARE_LEFT = rectangle(3, 4, 9, 11), rectangle(2, 3, 6, 9)
_DIAMOND = polygon([(3, 8), (8, 3), (13, 8), (8, 13)])
_L_SHAPE = polygon([(2, 3), (12, 3), (12, 8), (7, 8), (7, 15), (2, 15)])

BORDER_CASES: dict[str, Callable[[], Case]] = {
    "rectangle": _border([([_SQUARE], RED_GLASS)]),
    "opaque rectangle": _border([([_SQUARE], RED)]),
    "reversed rectangle": _border([([reverse(_SQUARE)], RED_GLASS)]),
    "rectangle in pieces": _border([([_SQUARE], RED_GLASS)], pieces=5),
    "rectangle on multiples of 8": _border([([rectangle(8, 8, 16, 24)], RED_GLASS)], (32, 32)),
    "rectangle on multiples of 8, in pieces": _border([([rectangle(8, 8, 24, 16)], RED)], (32, 32), pieces=7),
    "whole canvas": _border([([rectangle(0, 0, 16, 8)], RED_GLASS)], (8, 16)),
    "whole canvas, not a multiple of 8": _border([([rectangle(0, 0, 13, 7)], RED)], (7, 13), pieces=3),
    "right half of the canvas": _border([([rectangle(8, 0, 16, 9)], RED_GLASS)], (9, 16)),
    "one pixel": _border([([rectangle(5, 6, 6, 7)], RED_GLASS)]),
    "1x1 canvas": _border([([rectangle(0, 0, 1, 1)], RED_GLASS)], (1, 1)),
    "borders in one direction": _border(
        [([rectangle(3, 4.4, 9, 11.3)], RED_GLASS), ([rectangle(4.6, 2, 12.3, 7)], BLUE_GLASS)]
    ),
    "L": _border([([_L_SHAPE], RED_GLASS)], pieces=2),
    "L and turned L": _border([([_L_SHAPE], RED_GLASS), ([_L_SHAPE[:, :, ::-1]], BLUE_GLASS)]),
    "hole": _border([([rectangle(2, 2, 14, 13), reverse(rectangle(5, 4, 10, 9))], RED_GLASS)]),
    "corners on pixel corners": _border([([_DIAMOND], RED_GLASS)], pieces=2),
    "triangle with one side on a border": _border([([polygon([(4, 2), (4, 14), (13.4, 9.3)])], RED_GLASS)], pieces=3),
    "neighbours in two layers": _border([([_SQUARE_LEFT], RED_GLASS), ([rectangle(6, 3, 11, 9)], BLUE_GLASS)]),
    "opaque neighbours in two layers": _border([([_SQUARE_LEFT], RED), ([rectangle(6, 3, 11, 9)], BLUE)]),
    "same place in two layers": _border([([_SQUARE], RED_GLASS), ([reverse(_SQUARE)], BLUE)], pieces=2),
    "neighbours in one layer": _border([([_SQUARE_LEFT, rectangle(6, 3, 11, 9)], RED_GLASS)]),
    "opposite neighbours in one layer": _border([([_SQUARE_LEFT, reverse(rectangle(6, 3, 11, 9))], RED_GLASS)]),
    "doubled in one layer": _border([([_SQUARE, _SQUARE], RED_GLASS)]),
    "one inside another on a common border": _border([([_SQUARE, rectangle(3, 6, 7, 9)], RED_GLASS)]),
    "doubled, cutting pixels in half": _border([([_DIAMOND, _DIAMOND], RED_GLASS)]),
    "doubled, cutting pixels in half, in pieces": _border([([_DIAMOND, _DIAMOND], RED_GLASS)], pieces=3),
    "flat rectangle on a border": _border([([rectangle(5, 3, 5, 12)], RED_GLASS), ([_SQUARE_LEFT], BLUE_GLASS)]),
    "curve with a side on a border": _border(
        [([np.array([[(4, 4), (7, 4), (9, 4)], [(12, 4), (15.3, 9.2), (1.7, 12.6)]], dtype=np.float64)], RED_GLASS)],
        pieces=6,
    ),
}

#: Both kinds; where a test needs no derivative, the borders make no difference.
ALL_CASES: dict[str, Callable[[], Case]] = {
    **CASES,
    **{f"border: {name}": case for name, case in BORDER_CASES.items()},
}

#: Many layers, as kernels often have an inner depth that is fixed.
CROWDS: dict[str, Callable[[], Case]] = {
    "80 small, 70 large": lambda: many_layers((24, 24), 80, 70, 5),
    "256 large": lambda: many_layers((33, 41), 0, 256, 6),
    "300 small": lambda: many_layers((40, 30), 300, 0, 7),
    "20 small, 100 large, no background": lambda: many_layers((20, 27), 20, 100, 8, None),
}
