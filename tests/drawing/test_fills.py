# SPDX-License-Identifier: Apache-2.0
"""Fills of a drawing: packed gradients, their checks, and what drawings do with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills
from livecl.drawing.assembly import concatenate
from livecl.drawing.fills import concatenate_fills
from livecl.svg import format_svg, quantize

ARRAYS = ("kinds", "geometry", "stop_offsets", "stop_positions", "stop_colors")


def some_fills() -> Fills:
    rng = np.random.default_rng(1)
    return Fills(
        kinds=[SOLID, LINEAR, RADIAL],
        geometry=rng.uniform(0, 20, (3, 3, 2)),
        stop_offsets=[0, 0, 2, 5],
        stop_positions=[0, 1, 0, 0.3, 1],
        stop_colors=rng.uniform(0, 1, (5, 4)),
    )


def filled() -> Drawing:
    rng = np.random.default_rng(2)
    return Drawing(
        points=rng.uniform(0, 20, (12, 3, 2)), colors=rng.uniform(size=(3, 4)), size=(20, 20), fills=some_fills()
    )


def assert_equal(a: Fills, b: Fills) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kinds": [0, 1, 3]}, r"^fills\.kinds"),
        ({"kinds": [1, 1, 2]}, r"^fills\.stop_offsets: wanted two or more stops"),
        ({"geometry": np.zeros((2, 3, 2))}, r"^fills\.geometry: shape"),
        ({"stop_offsets": [0, 0, 2, 4]}, r"^fills\.stop_offsets: wanted 4 offsets from 0 to 5"),
        ({"stop_positions": [0, 1, 0.5, 0.3, 1]}, r"^fills\.stop_positions: must not decrease"),
        ({"stop_colors": np.full((5, 4), 1.5)}, r"^fills\.stop_colors: all numbers"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changes: dict[str, Any], message: str) -> None:
    values = {name: getattr(some_fills(), name) for name in ARRAYS}
    with pytest.raises(ValueError, match=message):
        Fills(**values | changes)


def test_fills_of_other_drawings_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^fills: got those of 2 layers, wanted 3"):
        filled().replace(fills=some_fills().subset([1, 2]))


def test_solid_is_what_is_not_said() -> None:
    drawing = filled().replace(fills=None)
    assert not drawing.fills.any_gradients and len(drawing.fills) == 3


def test_layers_take_their_fills_with_them() -> None:
    drawing = filled()
    twice = concatenate(drawing, drawing)
    assert_equal(twice.layer_subset([3, 4, 5]).fills, drawing.fills)
    assert_equal(twice.layer_subset([4]).fills, drawing.fills.subset([1]))
    assert_equal(twice.layer_subset([4]).fills, drawing.layer_subset([1]).fills)


def test_gradients_have_their_mean_for_colour() -> None:
    fills = Fills.linear((0, 0), (1, 0), [(1, 0, 0, 1), (0, 0, 1, 1)])
    drawing = filled().layer_subset([0]).replace(fills=fills)
    np.testing.assert_allclose(drawing.colors, [(0.5, 0, 0.5, 1)])
    fills = Fills.linear((0, 0), (1, 0), [(1, 0, 0, 1), (0, 0, 1, 0)], [0.5, 0.5])
    np.testing.assert_allclose(drawing.replace(fills=fills).colors, [(1, 0, 0, 0.5)])


def test_means_of_gradients_do_not_depend_on_others() -> None:
    stops = np.random.default_rng(7).random((4, 3, 4))
    stops[1, :, 3], stops[2, :, 3] = 1, 0  # opaque, and nothing to be seen of it
    parts = [
        Fills.linear((0, 0), (9, 0), colors[:count], np.sort(colors[:count, 0]))
        for colors, count in zip(stops, (3, 2, 3, 2), strict=True)
    ]
    together = concatenate_fills([parts[0], Fills.solid(2), *parts[1:], Fills.solid(1)])
    np.testing.assert_allclose(together.mean_colors(), np.concatenate([part.mean_colors() for part in parts]))
    assert together.mean_colors()[1:3, 3].tolist() == [1, 0]
    np.testing.assert_allclose(
        together.mean_colors()[2, :3],
        Fills.linear((0, 0), (9, 0), np.where(np.arange(4) == 3, 0.5, stops[2]), np.sort(stops[2][:, 0])).mean_colors()[
            0, :3
        ],
    )
    assert Fills.solid(3).mean_colors().shape == (0, 4)


def test_stretching_moves_the_lines_of_equal_colour() -> None:
    fills = Fills.linear((1, 2), (5, 6), [(1, 0, 0, 1), (0, 0, 1, 1)])
    p0, p1, _ = fills.stretched((2, 1), (3, 0)).geometry[0]
    # (3, 4) is half way, and so is (5, 2), on the same line of equal colour at right angles to p1 - p0.
    for point in ((3, 4), (5, 2)):
        place = np.array(point) * (2, 1) + (3, 0)
        assert (place - p0) @ (p1 - p0) / ((p1 - p0) @ (p1 - p0)) == pytest.approx(0.5)


def test_saved_gradients_are_the_quantized_ones() -> None:
    drawing = quantize(filled(), 2)
    np.testing.assert_array_equal(drawing.fills.geometry, np.round(drawing.fills.geometry, 2))
    np.testing.assert_array_equal(drawing.fills.stop_colors * 255, np.rint(drawing.fills.stop_colors * 255))
    text = format_svg(concatenate(filled(), filled()), 2)
    assert text.count("<linearGradient") == text.count("<radialGradient") == 1, "equal gradients are written once"
    assert text.count('fill="url(#') == 4
