# SPDX-License-Identifier: Apache-2.0
"""Layout of the buffers: kernels and host mean the same, few parameters, sizes checked before anything is made."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from support import drawings

from livecl import Rasterizer
from livecl.drawing import LINEAR, Fills
from livecl.errors import DeviceMemoryError
from livecl.opencl.device import OpenDevice, open_device
from livecl.opencl.program import kernel_parameters, program_source
from livecl.rendering import fills, layout, tiling
from livecl.rendering.layout import Sizes, pack_tables
from livecl.rendering.pipeline import DistanceWeight
from livecl.rendering.tiling import Grid, plan_spans

NUM_STOPS = 40


def _fields(struct: str) -> list[str]:
    """Return the names of the integers of a struct of the kernels, in order."""
    body = re.search(r"typedef struct \{([^{}]*)\} " + struct + ";", program_source())
    assert body is not None
    return re.findall(r"(\w+)[,;]", re.sub(r"//.*", "", body[1]))


def test_no_kernel_has_more_than_eight_parameters() -> None:
    assert {name: len(names) for name, names in kernel_parameters().items() if len(names) > 8} == {}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("TILE", tiling.TILE),
        ("FILL_REALS", fills.FILL_REALS),
        ("D_GEOMETRY", fills.D_GEOMETRY),
        ("D_STOP", fills.D_STOP),
    ],
)
def test_constants_are_those_of_the_kernels(name: str, value: int) -> None:
    assert re.findall(rf"#define {name} (\d+)", program_source()) == [str(value)]


def test_bands_give_the_grid_in_the_kernels_order() -> None:
    grid = Grid(33, 50, 8)
    spans = plan_spans(grid.boxes(np.array([[0.0, 0, 50, 33], [4, 4, 30, 30]]), 0.0), grid, 20)
    canvas = {"width": 50, "height": 33, "num_strips": 5, "num_tiles": 7, "period": 5}
    assert len(spans.bands) > 2
    for row, band in zip(spans.bands, spans.each_band, strict=True):
        ends = dict(zip(("first_span", "last_span", "first_strip", "last_strip"), row.tolist(), strict=True))
        assert dict(zip(_fields("Grid"), band.grid.tolist(), strict=True)) == canvas | ends
        assert band.grid.dtype == np.int32
        assert band.num_spans == row[1] - row[0] and band.num_tiles == 7 * (row[3] - row[2])
    assert spans.each_band[1].grid is spans.each_band[1].grid


def test_tables_lie_where_their_head_says() -> None:
    case = drawings.CASES["holes"]()
    drawing, grid = case.drawing, Grid(*case.drawing.size, 8)
    spans = plan_spans(grid.boxes(np.tile([[1.0, 1, 15, 15]], (drawing.num_layers, 1)), 0.0), grid, 1 << 17)
    counts = np.arange(1, drawing.num_segments + 1)
    packed = pack_tables(drawing, counts, spans)
    names = _fields("Tables")
    head = dict(zip(names, packed.tolist(), strict=False))
    assert 4 * len(names) % 16 == 0, "spans are vectors of 16 bytes"
    assert np.array_equal(packed[len(names) :][: spans.spans.size].reshape(-1, 4), spans.spans)
    assert head["num_layers"] == drawing.num_layers and head["num_segments"] == drawing.num_segments
    assert head["num_lines"] == counts.sum() and head["num_spans"] == len(spans.spans)
    assert head["num_stored"] == spans.num_tiles
    for name, table in {
        "layer_strips": spans.layer_strips.ravel(),
        "layer_spans": spans.layer_spans,
        "strip_offsets": spans.strip_offsets,
        "layer_segments": drawing.segment_offsets,
        "next_segments": drawing.next_segments,
        "line_offsets": np.concatenate([[0], np.cumsum(counts)]),
        "line_layers": np.repeat(drawing.segment_layers, counts),
    }.items():
        assert np.array_equal(packed[head[name] : head[name] + len(table)], table), name
    assert head["layer_strips"] % 2 == 0, "a vector of 8 bytes"


def test_result_is_split_where_the_sizes_say() -> None:
    sizes = Sizes(Grid(8, 8, 8, count=2), real=4, num_layers=3, num_segments=5, record=16)
    parts = sizes.split_result(np.arange(sizes.num_results))
    assert [part.shape for part in parts] == [(3, 4), (5, 4, 2), (2, 4), (3, 16)]
    joined = np.concatenate([part.ravel() for part in parts])
    assert np.array_equal(joined, np.arange(sizes.num_results))
    assert sizes.backward(plan_spans(np.zeros((3, 4), np.int32), sizes.grid, 1), 0)["result"] == 4 * sizes.num_results


def test_the_caller_s_pieces_may_change_afterwards(device: int) -> None:
    case = drawings.CASES["holes"]()
    rasterizer, pieces = Rasterizer(case.drawing.size, device), np.array(case.pieces)
    image = rasterizer.forward(case.drawing, pieces)
    pieces += 1000  # the layout stays that of the first call; a far move lays out the spans anew
    moved = case.drawing.moved(case.drawing.points + 50, case.drawing.colors, case.drawing.background)
    rasterizer.forward(moved, pieces)
    assert np.array_equal(rasterizer.forward(case.drawing, pieces), image)


def _many_stops() -> Any:
    """Return a drawing of three layers, one of them with a gradient of many stops."""
    boxes = [([drawings.rectangle(2, 2, 60, 60)], (*color, 0.5)) for color in np.eye(3)]
    drawing = drawings.build(boxes, (64, 64))
    stops = np.linspace(0, 1, NUM_STOPS)
    return drawing.replace(
        fills=Fills(
            kinds=[0, LINEAR, 0],
            geometry=np.array([np.zeros((3, 2)), [[0, 0], [60, 60], [0, 0]], np.zeros((3, 2))]),
            stop_offsets=[0, 0, NUM_STOPS, NUM_STOPS],
            stop_positions=stops,
            stop_colors=np.stack([stops, stops, stops, np.ones(NUM_STOPS)], axis=1),
        )
    )


@pytest.mark.parametrize("limit", ["max_bytes", "memory_bytes"])
def test_lack_of_memory_is_told_before_anything_is_made(
    limit: str, device: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawing, opened = _many_stops(), open_device(device)
    target, weight = np.zeros((64, 64, 3), np.float32), DistanceWeight(4.0)
    needed: dict[str, int] = {}
    require_room = OpenDevice.require_room

    def recording(self: OpenDevice, sizes: dict[str, int]) -> None:
        needed.update(sizes if len(sizes) > 1 else {})
        require_room(self, sizes)

    with monkeypatch.context() as patch:
        patch.setattr(OpenDevice, "require_room", recording)
        expected = Rasterizer((64, 64), device).loss_and_gradients(drawing, target, weight)[0]
    # Records of that many stops need more room than all else: 8 x 8 tiles of three layers.
    record = layout.LINE + fills.D_GEOMETRY + fills.D_STOP * NUM_STOPS
    assert needed["d_tiles"] == max(needed.values()) == 4 * (3 * 64 * record + 4 * 64)
    enough = needed["d_tiles"] if limit == "max_bytes" else sum(needed.values())

    made: list[str] = []
    buffer = OpenDevice.buffer

    def noting(self: OpenDevice, name: str, size: int, content: Any = None) -> Any:
        made.append(name)
        return buffer(self, name, size, content)

    monkeypatch.setattr(OpenDevice, "buffer", noting)
    rasterizer = Rasterizer((64, 64), device)
    uploaded = rasterizer.upload(target)
    monkeypatch.setattr(opened, limit, enough - 1)
    made.clear()
    told = {
        "max_bytes": r" has no room for 0.\d+ MB \(d_tiles; at most",
        "memory_bytes": r"MB \(.* d_tiles,.*; it has 0\.",
    }
    with pytest.raises(DeviceMemoryError, match=told[limit]):
        rasterizer.loss_and_gradients(drawing, uploaded, weight)
    assert not set(made) & needed.keys(), "only the drawing's own numbers are there"
    monkeypatch.setattr(opened, limit, enough)
    assert rasterizer.loss_and_gradients(drawing, uploaded, weight)[0] == expected
