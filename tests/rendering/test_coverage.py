# SPDX-License-Identifier: Apache-2.0
"""Coverage: the exact share of each pixel, from rendering a layer alone in opaque white over black."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from reference import images
from reference.coverage import coverage, enclosed_area, supersampled
from reference.flatten import flatten
from reference.rounding import UNIT, coverage_tolerance
from support import drawings, shapes

from livecl import Drawing
from livecl.geometry import bezier
from livecl.rendering.rasterizer import Rasterizer


def _coverages(rasterizer: Rasterizer, case: drawings.Case) -> np.ndarray:
    """Coverage of each layer: (N, H, W)."""
    layers = []
    for layer in range(case.drawing.num_layers):
        image = rasterizer.forward(shapes.alone(case.drawing, layer), pieces=shapes.pieces_of_layer(case, layer))
        np.testing.assert_array_equal(image[..., 0], image[..., 1])
        np.testing.assert_array_equal(image[..., 0], image[..., 2])
        layers.append(image[..., 0].copy())
    return np.array(layers)


def _of_path(rasterizer: Rasterizer, path: np.ndarray, size: tuple[int, int], pieces: int = 1) -> np.ndarray:
    drawing = drawings.build([([path], shapes.WHITE)], size, (0, 0, 0))
    return rasterizer.forward(drawing, pieces=np.full(len(path), pieces))[..., 0]


@pytest.mark.parametrize("name", drawings.ALL_CASES)
def test_double_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.ALL_CASES[name]()
    found = _coverages(rasterizer_for(case.drawing.size, np.float64), case)
    np.testing.assert_allclose(found, images.layer_coverages(case.drawing, case.pieces), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", drawings.ALL_CASES)
def test_float_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = drawings.ALL_CASES[name]()
    found = _coverages(rasterizer_for(case.drawing.size, np.float32), case)
    error = np.max(np.abs(found - images.layer_coverages(case.drawing, case.pieces)), axis=(1, 2))
    assert found.dtype == np.float32
    assert np.all(error <= coverage_tolerance(case.drawing, case.pieces))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", drawings.ALL_CASES)
def test_inside_is_exactly_one_and_outside_exactly_zero(rasterizer_for: RasterizerFor, name: str, dtype: type) -> None:
    # No residue of sums, so that "empty" and "opaque" can be told by comparison; up to rounding of the vertices, which
    # may put a line that lies on a pixel border into the pixel beside it.
    case = drawings.ALL_CASES[name]()
    found = _coverages(rasterizer_for(case.drawing.size, dtype), case)
    assert np.all((found >= 0) & (found <= 1))
    for layer, outlines in enumerate(flatten(case.drawing, case.pieces)):
        untouched = _untouched(outlines, case.drawing.size)
        share = coverage(outlines, case.drawing.size)
        np.testing.assert_array_equal(found[layer][untouched], np.round(share[untouched]))


@pytest.mark.parametrize("max_tiles", [1, 40, 1 << 17])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", drawings.ALL_CASES)
def test_all_layers_at_once(rasterizer_for: RasterizerFor, device: int, name: str, dtype: type, max_tiles: int) -> None:
    case = drawings.ALL_CASES[name]()
    one_by_one = _coverages(rasterizer_for(case.drawing.size, dtype), case)
    together = Rasterizer(case.drawing.size, device, dtype, max_tiles=max_tiles)
    np.testing.assert_array_equal(together.coverages(case.drawing, case.pieces), one_by_one)


def _untouched(outlines: list[np.ndarray], size: tuple[int, int]) -> np.ndarray:
    """Pixels that no line's bounding box touches: (H, W) bool."""
    column, row = np.arange(size[1]), np.arange(size[0])[:, None]
    touched = np.zeros(size, dtype=bool)
    for vertices in outlines:
        low = np.minimum(vertices, np.roll(vertices, -1, axis=0)) - 1e-3
        high = np.maximum(vertices, np.roll(vertices, -1, axis=0)) + 1e-3
        for (x_0, y_0), (x_1, y_1) in zip(low, high, strict=True):
            touched |= (column < x_1) & (column + 1 > x_0) & (row < y_1) & (row + 1 > y_0)
    return ~touched


def test_rectangle_by_hand(rasterizer_for: RasterizerFor) -> None:
    found = _of_path(rasterizer_for((5, 6), np.float64), drawings.rectangle(1.25, 0.5, 4.5, 3.75), (5, 6), 3)
    np.testing.assert_allclose(found, np.outer([0.5, 1, 1, 0.75, 0], [0, 0.75, 1, 1, 0.5, 0]), atol=1e-14)


def test_integer_rectangle_is_exact_in_single_precision(rasterizer_for: RasterizerFor) -> None:
    found = _of_path(rasterizer_for((12, 13), np.float32), drawings.rectangle(3, 2, 11, 9), (12, 13))
    expected = np.zeros((12, 13))
    expected[2:9, 3:11] = 1
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("segments", [2, 3, 4, 8])
def test_circle_of_cubics(rasterizer_for: RasterizerFor, segments: int) -> None:
    path = shapes.circle((10.3, 9.6), 8.1, segments)
    pieces = 64
    found = _of_path(rasterizer_for((20, 21), np.float64), path, (20, 21), pieces)
    drawing = drawings.build([([path], shapes.WHITE)], (20, 21))
    polyline = flatten(drawing, np.full(segments, pieces))[0]
    assert found.sum() == pytest.approx(enclosed_area(polyline), rel=1e-12)
    # The polyline's area against the cubics': a chord of length l on radius r cuts off l^3 / (12 r).
    cut_off = segments * pieces * (2 * np.pi * 8.1 / (segments * pieces)) ** 3 / (12 * 8.1)
    assert bezier.signed_area(drawing.cubics) - found.sum() == pytest.approx(cut_off, rel=0.2)
    # Four cubics lie within 2.8e-4 of the radius outside the circle, two within 1.9e-2, three within 1.8e-3.
    excess = {2: 1.9e-2, 3: 1.8e-3, 4: 2.8e-4, 8: 5e-6}[segments]
    assert -cut_off <= found.sum() - np.pi * 8.1**2 <= 2 * excess * np.pi * 8.1**2


def test_area_of_shapes_within_the_canvas(rasterizer_for: RasterizerFor) -> None:
    rasterizer = rasterizer_for((40, 40), np.float64)
    for seed in range(20):
        path = drawings.blob(seed, (20 + seed / 17, 19 - seed / 13), 12, segments=1 + seed % 5)
        outlines = flatten(drawings.build([([path], shapes.WHITE)], (40, 40)), np.full(len(path), 9))[0]
        if np.all(np.abs(supersampled(outlines, (40, 40)) - coverage(outlines, (40, 40))) < 0.1):  # not self-crossing
            assert _of_path(rasterizer, path, (40, 40), 9).sum() == pytest.approx(
                abs(enclosed_area(outlines)), rel=1e-11
            )


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.5, 1.0, 1.5])
def test_turned_square_keeps_its_area(rasterizer_for: RasterizerFor, angle: float) -> None:
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    corners = np.array([(-6, -6), (6, -6), (6, 6), (-6, 6)]) @ turn + (13, 12)
    assert _of_path(rasterizer_for((24, 26), np.float64), drawings.polygon(corners), (24, 26)).sum() == pytest.approx(
        144
    )


def test_what_lies_left_of_the_canvas_does_not_leak_in(rasterizer_for: RasterizerFor) -> None:
    for dtype in (np.float32, np.float64):
        rasterizer = rasterizer_for((16, 17), dtype)
        assert not _of_path(rasterizer, drawings.blob(5, (-20, 8), 6), (16, 17), 7).any()
        assert np.all(_of_path(rasterizer, drawings.blob(6, (8, 8), 60), (16, 17), 7) == 1)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("start", [(0, 2), (2, 0), (0, 0)])
@pytest.mark.parametrize("step", [(1, 0), (0, 1), (1, 1), (-1, 1)])
def test_lines_that_go_less_far_than_can_be_divided_by(
    rasterizer_for: RasterizerFor, dtype: type, start: tuple[int, int], step: tuple[int, int]
) -> None:
    """Across a pixel's border: 0 times infinity is no number, and the walk along such a line had no end."""
    tiny = float(np.finfo(dtype).smallest_normal) / 8 * np.array(step)  # 1 / tiny is infinite
    other = np.array(start) * 3.0
    drawing = drawings.build([([drawings.polygon([start + tiny, other - tiny, (6, 4)])], shapes.WHITE)], (8, 8))
    near = drawings.build([([drawings.polygon([start, other, (6, 4)])], shapes.WHITE)], (8, 8))
    rasterizer = rasterizer_for((8, 8), dtype)
    wanted = rasterizer.forward(near)
    np.testing.assert_array_equal(rasterizer.forward(drawing), wanted)  # the difference is below the numbers' rounding
    assert np.isfinite(rasterizer.backward(np.ones(wanted.shape)).points).all()


def test_far_coordinates(rasterizer_for: RasterizerFor) -> None:
    triangle = drawings.polygon([(-9000.3, -4000.1), (8000.7, 6000.2), (-7000.9, 9000.4)])
    found = _of_path(rasterizer_for((30, 31), np.float64), triangle, (30, 31))
    np.testing.assert_allclose(found, coverage([triangle[:, 0]], (30, 31)), atol=1e-9)
    drawing = drawings.build([([triangle], shapes.WHITE)], (30, 31))
    error = _of_path(rasterizer_for((30, 31), np.float32), triangle, (30, 31)) - coverage([triangle[:, 0]], (30, 31))
    assert np.max(np.abs(error)) <= coverage_tolerance(drawing, np.ones(3, dtype=int))[0]


def _crossing(first: float, second: float) -> np.ndarray:
    """Two long lines through the middle of pixel (10, 10), joined so that the windings there are 0, 1, 2, 1."""
    middle, reach = np.array((10.5, 10.5)), 9.0
    ends = [
        middle + reach * np.array((np.cos(angle), np.sin(angle)))
        for angle in (first, first + np.pi, second, second + np.pi)
    ]
    return drawings.polygon(
        [ends[1], ends[0], *_around(middle, ends[0], ends[3]), ends[3], ends[2], *_around(middle, ends[2], ends[1])]
    )


def _around(middle: np.ndarray, start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    """Vertices of the way from start to end clockwise on the screen, around the middle."""
    begin = np.arctan2(*(start - middle)[::-1])
    sweep = (np.arctan2(*(end - middle)[::-1]) - begin) % (2 * np.pi)
    return [
        middle + 9.0 * np.array((np.cos(begin + s * sweep), np.sin(begin + s * sweep)))
        for s in np.linspace(0, 1, 9)[1:-1]
    ]


def _error_in_the_middle(rasterizer: Rasterizer, drawing: Drawing) -> float:
    """How far the coverage of pixel (10, 10) lies from that of the nonzero rule, by 40 x 40 samples."""
    pieces = np.ones(drawing.num_segments, dtype=int)
    found = rasterizer.forward(drawing, pieces=pieces)[..., 0]
    return float(found[10, 10] - supersampled(flatten(drawing, pieces)[0], drawing.size, 40)[10, 10])


def test_self_crossing_errs_by_at_most_a_quarter(rasterizer_for: RasterizerFor) -> None:
    # Documented: min(|A|, 1) counts where the winding number is 2 twice. Where two edges cross at a right angle in the
    # middle of a pixel the windings 0, 1, 2, 1 have a quarter each: A = 1, but 3/4 is inside.
    rasterizer = rasterizer_for((21, 21), np.float64)
    errors = []
    for angle in np.linspace(0.01, np.pi / 2, 9):
        drawing = drawings.build([([_crossing(angle, angle + np.pi / 2)], shapes.WHITE)], (21, 21), (0, 0, 0))
        errors.append(_error_in_the_middle(rasterizer, drawing))
    assert np.max(errors) == pytest.approx(0.25, abs=0.02)
    assert np.min(errors) > -0.02


def test_doubled_outline_errs_by_at_most_half(rasterizer_for: RasterizerFor) -> None:
    # Documented: where two edges run together the windings are 2 and 0: a pixel half inside has A = 1.
    rasterizer = rasterizer_for((21, 21), np.float64)
    errors = []
    for share in np.linspace(0, 1, 11):
        square = drawings.rectangle(2, 2, 10 + share, 18)
        drawing = drawings.build([([square, square], shapes.WHITE)], (21, 21), (0, 0, 0))
        errors.append(_error_in_the_middle(rasterizer, drawing))
    np.testing.assert_allclose(errors, np.minimum(np.linspace(0, 1, 11), 1 - np.linspace(0, 1, 11)), atol=0.02)
    assert np.max(errors) <= 0.5


def test_opposite_windings_cancel(rasterizer_for: RasterizerFor) -> None:
    # Documented: where one pixel has windings of 1 and -1 they cancel in A, so a figure of eight loses twice what the
    # other crossings gain: half of the pixel at a right angle, all of it along a common edge in the pixel's middle.
    rasterizer = rasterizer_for((21, 21), np.float64)
    eight = drawings.polygon([(3.5, 3.5), (17.5, 17.5), (17.5, 3.5), (3.5, 17.5)])
    drawing = drawings.build([([eight], shapes.WHITE)], (21, 21), (0, 0, 0))
    assert _error_in_the_middle(rasterizer, drawing) == pytest.approx(-0.5, abs=0.03)
    neighbours = [drawings.rectangle(2, 2, 10.5, 18), drawings.reverse(drawings.rectangle(10.5, 2, 19, 18))]
    drawing = drawings.build([(neighbours, shapes.WHITE)], (21, 21), (0, 0, 0))
    assert _error_in_the_middle(rasterizer, drawing) == pytest.approx(-1, abs=1e-12)


def test_clean_layers_agree_with_supersampling(rasterizer_for: RasterizerFor) -> None:
    # 10 x 10 samples of an edge err by 0.1^2 / 12 in mean square in the pixels that it crosses, see test_reference.py.
    path = drawings.blob(7, (15, 14), 10)
    drawing = drawings.build([([path], shapes.WHITE)], (29, 30), (0, 0, 0))
    pieces = np.full(4, 12)
    found = rasterizer_for((29, 30), np.float32).forward(drawing, pieces=pieces)[..., 0]
    error = found - supersampled(flatten(drawing, pieces)[0], (29, 30))
    crossed = np.count_nonzero((found > 0) & (found < 1))
    assert crossed > 40
    assert np.sum(error**2) < crossed * 0.1**2 / 12
    assert np.max(np.abs(error)) < 0.05 + UNIT
