# SPDX-License-Identifier: Apache-2.0
"""Choice of fills: gradients are found again from their pictures, and flat layers stay flat."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from support.shapes import rectangle

import livecl
from livecl import Options
from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills
from livecl.drawing.fills import concatenate_fills
from livecl.layering.context import Context
from livecl.layering.fills.choice import shaded, shading_of
from livecl.layering.fills.ramps import LAYER_NUMBERS, Shading
from livecl.rendering.rasterizer import Rasterizer

COLORS = [(0.9, 0.2, 0.1, 1), (0.1, 0.3, 0.8, 1)]


def _square(fills: Fills | None) -> Drawing:
    return Drawing.from_outlines([[rectangle(4, 6, 36, 30)]], (0.4, 0.5, 0.6, 1), (36, 40), fills=fills)


def _wanted(fills: Fills | None, device: int) -> tuple[Context, Drawing]:
    """Return the context of a picture of a square, and the square in one colour."""
    drawing = _square(fills)
    return Context(Rasterizer(drawing.size, device), livecl.render(drawing, device), Options(fills="auto")), _square(
        None
    )


@pytest.mark.parametrize(
    ("fills", "kind"),
    [
        (Fills.linear((0, 0), (45, 30), COLORS), LINEAR),
        (Fills.radial((15, 12), (45, 12), (15, 42), COLORS), RADIAL),
        (None, SOLID),
    ],
    ids=["linear", "radial", "solid"],
)
def test_a_fill_is_found_from_its_picture(fills: Fills | None, kind: int, device: int) -> None:
    context, square = _wanted(fills, device)
    shade = shaded(context, square, np.ones(1, bool))
    assert shade.fills.kinds.tolist() == [kind]
    # What is left may be worth another stop at the most, and the rim of the square that no fit looks at.
    assert context.mse(shade) < LAYER_NUMBERS * shading_price(context)
    assert not shaded(context, square, np.zeros(1, bool)).fills.any_gradients
    assert shaded(context, shade, np.ones(1, bool)) is shade


def shading_price(context: Context) -> float:
    shading = shading_of(context.options)
    assert shading is not None
    pixels = context.target[..., 0].size
    return shading.price_in(pixels) / (3 * pixels)


def test_a_gradient_on_a_flat_layer_goes_back_to_one_colour(device: int) -> None:
    context, square = _wanted(None, device)
    slight = Fills.linear((0, 0), (45, 30), [(0.4, 0.5, 0.6, 1), (0.41, 0.5, 0.6, 1)])
    assert shaded(context, square.replace(fills=slight), np.ones(1, bool)).fills.kinds.tolist() == [SOLID]


def test_no_gradient_is_drawn_across_flat_colours(device: int) -> None:
    halves = [[rectangle(4, 6, 20, 30)], [rectangle(20, 6, 36, 30)]]
    drawing = Drawing.from_outlines(halves, COLORS, (36, 40))
    context = Context(Rasterizer(drawing.size, device), livecl.render(drawing, device), Options(fills="auto"))
    assert shaded(context, _square(None), np.ones(1, bool)).fills.kinds.tolist() == [SOLID]


def test_no_gradient_is_drawn_across_small_flat_spots(device: int) -> None:
    """Most of their pixels are beside an edge, which is neither flat nor a drift."""
    spots = [[rectangle(x, y, x + 5, y + 5)] for y in (4, 12, 20) for x in (4, 12, 20)]
    drawing = Drawing.from_outlines(spots, [COLORS[k % 2] for k in range(9)], (36, 40))
    context = Context(Rasterizer(drawing.size, device), livecl.render(drawing, device), Options())
    joined = Drawing.from_outlines([[spot for (spot,) in spots]], (0.4, 0.5, 0.6, 1), (36, 40))
    assert shaded(context, joined, np.ones(1, bool)).fills.kinds.tolist() == [SOLID]


def test_noise_may_have_a_gradient(device: int) -> None:
    """Noisy slopes have no smooth pixels; flat ones stay flat for the error alone."""
    noise = 0.03 * np.random.default_rng(0).standard_normal((36, 40, 3))
    for fills, kind in ((Fills.linear((0, 0), (45, 30), COLORS), LINEAR), (None, SOLID)):
        context, square = _wanted(fills, device)
        noisy = dataclasses.replace(context, target=(context.target + noise).astype(np.float32))
        assert shaded(noisy, square, np.ones(1, bool)).fills.kinds.tolist() == [kind]


def test_numbers_cost_no_less_on_small_pictures() -> None:
    shading = Shading(("linear",), 1e-7)
    assert shading.price_in(48 * 48) == shading.price_in(240 * 240) == pytest.approx(3e-7 * 57600)
    assert shading.price_in(480 * 240) == pytest.approx(6e-7 * 57600)


def test_a_fill_that_raises_the_error_is_not_taken(device: int) -> None:
    """Most of the layer lies below a translucent one, where the gradient of its own pixels is wrong."""
    ground, bright, clear = (0.3, 0.5, 0.6, 1), (0.9, 0.5, 0.6, 1), (0.3, 0.5, 0.6, 0.5)
    outlines = [[rectangle(4, 6, 60, 30)], [rectangle(16, 6, 60, 30)]]
    fills = concatenate_fills([Fills.linear((4, 0), (16, 0), [ground, bright]), Fills.solid(1)])
    picture = Drawing.from_outlines(outlines, [ground, ground], (36, 64), fills=fills)
    context = Context(Rasterizer(picture.size, device), livecl.render(picture, device), Options())
    over = Drawing.from_outlines(outlines, [ground, clear], (36, 64))
    assert shaded(context, over, np.array([True, False])) is over
    alone = over.layer_subset([0])
    context = dataclasses.replace(context, target=livecl.render(picture.layer_subset([0]), device))
    assert shaded(context, alone, np.array([True])).fills.kinds.tolist() == [LINEAR]


def test_fills_that_make_up_for_each_other_are_taken_together(device: int) -> None:
    """Of two layers that lie side by side and both want a gradient, both get one."""
    halves = [[rectangle(4, 6, 20, 30)], [rectangle(20, 6, 36, 30)]]
    fills = concatenate_fills([Fills.linear((4, 0), (20, 0), COLORS), Fills.linear((0, 6), (0, 30), COLORS)])
    picture = Drawing.from_outlines(halves, COLORS, (36, 40), fills=fills)
    context = Context(Rasterizer(picture.size, device), livecl.render(picture, device), Options())
    flat = Drawing.from_outlines(halves, COLORS, (36, 40))
    assert shaded(context, flat, np.ones(2, bool)).fills.kinds.tolist() == [LINEAR, LINEAR]


def test_a_translucent_layer_keeps_its_opacity(device: int) -> None:
    clear = [(*color[:3], 0.5) for color in COLORS]
    context, square = _wanted(Fills.linear((0, 0), (45, 30), clear), device)
    shade = shaded(context, square.replace(colors=[(0.4, 0.5, 0.6, 0.5)]), np.ones(1, bool))
    np.testing.assert_allclose(shade.fills.stop_colors[:, 3], 0.5)
    assert context.mse(shade) < LAYER_NUMBERS * shading_price(context)


def test_a_layer_over_nothing_gets_the_alpha_of_the_picture(device: int) -> None:
    fade = Fills.linear((4, 0), (36, 0), [(*COLORS[0][:3], 0.95), (*COLORS[0][:3], 0.1)])
    drawing = _square(fade).replace(background=None)
    context = Context(Rasterizer(drawing.size, device), livecl.render(drawing, device), Options(fills="auto"))
    shade = shaded(context, _square(None).replace(background=None), np.ones(1, bool))
    assert shade.fills.kinds.tolist() == [LINEAR]
    assert context.mse(shade) < LAYER_NUMBERS * shading_price(context)


def test_opaque_layers_have_stops_of_one_opacity(device: int) -> None:
    """Over nothing, the alpha of the picture falls from 0.95 to 0.1; training keeps it as it is in each stop."""
    fade = Fills.linear((4, 0), (36, 0), [(*COLORS[0][:3], 0.95), (*COLORS[1][:3], 0.1)])
    drawing = _square(fade).replace(background=None)
    options = Options(fills="auto", opacity="opaque")
    context = Context(Rasterizer(drawing.size, device), livecl.render(drawing, device), options)
    shade = shaded(context, _square(None).replace(background=None), np.ones(1, bool))
    assert shade.fills.any_gradients
    assert len(np.unique(shade.fills.stop_colors[:, 3])) == 1
    assert len(np.unique(shade.fills.stop_colors[:, 0])) > 1


def test_a_number_costs_a_share_of_a_layer() -> None:
    assert shading_of(Options(fills="solid")) is None
    assert shading_of(Options(colors=4)) is None and shading_of(Options(palette="lime")) is None
    dear, cheap = shading_of(Options(fills="linear", prune=2e-4)), shading_of(Options(fills="auto", prune=1e-6))
    assert dear is not None and cheap is not None
    assert dear.price == pytest.approx(200 * cheap.price)
    assert (dear.kinds, cheap.kinds) == (("linear",), ("linear", "radial"))


def test_runs_find_gradients_where_they_are_asked_for(device: int) -> None:
    target = livecl.render(_square(Fills.linear((0, 0), (45, 30), COLORS)), device)
    errors = {}
    for fills in ("solid", "auto", "linear"):
        options = livecl.Options(fills=fills, iterations=30, revisions=1)
        result = livecl.vectorize(target, paths=1, options=options, device=device)
        errors[fills] = result.mse
        assert result.drawing.fills.any_gradients == (fills != "solid")
    assert max(errors["auto"], errors["linear"]) < errors["solid"] / 5
