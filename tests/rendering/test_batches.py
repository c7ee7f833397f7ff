# SPDX-License-Identifier: Apache-2.0
"""Batches: many drawings in one launch give the bytes that each gives by itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import RasterizerFor
from support import drawings
from support.shapes import RED_GLASS, blob, rectangle

from livecl import Drawing, Gradients, Rasterizer
from livecl.drawing import LINEAR, Fills, Strokes
from livecl.drawing.assembly import empty_drawing
from livecl.rendering import batches
from livecl.rendering.stacks import Stack
from livecl.rendering.tiling import Grid, plan_spans

#: Of 21 rows: canvases end within a strip, in single precision as in double.
SIZE = (21, 20)


def _drawing(seed: int, num_layers: int, background: Any = (0.3, 0.6, 0.8), reach: float = 6) -> Drawing:
    rng = np.random.default_rng(seed)
    layers = [
        ([blob(seed + layer, rng.uniform(0, 20, 2), reach)], (*rng.uniform(0, 1, 3), rng.choice([0.6, 1.0])))
        for layer in range(num_layers)
    ]
    return drawings.build(layers, SIZE, background)


def _shaded(seed: int) -> Drawing:
    drawing = _drawing(seed, 2)
    fills = Fills(
        kinds=[0, LINEAR],
        geometry=np.array([np.zeros((3, 2)), [[2, 3], [17, 15], [0, 0]]]),
        stop_offsets=[0, 0, 2 + seed % 2],
        stop_positions=np.linspace(0.1, 0.9, 2 + seed % 2),
        stop_colors=np.random.default_rng(seed).uniform(0.1, 0.9, (2 + seed % 2, 4)),
    )
    return drawing.replace(fills=fills)


def _stroked(seed: int) -> Drawing:
    drawing = _drawing(seed, 3)
    pen = Strokes(widths=[0, 2.5, 1.2], caps=seed % 3, joins=1, is_open=np.array([False, True, False]))
    return drawing.replace(strokes=pen)


BATCHES: dict[str, list[Drawing]] = {
    "filled": [_drawing(seed, 1 + seed) for seed in range(4)] + [_drawing(9, 2, (0.9, 0.1, 0.2))],
    "without background": [_drawing(seed, 2, None) for seed in range(3)],
    "stroked": [_stroked(1), _drawing(2, 1), _stroked(3)],
    "shaded and solid": [_drawing(1, 2), _shaded(2), _stroked(3), _shaded(5)],
    "off the canvas": [
        _drawing(1, 3, reach=40),
        drawings.CASES["outside and around"]().drawing.replace(size=SIZE),
        _drawing(2, 1),
    ],
    "empty": [empty_drawing(SIZE, (0.2, 0.4, 0.6)), _drawing(3, 2), empty_drawing(SIZE)],
    "one": [_drawing(6, 2)],
}


def _assert_same(found: Gradients, expected: Gradients) -> None:
    for name in ("points", "colors", "background", "widths"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), name)
    assert (found.fills is None) == (expected.fills is None)
    if found.fills is not None and expected.fills is not None:
        for name in ("geometry", "stop_positions", "stop_colors"):
            np.testing.assert_array_equal(getattr(found.fills, name), getattr(expected.fills, name), name)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", BATCHES)
def test_images_and_gradients_are_those_of_each_drawing(rasterizer_for: RasterizerFor, name: str, dtype: type) -> None:
    batch, rasterizer = BATCHES[name], rasterizer_for(SIZE, dtype)

    images, pullback = rasterizer.vjp_all(batch)
    d_images = np.random.default_rng(1).normal(size=images.shape)
    found = pullback(d_images)

    assert images.shape == (len(batch), *SIZE, 3 if batch[0].background is not None else 4)
    assert images.dtype == dtype
    np.testing.assert_array_equal(rasterizer.forward_all(batch), images)
    for drawing, image, d_image, gradients in zip(batch, images, d_images, found, strict=True):
        expected, own = rasterizer.vjp(drawing)
        np.testing.assert_array_equal(image, expected)
        _assert_same(gradients, own(d_image))
    for gradients, again in zip(found, pullback(d_images), strict=True):
        _assert_same(again, gradients)


@pytest.mark.parametrize("max_tiles", [1, 11, 40])
def test_bands_are_those_of_each_drawing(device: int, max_tiles: int) -> None:
    batch = BATCHES["filled"]
    rasterizer = Rasterizer(SIZE, device, max_tiles=max_tiles)

    images, pullback = rasterizer.vjp_all(batch)
    found = pullback(images)

    for drawing, image, gradients in zip(batch, images, found, strict=True):
        expected, own = rasterizer.vjp(drawing)
        np.testing.assert_array_equal(image, expected)
        _assert_same(gradients, own(expected))


@pytest.mark.parametrize("max_tiles", [1, 5, 9, 14, 100])
def test_bands_are_whole_canvases_or_within_one(max_tiles: int) -> None:
    boxes = np.array([[0.0, 0, 20, 21], [3, 0, 9, 8], [0, 9, 20, 21]])
    alone, stacked = Grid(*SIZE, 8), Grid(*SIZE, 8, count=4)
    assert (stacked.period, stacked.num_strips) == (3, 12)
    own = alone.boxes(boxes, 0.0)
    shifted = np.concatenate([own + 3 * np.array([0, index, 0, index], np.int32) for index in range(4)])

    spans = plan_spans(shifted, stacked, max_tiles)

    by_itself = plan_spans(own, alone, max_tiles).bands[:, 2:]
    bands = spans.bands[:, 2:]
    if len(by_itself) > 1:  # too large for one: every canvas is cut as it would be alone
        assert np.array_equal(bands, np.concatenate([by_itself + 3 * index for index in range(4)]))
    else:
        assert not (bands % 3).any()
    assert bands[0, 0] == 0 and bands[-1, 1] == 12 and np.array_equal(bands[1:, 0], bands[:-1, 1])


@pytest.mark.parametrize(
    ("limit", "value", "sizes"),
    [
        ("MAX_STRIPS", 6, [2, 2, 1]),
        ("MAX_PIXELS", 3 * 21 * 20, [3, 2]),
        ("MAX_SEGMENTS", 3 * _drawing(0, 1).num_segments, [2, 1, 1, 1]),
    ],
)
def test_large_batches_are_worked_on_in_parts(
    rasterizer_for: RasterizerFor, monkeypatch: pytest.MonkeyPatch, limit: str, value: int, sizes: list[int]
) -> None:
    batch, rasterizer = BATCHES["filled"], rasterizer_for(SIZE, np.float32)
    expected, pullback = rasterizer.vjp_all(batch)
    gradients = pullback(expected)
    monkeypatch.setattr(batches, limit, value)
    split: list[int] = []
    stack_of = Stack.of
    monkeypatch.setattr(Stack, "of", lambda part: split.append(len(part)) or stack_of(part))

    images, parted = rasterizer.vjp_all(batch)

    assert split == sizes
    np.testing.assert_array_equal(images, expected)
    for one, other in zip(parted(images), gradients, strict=True):
        _assert_same(one, other)


def test_pieces_of_each_drawing(rasterizer_for: RasterizerFor) -> None:
    batch, rasterizer = BATCHES["stroked"], rasterizer_for(SIZE, np.float64)
    pieces = [np.full(drawing.num_segments, 2 + index) for index, drawing in enumerate(batch)]

    images, pullback = rasterizer.vjp_all(batch, pieces)
    found = pullback(images)

    np.testing.assert_array_equal(rasterizer.forward_all(batch, pieces), images)
    for drawing, own, gradients, image in zip(batch, pieces, found, images, strict=True):
        expected, single = rasterizer.vjp(drawing, own)
        np.testing.assert_array_equal(image, expected)
        _assert_same(gradients, single(expected))


def test_batches_leave_backward_to_the_drawing_rendered_last(rasterizer_for: RasterizerFor) -> None:
    rasterizer = rasterizer_for(SIZE, np.float64)
    drawing = _drawing(7, 2)
    image = rasterizer.forward(drawing)
    expected = rasterizer.backward(image)

    rasterizer.vjp_all(BATCHES["filled"])[1](np.zeros((5, *SIZE, 3)))

    _assert_same(rasterizer.backward(image), expected)


def test_what_does_not_fit_is_named(rasterizer_for: RasterizerFor) -> None:
    rasterizer, one = rasterizer_for(SIZE, np.float32), _drawing(1, 1)
    with pytest.raises(ValueError, match="drawings: got none"):
        rasterizer.forward_all([])
    with pytest.raises(ValueError, match="drawings: 1 has no background, 0 has one"):
        rasterizer.forward_all([one, _drawing(2, 1, None)])
    with pytest.raises(ValueError, match="drawings: 1 has a canvas of"):
        rasterizer.forward_all([one, one.replace(size=(8, 8))])
    with pytest.raises(ValueError, match="drawing: size"):
        rasterizer.forward_all([one.replace(size=(8, 8))])
    with pytest.raises(TypeError, match="drawing"):
        rasterizer.forward_all([one, np.zeros(3)])  # type: ignore[list-item]
    with pytest.raises(ValueError, match="pieces: for 1 drawings, wanted those of 2"):
        rasterizer.forward_all([one, one], [np.ones(one.num_segments, int)])
    images, pullback = rasterizer.vjp_all([one, one])
    with pytest.raises(ValueError, match="d_images: shape"):
        pullback(images[0])


def test_gradients_of_a_batch_are_differences(rasterizer_for: RasterizerFor) -> None:
    """Each drawing's gradient is that of its own pixels, on its own canvas, by central differences."""
    rasterizer = rasterizer_for(SIZE, np.float64)
    batch = [drawings.build([([rectangle(3.3, 4.2, 11.4, 15.7)], RED_GLASS)], SIZE), _drawing(4, 2)]
    pieces = [rasterizer.pieces(drawing) for drawing in batch]
    weights = np.random.default_rng(2).normal(size=(2, *SIZE, 3))
    found = rasterizer.vjp_all(batch, pieces)[1](weights)
    step = 1e-5
    for index, drawing in enumerate(batch):
        direction = np.random.default_rng(index).normal(size=drawing.points.shape)
        sums = []
        for sign in (1, -1):
            moved = list(batch)
            moved[index] = drawing.replace(points=drawing.points + sign * step * direction)
            sums.append((weights * rasterizer.forward_all(moved, pieces)).sum())
        assert (found[index].points * direction).sum() == pytest.approx((sums[0] - sums[1]) / (2 * step), rel=1e-6)
