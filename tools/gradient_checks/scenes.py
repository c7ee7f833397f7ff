# SPDX-License-Identifier: Apache-2.0
"""Random drawings of every kind that may occur in a run or an imported SVG."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from support import drawings
from support.drawings import Case
from support.shapes import Path

from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills

#: Canvases, (height, width): whole tiles or not, one pixel, one row. Few, as each has its own rasterizers.
SIZES = ((16, 16), (24, 31), (13, 7), (1, 1), (1, 41), (33, 50), (64, 48))
#: Most drawings have few layers; some have more than a run of the compositing kernel (32) holds.
FEW_LAYERS, MANY_LAYERS, MANY_SHARE = 7, 48, 0.03
#: Largest number of pieces of a segment.
MAX_PIECES = 9


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scene:
    """A random drawing.

    Attributes
    ----------
    case : Case
        The drawing and the pieces of its segments.
    kinds : tuple of str
        Kind of each layer.
    on_borders : (N,) bool
        Layers whose edges lie on pixel borders: their coordinates are whole numbers, which both precisions hold.
    """

    case: Case
    kinds: tuple[str, ...]
    on_borders: NDArray[np.bool_]


def random_scene(seed: int, index: int, fills: bool = False) -> Scene:
    """Return drawing `index` of a seed, optionally with random fills; it does not depend on other indices."""
    rng = np.random.default_rng([seed, index])
    size = SIZES[rng.integers(len(SIZES))]
    many = rng.uniform() < MANY_SHARE
    num_layers = int(rng.integers(FEW_LAYERS + 1, MANY_LAYERS + 1) if many else rng.integers(1, FEW_LAYERS + 1))
    kinds = tuple(str(kind) for kind in rng.choice(list(_KINDS), num_layers))
    layers = [(_KINDS[kind](rng, size), _color(rng)) for kind in kinds]
    background = None if rng.uniform() < 0.35 else rng.uniform(size=3)
    drawing = drawings.build(layers, size, background)
    case = drawings.varied_pieces(drawing, int(rng.integers(2**31)), MAX_PIECES)
    if fills:
        filled = drawing.replace(fills=random_fills(drawing, np.random.default_rng([seed, index, 2])))
        case = Case(drawing=filled, pieces=case.pieces)
    return Scene(case=case, kinds=kinds, on_borders=np.array([kind == "on borders" for kind in kinds]))


def random_fills(drawing: Drawing, rng: np.random.Generator) -> Fills:
    """Return a fill for each layer, a quarter of them solid; gradients lie about the layer, some are degenerate."""
    kinds = rng.choice((SOLID, LINEAR, RADIAL), drawing.num_layers, p=(0.25, 0.375, 0.375))
    counts = np.where(kinds == SOLID, 0, rng.choice((2, 2, 3, 5), drawing.num_layers))
    geometry = np.zeros((drawing.num_layers, 3, 2))
    positions = []
    for layer in range(drawing.num_layers):
        points = drawing.points[drawing.segment_layers == layer].reshape(-1, 2).clip(-50, 100)
        size = max(1.0, float(np.ptp(points, axis=0).max()))
        origin = points.mean(axis=0) + size * rng.normal(0, 0.4, 2)
        turns = rng.uniform(0, 2 * np.pi, 2)
        lengths = np.maximum(1.0, size * 2 ** rng.uniform(-1.5, 1, 2))
        geometry[layer] = origin
        geometry[layer, 1:] += lengths[:, None] * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        chance = rng.uniform()
        if chance < 0.04:
            geometry[layer, 1] = origin
        elif chance < 0.08:
            geometry[layer, 2] = 2 * origin - geometry[layer, 1]
        places = np.sort(rng.uniform(size=counts[layer]))
        if rng.uniform() < 0.3:
            places = np.linspace(0, 1, counts[layer])
        elif rng.uniform() < 0.15:
            places = np.round(2 * places) / 2
        positions.append(places)
    return Fills(
        kinds=kinds,
        geometry=geometry,
        stop_offsets=np.cumsum([0, *counts]),
        stop_positions=np.concatenate([np.zeros(0), *positions]),
        stop_colors=np.array([_color(rng) for _ in range(counts.sum())]).reshape(-1, 4),
    )


def _color(rng: np.random.Generator) -> tuple[float, ...]:
    """Return a colour; a quarter are opaque, one in twenty is invisible."""
    chance = rng.uniform()
    opacity = 1.0 if chance < 0.25 else 0.0 if chance > 0.95 else rng.uniform(0.02, 1)
    return (*rng.uniform(size=3), float(opacity))


def _place(rng: np.random.Generator, size: tuple[int, int]) -> NDArray[np.float64]:
    """Return a point on the canvas or a fifth of it outside, px."""
    return rng.uniform(-0.2, 1.2, 2) * size[::-1]


def _seed(rng: np.random.Generator) -> int:
    return int(rng.integers(2**31))


def _segments(rng: np.random.Generator) -> int:
    return int(rng.integers(1, 7))


def _blob(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    return [drawings.blob(_seed(rng), _place(rng, size), rng.uniform(0.1, 0.5) * max(size), _segments(rng))]


def _tiny(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    return [drawings.blob(_seed(rng), _place(rng, size), 10 ** rng.uniform(-2, 0), _segments(rng))]


def _large(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    return [drawings.blob(_seed(rng), _place(rng, size), rng.uniform(0.8, 4) * max(size), _segments(rng))]


def _outside(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    direction = rng.uniform(0, 2 * np.pi)
    center = np.array(size[::-1]) / 2 + rng.uniform(0.5, 1) * max(size) * np.array(
        [np.cos(direction), np.sin(direction)]
    )
    return [drawings.blob(_seed(rng), center, rng.uniform(0.1, 0.5) * max(size), _segments(rng))]


def _holes(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    center, radius = _place(rng, size), rng.uniform(0.2, 0.6) * max(size)
    inner = [
        drawings.reverse(
            drawings.blob(_seed(rng), center + rng.normal(size=2) * radius / 4, rng.uniform(0.1, 0.5) * radius, 3)
        )
        for _ in range(int(rng.integers(1, 3)))
    ]
    return [drawings.blob(_seed(rng), center, radius, 4), *inner]


def _tangle(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    return [drawings.tangle(_seed(rng), size, _segments(rng), 0.3 * max(size))]


def _doubled(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    """Two outlines that nearly coincide, in one direction or in opposite ones."""
    path = _blob(rng, size)[0]
    other = path + rng.normal(0, 0.05, path.shape)
    return [path, drawings.reverse(other) if rng.uniform() < 0.5 else other]


def _sliver(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    start, end = _place(rng, size), _place(rng, size)
    return [drawings.polygon([start, end, end + rng.normal(0, 0.3, 2), start + rng.normal(0, 0.3, 2)])]


def _rectangle(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    low, high = np.sort([_place(rng, size), _place(rng, size)], axis=0)
    return [drawings.rectangle(*low, *high)]


def _on_borders(rng: np.random.Generator, size: tuple[int, int]) -> list[Path]:
    low, high = np.sort(np.round([_place(rng, size), _place(rng, size)]), axis=0)
    path = drawings.rectangle(*low, *np.maximum(high, low + 1))
    return [path if rng.uniform() < 0.5 else drawings.reverse(path)]


_KINDS = {
    "blob": _blob,
    "tiny": _tiny,
    "large": _large,
    "outside": _outside,
    "holes": _holes,
    "tangle": _tangle,
    "doubled": _doubled,
    "sliver": _sliver,
    "rectangle": _rectangle,
    "on borders": _on_borders,
}
