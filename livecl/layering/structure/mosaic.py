# SPDX-License-Identifier: Apache-2.0
"""Pixel art: pictures of square cells in few colours, with exact outlines along the sides of cells.

Many small regions of hard steps hold no depth cues. A layer is a region, or all cells of one colour if there are more
regions than layers wanted, and extends behind later layers where that saves corners.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray, IntArray
from livecl.geometry.polylines import polygon_area
from livecl.layering.segmentation.flat import SAME_COLOR, FlatRegions
from livecl.layering.structure.layers import Layer

#: Least side of a cell, px. Single pixels are the hard edges of any drawing; only in pictures of few pixels they are
#: cells.
LEAST_SIDE, FEW_PIXELS = 2, 128 * 128
#: Most parts that become layers of their own and are tested for depth order.
MOST_PARTS = 64
#: Most colours of pixel art, and if its cells are pixels; most corners of its layers.
MOST_COLORS, MOST_COLORS_OF_PIXELS, MOST_CORNERS = 256, 32, 20_000
#: Levels of a channel that are distinguished; smaller differences are rounding.
LEVELS = 65535
_CROSS = ndimage.generate_binary_structure(2, 1)
#: Steps (row, column) along an outline in clockwise order: right, down, left, up.
_STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))


@dataclasses.dataclass(frozen=True, eq=False)
class Mosaic:
    """A picture as a grid of cells."""

    cells: IntArray  # (h, w), index of each cell's colour
    colors: FloatArray  # (K, C)
    rows: IntArray  # (h + 1,), horizontal sides of the cells, px
    columns: IntArray  # (w + 1,), vertical sides, px

    @property
    def enlarged(self) -> bool:
        """Whether every cell is larger than a pixel, except those cut by the page."""
        return _least_side(self.rows, self.columns) >= LEAST_SIDE

    @property
    def repeats(self) -> bool:
        """Whether colours recur, twice each on average, unlike on a ramp."""
        return self.num_parts >= 2 * len(self.colors)

    @functools.cached_property
    def parts(self) -> IntArray:
        """Labels of 8-connected cells of one colour: (h, w), from 0 on."""
        from skimage.measure import label

        return np.asarray(label(self.cells + 1, background=0, connectivity=2), dtype=np.int64) - 1

    @property
    def num_parts(self) -> int:
        """Number of 4-connected parts."""
        from skimage.measure import label

        return int(label(self.cells + 1, background=0, connectivity=1).max())

    def layers(self, ground: FloatArray, most: int) -> tuple[FlatRegions, list[Layer], BoolArray] | None:
        """Return the regions, the layers over a ground (C,), the lowest first, and their pixels (N, H, W).

        A layer is a part if there are at most `most` (and `MOST_PARTS`), else all cells of a colour. None if there are
        too many corners.
        """
        bare = self._bare(ground)
        parts, of_part = self.parts, np.zeros(self.parts.max() + 1, np.int64)
        of_part[parts.ravel()] = self.cells.ravel()
        by_color = self.num_parts > min(most, MOST_PARTS)
        unit = self.cells if by_color else parts
        unit = np.where(bare[parts], -1, unit)
        filled = {int(k): ndimage.binary_fill_holes(unit == k) for k in np.unique(unit[unit >= 0])}
        rank = np.full(max(filled, default=0) + 2, -1)  # the last entry is the ground's
        order = sorted(filled, key=lambda k: (-self._area(filled[k]), k))
        rank[order] = np.arange(len(order))
        ranks = rank[unit]
        sizes = np.bincount(self._on_pixels(parts).ravel())
        regions = FlatRegions(
            self._on_pixels(parts),
            self.colors[of_part],
            sizes,
            np.arange(len(sizes)),
            self._on_pixels(parts),
            np.ones(self._size),
            np.zeros(self._size),
        )
        layers, masks, corners = [], np.zeros((len(order), *self._size), bool), 0
        for number, k in enumerate(order):
            interruption.check()
            mask = simplest(ranks == number, ranks > number)
            corners += corner_count(mask)
            if corners > MOST_CORNERS:
                return None
            outlines = [np.stack([self.columns[x], self.rows[y]], axis=1).astype(np.float64) for y, x in loops(mask)]
            outlines.sort(key=lambda points: -abs(polygon_area(points)))
            color = self.colors[k if by_color else of_part[k]]
            shown = frozenset(np.unique(parts[ranks == number]).tolist())
            layers.append(Layer(outlines, color, shown, exact=True))
            masks[number] = self._on_pixels(mask)
        return regions, layers, masks

    def _bare(self, ground: FloatArray) -> BoolArray:
        """Return which parts are ground: of its colour, and at the page's border or without paint."""
        near = np.abs(self.colors - ground).max(axis=1) <= SAME_COLOR
        bare = np.zeros(self.parts.max() + 1, bool)
        bare[self.parts[near[self.cells]]] = True
        if len(ground) == 3:
            sides = (self.parts[0], self.parts[-1], self.parts[:, 0], self.parts[:, -1])
            outer = np.zeros_like(bare)
            outer[np.concatenate(sides)] = True
            bare &= outer
        return bare

    @property
    def _size(self) -> tuple[int, int]:
        return int(self.rows[-1]), int(self.columns[-1])

    def _area(self, mask: BoolArray) -> int:
        return int(np.diff(self.rows) @ mask @ np.diff(self.columns))

    def _on_pixels(self, values: NDArray[Any]) -> NDArray[Any]:
        return np.repeat(np.repeat(values, np.diff(self.rows), axis=0), np.diff(self.columns), axis=1)


def mosaic_of(image: NDArray[np.floating]) -> Mosaic | None:
    """Return a picture (H, W, C) as cells; None if it has too many colours, or cells of one pixel."""
    levels = np.round(np.asarray(image, dtype=np.float64) * LEVELS).astype(np.int64)
    rows, columns = _sides(levels, 0), _sides(levels, 1)
    enlarged = _least_side(rows, columns) >= LEAST_SIDE
    if not enlarged and image[..., 0].size > FEW_PIXELS:
        return None
    small = levels[rows[:-1]][:, columns[:-1]]
    colors, cells = np.unique(small.reshape(-1, small.shape[2]), axis=0, return_inverse=True)
    if len(colors) > (MOST_COLORS if enlarged else MOST_COLORS_OF_PIXELS):
        return None
    return Mosaic(cells.reshape(small.shape[:2]).astype(np.int64), colors / LEVELS, rows, columns)


def _least_side(*sides: IntArray) -> int:
    """Return the least side, px, of the cells not cut by the page."""
    return min(int(np.diff(along)[1:-1].min(initial=2**31)) for along in sides)


def _sides(levels: IntArray, axis: int) -> IntArray:
    """Return the positions where rows or columns differ from the preceding one, and both ends."""
    changes = np.diff(levels, axis=axis).any(axis=(1 - axis, 2))
    return np.concatenate([[0], np.flatnonzero(changes) + 1, [levels.shape[axis]]])


def simplest(own: BoolArray, later: BoolArray) -> BoolArray:
    """Return the cells of a layer: its own, and those of later layers (h, w) where they save corners."""
    hollows, count = ndimage.label(~own, _CROSS)
    shown = np.unique(hollows[~own & ~later])
    mask = own | (np.isin(hollows, np.setdiff1d(np.arange(1, count + 1), shown)) & later)
    patches, _ = ndimage.label(later & ~mask, _CROSS)
    beside = np.setdiff1d(np.unique(patches[ndimage.binary_dilation(mask, _CROSS)]), [0])
    boxes = ndimage.find_objects(patches)
    for patch in beside:
        box = tuple(slice(max(side.start - 1, 0), side.stop + 1) for side in boxes[patch - 1])
        extended = mask[box] | (patches[box] == patch)
        if corner_count(extended, box, own.shape) < corner_count(mask[box], box, own.shape):
            mask[box] = extended
    return mask


def corner_count(mask: BoolArray, box: tuple[slice, ...] | None = None, size: tuple[int, ...] | None = None) -> int:
    """Count the corners of the outlines of cells (h, w); for a box of a grid, those inside it."""
    padded = np.pad(mask, 1).astype(np.int8)
    odd = padded[1:, 1:] + padded[:-1, 1:] + padded[1:, :-1] + padded[:-1, :-1]
    crossed = (odd == 2) & (padded[1:, 1:] == padded[:-1, :-1])
    corners = (odd % 2) + 2 * crossed
    if box is not None and size is not None:
        inner = tuple(
            slice(0 if side.start == 0 else 1, None if side.stop >= end else -1)
            for side, end in zip(box, size, strict=True)
        )
        corners = corners[inner]
    return int(corners.sum())


def loops(mask: BoolArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the corners (rows, columns) of each outline of cells (h, w), clockwise; holes anticlockwise."""
    padded = np.pad(mask, 1)
    edges: dict[tuple[int, int], list[int]] = {}
    sides = (
        (padded[1:, 1:-1] & ~padded[:-1, 1:-1], (0, 0), 0),  # cells below: to the right
        (padded[1:-1, :-1] & ~padded[1:-1, 1:], (0, 0), 1),  # cells to the left: down
        (padded[:-1, 1:-1] & ~padded[1:, 1:-1], (0, 1), 2),
        (padded[1:-1, 1:] & ~padded[1:-1, :-1], (1, 0), 3),
    )
    for marked, (down, right), way in sides:
        for row, column in np.argwhere(marked).tolist():
            edges.setdefault((row + down, column + right), []).append(way)
    for start in sorted(edges):  # the first corner of each outline
        while edges[start]:
            at, way, before = start, edges[start][0], -1
            corners: list[tuple[int, int]] = []
            while not corners or at != start:
                edges[at].remove(way)
                if way != before:
                    corners.append(at)
                at, before = (at[0] + _STEPS[way][0], at[1] + _STEPS[way][1]), way
                # Where two cells touch at a corner alone, the outline stays with its own: it turns right.
                way = next((turn % 4 for turn in (way + 1, way, way + 3) if turn % 4 in edges[at]), -1)
            rows, columns = np.array(corners).T
            yield rows, columns
