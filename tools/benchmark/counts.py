# SPDX-License-Identifier: Apache-2.0
"""What a scene is made of, counted from its outlines alone: lines, pixels they cross, tiles that each layer concerns.

Independent of how the program goes about it, and slow. A tile is 8x8 px here, whatever the program's tiles are.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.geometry.bezier import evaluate

TILE = 8
#: Outlines are sampled this densely, px: a tile whose corner they cut by less may go uncounted.
_STEP = 0.25

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class Counts:
    """What one iteration has to deal with.

    Attributes
    ----------
    layers, segments : int
        Of the drawing.
    lines : int
        Lines that the outlines are flattened into.
    cells : int
        Pixels of the canvas that a line crosses, summed over lines.
    edge_tiles : int
        Tiles that a layer's outline passes, summed over layers.
    band_tiles : int
        Tiles with a pixel nearer than tau to a layer's outline, summed over layers.
    lit_tiles : int
        Tiles of the canvas that are in some layer's band: elsewhere the distance weight is 0.
    blended_tiles : int
        Layers that show in a lit tile, where some outline passes in it, summed over tiles: blended pixel by pixel.
    flat_tiles : int
        Layers that show in a lit tile where no outline passes, summed over tiles: blended once for the tile.
    """

    layers: int
    segments: int
    lines: int
    cells: int
    edge_tiles: int
    band_tiles: int
    lit_tiles: int
    blended_tiles: int
    flat_tiles: int


def counts(drawing: Drawing, pieces: ArrayLike, tau: float) -> Counts:
    """Count what an iteration on a drawing has to deal with.

    Parameters
    ----------
    drawing : Drawing
        The scene.
    pieces : (M,) array_like of int
        Lines that each segment is flattened into.
    tau : float
        Reach of the distance weight, px.
    """
    height, width = drawing.size
    shape = -(-height // TILE), -(-width // TILE)
    lines = [_lines(cubic, int(n)) for cubic, n in zip(drawing.cubics, np.asarray(pieces), strict=True)]
    offsets = drawing.segment_offsets
    edges, bands, shown = (np.zeros((drawing.num_layers, *shape), bool) for _ in range(3))
    cells = 0
    for layer in range(drawing.num_layers):
        own = np.concatenate(lines[offsets[layer] : offsets[layer + 1]])
        cells += crossed_cells(own, drawing.size)
        samples = _samples(own)
        edges[layer] = _passed(samples, drawing.size)
        bands[layer] = near_tiles(samples, drawing.size, tau)
        shown[layer] = edges[layer] | inner_tiles(own, shape)
    opaque = shown & ~edges & (drawing.colors[:, 3] == 1)[:, None, None]
    hidden = np.cumsum(opaque[::-1], axis=0)[::-1] - opaque > 0
    lit = bands.any(axis=0)
    shown &= lit & ~hidden
    passed = (edges & shown).any(axis=0)
    return Counts(
        layers=drawing.num_layers,
        segments=drawing.num_segments,
        lines=sum(map(len, lines)),
        cells=cells,
        edge_tiles=int(edges.sum()),
        band_tiles=int(bands.sum()),
        lit_tiles=int(lit.sum()),
        blended_tiles=int((shown & passed).sum()),
        flat_tiles=int((shown & ~passed).sum()),
    )


def _lines(cubic: FloatArray, pieces: int) -> FloatArray:
    """Lines (x0, y0, x1, y1) of a segment: (n, 4)."""
    vertices = evaluate(cubic, np.linspace(0, 1, pieces + 1))
    return np.concatenate([vertices[:-1], vertices[1:]], axis=1)


def _samples(lines: FloatArray) -> FloatArray:
    """Points along lines, `_STEP` apart at most, both ends included: (K, 2)."""
    length = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    steps = np.ceil(length / _STEP).astype(int) + 1
    line = np.repeat(np.arange(len(lines)), steps + 1)
    s = (np.arange(len(line)) - np.repeat(np.cumsum(steps + 1) - (steps + 1), steps + 1)) / np.repeat(steps, steps + 1)
    return np.asarray(lines[line, :2] + s[:, None] * (lines[line, 2:] - lines[line, :2]))


def crossed_cells(lines: FloatArray, size: tuple[int, int]) -> int:
    """Return how many pixels lines cross, each by itself: borders crossed plus one; parts off the canvas left out."""
    bound = np.array(size[::-1])
    start, end = np.clip(lines[:, :2], 0, bound), np.clip(lines[:, 2:], 0, bound)
    on_canvas = np.any(start != end, axis=1)
    return int(np.abs(np.floor(end) - np.floor(start)).sum(axis=1)[on_canvas].sum() + on_canvas.sum())


def _passed(samples: FloatArray, size: tuple[int, int]) -> BoolArray:
    """Tiles of the canvas that hold a sample: (rows, columns)."""
    shape = -(-size[0] // TILE), -(-size[1] // TILE)
    tiles = np.zeros(shape, bool)
    inside = np.all((samples >= 0) & (samples < np.array(size[::-1])), axis=1)
    columns, rows = (samples[inside] // TILE).astype(int).T
    tiles[rows, columns] = True
    return tiles


def inner_tiles(lines: FloatArray, shape: tuple[int, int]) -> BoolArray:
    """Tiles whose centre lies inside an outline by the nonzero rule: (rows, columns)."""
    change = np.zeros((shape[0], shape[1] + 1), int)
    centers = (np.arange(shape[0]) + 0.5) * TILE
    low, high = np.minimum(lines[:, 1], lines[:, 3]), np.maximum(lines[:, 1], lines[:, 3])
    crossing, row = np.nonzero((low[:, None] <= centers) & (centers < high[:, None]))
    x0, y0, x1, y1 = lines[crossing].T
    x = x0 + (centers[row] - y0) / (y1 - y0) * (x1 - x0)
    column = np.clip(np.ceil(x / TILE - 0.5), 0, shape[1]).astype(int)
    np.add.at(change, (row, column), np.sign(y1 - y0).astype(int))
    return np.asarray(np.cumsum(change, axis=1)[:, :-1] != 0)


def near_tiles(samples: FloatArray, size: tuple[int, int], reach: float) -> BoolArray:
    """Tiles with a pixel within `reach` of an outline, measured to the pixels that it passes: (rows, columns)."""
    from scipy.ndimage import distance_transform_edt

    height, width = size
    tiles = np.zeros((-(-height // TILE), -(-width // TILE)), bool)
    pixels = np.floor(samples).astype(int)
    margin = int(np.ceil(reach)) + 1
    close = np.all((pixels >= -margin) & (pixels < np.array([width, height]) + margin), axis=1)
    if not close.any():
        return tiles
    columns, rows = pixels[close].T
    first = np.array([rows.min(), columns.min()]) - margin
    far = np.ones(np.array([rows.max(), columns.max()]) + margin + 1 - first, bool)
    far[rows - first[0], columns - first[1]] = False
    near_rows, near_columns = np.nonzero(distance_transform_edt(far) < reach) + first[:, None]
    inside = (near_rows >= 0) & (near_rows < height) & (near_columns >= 0) & (near_columns < width)
    tiles[near_rows[inside] // TILE, near_columns[inside] // TILE] = True
    return tiles
