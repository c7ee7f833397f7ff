# SPDX-License-Identifier: Apache-2.0
"""Tiling of the canvas into strips and tiles, and the spans of tiles that layers may touch: host side of common.h.

A strip is `lanes` rows, a tile TILE columns of a strip. A span is the row of tiles where a layer's box meets a strip.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import Int32Array

#: Columns of a tile; the same as in kernels/common.h.
TILE = 8


@dataclasses.dataclass(frozen=True)
class Grid:
    """A canvas of `height` x `width` px in strips of `lanes` rows and tiles of TILE columns, padded to whole ones.

    With a `count`, that many canvases, stacked: the strips of one follow those of the other.
    """

    height: int
    width: int
    lanes: int
    count: int = 1

    @property
    def period(self) -> int:
        """Strips of one canvas; the last may extend beyond it."""
        return -(-self.height // self.lanes)

    @property
    def num_strips(self) -> int:
        """Strips of all canvases."""
        return self.count * self.period

    @property
    def num_tiles(self) -> int:
        """Tiles in a strip."""
        return -(-self.width // TILE)

    @property
    def num_columns(self) -> int:
        """Columns of the padded canvas."""
        return self.num_tiles * TILE

    def pack(self, image: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any]:
        """Turn images (count, H, W, C), or one without the axes of 1, into planes (C, num_strips, num_columns, lanes).

        Padding is 0.
        """
        image = image.reshape(self.count, self.height, self.width, -1)
        padded = np.zeros((self.count, self.period * self.lanes, self.num_columns, image.shape[3]), dtype)
        padded[:, : self.height, : self.width] = image
        strips = padded.reshape(self.num_strips, self.lanes, self.num_columns, -1)
        return np.ascontiguousarray(strips.transpose(3, 0, 2, 1))

    def unpack(self, planes: NDArray[Any]) -> NDArray[Any]:
        """Turn planes (C, num_strips, num_columns, lanes) into images (count, H, W, C), or the one (H, W, C)."""
        rows = planes.transpose(1, 3, 2, 0).reshape(self.count, self.period * self.lanes, self.num_columns, -1)
        images = np.ascontiguousarray(rows[:, : self.height, : self.width])
        return images if self.count > 1 else images[0]

    def boxes(self, bounds: NDArray[np.float64], margin: float) -> Int32Array:
        """Return the tiles within `margin` px of bounds (x_min, y_min, x_max, y_max), (N, 4) px, on one canvas.

        Returns
        -------
        (N, 4) int32
            First tile, first strip, and the same past the last; empty (first = past the last) off the canvas.
        """
        tile_size = np.array([TILE, self.lanes])
        ends = np.array([self.num_tiles, self.period])
        first = np.clip(np.floor((bounds[:, :2] - margin) / tile_size), 0, ends)
        last = np.clip(np.floor((bounds[:, 2:] + margin) / tile_size) + 1, first, ends)
        return np.concatenate([first, last], axis=1).astype(np.int32)

    def limits(self, boxes: Int32Array, margin: float) -> NDArray[np.float64]:
        """Return the largest bounds for which all tiles within `margin` px of them lie in `boxes`: (N, 4), px."""
        tile_size, ends = np.array([TILE, self.lanes]), np.array([self.num_tiles, self.period])
        low = np.where(boxes[:, :2] > 0, boxes[:, :2] * tile_size + margin, -np.inf)
        high = np.where(boxes[:, 2:] < ends, boxes[:, 2:] * tile_size - margin, np.inf)
        return np.concatenate([low, high], axis=1)


@dataclasses.dataclass(frozen=True)
class Spans:
    """The spans of all layers, sorted by strip and then by layer, with tables for kernels to find them."""

    #: (K, 4): layer, strip, first tile | past-the-last tile << 16, index of the strip's tile 0 in the per-tile buffers.
    spans: Int32Array
    strip_offsets: Int32Array  # (num_strips + 1,), first span of each strip
    layer_strips: Int32Array  # (N, 2), index into `layer_spans` of strip 0, first strip | past-the-last strip << 16
    layer_spans: Int32Array  # (K,), numbers of the spans, by layer and then by strip
    #: (B, 4): first span, past-the-last span, first strip, past-the-last strip of each band; a band's tiles fit the
    #: buffers.
    bands: Int32Array
    num_tiles: int  # tiles of the largest band
    grid: Grid  # the canvas, or canvases

    @functools.cached_property
    def each_band(self) -> tuple[Band, ...]:
        """The bands; always the same objects, so that unchanged arguments are not set again."""
        grid = self.grid
        canvas = [grid.width, grid.height, grid.num_strips, grid.num_tiles, grid.period]
        return tuple(
            Band(int(last_span - first_span), int(last_strip - first_strip) * grid.num_tiles, struct)
            for (first_span, last_span, first_strip, last_strip), struct in (
                (band, np.array([*canvas, *band], np.int32)) for band in self.bands
            )
        )


class Band(NamedTuple):
    """Strips of the canvas that are processed together."""

    #: Spans, and tiles of the canvas, in the band.
    num_spans: int
    num_tiles: int
    grid: Int32Array  # (9,), `Grid` of common.h, for the band


def plan_spans(boxes: Int32Array, grid: Grid, max_tiles: int) -> Spans:
    """Lay out the spans of the layers' boxes.

    Parameters
    ----------
    boxes : (N, 4) int32
        As :meth:`Grid.boxes` returns them; strips counted from the first of all canvases.
    grid : Grid
        The canvas, or canvases.
    max_tiles : int
        Largest number of tiles of a band; a single strip is never split.
    """
    widths = boxes[:, 2] - boxes[:, 0]
    heights = np.where(widths > 0, boxes[:, 3] - boxes[:, 1], 0)
    ends = np.cumsum(heights)
    starts = ends - heights
    layers = np.repeat(np.arange(len(boxes)), heights)
    strips = np.arange(len(layers)) + (boxes[:, 1] - starts)[layers]
    order = np.argsort(strips, kind="stable")
    layers, strips = layers[order], strips[order]
    strip_offsets = np.searchsorted(strips, np.arange(grid.num_strips + 1))
    layer_spans = np.empty_like(order)
    layer_spans[order] = np.arange(len(order))

    tile_ends = np.concatenate([[0], np.cumsum(widths[layers])])
    band_strips = _cut(tile_ends[strip_offsets], max_tiles, grid.period)
    band_spans = strip_offsets[band_strips]
    bands = np.stack([band_spans[:-1], band_spans[1:], band_strips[:-1], band_strips[1:]], axis=1)
    band_tiles = tile_ends[band_spans]
    first_tiles = tile_ends[:-1] - np.repeat(band_tiles[:-1], np.diff(band_spans))

    x = boxes[layers, 0] | boxes[layers, 2] << 16
    spans = np.stack([layers, strips, x, first_tiles - boxes[layers, 0]], axis=1)
    layer_strips = np.stack([starts - boxes[:, 1], boxes[:, 1] | (boxes[:, 1] + heights) << 16], axis=1)
    return Spans(
        spans=spans.astype(np.int32),
        strip_offsets=strip_offsets.astype(np.int32),
        layer_strips=layer_strips.astype(np.int32),
        layer_spans=layer_spans.astype(np.int32),
        bands=bands.astype(np.int32),
        num_tiles=int(np.diff(band_tiles).max()),
        grid=grid,
    )


def _cut(tiles_before: NDArray[Any], max_tiles: int, period: int) -> NDArray[Any]:
    """Divide strips into runs of at most `max_tiles` tiles, or one strip: the first strips of the runs, and the end.

    Runs are whole canvases, of `period` strips, or parts of one: a canvas is divided as it would be alone.
    """
    num_strips = len(tiles_before) - 1
    cuts = [0]
    while cuts[-1] < num_strips:
        begin = cuts[-1]
        fits = int(np.searchsorted(tiles_before, tiles_before[begin] + max_tiles, side="right")) - 1
        whole, canvas_end = fits // period * period, (begin // period + 1) * period
        cuts.append(whole if whole > begin and begin % period == 0 else min(max(fits, begin + 1), canvas_end))
    return np.array(cuts)
