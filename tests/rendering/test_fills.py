# SPDX-License-Identifier: Apache-2.0
"""Gradient fills: images against the reference, and gradients of geometry and stops against central differences."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from reference import differences, images
from reference.composite import squared_error
from reference.fill_rounding import fills_tolerance
from reference.places import same_numbers
from reference.rounding import colors_tolerance, image_tolerance, points_tolerance
from support import drawings, shapes
from support.case_losses import Losses

from livecl.drawing import LINEAR, RADIAL, SOLID, Fills
from livecl.rendering.rasterizer import Rasterizer

RELATIVE = 1e-6


def _case(
    seed: int,
    background: tuple[float, ...] | None,
    kinds: list[int],
    size: tuple[int, int] = (26, 21),
    most_stops: int = 4,
) -> drawings.Case:
    """Return blobs over one another with random fills of two stops or more, transparent, opaque and between."""
    rng = np.random.default_rng(seed)
    layers: list[shapes.Layer] = [
        ([shapes.blob(seed + k, rng.uniform(7, 15, 2), rng.uniform(4, 9))], rng.uniform(0.1, 0.9, 4)) for k in kinds
    ]
    counts = [int(rng.integers(2, most_stops + 1)) if kind != SOLID else 0 for kind in kinds]
    positions = [(np.arange(count) + rng.uniform(0.2, 0.8, count)) / max(count, 1) for count in counts]
    colors = rng.uniform(0, 1, (sum(counts), 4))
    colors[rng.random(len(colors)) < 0.15, 3] = 1
    colors[rng.random(len(colors)) < 0.1, 3] = 0
    fills = Fills(
        kinds=kinds,
        geometry=rng.uniform(2, 18, (len(kinds), 3, 2)),
        stop_offsets=np.cumsum([0, *counts]),
        stop_positions=np.concatenate([np.zeros(0), *positions]),
        stop_colors=colors,
    )
    drawing = drawings.build(layers, size, background).replace(fills=fills)
    return drawings.Case(drawing=drawing, pieces=np.full(drawing.num_segments, 5, np.int32))


CASES = {
    "over a background": lambda: _case(1, (1.0, 0.9, 0.8), [RADIAL, LINEAR, SOLID, RADIAL, LINEAR]),
    "over nothing": lambda: _case(2, None, [LINEAR, SOLID, RADIAL, LINEAR, SOLID]),
    "linear": lambda: _case(3, (0.0, 0.0, 0.0), [LINEAR]),
    "radial": lambda: _case(4, None, [RADIAL]),
    "crowd": lambda: _case(5, (1.0, 1.0, 1.0), [SOLID, LINEAR, RADIAL] * 24),
    "many stops, few in a tile": lambda: _case(10, None, [LINEAR, RADIAL, LINEAR, RADIAL], most_stops=12),
    "crowd over nothing": lambda: _case(6, None, [LINEAR, RADIAL, RADIAL] * 13),
}


@pytest.mark.parametrize("name", CASES)
def test_image_against_reference(rasterizer_for: RasterizerFor, name: str) -> None:
    case = CASES[name]()
    image = rasterizer_for(case.drawing.size, np.float64).forward(case.drawing, pieces=case.pieces)
    np.testing.assert_allclose(image, images.render(case.drawing, case.pieces), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_float_against_double(rasterizer_for: RasterizerFor, name: str) -> None:
    case = CASES[name]()
    drawing, pieces = case.drawing, case.pieces
    single, double = (Losses(rasterizer_for(drawing.size, dtype), case) for dtype in (np.float32, np.float64))
    with same_numbers():
        rendered, image = (losses.rasterizer.forward(drawing.replace(), pieces) for losses in (single, double))
        gradients = [losses.gradients() for losses in (single, double)]
    allowed = image_tolerance(drawing, pieces)
    assert np.all(np.abs(rendered - image) <= allowed)
    d_error = single.weight[..., None] * squared_error(image, single.target)[1]
    factor = 2 if drawing.background is not None else 6  # d_error is linear in the image, by up to this
    d_images = single.d_image, d_error + factor / 2 * allowed * np.sign(d_error)
    for found, exact, d_image in zip(*gradients, d_images, strict=True):
        tolerance = fills_tolerance(drawing, pieces, d_image)
        for part in ("geometry", "stop_positions", "stop_colors"):
            errors = np.abs(getattr(found.fills, part) - getattr(exact.fills, part))
            assert np.all(errors <= getattr(tolerance, part)), part
        assert np.all(np.abs(found.points - exact.points) <= points_tolerance(drawing, pieces, d_image))
        colors = colors_tolerance(drawing, pieces, d_image)
        assert np.max(np.abs(found.colors - exact.colors)) <= colors
        if exact.background is not None:
            assert found.background is not None
            assert np.max(np.abs(found.background - exact.background)) <= colors


def test_tolerance_of_fills_is_small(rasterizer_for: RasterizerFor) -> None:
    """A hundredth of the gradient left out would be noticed: the bound is no larger, of one layer's."""
    case = CASES["linear"]()
    losses = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    found = losses.gradients()[0].fills
    tolerance = fills_tolerance(case.drawing, case.pieces, losses.d_image)
    for part in ("geometry", "stop_positions", "stop_colors"):
        assert np.max(getattr(tolerance, part)) <= 0.01 * np.max(np.abs(getattr(found, part))), part


def _numerical(losses: Losses, name: str, entries: list[int]) -> np.ndarray:
    fills = losses.case.drawing.fills

    def of(values: np.ndarray) -> np.ndarray:
        return losses(fills=fills.with_numbers(**{name: values}))

    values = getattr(fills, name)
    if name == "stop_colors":
        return differences.of_quadratic(of, values, entries)
    return differences.by_small_steps(of, values, entries)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("part", ["geometry", "stop_positions", "stop_colors"])
def test_gradients_against_differences(rasterizer_for: RasterizerFor, name: str, part: str) -> None:
    case = CASES[name]()
    losses = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    size = getattr(case.drawing.fills, part).size
    entries = np.random.default_rng(7).choice(size, min(size, 40), replace=False).tolist()
    for found, expected in zip(losses.gradients(), _numerical(losses, part, entries), strict=True):
        gradient = getattr(found.fills, part)
        error = np.linalg.norm(gradient.ravel()[entries] - expected)
        assert error <= RELATIVE * np.linalg.norm(gradient), f"relative {error / np.linalg.norm(gradient):.1e}"


@pytest.mark.parametrize("name", CASES)
def test_outlines_and_solid_colours_against_differences(rasterizer_for: RasterizerFor, name: str) -> None:
    case = CASES[name]()
    losses = Losses(rasterizer_for(case.drawing.size, np.float64), case)
    points, colors = case.drawing.points, case.drawing.colors
    entries = np.random.default_rng(8).choice(points.size, min(points.size, 30), replace=False).tolist()
    numerical = differences.by_small_steps(lambda x: losses(points=x), points, entries)
    for found, expected in zip(losses.gradients(), numerical, strict=True):
        error = np.linalg.norm(found.points.ravel()[entries] - expected)
        assert error <= RELATIVE * np.linalg.norm(found.points)
    solid = np.flatnonzero(case.drawing.fills.kinds == SOLID)[:4]
    entries = [4 * int(layer) + channel for layer in solid for channel in range(4)]
    if entries:
        numerical = differences.of_quadratic(lambda x: losses(colors=x), colors, entries)
        for found, expected in zip(losses.gradients(), numerical, strict=True):
            assert np.linalg.norm(found.colors.ravel()[entries] - expected) <= RELATIVE * np.linalg.norm(found.colors)
    gradients = losses.gradients()[0]
    assert not gradients.colors[case.drawing.fills.gradient_layers].any()


@pytest.mark.parametrize(
    "fills",
    [
        Fills.linear((3, 4), (3, 4), [(1, 0, 0, 1), (0, 0.5, 1, 0.5)]),
        Fills.radial((3, 4), (3, 4), (3, 4), [(1, 0, 0, 1), (0, 0.5, 1, 0.5)]),
        Fills.radial((3, 4), (5, 4), (9, 4), [(1, 0, 0, 1), (0, 0.5, 1, 0.5)]),
    ],
    ids=["linear", "radius 0", "flat ellipse"],
)
def test_degenerate_geometry_is_the_last_stop(rasterizer_for: RasterizerFor, fills: Fills) -> None:
    solid = drawings.build([([shapes.rectangle(1, 1, 9, 7)], (0, 0.5, 1, 0.5))], (10, 10))
    rasterizer = rasterizer_for((10, 10), np.float64)
    image = rasterizer.forward(solid).copy()
    found = rasterizer.forward(solid.replace(fills=fills))
    np.testing.assert_allclose(found, image, atol=1e-15)
    gradients = rasterizer.backward(np.ones_like(image))
    assert gradients.fills is not None and not gradients.fills.geometry.any()
    assert gradients.fills.stop_colors[1].all() and not gradients.fills.stop_colors[0].any()


@pytest.mark.parametrize("length", [1e-3, 1e-10, 1e-40, 1e-170, 5e-324])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_short_linear_gradient_is_a_step(rasterizer_for: RasterizerFor, dtype: type, length: float) -> None:
    """Its first colour on one side, its last on the other; nothing overflows, and no pixel is between."""
    fills = Fills.linear((0, 0), (length, 0), [(1, 0, 0, 1), (0, 0.5, 1, 0.5)])
    square = drawings.build([([shapes.rectangle(-9, -9, 17, 17)], shapes.WHITE)], (8, 8))
    square = square.replace(fills=fills)
    rasterizer = rasterizer_for((8, 8), dtype)
    right = np.array((0.5, 0.75, 1))  # the last colour, half over white
    assert np.array_equal(rasterizer.forward(square), np.broadcast_to(right, (8, 8, 3)).astype(dtype))
    gradients = rasterizer.backward(np.ones((8, 8, 3)))
    assert gradients.fills is not None
    assert all(np.isfinite(part).all() for part in vars(gradients.fills).values())
    turned = Fills.linear((0, 0), (-length, 0), [(1, 0, 0, 1), (0, 0.5, 1, 0.5)])
    image = rasterizer.forward(square.replace(fills=turned))
    assert np.array_equal(image, np.broadcast_to((1, 0, 0), (8, 8, 3)))


@pytest.mark.parametrize("size", [1e-10, 1e-25, 1e-160])
def test_an_ellipse_like_a_point_is_the_last_stop(rasterizer_for: RasterizerFor, size: float) -> None:
    fills = Fills.radial((0, 0), (size, 0), (0, size), [(1, 0, 0, 1), (0, 0.5, 1, 1)])
    square = drawings.build([([shapes.rectangle(-9, -9, 17, 17)], shapes.WHITE)], (8, 8)).replace(fills=fills)
    for dtype in (np.float32, np.float64):
        rasterizer = rasterizer_for((8, 8), dtype)
        assert np.array_equal(rasterizer.forward(square), np.broadcast_to((0, 0.5, 1), (8, 8, 3)))
        gradients = rasterizer.backward(np.ones((8, 8, 3)))
        assert gradients.fills is not None and np.isfinite(gradients.fills.geometry).all()


def test_steps_and_ends(rasterizer_for: RasterizerFor) -> None:
    """Two stops at one place are a step; beyond the stops, the first and the last colour go on."""
    fills = Fills.linear((2, 0), (6, 0), [(1, 0, 0, 1), (1, 0, 0, 1), (0, 0, 1, 1), (0, 1, 1, 1)], [0, 0.5, 0.5, 1])
    drawing = drawings.build([([shapes.rectangle(-1, -1, 9, 9)], shapes.WHITE)], (1, 8)).replace(fills=fills)
    image = rasterizer_for((1, 8), np.float64).forward(drawing)[0]
    expected = [(1, 0, 0)] * 4 + [(0, 0.25, 1), (0, 0.75, 1), (0, 1, 1), (0, 1, 1)]
    np.testing.assert_allclose(image, expected, atol=1e-14)


@pytest.mark.parametrize("kind", ["linear", "radial"])
def test_which_stops_a_tile_reaches_changes_nothing(rasterizer_for: RasterizerFor, kind: str) -> None:
    """Stops on pixel centres, steps among them: as the canvas is moved under the tiles, gradients stay."""
    positions = np.array([0, 3, 3, 7, 8, 8, 12, 16]) / 16
    colors = np.random.default_rng(3).uniform(size=(8, 4))
    d_image = np.random.default_rng(4).normal(size=(9, 18, 3))
    found = []
    for left in range(9):
        corner = np.array([left + 0.5, 4.5])
        ends = corner + ([(16, 0)] if kind == "linear" else [(16, 0), (0, 16)])
        fills = getattr(Fills, kind)(corner, *ends, colors, positions)
        drawing = drawings.build([([shapes.rectangle(left, 0, left + 18, 9)], shapes.WHITE)], (9, 27))
        rasterizer = rasterizer_for((9, 27), np.float64)
        rasterizer.forward(drawing.replace(fills=fills))
        found.append(rasterizer.backward(np.pad(d_image, ((0, 0), (left, 9 - left), (0, 0)))).fills)
    for gradients in found[1:]:
        for part, values in vars(found[0]).items():
            np.testing.assert_allclose(getattr(gradients, part), values, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_equal_stops_are_a_solid_fill(rasterizer_for: RasterizerFor, dtype: type) -> None:
    case = CASES["over a background"]()
    solid = case.drawing.replace(fills=None)
    fills = Fills(
        kinds=[LINEAR, RADIAL] * 2 + [LINEAR],
        geometry=case.drawing.fills.geometry,
        stop_offsets=2 * np.arange(6),
        stop_positions=[0, 1] * 5,
        stop_colors=np.repeat(solid.colors, 2, axis=0),
    )
    rasterizer = rasterizer_for(solid.size, dtype)
    image = rasterizer.forward(solid, pieces=case.pieces).copy()
    np.testing.assert_array_equal(rasterizer.forward(solid.replace(fills=fills), pieces=case.pieces), image)


def test_bands_and_repeats_give_the_same_gradient() -> None:
    case = _case(9, (1.0, 1.0, 1.0), [LINEAR, RADIAL, SOLID] * 3, (70, 40))
    whole, banded = Rasterizer((70, 40)), Rasterizer((70, 40), max_tiles=8)
    d_image = np.random.default_rng(1).normal(size=(70, 40, 3))
    found = []
    for rasterizer in (whole, whole, banded):
        rasterizer.forward(case.drawing, pieces=case.pieces)
        gradients = rasterizer.backward(d_image).fills
        assert gradients is not None
        found.append(gradients)
    np.testing.assert_array_equal(found[0].geometry, found[1].geometry)
    np.testing.assert_array_equal(found[0].stop_colors, found[1].stop_colors)
    # Sums in another order: both lie within what rounding allows.
    tolerance = fills_tolerance(case.drawing, case.pieces, d_image)
    for part in ("geometry", "stop_positions", "stop_colors"):
        errors = np.abs(getattr(found[0], part) - getattr(found[2], part))
        assert np.all(errors <= 2 * getattr(tolerance, part)), part
