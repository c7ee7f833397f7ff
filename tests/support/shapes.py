# SPDX-License-Identifier: Apache-2.0
"""Builders of outlines, and of drawings made of them.

A path is (s, 3, 2): one closed subpath of s segments (anchor, handle, handle), px. A layer is a list of paths and a
straight RGBA colour.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing

Path = NDArray[np.float64]
Layer = tuple[Sequence[Path], Sequence[float]]

RED, GREEN, BLUE = (0.9, 0.1, 0.2, 1.0), (0.1, 0.8, 0.3, 1.0), (0.2, 0.3, 0.9, 1.0)
RED_GLASS, GREEN_GLASS, BLUE_GLASS = (0.9, 0.1, 0.2, 0.6), (0.1, 0.8, 0.3, 0.45), (0.2, 0.3, 0.9, 0.7)
WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Case:
    """A drawing, and the number of pieces of each of its segments."""

    drawing: Drawing
    pieces: NDArray[np.int32]


def build(layers: Sequence[Layer], size: tuple[int, int], background: ArrayLike | None = (1.0, 1.0, 1.0)) -> Drawing:
    """Return the drawing of layers, bottom first."""
    paths = [path for outlines, _ in layers for path in outlines]
    return Drawing(
        points=np.concatenate(paths),
        colors=np.array([color for _, color in layers]),
        size=size,
        background=background,
        subpath_offsets=np.cumsum([0] + [len(path) for path in paths]).astype(np.int32),
        layer_offsets=np.cumsum([0] + [len(outlines) for outlines, _ in layers]).astype(np.int32),
    )


def alone(drawing: Drawing, layer: int) -> Drawing:
    """Return one layer in opaque white over black: each channel of its image is the layer's coverage."""
    return drawing.layer_subset([layer]).replace(colors=[WHITE], background=np.zeros(3))


def pieces_of_layer(case: Case, layer: int) -> NDArray[np.int32]:
    """Return the pieces of one layer's segments."""
    return case.pieces[case.drawing.segment_layers == layer]


def polygon(vertices: ArrayLike) -> Path:
    """Return a path of straight segments, the handles at a third and two thirds of each."""
    start = np.asarray(vertices, dtype=np.float64)
    end = np.roll(start, -1, axis=0)
    return np.stack([start, start + (end - start) / 3, start + 2 * (end - start) / 3], axis=1)


def rectangle(x_0: float, y_0: float, x_1: float, y_1: float) -> Path:
    """Return a rectangle, of positive area where x_0 < x_1 and y_0 < y_1."""
    return polygon([(x_0, y_0), (x_1, y_0), (x_1, y_1), (x_0, y_1)])


def circle(center: ArrayLike, radius: float, segments: int = 4) -> Path:
    """Return the usual approximation of a circle by two or more cubics: handles of 4/3 tan(pi / (2 s)) radii."""
    angle = 2 * np.pi * np.arange(segments) / segments
    step = 2 * np.pi / segments
    handle = 4 / 3 * np.tan(step / 4)

    def at(angle: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1), np.stack([-np.sin(angle), np.cos(angle)], axis=-1)

    (start, start_tangent), (end, end_tangent) = at(angle), at(angle + step)
    unit = np.stack([start, start + handle * start_tangent, end - handle * end_tangent], axis=1)
    return np.asarray(center, dtype=np.float64) + radius * unit


def blob(seed: int, center: ArrayLike, radius: float, segments: int = 4) -> Path:
    """Return a path whose 3 s control points lie about a circle, as after a few steps of training."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(3 * segments) + rng.uniform(-0.3, 0.3, 3 * segments)) / (3 * segments)
    reach = radius * rng.uniform(0.75, 1.3, 3 * segments)
    points = np.asarray(center) + reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return points.reshape(segments, 3, 2)


def tangle(seed: int, size: tuple[int, int], segments: int = 4, margin: float = 0.0) -> Path:
    """Return a path of control points anywhere on the canvas and up to `margin` px around it."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-margin, np.array(size[::-1]) + margin, (segments, 3, 2))


def reverse(path: Path) -> Path:
    """Return the same outline run through the other way, from the same first anchor."""
    cyclic = path.reshape(-1, 2)
    return np.roll(cyclic[::-1], 1, axis=0).reshape(path.shape)


def random_colors(seed: int, count: int, low: float = 0.2, high: float = 0.9) -> NDArray[np.float64]:
    """Return random straight RGBA (count, 4) with opacities between `low` and `high`."""
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.uniform(size=(count, 3)), rng.uniform(low, high, (count, 1))], axis=1)


def many_layers(
    size: tuple[int, int],
    num_small: int,
    num_large: int,
    seed: int,
    background: ArrayLike | None = (1.0, 1.0, 1.0),
) -> Case:
    """Return small blobs, and among them translucent ones that reach over most of the canvas or all of it."""
    rng = np.random.default_rng(seed)
    height, width = size
    paths = [
        blob(1000 * seed + i, rng.uniform((0, 0), (width, height)), rng.uniform(1, 4), segments=2)
        for i in range(num_small)
    ]
    paths += [
        blob(2000 * seed + i, (width / 2, height / 2), rng.uniform(0.4, 1.2) * max(size), segments=3)
        for i in range(num_large)
    ]
    order = rng.permutation(len(paths))
    colors = random_colors(seed, len(paths), 0.02, 0.2)
    return straight(build([([paths[i]], tuple(colors[i])) for i in order], size, background), 5)


def varied_pieces(drawing: Drawing, seed: int = 0, most: int = 9) -> Case:
    """Return the drawing with a random number of pieces for each segment."""
    rng = np.random.default_rng(seed)
    return Case(drawing=drawing, pieces=rng.integers(1, most + 1, drawing.num_segments, dtype=np.int32))


def straight(drawing: Drawing, pieces: int = 1) -> Case:
    """Return the drawing with the same number of pieces for all segments."""
    return Case(drawing=drawing, pieces=np.full(drawing.num_segments, pieces, dtype=np.int32))
