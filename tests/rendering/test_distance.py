# SPDX-License-Identifier: Apache-2.0
"""Distance weight, eq. (1), against the reference."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from reference.distance import distance_weight
from reference.rounding import UNIT
from support import drawings, shapes


@pytest.mark.parametrize("tau", [10.0, 1.7])
@pytest.mark.parametrize("name", drawings.ALL_CASES)
def test_double_against_reference(rasterizer_for: RasterizerFor, name: str, tau: float) -> None:
    case = drawings.ALL_CASES[name]()
    found = rasterizer_for(case.drawing.size, np.float64).distance_weight(case.drawing, tau=tau, pieces=case.pieces)
    assert found.shape == case.drawing.size and found.dtype == np.float64
    np.testing.assert_allclose(found, distance_weight(case.drawing, tau, case.pieces), rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", drawings.ALL_CASES)
def test_float_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    # Vertex, foot and difference take some 16 roundings of the coordinates' size s, so a distance is off by e = 16 s
    # units, and if its square is computed otherwise than as a sum of squares, by up to sqrt(16 units) s where it is
    # nearly 0. A layer's weight is (tau - d) / sum; the sum is off by no more than e a pixel, and by a unit for each of
    # its P additions.
    case = drawings.ALL_CASES[name]()
    found = rasterizer_for(case.drawing.size, np.float32).distance_weight(case.drawing, tau=10.0, pieces=case.pieces)
    expected = distance_weight(case.drawing, 10.0, case.pieces)
    scale = max(*case.drawing.size, float(np.max(np.abs(case.drawing.points))))
    num_pixels = expected.size
    error = np.sqrt(16 * UNIT) * scale / 10
    relative = 16 * UNIT * scale + UNIT * num_pixels
    assert found.dtype == np.float32
    assert np.max(np.abs(found - expected)) <= np.max(expected) * (error + relative)
    assert found.sum(dtype=np.float64) == pytest.approx(1, rel=UNIT * num_pixels + 1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_sums_to_one(rasterizer_for: RasterizerFor, dtype: type) -> None:
    for name in ("translucent", "1x1", "13x7", "33x50"):
        case = drawings.CASES[name]()
        weight = rasterizer_for(case.drawing.size, dtype).distance_weight(case.drawing, pieces=case.pieces)
        assert np.all(weight >= 0)
        assert weight.sum(dtype=np.float64) == pytest.approx(1, rel=1e-5 if dtype is np.float32 else 1e-12)


def test_is_the_distance_to_a_line(rasterizer_for: RasterizerFor) -> None:
    flat = drawings.polygon([(-50, 6.5), (80, 6.5)])
    drawing = drawings.build([([flat], drawings.RED)], (13, 9))
    weight = rasterizer_for((13, 9), np.float64).distance_weight(drawing, tau=4.0, pieces=np.full(2, 3))
    rows = np.maximum(4 - np.abs(np.arange(13) - 6), 0)
    np.testing.assert_allclose(weight, np.repeat(rows[:, None], 9, axis=1) / (9 * 16), atol=1e-14)


def test_layer_far_outside_is_ignored(rasterizer_for: RasterizerFor) -> None:
    near, far = ([shapes.circle((9, 8), 4)], drawings.RED), ([shapes.circle((150, -90), 5)], drawings.BLUE)
    rasterizer = rasterizer_for((17, 18), np.float64)
    alone = rasterizer.distance_weight(drawings.build([near], (17, 18)), pieces=np.full(4, 8)).copy()
    for layers in ([near, far], [far, near], [far, near, far]):
        weight = rasterizer.distance_weight(drawings.build(layers, (17, 18)), pieces=np.full(4 * len(layers), 8))
        np.testing.assert_allclose(weight, alone, rtol=1e-14)
    assert not rasterizer.distance_weight(drawings.build([far], (17, 18)), pieces=np.full(4, 8)).any()


def test_outline_just_outside_counts(rasterizer_for: RasterizerFor) -> None:
    outside = drawings.polygon([(-3.5, -40), (-3.5, 60), (-20, 10)])
    weight = rasterizer_for((8, 12), np.float64).distance_weight(
        drawings.build([([outside], drawings.RED)], (8, 12)), tau=10.0, pieces=np.ones(3, dtype=int)
    )
    columns = np.maximum(10 - (np.arange(12) + 4), 0)
    np.testing.assert_allclose(weight, np.tile(columns / columns.sum() / 8, (8, 1)), atol=1e-14)


def test_layer_is_counted_once_whatever_its_subpaths(rasterizer_for: RasterizerFor) -> None:
    ring = [shapes.circle((14, 15), 9), drawings.reverse(shapes.circle((14, 15), 5))]
    drawing = drawings.build([(ring, drawings.RED), ([shapes.circle((20, 10), 3)], drawings.BLUE)], (28, 30))
    pieces = np.full(12, 7)
    found = rasterizer_for((28, 30), np.float64).distance_weight(drawing, tau=3.0, pieces=pieces)
    np.testing.assert_allclose(found, distance_weight(drawing, 3.0, pieces), atol=1e-12)


def test_many_layers(rasterizer_for: RasterizerFor) -> None:
    case = drawings.many_layers((24, 24), 80, 70, 5)
    found = rasterizer_for((24, 24), np.float64).distance_weight(case.drawing, tau=10.0, pieces=case.pieces)
    np.testing.assert_allclose(found, distance_weight(case.drawing, 10.0, case.pieces), atol=1e-12)


def test_pieces_are_chosen_as_in_forward(rasterizer_for: RasterizerFor) -> None:
    from livecl.geometry.bezier import pieces_for

    drawing = drawings.CASES["translucent"]().drawing
    rasterizer = rasterizer_for(drawing.size, np.float64)
    chosen = rasterizer.distance_weight(drawing).copy()
    np.testing.assert_array_equal(
        chosen, rasterizer.distance_weight(drawing, tau=10.0, pieces=pieces_for(drawing.cubics, 0.02))
    )


def test_another_tau_for_the_same_drawing(rasterizer_for: RasterizerFor) -> None:
    drawing, pieces = drawings.build([([shapes.circle((30, 30), 4)], (0, 0, 0, 1))], (60, 60)), np.full(4, 5)
    rasterizer = rasterizer_for((60, 60), np.float64)
    for tau in (3.0, 25.0):
        found = rasterizer.distance_weight(drawing, tau, pieces)
        np.testing.assert_allclose(found, distance_weight(drawing, tau, pieces), atol=1e-12)


@pytest.mark.parametrize("tau", [0.0, -1.0, float("nan"), float("inf")])
def test_wrong_tau(rasterizer_for: RasterizerFor, tau: float) -> None:
    drawing = drawings.CASES["translucent"]().drawing
    with pytest.raises(ValueError, match="tau"):
        rasterizer_for(drawing.size, np.float32).distance_weight(drawing, tau=tau)
