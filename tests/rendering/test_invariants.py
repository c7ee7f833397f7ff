# SPDX-License-Identifier: Apache-2.0
"""What must hold for any drawing: symmetries, invisible layers, the same bytes for the same input, and errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import RasterizerFor
from reference.rounding import coverage_tolerance, image_tolerance, points_tolerance
from support import drawings, shapes

from livecl import Drawing, list_devices
from livecl.drawing.assembly import concatenate, empty_drawing
from livecl.rendering.rasterizer import Gradients, Rasterizer

DTYPES = [np.float32, np.float64]
GENERIC = [
    "opaque",
    "translucent",
    "rgba",
    "winding 2",
    "holes",
    "1 to 9 segments",
    "across the canvas's borders",
    "tangles",
]


def _image_like(drawing: Drawing, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(*drawing.size, 4 if drawing.background is None else 3))


def _render(
    rasterizer_for: RasterizerFor, case: drawings.Case, dtype: type, d_image: np.ndarray
) -> tuple[np.ndarray, Gradients]:
    rasterizer = rasterizer_for(case.drawing.size, dtype)
    image = rasterizer.forward(case.drawing, pieces=case.pieces).copy()
    return image, rasterizer.backward(d_image)


def _check(
    found: tuple[np.ndarray, np.ndarray],
    expected: tuple[np.ndarray, np.ndarray],
    case: drawings.Case,
    dtype: type,
    d_image: np.ndarray,
) -> None:
    """Compare images and d_points, each off by its own rounding; in double the same, in smaller units."""
    factor = 2.0 if dtype is np.float32 else 2.0 * 2.0**-29
    allowed = float(np.max(image_tolerance(case.drawing, case.pieces)))  # images may be cut
    assert np.max(np.abs(found[0] - expected[0])) <= factor * allowed
    assert np.all(np.abs(found[1] - expected[1]) <= factor * points_tolerance(case.drawing, case.pieces, d_image))


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", GENERIC)
def test_whole_pixel_shift_shifts_the_image(rasterizer_for: RasterizerFor, name: str, dtype: type) -> None:
    case = drawings.CASES[name]()
    height, width = case.drawing.size
    down, right = 9, 3
    larger = drawings.Case(drawing=case.drawing.replace(size=(height + 12, width + 7)), pieces=case.pieces)
    moved = drawings.Case(
        drawing=larger.drawing.replace(points=case.drawing.points + np.array((right, down))), pieces=case.pieces
    )
    d_image = _image_like(case.drawing)
    d_larger, d_moved = np.zeros_like(_image_like(larger.drawing)), np.zeros_like(_image_like(moved.drawing))
    d_larger[:height, :width] = d_image
    d_moved[down : down + height, right : right + width] = d_image
    image, gradients = _render(rasterizer_for, larger, dtype, d_larger)
    shifted, d_shifted = _render(rasterizer_for, moved, dtype, d_moved)
    expected = image[: height + 12 - down, : width + 7 - right], gradients.points
    _check((shifted[down:, right:], d_shifted.points), expected, moved, dtype, d_moved)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", GENERIC)
def test_transposed_drawing_gives_the_transposed_image(rasterizer_for: RasterizerFor, name: str, dtype: type) -> None:
    case = drawings.CASES[name]()
    turned = drawings.Case(
        drawing=case.drawing.replace(points=case.drawing.points[..., ::-1], size=case.drawing.size[::-1]),
        pieces=case.pieces,
    )
    d_image = _image_like(case.drawing)
    image, gradients = _render(rasterizer_for, case, dtype, d_image)
    transposed, d_transposed = _render(rasterizer_for, turned, dtype, np.swapaxes(d_image, 0, 1))
    turned_back = np.swapaxes(transposed, 0, 1), d_transposed.points[..., ::-1]
    _check(turned_back, (image, gradients.points), case, dtype, d_image)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", GENERIC)
def test_mirrored_drawing_gives_the_mirrored_image(rasterizer_for: RasterizerFor, name: str, dtype: type) -> None:
    case = drawings.CASES[name]()
    flipped = drawings.Case(
        drawing=case.drawing.replace(points=(case.drawing.size[1], 0) + case.drawing.points * (-1, 1)),
        pieces=case.pieces,
    )
    d_image = _image_like(case.drawing)
    image, gradients = _render(rasterizer_for, case, dtype, d_image)
    mirrored, d_mirrored = _render(rasterizer_for, flipped, dtype, d_image[:, ::-1])
    turned_back = mirrored[:, ::-1], d_mirrored.points * (-1, 1)
    _check(turned_back, (image, gradients.points), case, dtype, d_image)


@pytest.mark.parametrize("dtype", DTYPES)
def test_reversed_paths_change_nothing(rasterizer_for: RasterizerFor, dtype: type) -> None:
    layers = [
        ([drawings.blob(1, (9, 8), 6)], drawings.RED_GLASS),
        ([drawings.tangle(2, (20, 21), 5)], drawings.BLUE_GLASS),
    ]
    case = drawings.straight(drawings.build(layers, (20, 21)), 6)
    turned = drawings.build([([drawings.reverse(path) for path in paths], color) for paths, color in layers], (20, 21))
    d_image = _image_like(case.drawing)
    image, gradients = _render(rasterizer_for, case, dtype, d_image)
    reversed_image, d_reversed = _render(rasterizer_for, drawings.straight(turned, 6), dtype, d_image)
    back = np.concatenate([drawings.reverse(d_reversed.points[:4]), drawings.reverse(d_reversed.points[4:])])
    _check((reversed_image, back), (image, gradients.points), case, dtype, d_image)


@pytest.mark.parametrize("dtype", DTYPES)
def test_first_anchor_can_be_any(rasterizer_for: RasterizerFor, dtype: type) -> None:
    path = drawings.tangle(3, (20, 21), 5)
    case = drawings.straight(drawings.build([([path], drawings.RED_GLASS)], (20, 21)), 6)
    rolled = drawings.straight(drawings.build([([np.roll(path, 2, axis=0)], drawings.RED_GLASS)], (20, 21)), 6)
    d_image = _image_like(case.drawing)
    image, gradients = _render(rasterizer_for, case, dtype, d_image)
    rolled_image, d_rolled = _render(rasterizer_for, rolled, dtype, d_image)
    turned_back = rolled_image, np.roll(d_rolled.points, -2, axis=0)
    _check(turned_back, (image, gradients.points), case, dtype, d_image)


@pytest.mark.parametrize("dtype", DTYPES)
def test_coverage_sums_to_area(rasterizer_for: RasterizerFor, dtype: type) -> None:
    # Straight sides, so that the area is known: 4 * 7.5^2 / 2 for the diamond, base times height of the parallelogram.
    cases = [
        (drawings.polygon([(10.3, 2.6), (17.8, 10.1), (10.3, 17.6), (2.8, 10.1)]), 2 * 7.5**2),
        (drawings.polygon([(3.2, 4.7), (13.7, 4.7), (16.9, 15.3), (6.4, 15.3)]), 10.5 * 10.6),
        (drawings.rectangle(1.1, 2.2, 18.7, 19.3), 17.6 * 17.1),
    ]
    for path, area in cases:
        case = drawings.straight(drawings.build([([path], shapes.WHITE)], (21, 20), (0, 0, 0)), 3)
        found = rasterizer_for((21, 20), dtype).forward(case.drawing, pieces=case.pieces)[..., 0].sum(dtype=np.float64)
        crossed = 80  # pixels on the outline, at most; the others are exactly 0 or 1
        tolerance = crossed * coverage_tolerance(case.drawing, case.pieces)[0] if dtype is np.float32 else 1e-10
        assert found == pytest.approx(area, abs=tolerance)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("at", [0, 1, 3])
def test_transparent_layer_changes_nothing(rasterizer_for: RasterizerFor, at: int, dtype: type) -> None:
    case = drawings.CASES["translucent"]()
    invisible = drawings.build([([drawings.blob(4, (10, 10), 8)], (0.9, 0.8, 0.7, 0.0))], case.drawing.size)
    order = np.insert(np.arange(3), at, 3)
    with_it = concatenate(case.drawing, invisible).layer_subset(order)
    pieces = np.concatenate([case.pieces[case.drawing.segment_layers == n] if n < 3 else np.full(4, 5) for n in order])
    d_image = _image_like(case.drawing)
    image, gradients = _render(rasterizer_for, case, dtype, d_image)
    same, d_same = _render(rasterizer_for, drawings.Case(drawing=with_it, pieces=pieces), dtype, d_image)
    np.testing.assert_array_equal(same, image)
    kept = order < 3
    others = kept[with_it.segment_layers]
    _check((same, d_same.points[others]), (image, gradients.points), case, dtype, d_image)
    assert not d_same.points[~others].any()
    scale = 4 * np.finfo(dtype).eps
    np.testing.assert_allclose(d_same.colors[kept], gradients.colors, rtol=0, atol=scale * np.sum(np.abs(d_image)))


def test_disjoint_layers_can_change_places(rasterizer_for: RasterizerFor) -> None:
    layers = [([shapes.circle((6, 6), 4)], drawings.RED_GLASS), ([shapes.circle((17, 15), 5)], drawings.BLUE_GLASS)]
    rasterizer = rasterizer_for((22, 24), np.float32)
    image = rasterizer.forward(drawings.build(layers, (22, 24))).copy()
    np.testing.assert_array_equal(rasterizer.forward(drawings.build(layers[::-1], (22, 24))), image)


def test_split_segment_changes_nothing(rasterizer_for: RasterizerFor) -> None:
    # De Casteljau at t = 1/2: one cubic of 8 pieces becomes two of 4.
    path = drawings.blob(5, (10, 10), 7, segments=3)
    (a, b, c), d = path[0], path[1, 0]
    ab, bc, cd = (a + b) / 2, (b + c) / 2, (c + d) / 2
    abc, bcd = (ab + bc) / 2, (bc + cd) / 2
    halves = np.array([[a, ab, abc], [(abc + bcd) / 2, bcd, cd]])
    split = np.concatenate([halves, path[1:]])
    rasterizer = rasterizer_for((20, 20), np.float64)
    image = rasterizer.forward(drawings.build([([path], drawings.RED)], (20, 20)), pieces=np.array([8, 5, 6])).copy()
    same = rasterizer.forward(drawings.build([([split], drawings.RED)], (20, 20)), pieces=np.array([4, 4, 5, 6]))
    np.testing.assert_allclose(same, image, atol=1e-12)


@pytest.mark.parametrize("dtype", DTYPES)
def test_same_input_same_bytes(rasterizer_for: RasterizerFor, device: Any, dtype: type) -> None:
    case = drawings.many_layers((24, 24), 40, 30, 6)
    other = drawings.many_layers((24, 24), 3, 2, 7)
    target, weight = np.random.default_rng(8).uniform(size=(24, 24, 3)), np.ones((24, 24))

    def everything(rasterizer: Rasterizer) -> bytes:
        image = rasterizer.forward(case.drawing, pieces=case.pieces)
        parts = [image.tobytes()]
        first = rasterizer.backward(_image_like(case.drawing))
        loss, second = rasterizer.loss_and_gradients(case.drawing, target, weight, pieces=case.pieces)
        for gradients in (first, second):
            assert gradients.background is not None
            parts += [gradients.points.tobytes(), gradients.colors.tobytes(), gradients.background.tobytes()]
        parts += [np.float64(loss).tobytes(), rasterizer.distance_weight(case.drawing, pieces=case.pieces).tobytes()]
        return b"".join(parts)

    rasterizer = rasterizer_for((24, 24), dtype)
    expected = everything(rasterizer)
    for _ in range(10):
        assert everything(rasterizer) == expected
    rasterizer.loss_and_gradients(other.drawing, target, weight, pieces=other.pieces)
    rasterizer.forward(case.drawing.replace(background=None), pieces=case.pieces)
    assert everything(rasterizer) == expected, "earlier renders must leave no trace"
    assert everything(Rasterizer((24, 24), device=device, dtype=dtype)) == expected, "nor may the object matter"


@pytest.mark.parametrize("dtype", DTYPES)
def test_backward_can_be_called_again(rasterizer_for: RasterizerFor, dtype: type) -> None:
    case = drawings.CASES["translucent"]()
    rasterizer = rasterizer_for(case.drawing.size, dtype)
    image = rasterizer.forward(case.drawing, pieces=case.pieces)
    before = image.copy()
    first = rasterizer.backward(_image_like(case.drawing, 1))
    kept = first.points.copy()
    doubled = rasterizer.backward(2 * _image_like(case.drawing, 1))
    rasterizer.distance_weight(case.drawing, pieces=case.pieces)
    again = rasterizer.backward(_image_like(case.drawing, 1))
    np.testing.assert_array_equal(again.points, first.points)
    np.testing.assert_array_equal(again.colors, first.colors)
    np.testing.assert_array_equal(doubled.points, 2 * first.points)
    np.testing.assert_array_equal(first.points, kept)
    rasterizer.forward(empty_drawing(case.drawing.size), pieces=np.zeros(0, dtype=int))
    np.testing.assert_array_equal(image, before)


def test_backward_is_of_the_drawing_last_rendered(rasterizer_for: RasterizerFor) -> None:
    case, other = drawings.CASES["opaque"](), drawings.straight(drawings.CASES["opaque"]().drawing.layer_subset([1]), 7)
    rasterizer = rasterizer_for(case.drawing.size, np.float64)
    d_image = _image_like(case.drawing)
    rasterizer.forward(other.drawing, pieces=other.pieces)
    expected = rasterizer.backward(d_image)
    rasterizer.forward(case.drawing, pieces=case.pieces)
    rasterizer.forward(other.drawing, pieces=other.pieces)
    np.testing.assert_array_equal(rasterizer.backward(d_image).points, expected.points)


@pytest.mark.parametrize("name", GENERIC)
def test_devices_agree(name: str) -> None:
    devices = list_devices()
    if len(devices) < 2:
        pytest.skip("only one device found")
    case = drawings.CASES[name]()
    d_image = _image_like(case.drawing)
    results = []
    for found in devices:
        rasterizer = Rasterizer(case.drawing.size, device=found.index, dtype=np.float32)
        image = rasterizer.forward(case.drawing, pieces=case.pieces).copy()
        results.append((image, rasterizer.backward(d_image).points))
    for result in results[1:]:
        _check(result, results[0], case, np.float32, d_image)


class TestErrors:
    """Wrong arguments raise ValueError, and leave the rasterizer usable."""

    SIZE = (10, 12)

    @pytest.fixture
    def drawing(self) -> Drawing:
        return drawings.build([([shapes.circle((5, 5), 3)], drawings.RED)], self.SIZE)

    @pytest.mark.parametrize("shape", [(10, 12), (10, 12, 4), (12, 10, 3), (360,), (10, 12, 3, 1)])
    def test_wrong_shape_of_d_image(
        self, rasterizer_for: RasterizerFor, drawing: Drawing, shape: tuple[int, ...]
    ) -> None:
        rasterizer = rasterizer_for(self.SIZE, np.float32)
        rasterizer.forward(drawing)
        expected = rasterizer.backward(np.ones((10, 12, 3))).points
        with pytest.raises(ValueError, match="d_image"):
            rasterizer.backward(np.ones(shape))
        np.testing.assert_array_equal(rasterizer.backward(np.ones((10, 12, 3))).points, expected)

    def test_three_channels_for_a_transparent_canvas(self, rasterizer_for: RasterizerFor, drawing: Drawing) -> None:
        rasterizer = rasterizer_for(self.SIZE, np.float32)
        rasterizer.forward(drawing.replace(background=None))
        with pytest.raises(ValueError, match="d_image"):
            rasterizer.backward(np.ones((10, 12, 3)))

    def test_drawing_of_another_size(self, rasterizer_for: RasterizerFor, drawing: Drawing) -> None:
        rasterizer = rasterizer_for(self.SIZE, np.float32)
        other = drawing.replace(size=(12, 10))
        with pytest.raises(ValueError, match="size"):
            rasterizer.forward(other)
        with pytest.raises(ValueError, match="size"):
            rasterizer.distance_weight(other)
        with pytest.raises(ValueError, match="size"):
            rasterizer.loss_and_gradients(other, np.zeros((12, 10, 3)), np.ones((12, 10)))

    def test_wrong_target_and_weight(self, rasterizer_for: RasterizerFor, drawing: Drawing) -> None:
        rasterizer = rasterizer_for(self.SIZE, np.float32)
        with pytest.raises(ValueError, match="target"):
            rasterizer.loss_and_gradients(drawing, np.zeros((10, 12, 4)), np.ones(self.SIZE))
        with pytest.raises(ValueError, match="target"):
            rasterizer.loss_and_gradients(drawing.replace(background=None), np.zeros((10, 12, 3)), np.ones(self.SIZE))
        with pytest.raises(ValueError, match="weight"):
            rasterizer.loss_and_gradients(drawing, np.zeros((10, 12, 3)), np.ones((12, 10)))

    def test_backward_before_forward(self, device: Any) -> None:
        with pytest.raises((ValueError, RuntimeError), match="forward"):
            Rasterizer(self.SIZE, device=device).backward(np.ones((10, 12, 3)))

    @pytest.mark.parametrize("size", [(0, 5), (5, -1), (2.5, 4), 7])
    def test_wrong_size(self, device: Any, size: Any) -> None:
        with pytest.raises(ValueError, match="size"):
            Rasterizer(size, device=device)

    @pytest.mark.parametrize("dtype", [np.int32, np.float16, np.complex64])
    def test_wrong_dtype(self, device: Any, dtype: type) -> None:
        with pytest.raises((ValueError, TypeError), match="dtype"):
            Rasterizer(self.SIZE, device=device, dtype=dtype)

    @pytest.mark.parametrize("tolerance", [0.0, -0.1, float("nan")])
    def test_wrong_tolerance(self, device: Any, tolerance: float) -> None:
        with pytest.raises(ValueError, match="tolerance"):
            Rasterizer(self.SIZE, device=device, tolerance=tolerance)

    def test_inputs_are_left_alone(self, rasterizer_for: RasterizerFor, drawing: Drawing) -> None:
        rasterizer = rasterizer_for(self.SIZE, np.float32)
        target, weight, d_image = np.full((10, 12, 3), 0.3), np.full(self.SIZE, 0.7), np.full((10, 12, 3), 0.1)
        rasterizer.loss_and_gradients(drawing, target, weight)
        rasterizer.forward(drawing)
        rasterizer.backward(d_image)
        assert np.all(target == 0.3) and np.all(weight == 0.7) and np.all(d_image == 0.1)
