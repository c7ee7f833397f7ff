# SPDX-License-Identifier: Apache-2.0
"""Drawings with gradient fills: read back equal, and shown by resvg and cairo as fills are defined."""

from __future__ import annotations

import io

import compare_svg
import numpy as np
import pytest
from numpy.typing import NDArray
from support.svg_documents import document

import livecl
from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills
from livecl.drawing.fills import concatenate_fills
from livecl.svg import LayerStyle, format_svg, quantize, read_svg
from livecl.svg.gradients import stop_colors

SIZE = 64
FILLS = ("kinds", "geometry", "stop_offsets", "stop_positions", "stop_colors")


def random_fill(rng: np.random.Generator, kind: int) -> Fills:
    """Return a fill about the canvas: 2 to 5 stops, some translucent, at one place, or of one colour; some flat."""
    if kind == SOLID:
        return Fills.solid(1)
    count = int(rng.integers(2, 6))
    positions = np.sort(rng.uniform(0, 1, count))
    positions[1] = positions[rng.integers(0, 2)]
    colors = rng.uniform(0, 1, (count, 4))
    colors[:, 3] = np.where(rng.random() < 0.5, 1, colors[:, 3])
    points = rng.uniform(-10, SIZE + 10, (3, 2))
    way = rng.random()
    if way < 0.05:
        points[1:] = points[0]
    elif way < 0.1:
        points[2] = 2 * points[1] - points[0]
    elif way < 0.15:
        colors[:] = colors[0]
    elif way < 0.3:
        points[1:] = points[0] + np.eye(2) * rng.uniform(5, 50)
    if kind == LINEAR:
        return Fills.linear(points[0], points[1], colors, positions)
    return Fills.radial(*points, colors, positions)


def random_drawing(rng: np.random.Generator, layers: int) -> Drawing:
    fills = concatenate_fills([random_fill(rng, int(rng.integers(0, 3))) for _ in range(layers)])
    points = rng.uniform(0, SIZE, (3 * layers, 3, 2))
    return Drawing(points=points, colors=rng.uniform(0, 1, (layers, 4)), size=(SIZE, SIZE), fills=fills)


@pytest.mark.parametrize("precision", [0, 3, 9])
@pytest.mark.parametrize("layers", ["inkscape", "plain"])
def test_read_back_equal(precision: int, layers: LayerStyle) -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        drawing = random_drawing(rng, 5)
        wanted, text = quantize(drawing, precision), format_svg(drawing, precision, layers)
        got = read_svg(text.encode())
        for name in FILLS:
            np.testing.assert_array_equal(getattr(got.fills, name), getattr(wanted.fills, name), err_msg=name)
        np.testing.assert_array_equal(got.points, wanted.points)
        np.testing.assert_array_equal(got.colors, wanted.colors)
        assert format_svg(got, precision, layers) == text
        again = quantize(wanted, precision)
        assert all(np.array_equal(getattr(again.fills, name), getattr(wanted.fills, name)) for name in FILLS)


@pytest.mark.parametrize("kind", [LINEAR, RADIAL])
@pytest.mark.parametrize(("renderer", "bound"), [("resvg", 3e-5), ("cairo", 1e-5)])
def test_shown_as_defined(kind: int, renderer: str, bound: float) -> None:
    """Colours at pixel centres by the definition of `Fills`; edges of colour are left out, which renderers sample."""
    rng = np.random.default_rng(2)
    centers = np.stack(np.meshgrid(*[np.arange(SIZE) + 0.5] * 2), axis=-1)
    errors = []
    while len(errors) < 20:
        fill = random_fill(rng, kind)
        size = abs(np.linalg.det(fill.geometry[0, 1:] - fill.geometry[0, 0])) if kind == RADIAL else 100.0
        if np.diff(fill.stop_positions).min() < 0.05 or size < 100:
            continue
        drawing = quantize(
            Drawing(points=cover(), colors=[[0, 0, 0, 1]], size=(SIZE, SIZE), background=None, fills=fill)
        )
        fill, origin = drawing.fills, drawing.fills.geometry[0, 0]
        if kind == LINEAR:
            along = fill.geometry[0, 1] - origin
            t = (centers - origin) @ along / (along @ along)
        else:
            axes = (fill.geometry[0, 1:] - origin).T
            t = np.linalg.norm((centers - origin) @ np.linalg.inv(axes).T, axis=-1)
        straight = stop_colors(np.column_stack([fill.stop_positions, fill.stop_colors]), t)
        wanted = np.concatenate([straight[..., :3] * straight[..., 3:], straight[..., 3:]], axis=-1)
        errors.append(np.square(shown_by(renderer, format_svg(drawing)) - wanted).mean())
    assert max(errors) < bound


def cover() -> NDArray[np.float64]:
    """Return the canvas's edge as rows (anchor, handle, handle)."""
    corners = np.array([[0, 0], [SIZE, 0], [SIZE, SIZE], [0, SIZE]], dtype=float)
    ends = np.roll(corners, -1, axis=0)
    return np.stack([corners, corners, ends], axis=1)


def shown_by(renderer: str, text: str) -> NDArray[np.float64]:
    """Return a renderer's picture in premultiplied RGBA: (H, W, 4)."""
    if renderer == "resvg":
        pytest.importorskip("resvg_py")
        return compare_svg.shown_by_resvg(text)
    cairosvg = pytest.importorskip("cairosvg")
    return compare_svg.premultiplied(livecl.read_image(io.BytesIO(cairosvg.svg2png(bytestring=text.encode()))))


def test_foreign_gradients_become_fills() -> None:
    stops = '<stop offset="0" stop-color="red"/><stop offset="1" stop-color="blue"/>'
    drawing = read_svg(
        document(
            f'<linearGradient id="a" x2=".5">{stops}</linearGradient><radialGradient id="b">{stops}</radialGradient>'
            '<rect x="10" width="40" height="20" fill="url(#a)"/><rect width="9" height="9" fill="lime"/>'
            '<circle cx="50" cy="60" r="20" fill="url(#b)"/>'
        )
    )
    assert drawing.fills.kinds.tolist() == [LINEAR, SOLID, RADIAL]
    np.testing.assert_array_equal(drawing.fills.geometry[0, :2], [[10, 0], [30, 0]])
    np.testing.assert_allclose(drawing.fills.geometry[2], [[50, 60], [70, 60], [50, 80]])
    np.testing.assert_array_equal(drawing.fills.stop_colors, [[1, 0, 0, 1], [0, 0, 1, 1]] * 2)


def test_gradients_that_reach_far_are_cut_to_the_shape() -> None:
    """From black at -1e7 px to white at 1e7: grey within the shape, by the colours where the shape's box ends."""
    stops = '<stop offset="0"/><stop offset="1" stop-color="white"/>'
    where = 'gradientUnits="userSpaceOnUse" x1="-1e7" x2="1e7"'
    rect = '<rect x="10" width="40" height="20" fill="url(#a)"/>'
    drawing = read_svg(document(f'<linearGradient id="a" {where}>{stops}</linearGradient>{rect}'))
    np.testing.assert_allclose(drawing.fills.geometry[0, :2], [[10, 10], [50, 10]])
    np.testing.assert_allclose(drawing.fills.stop_colors[:, 0], [0.5 + 10 / 2e7, 0.5 + 50 / 2e7])
    with pytest.warns(UserWarning, match=r"gradients too far away, read as one colour \(1, off by "):
        circle = f'<radialGradient id="a" gradientUnits="userSpaceOnUse" cx="2e6" r="3e6">{stops}</radialGradient>'
        assert not read_svg(document(circle + rect)).fills.any_gradients
