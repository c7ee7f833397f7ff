# SPDX-License-Identifier: Apache-2.0
"""Choice of fills: gradients are found again from their pictures, and flat layers stay flat."""

from __future__ import annotations

import numpy as np
import pytest
from support.shapes import rectangle

import livecl
from livecl import Options
from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills
from livecl.layering.context import Context
from livecl.layering.fills import best_fill, shaded
from livecl.rendering.rasterizer import Rasterizer

COLORS = [(0.9, 0.2, 0.1, 1), (0.1, 0.3, 0.8, 1)]


def _square(fills: Fills | None) -> Drawing:
    return Drawing.from_outlines([[rectangle(4, 6, 36, 30)]], (0.4, 0.5, 0.6, 1), (36, 40), fills=fills)


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
    drawing = _square(fills)
    target = livecl.render(drawing, device)
    weight = np.zeros(drawing.size)
    weight[6:30, 4:36] = 1
    found = {fitted.kind: fitted.error / weight.sum() for fitted in best_fill(target, weight)}
    assert found[kind] < 1e-4, "the centre of a radial gradient is found to a fraction of a pixel"
    rasterizer = Rasterizer(drawing.size, device)
    context = Context(rasterizer, target, Options())
    shade = shaded(context, _square(None), ["linear", "radial"], np.ones(1, bool))
    assert shade.fills.kinds.tolist() == [kind]
    assert np.mean((rasterizer.forward(shade) - target) ** 2) < 1e-4
    held = shaded(context, _square(None), ["linear", "radial"], np.zeros(1, bool))
    assert not held.fills.any_gradients


def test_runs_find_gradients_where_they_are_asked_for(device: int) -> None:
    target = livecl.render(_square(Fills.linear((0, 0), (45, 30), COLORS)), device)
    errors = {}
    for fills in ("solid", "auto", "linear"):
        options = livecl.Options(fills=fills, iterations=30, revisions=1)
        result = livecl.vectorize(target, paths=1, options=options, device=device)
        errors[fills] = result.mse
        assert result.drawing.fills.any_gradients == (fills != "solid")
    assert max(errors["auto"], errors["linear"]) < errors["solid"]
