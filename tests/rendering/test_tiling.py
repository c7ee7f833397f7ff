# SPDX-License-Identifier: Apache-2.0
"""The cut of the canvas into strips and tiles, and the plan of the spans, against their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings

from livecl.drawing.assembly import empty_drawing
from livecl.drawing.canvas import layer_boxes
from livecl.opencl.program import LANES, kernel_dir
from livecl.rendering.tiling import TILE, Grid, Spans, plan_spans

SIZES = [(1, 1), (8, 8), (9, 7), (24, 40), (33, 50), (5, 129)]


def _boxes(seed: int, count: int, grid: Grid) -> NDArray[np.int32]:
    """Return random boxes (first tile, first strip, past the last), among them empty ones and the whole canvas."""
    rng = np.random.default_rng(seed)
    x = np.sort(rng.integers(0, grid.num_tiles + 1, size=(count, 2)), axis=1)
    y = np.sort(rng.integers(0, grid.num_strips + 1, size=(count, 2)), axis=1)
    boxes = np.stack([x[:, 0], y[:, 0], x[:, 1], y[:, 1]], axis=1)
    boxes[::7] = (0, 0, grid.num_tiles, grid.num_strips)
    return boxes.astype(np.int32)


def _tiles_of(spans: Spans, band: NDArray[np.int32], layer: int) -> list[tuple[int, int, int]]:
    """Return (strip, tile, place in the buffers) of all tiles that a band's spans give a layer."""
    found = []
    for owner, strip, ends, zero in spans.spans[band[0] : band[1]].tolist():
        if owner == layer:
            found += [(strip, tile, zero + tile) for tile in range(ends & 0xFFFF, ends >> 16)]
    return found


def test_constants_are_those_of_the_kernels() -> None:
    assert f"#define TILE {TILE}\n" in (kernel_dir() / "common.h").read_text(encoding="utf-8")
    assert {name: lanes * np.dtype(name).itemsize for name, lanes in LANES.items()} == {"float32": 32, "float64": 32}


@pytest.mark.parametrize("lanes", [4, 8])
@pytest.mark.parametrize("size", SIZES)
def test_grid_covers_the_canvas_with_less_than_a_tile_to_spare(size: tuple[int, int], lanes: int) -> None:
    grid = Grid(*size, lanes)
    assert 0 <= grid.num_strips * lanes - size[0] < lanes
    assert 0 <= grid.num_columns - size[1] < TILE and grid.num_columns == grid.num_tiles * TILE


@pytest.mark.parametrize("lanes", [4, 8])
@pytest.mark.parametrize("size", SIZES)
def test_pack_puts_rows_of_a_strip_side_by_side_and_unpack_undoes_it(size: tuple[int, int], lanes: int) -> None:
    grid = Grid(*size, lanes)
    image = np.random.default_rng(0).normal(size=(*size, 3))
    planes = grid.pack(image, np.dtype(np.float64))
    assert planes.shape == (3, grid.num_strips, grid.num_columns, lanes) and planes.flags.c_contiguous
    for row, column in [(0, 0), (size[0] - 1, size[1] - 1), (size[0] // 2, size[1] // 3)]:
        assert np.array_equal(planes[:, row // lanes, column, row % lanes], image[row, column])
    assert np.count_nonzero(planes) == image.size  # the rest is padding
    assert np.array_equal(grid.unpack(planes), image)


def test_pack_of_one_channel_and_of_another_type() -> None:
    grid = Grid(9, 7, 8)
    image = np.random.default_rng(0).normal(size=(9, 7))
    planes = grid.pack(image, np.dtype(np.float32))
    assert planes.shape == (1, 2, 8, 8) and planes.dtype == np.float32
    assert np.array_equal(grid.unpack(planes)[..., 0], image.astype(np.float32))


def test_bounds_hold_the_control_points() -> None:
    case = drawings.CASES["holes"]()
    drawing = case.drawing
    bounds = layer_boxes(drawing)
    for layer in range(drawing.num_layers):
        points = drawing.points[drawing.segment_layers == layer].reshape(-1, 2)
        assert bounds[layer].tolist() == [*points.min(axis=0), *points.max(axis=0)]
    assert layer_boxes(empty_drawing((4, 4))).shape == (0, 4)


@pytest.mark.parametrize("margin", [0.0, 0.125, 11.0])
@pytest.mark.parametrize("lanes", [4, 8])
def test_boxes_hold_the_tiles_within_the_margin_and_no_others(lanes: int, margin: float) -> None:
    grid = Grid(37, 61, lanes)
    rng = np.random.default_rng(1)
    low = rng.uniform(-90, 110, size=(200, 2))
    bounds = np.concatenate([low, low + rng.uniform(0, 60, size=(200, 2))], axis=1)
    boxes = grid.boxes(bounds, margin)
    assert boxes.dtype == np.int32
    for (x0, y0, x1, y1), (first_tile, first_strip, end_tile, end_strip) in zip(bounds, boxes.tolist(), strict=True):
        tiles = [t for t in range(grid.num_tiles) if TILE * t <= x1 + margin and TILE * (t + 1) > x0 - margin]
        strips = [s for s in range(grid.num_strips) if lanes * s <= y1 + margin and lanes * (s + 1) > y0 - margin]
        assert list(range(first_tile, end_tile)) == tiles
        assert list(range(first_strip, end_strip)) == strips


@pytest.mark.parametrize("margin", [0.125, 10.125])
def test_bounds_within_the_limits_stay_in_their_boxes(margin: float) -> None:
    grid = Grid(37, 61, 8)
    rng = np.random.default_rng(2)
    low = rng.uniform(-30, 60, size=(300, 2))
    bounds = np.concatenate([low, low + rng.uniform(0, 40, size=(300, 2))], axis=1)
    boxes = grid.boxes(bounds, margin + 3)
    limits = grid.limits(boxes, margin)
    moved = bounds + rng.uniform(-8, 8, size=(300, 1)) * rng.integers(0, 2, size=(300, 4))
    moved[:, 2:] = np.maximum(moved[:, 2:], moved[:, :2])
    tight = grid.boxes(moved, margin)
    inside = (tight[:, :2] >= boxes[:, :2]).all(axis=1) & (tight[:, 2:] <= boxes[:, 2:]).all(axis=1)
    allowed = (moved[:, :2] >= limits[:, :2]).all(axis=1) & (moved[:, 2:] < limits[:, 2:]).all(axis=1)
    assert np.all(inside[allowed])
    # A step of 3 px never leaves boxes laid out with 3 px to spare.
    assert np.all((bounds[:, :2] - 3 >= limits[:, :2]) & (bounds[:, 2:] + 3 <= limits[:, 2:]))
    assert 30 < allowed.sum() < 300


@pytest.mark.parametrize("max_tiles", [1, 7, 40, 1 << 17])
@pytest.mark.parametrize("seed", range(3))
def test_spans_cover_every_layer_s_box_exactly_once(seed: int, max_tiles: int) -> None:
    grid = Grid(70, 90, 8)
    boxes = _boxes(seed, 23, grid)
    spans = plan_spans(boxes, grid, max_tiles)
    for layer, (x0, y0, x1, y1) in enumerate(boxes.tolist()):
        found = [tile[:2] for band in spans.bands for tile in _tiles_of(spans, band, layer)]
        assert sorted(found) == [(strip, tile) for strip in range(y0, y1) for tile in range(x0, x1)]


@pytest.mark.parametrize("max_tiles", [1, 7, 40, 1 << 17])
def test_bands_fit_and_share_the_buffers_without_overlap(max_tiles: int) -> None:
    grid = Grid(70, 90, 8)
    boxes = _boxes(5, 23, grid)
    spans = plan_spans(boxes, grid, max_tiles)
    assert np.array_equal(spans.bands[1:, [0, 2]], spans.bands[:-1, [1, 3]])
    assert spans.bands[0, [0, 2]].tolist() == [0, 0]
    assert spans.bands[-1, [1, 3]].tolist() == [len(spans.spans), grid.num_strips]
    widths = boxes[:, 2] - boxes[:, 0]
    for band in spans.bands:
        places = [tile[2] for layer in range(len(boxes)) for tile in _tiles_of(spans, band, layer)]
        assert sorted(places) == list(range(len(places))) and len(places) <= spans.num_tiles
        strips = range(band[2], band[3])
        needed = sum(int(widths[(boxes[:, 1] <= s) & (s < boxes[:, 3])].sum()) for s in strips)
        assert len(places) == needed
        assert needed <= max_tiles or len(strips) == 1, "only a single strip may hold more"
    assert spans.num_tiles <= max(max_tiles, max(int(widths.sum()), 1))


def test_one_band_where_all_fits() -> None:
    grid = Grid(70, 90, 8)
    boxes = _boxes(5, 23, grid)
    whole = int(np.prod(boxes[:, 2:] - boxes[:, :2], axis=1).sum())
    assert len(plan_spans(boxes, grid, whole).bands) == 1
    assert len(plan_spans(boxes, grid, whole - 1).bands) > 1


def test_tables_lead_to_the_spans() -> None:
    grid = Grid(70, 90, 8)
    boxes = _boxes(6, 23, grid)
    spans = plan_spans(boxes, grid, 30)
    layers, strips = spans.spans[:, 0], spans.spans[:, 1]
    assert np.array_equal(np.lexsort((layers, strips)), np.arange(len(layers))), "by strip and then by layer"
    for strip in range(grid.num_strips):
        first, end = spans.strip_offsets[strip : strip + 2]
        assert np.all(strips[first:end] == strip)
    assert spans.strip_offsets[-1] == len(spans.spans)
    for layer in range(len(boxes)):
        zero, ends = spans.layer_strips[layer].tolist()
        for strip in range(ends & 0xFFFF, ends >> 16):
            span = spans.layer_spans[zero + strip]
            assert (layers[span], strips[span]) == (layer, strip)
        box = boxes[layer]
        expected = range(box[1], box[3]) if box[2] > box[0] else range(0)
        assert len(range(ends & 0xFFFF, ends >> 16)) == len(expected)


@pytest.mark.parametrize("count", [0, 5])
def test_no_layers_or_all_off_the_canvas(count: int) -> None:
    grid = Grid(20, 20, 8)
    boxes = grid.boxes(np.tile([[100.0, 100.0, 120.0, 130.0]], (count, 1)), 0.125)
    spans = plan_spans(boxes, grid, 4)
    assert len(spans.spans) == 0 and spans.num_tiles == 0
    assert spans.bands[:, :2].max() == 0
    # Every strip still belongs to a band: the background is painted on it.
    assert spans.bands[0, 2] == 0 and spans.bands[-1, 3] == grid.num_strips
