# SPDX-License-Identifier: Apache-2.0
"""Neighbours of one colour become one layer where that costs next to nothing; and only those that may."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import RasterizerFor
from numpy.typing import NDArray
from support import shapes
from support.shapes import circle, rectangle

from livecl import Drawing, Options
from livecl.drawing.assembly import concatenate
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.image.errors import visible_mse
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas
from livecl.layering.revision import merging
from livecl.layering.revision.merging import Merged, _best, merge_neighbors
from livecl.rendering.rasterizer import Rasterizer

SIZE = (32, 40)
#: Rise of the error that a merge may cost: rounded corners of a bar of four segments, for which there are eight before.
TOLERANCE = 1e-3
RED, BLUE = (0.9, 0.1, 0.2, 1.0), (0.2, 0.3, 0.9, 1.0)


def _halves(color: tuple[float, ...] = RED) -> Drawing:
    """Return a disc, two halves of a bar across it, and a spot on one half."""
    layers = [
        ([circle((20, 16), 12)], BLUE),
        ([rectangle(2, 10, 20, 22)], RED),
        ([rectangle(20, 10, 38, 22)], color),
        ([circle((30, 16), 3)], BLUE),
    ]
    return shapes.build(layers, SIZE)


@pytest.fixture
def rasterizer(rasterizer_for: RasterizerFor) -> Rasterizer:
    return rasterizer_for(SIZE, np.float32)


def _merged(drawing: Drawing, rasterizer: Rasterizer, tolerance: float = TOLERANCE, **changes: Any) -> Merged:
    target = changes.pop("target", None)
    free = changes.pop("free", np.ones(drawing.num_layers, bool))
    target = rasterizer.forward(drawing) if target is None else target
    return merge_neighbors(Context(rasterizer, target, Options(**changes)), drawing, free, tolerance)


def test_two_halves_become_one(rasterizer: Rasterizer) -> None:
    drawing = _halves()
    target = rasterizer.forward(drawing)
    merged = _merged(drawing, rasterizer)
    assert merged.sources.tolist() == [0, -1, 3]
    assert merged.drawing.num_layers == 3
    np.testing.assert_array_equal(merged.drawing.colors[1], RED)
    assert visible_mse(rasterizer.forward(merged.drawing), target) < TOLERANCE


@pytest.mark.parametrize("held", [1, 2])
def test_layers_that_are_held_stay(held: int, rasterizer: Rasterizer) -> None:
    merged = _merged(_halves(), rasterizer, free=np.arange(4) != held)
    assert merged.sources.tolist() == [0, 1, 2, 3]


def test_other_colors_stay(rasterizer: Rasterizer) -> None:
    assert _merged(_halves((0.9, 0.3, 0.2, 1.0)), rasterizer).sources.tolist() == [0, 1, 2, 3]


def test_what_would_cost_too_much_stays(rasterizer: Rasterizer) -> None:
    drawing = _halves((0.94, 0.14, 0.24, 1.0))
    wrong = (18 * 12 - 9 * np.pi) * 0.04**2 / (SIZE[0] * SIZE[1])  # one half in the other's colour, but for the spot
    assert _merged(drawing, rasterizer, 0.9 * wrong).sources.tolist() == [0, 1, 2, 3]
    assert _merged(drawing, rasterizer, TOLERANCE + wrong).drawing.num_layers == 3


@pytest.mark.parametrize("gradients", [False, True])
@pytest.mark.parametrize("background", [(0.4, 0.8, 0.6), None])
@pytest.mark.parametrize("pair", [(0, 1), (0, 4), (2, 4), (1, 3)])
def test_the_rise_of_the_error_is_that_of_rendered_pictures(
    pair: tuple[int, int], background: tuple[float, float, float] | None, gradients: bool, rasterizer: Rasterizer
) -> None:
    rng = np.random.default_rng(sum(pair))
    layers = [
        ([circle(rng.uniform((8, 8), (32, 24)), rng.uniform(5, 12))], (*rng.uniform(size=3), rng.uniform(0.3, 1)))
        for _ in range(5)
    ]
    drawing = shapes.build(layers, SIZE, background)
    if gradients:
        stops = rng.uniform((0, 0, 0, 0.6), 1, (5, 2, 4))
        fills = [Fills.linear(*rng.uniform((0, 0), (40, 32), (2, 2)), colors) for colors in stops]
        drawing = drawing.replace(fills=concatenate_fills(fills))
    channels = 3 if background else 4
    target: NDArray[Any] = rng.uniform(0.2, 0.8, size=(*SIZE, channels)).astype(np.float32)
    best = _best(Context(rasterizer, target, Options()), drawing, layer_alphas(drawing, rasterizer), pair)
    order = np.arange(5)
    order[best.depth] = 5
    merged = concatenate(drawing, best.layer).layer_subset(order[order != sum(pair) - best.depth])
    before, after = (visible_mse(rasterizer.forward(each), target) for each in (drawing, merged))
    # Means of squares of float32 colours, each off by a few eps.
    rounding = 20 * float(np.finfo(np.float32).eps)
    assert best.change == pytest.approx(after - before, abs=rounding)
    assert abs(best.change) > 4 * rounding


def test_parts_of_two_regions_of_the_picture_stay(rasterizer: Rasterizer) -> None:
    # The drawing lacks the line between the halves, so that one bar would be as good: but there are two things.
    drawing = _halves()
    target = rasterizer.forward(drawing).copy()
    target[10:22, 19:21] = 0
    assert _merged(drawing, rasterizer, target=target).sources.tolist() == [0, 1, 2, 3]


def test_the_errors_of_several_merges_add_up(rasterizer: Rasterizer) -> None:
    other = (0.94, 0.14, 0.24, 1.0)

    def bars(tops: tuple[int, ...]) -> Drawing:
        halves = [([rectangle(x, top, x + 18, top + 8)], c) for top in tops for x, c in ((2, RED), (20, other))]
        return shapes.build(halves, SIZE)

    one = bars((4,))
    merged = _merged(one, rasterizer, 1.0).drawing
    cost = visible_mse(rasterizer.forward(merged), rasterizer.forward(one))
    assert merged.num_layers == 1 and cost > 1e-5
    for factor, left in ((0.9, 4), (1.5, 3), (2.1, 2)):
        assert _merged(bars((4, 18)), rasterizer, factor * cost).drawing.num_layers == left


def test_a_pair_that_would_cost_too_much_is_tried_once(rasterizer: Rasterizer, monkeypatch: pytest.MonkeyPatch) -> None:
    # Two bars of two halves. The halves of the smaller one differ; they are not tried again after the other's merge.
    parts = [(2, 4, 12, RED), (20, 4, 12, (0.94, 0.14, 0.24, 1.0)), (2, 18, 30, RED), (20, 18, 30, RED)]
    drawing = shapes.build([([rectangle(x, top, x + 18, bottom)], c) for x, top, bottom, c in parts], SIZE)
    target = rasterizer.forward(drawing)
    tried: list[tuple[int, int]] = []

    def noted(context: Context, given: Drawing, alphas: np.ndarray, pair: tuple[int, int]) -> merging._Merge:
        tried.append(pair)
        return _best(context, given, alphas, pair)

    monkeypatch.setattr(merging, "_best", noted)
    # With eight segments, as many as both halves have, the merge of equal ones costs nothing.
    context = Context(rasterizer, target, Options(segments=8))
    merged = merge_neighbors(context, drawing, np.ones(4, bool), 18 * 8 * 0.03**2 / (SIZE[0] * SIZE[1]))
    assert merged.sources.tolist() == [0, 1, -1]
    assert len(tried) == 2


def test_an_error_that_falls_does_not_pay_for_other_merges(rasterizer: Rasterizer) -> None:
    # The picture has no gap between the halves of the smaller bar; those of the larger one differ.
    gap = [(2, 4, 20, 12, RED), (20.4, 4, 38, 12, RED)]
    differing = [(2, 18, 20, 30, RED), (20, 18, 38, 30, (0.94, 0.14, 0.24, 1.0))]
    drawing = shapes.build([([rectangle(*box)], color) for *box, color in gap + differing], SIZE)
    target = rasterizer.forward(drawing).copy()
    target[4:12, 18:23] = RED[:3]
    merged = _merged(drawing, rasterizer, 1e-6, target=target, segments=8)
    assert merged.sources.tolist() == [-1, 2, 3]
    assert visible_mse(rasterizer.forward(merged.drawing), target) < visible_mse(rasterizer.forward(drawing), target)


@pytest.mark.parametrize(("x", "radius", "sources"), [(8, 7, [-1, 1]), (29, 8, [1, -1])])
def test_what_lies_between_two_layers_stays_above_or_below_them(
    x: float, radius: float, sources: list[int], rasterizer: Rasterizer
) -> None:
    layers = [([rectangle(2, 10, 20, 22)], RED), ([circle((x, 16), radius)], BLUE), ([rectangle(20, 10, 38, 22)], RED)]
    assert _merged(shapes.build(layers, SIZE), rasterizer).sources.tolist() == sources


def test_an_outline_of_few_segments_may_cost_a_little(rasterizer: Rasterizer) -> None:
    # Both outlines as they are would be exact, with eight segments.
    merged = _merged(_halves(), rasterizer).drawing
    assert sum(len(merged.points[subpath]) for subpath in merged.subpaths(1)) < 8


def test_both_outlines_are_kept_where_none_of_few_segments_follows_them(rasterizer: Rasterizer) -> None:
    drawing = shapes.build([([rectangle(2, 4, 10, 28)], RED), ([rectangle(10, 20, 36, 28)], RED)], SIZE)
    merged = _merged(drawing, rasterizer, 1e-6, max_segments=4)
    assert merged.sources.tolist() == [-1]
    np.testing.assert_array_equal(merged.drawing.points, drawing.points)


@pytest.mark.parametrize("split", [10, 30])
def test_the_color_is_that_of_the_larger_part(split: float, rasterizer: Rasterizer) -> None:
    other = (0.94, 0.14, 0.24, 1.0)
    boxes = [([rectangle(2, 10, split, 22)], RED), ([rectangle(split, 10, 38, 22)], other)]
    merged = _merged(shapes.build(boxes, SIZE), rasterizer)
    np.testing.assert_array_equal(merged.drawing.colors, [RED if split > 20 else other])


def test_small_parts_are_merged_first(rasterizer: Rasterizer) -> None:
    other = (0.94, 0.14, 0.24, 1.0)
    parts = [(2, 18, 30, RED), (20, 18, 30, other), (2, 4, 12, RED), (20, 4, 12, other)]
    drawing = shapes.build([([rectangle(x, top, x + 18, bottom)], c) for x, top, bottom, c in parts], SIZE)
    either = 18 * 12 * 0.04**2 / (SIZE[0] * SIZE[1])
    assert _merged(drawing, rasterizer, 1.1 * either, segments=8).sources.tolist() == [0, 1, -1]
