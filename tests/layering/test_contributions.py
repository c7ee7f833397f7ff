# SPDX-License-Identifier: Apache-2.0
"""Shares of layers in the picture, and what taking one away changes, against rendered pictures."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from support import drawings, shapes
from support.drawings import rectangle

from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.image.errors import mse
from livecl.layering.contributions import composited_colors, layer_alphas, removal_changes, visible_shares
from livecl.layering.stack import LayerStack
from livecl.rendering.rasterizer import Rasterizer
from livecl.rendering.single import render

SIZE = (12, 16)
EPS = float(np.finfo(np.float32).eps)
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)


def drawn(*layers: tuple[shapes.Path, ArrayLike], background: ArrayLike | None = (1.0, 1.0, 1.0)) -> Drawing:
    return drawings.build([([path], color) for path, color in layers], SIZE, background)


def opacity(color: tuple[float, ...], alpha: float) -> tuple[float, ...]:
    return (*color[:3], alpha)


def shaded_fills(count: int) -> Fills:
    """Return translucent gradients across 20 x 20 px for some layers: linear and radial in turn."""
    ends = [[(0.9, 0.1, 0.2, 0.4), (0.1, 0.8, 0.3, 0.9)], [(0.2, 0.2, 0.9, 0.8), (0.9, 0.9, 0.1, 0.3)]]
    linear, radial = Fills.linear((2, 3), (17, 12), ends[0]), Fills.radial((9, 8), (19, 9), (8, 15), ends[1])
    return concatenate_fills([(linear, radial)[layer % 2] for layer in range(count)])


def test_shares_of_stacked_glass() -> None:
    drawing = drawn((rectangle(0, 0, 8, 12), opacity(RED, 0.5)), (rectangle(4, 0, 16, 12), opacity(BLUE, 0.75)))
    shares = visible_shares(layer_alphas(drawing))
    assert shares[:, 0, 2] == pytest.approx([0.5, 0])
    assert shares[:, 0, 6] == pytest.approx([0.5 * 0.25, 0.75])
    assert shares[:, 0, 12] == pytest.approx([0, 0.75])


def test_shares_make_up_the_picture() -> None:
    drawing = drawings.CASES["translucent"]().drawing
    shares = visible_shares(layer_alphas(drawing))
    rest = 1 - shares.sum(axis=0)
    image = np.einsum("nhw,nc->hwc", shares, drawing.colors[:, :3]) + rest[..., None] * drawing.background
    # Sums of at most 10 terms of size 1 in single precision, made in two orders.
    assert image == pytest.approx(render(drawing), abs=20 * EPS)


@pytest.mark.parametrize("background", [(0.4, 0.8, 0.6), None])
@pytest.mark.parametrize("gradients", [False, True])
def test_removal_changes_are_those_of_the_rendered_pictures(gradients: bool, background: ArrayLike | None) -> None:
    drawing = drawings.CASES["tangles"]().drawing.replace(background=background)
    if gradients:
        drawing = drawing.replace(fills=shaded_fills(drawing.num_layers))
    target = np.random.default_rng(0).uniform(size=(*drawing.size, 3 if background else 4))
    found = removal_changes(drawing, layer_alphas(drawing), target)
    layers = np.arange(drawing.num_layers)
    error = mse(render(drawing), target)
    without = [mse(render(drawing.layer_subset(layers != layer)), target) for layer in layers]
    # Means of squares of float32 colours, each off by a few eps.
    assert found == pytest.approx(np.array(without) - error, abs=20 * EPS)
    assert len(found) > 1


@pytest.mark.parametrize("background", [(0.4, 0.8, 0.6), None])
def test_a_stack_of_gradients_is_the_rendered_picture(background: ArrayLike | None) -> None:
    drawing = drawings.CASES["tangles"]().drawing.replace(background=background)
    drawing = drawing.replace(fills=shaded_fills(drawing.num_layers))
    ground, colors = composited_colors(drawing)
    image = render(drawing)
    stack = LayerStack(ground, layer_alphas(drawing), colors, image)
    # Each layer composites float32 colours once, off by a few eps.
    np.testing.assert_allclose(stack.image, image, atol=4 * drawing.num_layers * EPS)


def test_removal_changes_of_hidden_and_outside_layers_are_zero() -> None:
    drawing = drawn(
        (rectangle(4, 4, 8, 8), BLUE),
        (rectangle(2, 2, 10, 10), RED),
        (rectangle(-9, -9, -2, -2), RED),
        (rectangle(20, 2, 30, 9), RED),
    )
    changes = removal_changes(drawing, layer_alphas(drawing), render(drawing))
    assert changes[[0, 2, 3]] == pytest.approx(0, abs=1e-12)
    assert changes[1] > 0.1


@pytest.mark.parametrize("background", [(1.0, 1.0, 1.0), None])
def test_gradients_that_are_looked_at_where_layers_cover_are_as_elsewhere(background: ArrayLike | None) -> None:
    drawing = drawn((rectangle(2, 1, 8, 11), RED), (rectangle(4, 3, 13, 9), BLUE), background=background)
    drawing = drawing.replace(fills=shaded_fills(2))
    everywhere, covered = composited_colors(drawing)[1], composited_colors(drawing, covered=True)[1]
    coverages = Rasterizer(SIZE).coverages(drawing)
    for layer, (whole, part, coverage) in enumerate(zip(everywhere, covered, coverages, strict=True)):
        assert (part[coverage > 0] == whole[coverage > 0]).all() and not part[0, 0, :3].any()
        opacities = drawing.fills.colors_at(layer, np.argwhere(coverage > 0)[:, ::-1] + 0.5)[:, 3]
        assert layer_alphas(drawing)[layer][coverage > 0] == pytest.approx(opacities * coverage[coverage > 0], rel=EPS)


def test_one_opacity_of_all_stops_is_that_of_the_gradient() -> None:
    ends = [(0.9, 0.1, 0.2, 0.4), (0.1, 0.8, 0.3, 0.4)]
    drawing = drawn((rectangle(2, 1, 8, 11), RED)).replace(fills=Fills.linear((2, 3), (17, 12), ends))
    assert drawing.fills.opacity(0) == 0.4 and shaded_fills(1).opacity(0) is None
    assert layer_alphas(drawing)[0] == pytest.approx(Rasterizer(SIZE).coverages(drawing)[0] * np.float32(0.4))
