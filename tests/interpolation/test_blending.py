# SPDX-License-Identifier: Apache-2.0
"""Drawings between two: the ends, points, colours, layers without partners, canvases."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from support.drawings import BLUE, GREEN, RED, RED_GLASS, blob, build, random_colors, rectangle, reverse
from support.shapes import circle

import livecl
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.geometry import bezier
from livecl.interpolation.blending import collapsed, correspond, fit_canvas, interpolate, mix_colors
from livecl.rendering.rasterizer import Rasterizer

SIZE = (60, 60)


def drawing_of(seed: int, count: int, segments: int) -> Drawing:
    """Return blobs of random translucent colours, the second one a ring, over a grey ground."""
    rng = np.random.default_rng(seed)
    paths = [blob(100 * seed + i, rng.uniform(15, 45, 2), rng.uniform(5, 14), segments) for i in range(count)]
    colors = random_colors(seed, count)
    layers = [([path], tuple(color)) for path, color in zip(paths, colors, strict=True)]
    layers[1] = ([circle((30, 30), 12), reverse(circle((31, 30), 5))], tuple(colors[1]))
    return build(layers, SIZE, background=rng.uniform(0.3, 0.7, 3))


@pytest.mark.parametrize("match", ["order", "nearest"])
@pytest.mark.parametrize("lone", ["fade", "grow"])
@pytest.mark.parametrize("counts", [(4, 4, 4, 4), (3, 4, 6, 7)], ids=["alike", "different"])
def test_ends_look_the_same(counts: tuple[int, int, int, int], lone: str, match: str, device: int) -> None:
    a, b = drawing_of(1, counts[0], counts[1]), drawing_of(2, counts[2], counts[3])
    # Segments that are cut are flattened at other places, each within 1e-4 px of the curve: edges differ by 2e-4 px, a
    # pixel by as much of a colour for each of the six edges, at most, that meet in it.
    rasterizer = Rasterizer(SIZE, device, tolerance=1e-4)
    for t, end in ((0.0, a), (1.0, b)):
        between = interpolate(a, b, t, match=match, lone=lone)
        difference = rasterizer.forward(between) - rasterizer.forward(end)
        assert np.mean(np.square(difference)) < 1e-6
        assert np.abs(difference).max() < 1.2e-3


def test_ends_are_exact_where_nothing_is_cut() -> None:
    a, b = drawing_of(1, 4, 4), drawing_of(2, 4, 4)
    first, last = interpolate(a, b, [0, 1])
    np.testing.assert_array_equal(first.points, a.points)
    np.testing.assert_array_equal(first.colors, a.colors)
    np.testing.assert_array_equal(first.background, a.background)
    np.testing.assert_array_equal(last.colors, b.colors)
    np.testing.assert_array_equal(last.background, b.background)
    assert first.same_structure(last)


def test_linear_in_points() -> None:
    a, b = drawing_of(1, 4, 3), drawing_of(2, 4, 5)
    start, middle, end = interpolate(a, b, [0, 0.25, 1])
    # Sums of two products of numbers below 100: a few eps of 1e2.
    np.testing.assert_allclose(middle.points, 0.75 * start.points + 0.25 * end.points, atol=1e-12)
    np.testing.assert_allclose(middle.background, 0.75 * a.background + 0.25 * b.background, atol=1e-15)


def test_scalar_and_sequence() -> None:
    a, b = drawing_of(1, 4, 4), drawing_of(2, 4, 4)
    one = livecl.interpolate(a, b, 0.5)
    (same,) = livecl.interpolate(a, b, [0.5])
    np.testing.assert_array_equal(one.points, same.points)
    assert livecl.interpolate(a, b, []) == []


def test_moved_shape_keeps_its_form() -> None:
    path = blob(5, (20, 20), 10, segments=5)
    other = np.roll(reverse(path), 6, axis=0) + np.array((22.0, 18.0))  # other start, other way round
    a, b = build([([path], RED)], SIZE), build([([other], RED)], SIZE)
    halfway = interpolate(a, b, 0.5)
    np.testing.assert_allclose(halfway.points, path + np.array((11.0, 9.0)), atol=1e-12)


def test_colors_that_fade_do_not_tint() -> None:
    clear_red, blue = np.array([1.0, 0, 0, 0]), np.array([0, 0, 1.0, 1])
    np.testing.assert_allclose(mix_colors(clear_red, blue, 0.5), (0, 0, 1, 0.5))
    np.testing.assert_allclose(mix_colors(clear_red, np.array([0, 1.0, 0, 0]), 0.25), (0.75, 0.25, 0, 0))
    opaque = mix_colors((1, 0, 0, 1), (0, 1, 0.5, 1), 0.25)
    np.testing.assert_allclose(opaque, (0.75, 0.25, 0.125, 1))


def test_premultiplied_mix_is_the_mean_of_the_pictures(device: int) -> None:
    a, b = build([([rectangle(8, 8, 40, 40)], RED_GLASS)], SIZE), build([([rectangle(8, 8, 40, 40)], GREEN)], SIZE)
    rasterizer = Rasterizer(SIZE, device)
    between = rasterizer.forward(interpolate(a, b, 0.3))
    mean = 0.7 * rasterizer.forward(a) + 0.3 * rasterizer.forward(b)
    np.testing.assert_allclose(between, mean, atol=4 * np.finfo(np.float32).eps)


def areas(drawing: Drawing) -> NDArray[np.float64]:
    cubics = drawing.cubics
    return np.array([abs(bezier.signed_area(cubics[i:j])) for i, j in itertools.pairwise(drawing.segment_offsets)])


def test_lone_layer_fades_or_grows() -> None:
    a = build([([rectangle(5, 5, 55, 55)], RED)], SIZE)
    b = build([([rectangle(5, 5, 55, 55)], RED), ([rectangle(20, 20, 30, 40)], BLUE)], SIZE)
    fading = interpolate(a, b, [0, 0.5, 1])
    np.testing.assert_allclose([drawing.colors[1, 3] for drawing in fading], [0, 0.5, 1])
    np.testing.assert_allclose([areas(drawing)[1] for drawing in fading], [200, 200, 200])
    growing = interpolate(a, b, [0, 0.5, 1], lone="grow")
    np.testing.assert_array_equal([drawing.colors[1] for drawing in growing], [BLUE] * 3)
    np.testing.assert_allclose([areas(drawing)[1] for drawing in growing], [0, 50, 200], atol=1e-12)
    np.testing.assert_allclose(growing[0].points[4:], np.broadcast_to((25.0, 30.0), (4, 3, 2)), atol=1e-12)
    leaving = interpolate(b, a, [0, 1], lone="grow")
    np.testing.assert_allclose([areas(drawing)[1] for drawing in leaving], [200, 0], atol=1e-12)


def test_stages_and_names_come_along() -> None:
    a = build([([rectangle(5, 5, 55, 55)], RED)], SIZE).replace(stages=[3])
    b = build([([rectangle(5, 5, 55, 55)], RED), ([rectangle(20, 20, 30, 40)], BLUE)], SIZE).replace(stages=[1, 2])
    assert interpolate(a, b, 0.5).stages.tolist() == [3, 2]
    assert interpolate(a, b.replace(names=["ground", "eye"]), 0.5).names == ("ground", "eye")
    assert interpolate(a.replace(names=["head"]), b.replace(names=["ground", ""]), 0.5).names == ("head", "")


def test_empty_drawings() -> None:
    a, b = empty_drawing(SIZE, (1, 0, 0)), empty_drawing(SIZE, (0, 0, 1))
    halfway = interpolate(a, b, 0.5)
    assert halfway.num_layers == 0
    np.testing.assert_allclose(halfway.background, (0.5, 0, 0.5))
    assert interpolate(a, drawing_of(1, 4, 4), 0.5).num_layers == 4


def test_without_background() -> None:
    a, b = (drawing_of(seed, 4, 4).replace(background=None) for seed in (1, 2))
    assert interpolate(a, b, 0.5).background is None


def test_refusals() -> None:
    a = drawing_of(1, 4, 4)
    with pytest.raises(ValueError, match=r"b: canvas of \(30, 60\) px, wanted that of a, \(60, 60\); .*fit_canvas"):
        correspond(a, a.replace(size=(30, 60)))
    with pytest.raises(ValueError, match="b: one drawing has a background and the other has none"):
        correspond(a, a.replace(background=None))
    with pytest.raises(ValueError, match="lone: got 'pop', wanted 'fade' or 'grow'"):
        correspond(a, a, lone="pop")
    for t in (-0.1, 1.5, float("nan"), [[0.5]]):
        with pytest.raises(ValueError, match=r"t: got .* wanted a number from 0 to 1"):
            interpolate(a, a, t)


def test_fit_canvas() -> None:
    drawing = build([([rectangle(0, 0, 60, 30)], RED)], (30, 60))
    fitted = fit_canvas(drawing, (100, 100))
    assert fitted.size == (100, 100)
    np.testing.assert_allclose(fitted.points[:, 0], [(0, 25), (100, 25), (100, 75), (0, 75)], atol=1e-12)


def test_collapsed() -> None:
    points = collapsed(build([([rectangle(10, 20, 30, 50)], RED), ([circle((9, 8), 3)], BLUE)], SIZE)).points
    np.testing.assert_allclose(points[:4], np.broadcast_to((20.0, 35.0), (4, 3, 2)), atol=1e-12)
    np.testing.assert_allclose(points[4:], np.broadcast_to((9.0, 8.0), (4, 3, 2)), atol=1e-12)
