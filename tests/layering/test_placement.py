# SPDX-License-Identifier: Apache-2.0
"""New layers: where they start, what they look like, in which colour and at which depth, for each rule of placement."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import RasterizerFor
from numpy.typing import NDArray
from support import drawings, shapes
from support.placing import Placer

from livecl import Drawing, Options, interruption
from livecl.drawing.assembly import concatenate, empty_drawing
from livecl.geometry.bezier import signed_area
from livecl.geometry.outlines import circle
from livecl.layering import placement
from livecl.layering.componentwise.candidates import SMALL_REGION
from livecl.layering.componentwise.painting import Painting
from livecl.layering.context import Context
from livecl.layering.placement import place_paths

FloatArray = NDArray[np.float64]

#: A picture is held in single precision while layers are tried: a few roundings of numbers up to 1.
SINGLE = 8 * 2.0**-24

RED, GREEN, BLUE = (0.9, 0.1, 0.2), (0.1, 0.8, 0.3), (0.2, 0.3, 0.9)
RED4 = (*RED, 1.0)


@pytest.fixture
def place(rasterizer_for: RasterizerFor) -> Placer:
    return Placer(rasterizer_for)


def _three_shapes() -> FloatArray:
    """Return a disc of 317 px, a bar of 80 and a square of 25 on white; the error is in the same order."""
    rows, columns = np.indices((36, 48)) + 0.5
    target = np.ones((36, 48, 3))
    target[np.hypot(columns - 14, rows - 16) < 10] = RED
    target[28:32, 20:40] = BLUE
    target[5:10, 36:41] = GREEN
    return target


def test_components_become_circles_of_the_target_s_color(place: Placer) -> None:
    options = Options.paper(radius=3.5, segments=5)
    drawing = place(_three_shapes(), 3, options)
    assert drawing.num_layers == 3 and drawing.size == (36, 48)
    assert np.array_equal(drawing.segment_offsets, [0, 5, 10, 15]) and np.array_equal(drawing.layer_offsets, range(4))
    np.testing.assert_allclose(drawing.colors, [(*RED, 1), (*BLUE, 1), (*GREEN, 1)])
    for layer, center in enumerate([(14, 16), (30, 30), (38.5, 7.5)]):
        path = drawing.layer_subset([layer]).points
        np.testing.assert_allclose(path, circle(center, 3.5, 5), atol=1e-9)


def test_the_color_is_the_target_s_where_the_circle_is_put(place: Placer) -> None:
    # Not the mean of the component, as a slope of colours shows; for a ring, the colour of its own pixel.
    rows, columns = np.indices((24, 24))
    distance = np.hypot(rows - 12, columns - 12)
    target = np.where((distance < 9)[..., None], np.stack([rows / 23, columns / 23, 0 * rows], axis=-1), 1)
    one_bin = Options.paper(bins=1)
    drawing = place(target, 1, one_bin)
    np.testing.assert_allclose(drawing.colors[0], (12 / 23, 12 / 23, 0, 1))
    target[distance < 6] = 1
    drawing = place(target, 1, one_bin)
    column, row = np.floor(drawing.points.reshape(-1, 2).mean(axis=0)).astype(int)
    assert 6 <= distance[row, column] < 9
    np.testing.assert_allclose(drawing.colors[0], (*target[row, column], 1))


def test_components_with_fitted_outlines_cover_their_pixels(place: Placer) -> None:
    target = _three_shapes()
    drawing = place(target, 3, Options.paper(shape="outline"))
    for alpha, color in zip(place.alphas(drawing), (RED, BLUE, GREEN), strict=True):
        mask = (target == color).all(axis=-1)
        # The fit leaves the region by half a pixel along its border at most, in the mean.
        assert np.abs(alpha - mask).sum() < 0.5 * 4 * np.sqrt(mask.sum())


def test_random_outlines_start_at_the_components(place: Placer) -> None:
    drawing = place(_three_shapes(), 2, Options.paper(shape="random"))
    np.testing.assert_allclose(drawing.points[[0, 4], 0], [(14, 16), (30, 30)], atol=1e-9)
    again = place(_three_shapes(), 2, Options.paper(shape="random"))
    other = place(_three_shapes(), 2, Options.paper(shape="random"), seed=1)
    assert np.array_equal(drawing.points, again.points) and not np.array_equal(drawing.points, other.points)


def test_random_places_are_uniform_and_take_the_target_s_color(place: Placer) -> None:
    target = np.random.default_rng(0).uniform(size=(20, 50, 3))
    drawing = place(target, 400, Options.paper(placement="random", segments=2))
    centers = drawing.points.reshape(400, 6, 2).mean(axis=1)
    assert np.all(centers >= 0) and np.all(centers < (50, 20))
    # 100 are expected in each quarter, with a deviation of 8.7.
    quarters = np.histogram2d(*centers.T, bins=2, range=[[0, 50], [0, 20]])[0]
    assert np.all(np.abs(quarters - 100) < 4 * 8.7)
    columns, rows = np.floor(centers).astype(int).T
    np.testing.assert_allclose(drawing.colors, np.concatenate([target[rows, columns], np.ones((400, 1))], axis=1))


def test_the_baseline_s_paths_are_random_in_all(place: Placer) -> None:
    drawing = place(_three_shapes(), 200, Options.diffvg())
    assert drawing.colors.min() >= 0 and drawing.colors.max() <= 1
    np.testing.assert_allclose(drawing.colors.mean(axis=0), 0.5, atol=4 * np.sqrt(1 / 12 / 200))
    assert np.array_equal(drawing.points, place(_three_shapes(), 200, Options.diffvg()).points)
    assert not np.array_equal(drawing.colors, place(_three_shapes(), 200, Options.diffvg(), seed=1).colors)


@pytest.mark.parametrize("rule", ["component", "region"])
def test_rules_without_chance_leave_the_random_source_alone(rasterizer_for: RasterizerFor, rule: str) -> None:
    rng = np.random.default_rng(3)
    before = rng.bit_generator.state
    target, options = _three_shapes(), Options(placement=rule, shape="outline")
    context = Context(rasterizer_for((36, 48), np.float32), target, options)
    place_paths(context, empty_drawing((36, 48)), 2, rng)
    assert rng.bit_generator.state == before


def test_a_stop_is_looked_for_between_the_parts_of_the_work_before_regions_are_looked_at(
    rasterizer_for: RasterizerFor, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    rasterizer = rasterizer_for((36, 48), np.float32)
    for name in ("layer_alphas", "LayerStack", "Painting", "region_candidates"):
        part = getattr(placement, name)
        monkeypatch.setattr(placement, name, lambda *a, n=name, p=part: done.append(n) or p(*a))
    context = Context(rasterizer, _three_shapes(), Options(placement="region"))
    with interruption.interruptible(lambda: done.append("check")):
        place_paths(context, empty_drawing((36, 48)), 1, np.random.default_rng(0))
    before = done[: done.index("region_candidates")]
    assert before == ["check", "check", "layer_alphas", "LayerStack", "check", "Painting", "check"]


def test_regions_are_painted_in_the_order_of_their_error(place: Placer) -> None:
    target = _three_shapes()
    drawing = place(target, 3, Options(placement="region"))
    np.testing.assert_allclose(drawing.colors, [(*RED, 1), (*BLUE, 1), (*GREEN, 1)], atol=1e-9)
    before = place.error(target, empty_drawing((36, 48)))
    for count in (1, 2, 3):
        error = place.error(target, drawing.layer_subset(range(count)))
        assert error < before
        before = error
    # What is left is on the borders: the target's pixels are whole, those of an outline are not, and are off by up to
    # one half on about as many pixels as the borders are long, 63 + 48 + 20.
    assert before < 131 * 3 / 4


def test_later_paths_see_what_earlier_ones_painted(place: Placer) -> None:
    # A disc within a disc: the second path paints the inner one, on the first.
    rows, columns = np.indices((32, 32)) + 0.5
    distance = np.hypot(rows - 16, columns - 16)
    target = np.ones((32, 32, 3))
    target[distance < 13], target[distance < 6] = (0.1, 0.1, 0.1), (0.9, 0.5, 0.1)
    drawing = place(target, 2, Options(placement="region"))
    np.testing.assert_allclose(drawing.colors[:, :3], [(0.1, 0.1, 0.1), (0.9, 0.5, 0.1)], atol=1e-9)
    for layer, radius in enumerate((13, 6)):
        path = drawing.layer_subset([layer]).points
        cubics = np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)
        assert abs(signed_area(cubics)) == pytest.approx(np.pi * radius**2, rel=0.05)


def test_circles_for_regions_lie_at_their_center(place: Placer) -> None:
    drawing = place(_three_shapes(), 1, Options(placement="region", shape="circle", radius=4.0, segments=3))
    center = drawing.points.reshape(-1, 2).mean(axis=0)
    np.testing.assert_allclose(center, (14, 16), atol=0.2)  # of parts of the disc that would gain as much
    np.testing.assert_allclose(drawing.points, circle(center, 4, 3), atol=1e-9)


def test_random_outlines_for_regions(place: Placer) -> None:
    options = Options(placement="region", shape="random")
    drawing = place(_three_shapes(), 1, options)
    center = drawing.points.reshape(-1, 2).mean(axis=0)
    assert np.ptp(np.hypot(*(drawing.points.reshape(-1, 2) - center).T)) > 1e-3, "a circle"
    assert not np.array_equal(drawing.points, place(_three_shapes(), 1, options, seed=1).points)


def test_random_colors_for_regions(place: Placer) -> None:
    options = Options(placement="region", new_color="random")
    first, second = (place(_three_shapes(), 1, options, seed=seed).colors for seed in (0, 1))
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("placement", ["component", "region"])
def test_the_smallest_regions_become_circles_of_their_area(place: Placer, placement: str) -> None:
    target = np.ones((20, 20, 3))
    target[4:7, 9:12] = 0.0
    drawing = place(target, 1, Options(placement=placement, shape="outline", max_segments=4))
    assert (target == 0).all(axis=-1).sum() < SMALL_REGION
    np.testing.assert_allclose(drawing.points, circle((10.5, 5.5), np.sqrt(9 / np.pi), 4), atol=1e-12)


@pytest.mark.parametrize("size", [(12, 17), (1, 1), (1, 9)])
@pytest.mark.parametrize("shape", ["outline", "circle"])
@pytest.mark.parametrize("rule", ["component", "region"])
def test_paths_for_a_perfect_picture(place: Placer, rule: str, shape: str, size: tuple[int, int]) -> None:
    drawing = place(np.ones((*size, 3)), 5, Options(placement=rule, shape=shape))
    # No region is worth a path, but a picture's first is never left out.
    assert drawing.num_layers == (1 if rule == "region" else 5) and drawing.size == size
    layers = [drawing.layer_subset([k]) for k in range(drawing.num_layers)]
    centers = np.array([layer.points.reshape(-1, 2).mean(axis=0) for layer in layers])
    assert np.all(centers >= 0) and np.all(centers <= size[::-1])


@pytest.mark.parametrize("options", [Options.paper(), Options.released(), Options(), Options.diffvg()])
def test_pictures_in_single_precision_give_the_same_places(place: Placer, options: Options) -> None:
    target = _three_shapes()
    double, single = place(target, 2, options), place(target.astype(np.float32), 2, options)
    np.testing.assert_allclose(single.points, double.points, atol=1e-5)
    np.testing.assert_allclose(single.colors, double.colors, atol=1e-6)


@pytest.mark.parametrize("options", [Options.paper(), Options.paper(shape="outline"), Options.diffvg()])
def test_all_but_regions_go_on_top(place: Placer, options: Options) -> None:
    below = drawings.build([([shapes.circle((20, 20), 9)], (*GREEN, 1)), ([shapes.circle((9, 9), 5)], RED4)], (36, 48))
    assert place.on(below, _three_shapes(), 3, options).order.tolist() == [0, 1, 2, 3, 4]


def _ring() -> tuple[FloatArray, Drawing]:
    """Return a blue disc with a red one on it as the target, and a drawing that has only the red one."""
    rows, columns = np.indices((32, 32)) + 0.5
    away = np.hypot(rows - 16, columns - 16)
    target = np.ones((32, 32, 3))
    target[away < 13], target[away < 6] = BLUE, RED
    return target, drawings.build([([shapes.circle((16, 16), 6)], RED4)], (32, 32))


def test_a_region_goes_below_what_it_would_hide(place: Placer) -> None:
    target, inner = _ring()
    placement = place.on(inner, target, 1, Options(placement="region"))
    assert placement.order.tolist() == [1, 0]
    np.testing.assert_allclose(placement.drawing.colors, [(*BLUE, 1)], atol=1e-7)
    whole = concatenate(inner, placement.drawing)
    assert place.error(target, whole.layer_subset(placement.order)) < place.error(target, whole) / 5
    on_top = place.on(inner, target, 1, Options.paper(shape="outline"))
    assert on_top.order.tolist() == [0, 1]


def test_several_paths_of_one_stage_are_ordered_among_themselves_too(place: Placer) -> None:
    target, inner = _ring()
    target[1:5, 1:9] = GREEN
    placement = place.on(inner, target, 2, Options(placement="region"))
    assert sorted(placement.order) == [0, 1, 2]
    colors = concatenate(inner, placement.drawing).layer_subset(placement.order).colors[:, :3]
    found = [int(np.argmin(np.abs(np.array([RED, GREEN, BLUE]) - color).sum(axis=1))) for color in colors]
    assert sorted(found) == [0, 1, 2] and found.index(2) < found.index(0)


@pytest.mark.parametrize(
    ("background", "opacity", "follow"),
    [(None, "snap", True), (None, "train", True), (None, "opaque", False), ((1, 1, 1), "snap", False)],
)
def test_opacities_follow_a_new_layer_over_nothing_unless_they_are_fixed(
    place: Placer, monkeypatch: pytest.MonkeyPatch, background: Any, opacity: Any, follow: bool
) -> None:
    asked = []

    class Told(Painting):
        def __init__(self, *arguments: Any) -> None:
            asked.append(arguments[2])
            super().__init__(*arguments)

    monkeypatch.setattr("livecl.layering.placement.Painting", Told)
    target = np.ones((12, 12, 3 if background else 4))
    place.on(empty_drawing((12, 12), background), target, 1, Options(placement="region", opacity=opacity))
    assert asked == [follow]
