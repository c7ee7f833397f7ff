# SPDX-License-Identifier: Apache-2.0
"""Measures of pictures and layers, on drawings whose answers are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import ArrayLike
from support import drawings
from support.drawings import polygon, rectangle

from livecl.drawing.drawing import Drawing, empty_drawing
from livecl.geometry.bezier import bernstein
from livecl.geometry.crossings import crossing_area
from livecl.layering import metrics
from livecl.layering.metrics import self_crossing
from livecl.rendering.rasterizer import render

SIZE = (12, 16)
EPS = float(np.finfo(np.float32).eps)
RED, BLUE, WHITE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0)


def drawn(*layers: tuple[drawings.Path, ArrayLike], background: ArrayLike | None = (1.0, 1.0, 1.0)) -> Drawing:
    return drawings.build([([path], color) for path, color in layers], SIZE, background)


def opacity(color: tuple[float, ...], alpha: float) -> tuple[float, ...]:
    return (*color[:3], alpha)


def cubics(path: drawings.Path) -> np.ndarray:
    return drawn((path, RED)).cubics


def test_picture_measures() -> None:
    target = np.random.default_rng(0).uniform(0.2, 0.8, (20, 30, 3))
    assert metrics.mse(target + 0.1, target) == pytest.approx(0.01)
    assert metrics.psnr(target + 0.1, target) == pytest.approx(20)
    assert (metrics.mse(target, target), metrics.psnr(target, target)) == (0, math.inf)
    assert metrics.ssim(target, target) == pytest.approx(1)
    assert metrics.ssim(1 - target, target) < 0


@pytest.mark.parametrize("side", [3, 4, 6, 7, 8])
def test_ssim_of_small_pictures(side: int) -> None:
    target = np.random.default_rng(0).uniform(size=(side, 9, 3))
    assert metrics.ssim(target, target) == pytest.approx(1)


def test_picture_measures_refuse_other_shapes() -> None:
    with pytest.raises(ValueError, match="image: shape"):
        metrics.mse(np.zeros((4, 4, 3)), np.zeros((4, 4, 4)))
    with pytest.raises(ValueError, match="at least 3 px"):
        metrics.ssim(np.zeros((2, 9, 3)), np.zeros((2, 9, 3)))


def test_num_parameters() -> None:
    assert metrics.num_parameters(drawn((rectangle(1, 1, 5, 5), RED), (rectangle(1, 1, 5, 5), RED))) == 2 * (4 * 6 + 4)


def test_shares_of_stacked_glass() -> None:
    drawing = drawn((rectangle(0, 0, 8, 12), opacity(RED, 0.5)), (rectangle(4, 0, 16, 12), opacity(BLUE, 0.75)))
    shares = metrics.visible_shares(metrics.layer_alphas(drawing))
    assert shares[:, 0, 2] == pytest.approx([0.5, 0])
    assert shares[:, 0, 6] == pytest.approx([0.5 * 0.25, 0.75])
    assert shares[:, 0, 12] == pytest.approx([0, 0.75])


def test_shares_make_up_the_picture() -> None:
    drawing = drawings.CASES["translucent"]().drawing
    shares = metrics.visible_shares(metrics.layer_alphas(drawing))
    rest = 1 - shares.sum(axis=0)
    image = np.einsum("nhw,nc->hwc", shares, drawing.colors[:, :3]) + rest[..., None] * drawing.background
    # Sums of at most 10 terms of size 1 in single precision, made in two orders.
    assert image == pytest.approx(render(drawing), abs=20 * EPS)


def test_flat_regions() -> None:
    target = np.zeros((4, 9, 3))
    target[:, 3:, 0] = 1.0  # a second region
    target[:, 5:, 0] -= np.linspace(0, 0.15, 4)  # a slow gradient goes on in it
    target[0, 0] = 0.05  # just about the same
    target[3, 0, 2] = 0.06  # one channel differs
    regions = metrics.flat_regions(target)
    assert len(np.unique(regions)) == 3
    assert len(np.unique(regions[:, 3:])) == 1
    assert regions[0, 0] == regions[0, 2] != regions[3, 0]


def test_flat_regions_are_not_joined_across_corners() -> None:
    assert len(np.unique(metrics.flat_regions(np.eye(2)[..., None] * np.ones(3)))) == 4


def test_one_pixel_is_one_region() -> None:
    assert metrics.flat_regions(np.zeros((1, 1, 3))).tolist() == [[0]]


def test_region_shares() -> None:
    target = np.ones((*SIZE, 3))
    target[:, :8] = 0
    drawing = drawn(
        (rectangle(0, 0, 8, 12), RED),  # below the next: its rows 2 to 11
        (rectangle(0, 0, 10, 2), RED),  # 8 of 10 columns
        (rectangle(12, 4, 16, 8), opacity(RED, 0.5)),  # visible nowhere: one half is not more than it
    )
    shares = metrics.visible_shares(metrics.layer_alphas(drawing))
    assert metrics.region_shares(shares, metrics.flat_regions(target)) == pytest.approx([1, 0.8, 0])


def test_removal_changes_are_those_of_the_rendered_pictures() -> None:
    drawing = drawings.CASES["tangles"]().drawing
    target = np.random.default_rng(0).uniform(size=(*drawing.size, 3))
    found = metrics.removal_changes(drawing, metrics.layer_alphas(drawing), target)
    layers = np.arange(drawing.num_layers)
    error = metrics.mse(render(drawing), target)
    without = [metrics.mse(render(drawing.layer_subset(layers != layer)), target) for layer in layers]
    # Means of squares of float32 colours, each off by a few eps.
    assert found == pytest.approx(np.array(without) - error, abs=20 * EPS)
    assert len(found) > 1


def test_removal_changes_of_hidden_and_outside_layers_are_zero() -> None:
    drawing = drawn(
        (rectangle(4, 4, 8, 8), BLUE),
        (rectangle(2, 2, 10, 10), RED),
        (rectangle(-9, -9, -2, -2), RED),
        (rectangle(20, 2, 30, 9), RED),
    )
    changes = metrics.removal_changes(drawing, metrics.layer_alphas(drawing), render(drawing))
    assert changes[[0, 2, 3]] == pytest.approx(0, abs=1e-12)
    assert changes[1] > 0.1


def test_mergeable_pairs() -> None:
    drawing = drawn(
        (rectangle(0, 0, 4, 4), RED),
        (rectangle(4, 0, 8, 4), (0.96, 0.04, 0.0, 1.0)),  # beside layer 0, nearly its colour
        (rectangle(8.5, 0, 12.5, 4), RED),  # a mixed pixel away from layer 1
        (rectangle(0, 8, 4, 12), RED),  # far off
        (rectangle(4, 8, 8, 12), opacity(RED, 0.9)),  # beside layer 3, but less opaque
        (rectangle(8, 8, 12, 12), BLUE),  # another colour
    )
    pairs = metrics.mergeable_pairs(drawing, metrics.visible_shares(metrics.layer_alphas(drawing)))
    assert pairs.tolist() == [[0, 1], [1, 2]]
    assert metrics.num_mergeable(drawing.num_layers, pairs) == 2


def test_nearly_opaque() -> None:
    drawing = drawn(*((rectangle(0, 0, 4, 4), opacity(RED, alpha)) for alpha in (1, 254 / 255, 0.91, 0.9, 0.4, 0)))
    assert metrics.nearly_opaque(drawing).tolist() == [False, True, True, False, False, False]


def test_measure_layers() -> None:
    drawing = drawn(
        (rectangle(1, 1, 7, 11), RED),
        (rectangle(9, 1, 15, 11), RED),
        (rectangle(9, 1, 15, 6), opacity(RED, 0.95)),  # hardly changes anything, could be part of the one below
        (polygon(np.array(BOW_TIE) / 2 + 2), BLUE),  # two regions, within the first layer
    )
    measures = metrics.measure_layers(drawing, render(drawing))
    assert measures == metrics.LayerMeasures(
        layers=4, in_one_region=3, self_crossing=1, needless=1, mergeable=1, nearly_opaque=1
    )


def test_measure_layers_without_layers_or_background() -> None:
    nothing = metrics.LayerMeasures(
        layers=0, in_one_region=0, self_crossing=0, needless=0, mergeable=0, nearly_opaque=0
    )
    assert metrics.measure_layers(empty_drawing(SIZE), np.zeros((*SIZE, 3))) == nothing
    white = drawn((rectangle(2, 2, 9, 9), WHITE), background=None)
    assert metrics.measure_layers(white, np.ones((*SIZE, 3))).needless == 1
    assert metrics.measure_layers(white, render(white)).needless == 0
    with pytest.raises(ValueError, match="target: shape"):
        metrics.measure_layers(white.replace(background=(0, 0, 0)), np.ones((*SIZE, 4)))


SIMPLE = {
    "circle": drawings.circle((8, 6), 5),
    "circle, the other way": drawings.reverse(drawings.circle((8, 6), 5)),
    "square": rectangle(1, 1, 5, 5),
    "notch whose tip touches the other side": polygon([(0, 0), (8, 0), (8, 8), (5, 8), (4, 0), (3, 8), (0, 8)]),
    "there and back on one line": polygon([(1, 1), (9, 5)]),
    "spike of no width": polygon([(0, 0), (8, 0), (8, 4), (12, 4), (8, 4), (8, 8), (0, 8)]),
    "cusp": np.array([[(2, 2), (10, 10), (2, 10)], [(10, 2), (8, 0), (4, 0)]], dtype=float),
    "lobes that touch at their corners": polygon([(0, 0), (4, 4), (8, 0), (8, 8), (4, 4), (0, 8)]),
    "one point": np.full((4, 3, 2), 3.0),
}


@pytest.mark.parametrize("name", SIMPLE)
def test_outlines_that_do_not_cross(name: str) -> None:
    # Nothing but rounding of areas below 100 px^2.
    assert crossing_area(cubics(SIMPLE[name])) <= 1e-12


BOW_TIE = [(0, 0), (8, 8), (8, 0), (0, 8)]
#: Outlines and the area of their other winding, px^2.
CROSSING = {
    "bow tie": (BOW_TIE, 16),
    "bow tie with corners in the crossing": ([(0, 0), (4, 4), (8, 8), (8, 0), (4, 4), (0, 8)], 16),
    "loop inside, winding 2": ([(0, 0), (9, 0), (9, 6), (4, 6), (4, 3), (6, 3), (6, 9), (0, 9)], 2 * 3),
    "loop outside, winding of the other sign": ([(0, 4), (9, 4), (9, 0), (6, 0), (6, 12), (0, 12)], 3 * 4),
    "strands that overlap for a while": ([(0, 0), (4, 4), (8, 4), (12, 8), (12, 0), (8, 4), (4, 4), (0, 8)], 16),
}


@pytest.mark.parametrize("name", CROSSING)
def test_area_of_other_winding(name: str) -> None:
    corners, area = CROSSING[name]
    assert crossing_area(cubics(polygon(corners))) == pytest.approx(area, rel=1e-9)
    assert crossing_area(cubics(polygon(corners[::-1]))) == pytest.approx(area, rel=1e-9)


def test_blocks_make_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    tangle = cubics(polygon(np.random.default_rng(0).uniform(0, 12, (40, 2))))
    whole = crossing_area(tangle)
    monkeypatch.setattr("livecl.geometry.crossings._BLOCK", 100)
    assert crossing_area(tangle) == pytest.approx(whole, rel=1e-9)
    assert whole > 1


def test_loop_of_a_single_cubic() -> None:
    cubic = np.array([(0.0, 0.0), (9.0, 6.0), (-3.0, 6.0), (6.0, 0.0)])
    closed = np.stack([cubic, np.linspace(cubic[3], cubic[0], 4)])
    # x(t) = x(1 - t) at the crossing, by symmetry x = 3 there: 27 t (1 - t)^2 - 9 t^2 (1 - t) + 6 t^3 = 3.
    times = np.roots([27 + 9 + 6, -54 - 9, 27, -3])
    first = float(np.sort(times[np.abs(times.imag) < 1e-9].real)[0])
    points = bernstein(np.linspace(first, 1 - first, 20001)) @ cubic
    following = np.roll(points, -1, axis=0)
    area = abs(np.sum(points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0])) / 2
    assert area > 0.1
    # The flattening of 0.01 px along the loop's outline, some 4 px long.
    assert crossing_area(closed) == pytest.approx(area, abs=0.04)
    assert crossing_area(closed, tolerance=1e-5) == pytest.approx(area, abs=4e-5)


def test_self_crossing_names_layers() -> None:
    tie = polygon(BOW_TIE)
    drawing = drawings.build(
        [
            ([rectangle(0, 0, 4, 4)], RED),
            ([rectangle(0, 0, 9, 9), tie], RED),
            ([rectangle(0, 0, 9, 9), rectangle(6, 6, 12, 12)], RED),  # subpaths may cross each other
            ([tie], RED),
        ],
        SIZE,
    )
    assert self_crossing(drawing).tolist() == [False, True, False, True]
    assert self_crossing(empty_drawing(SIZE)).tolist() == []
