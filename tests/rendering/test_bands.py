# SPDX-License-Identifier: Apache-2.0
"""Canvases worked on in bands of strips: the same results in bounded memory."""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np
import pytest
from reference.rounding import UNIT, image_tolerance
from support import drawings
from support.runs import SMALL

from livecl import Options, Rasterizer, vectorize
from livecl.opencl.launcher import Launcher
from livecl.run import work

CASES = ["translucent", "holes", "across the canvas's borders", "tangles", "33x50"]


@pytest.mark.parametrize("name", CASES)
def test_bands_change_nothing_but_the_order_of_sums(name: str, device: int) -> None:
    case = drawings.CASES[name]()
    drawing, pieces = case.drawing, case.pieces
    rng = np.random.default_rng(0)
    channels = 3 if drawing.background is not None else 4
    target, weight = rng.uniform(size=(*drawing.size, channels)), rng.uniform(size=drawing.size)
    whole = Rasterizer(drawing.size, device)
    image = whole.forward(drawing, pieces)
    loss, gradients = whole.loss_and_gradients(drawing, target, weight, pieces)
    closeness = whole.distance_weight(drawing, pieces=pieces)
    num_pixels = drawing.size[0] * drawing.size[1]
    for max_tiles in (1, 11):
        banded = Rasterizer(drawing.size, device, max_tiles=max_tiles)
        assert np.array_equal(banded.forward(drawing, pieces), image)
        banded_loss, banded_gradients = banded.loss_and_gradients(drawing, target, weight, pieces)
        assert banded_loss == pytest.approx(loss, rel=num_pixels * UNIT)
        for found, expected in [
            (banded_gradients.points, gradients.points),
            (banded_gradients.colors, gradients.colors),
            (banded_gradients.background, gradients.background),
        ]:
            if expected is not None:
                np.testing.assert_allclose(found, expected, rtol=0, atol=num_pixels * UNIT * np.abs(expected).max())
        np.testing.assert_allclose(
            banded.distance_weight(drawing, pieces=pieces), closeness, rtol=num_pixels * UNIT, atol=0
        )
        again = banded.backward(np.ones_like(image))
        assert np.isfinite(again.points).all()
    assert np.all(np.abs(image) <= 1 + image_tolerance(drawing, pieces))


def test_memory_is_bounded_by_the_tiles_of_a_band(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: dict[str, int] = {}
    reserve = Launcher.reserve

    def recording(self: Launcher, wanted: Mapping[str, int]) -> None:
        for name, num_bytes in wanted.items():
            sizes[name] = max(sizes.get(name, 0), num_bytes)
        reserve(self, wanted)

    monkeypatch.setattr(Launcher, "reserve", recording)
    covers = [([drawings.rectangle(-1, -1, 200, 200)], (*color, 0.5)) for color in np.eye(3)] * 20
    drawing = drawings.build(covers, (96, 80))
    target, weight = np.zeros((96, 80, 3)), np.ones((96, 80))
    strip = 60 * 10  # tiles of 60 layers in a strip of 80 px
    largest = {}
    for max_tiles in (1, 3 * strip, 1 << 17):
        sizes.clear()
        rasterizer = Rasterizer((96, 80), device, max_tiles=max_tiles)
        rasterizer.distance_weight(drawing)
        rasterizer.loss_and_gradients(drawing, target, weight)
        rasterizer.coverages(drawing)
        largest[max_tiles] = {name: sizes[name] for name in ("cells", "distances", "d_tiles", "planes")}
    tile, number = 8 * 32, 4  # bytes: 8 columns of a strip of 8 rows in single precision; an integer or a number
    sums = (60 * 12 + 60) * number  # of each span and layer
    canvas = 4 * 12 * 10 * number  # loss and gradient of the background, of each tile
    for max_tiles, num_strips in ((1, 1), (3 * strip, 3), (1 << 17, 12)):
        assert largest[max_tiles]["cells"] == num_strips * strip * (2 * tile + number)
        assert largest[max_tiles]["distances"] == num_strips * strip * (tile + number) + sums
        assert largest[max_tiles]["d_tiles"] == num_strips * strip * 4 * number + canvas
    plane = 12 * 10 * tile
    assert [bands["planes"] for bands in largest.values()] == [plane, 3 * strip // 120 * plane, 60 * plane]


@pytest.mark.parametrize("options", [Options.paper(iterations=4), Options(iterations=4, revisions=1)])
def test_the_loop_is_the_same_in_bands(options: Options, device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = vectorize(SMALL, schedule=[1, 2], options=options, device=device)
    monkeypatch.setattr(work, "Rasterizer", functools.partial(Rasterizer, max_tiles=2))
    banded = vectorize(SMALL, schedule=[1, 2], options=options, device=device)
    assert banded.drawing.num_layers == whole.drawing.num_layers
    # Sums of gradients in another order, which a few steps of Adam do not yet make more of.
    np.testing.assert_allclose(banded.drawing.points, whole.drawing.points, atol=0.01)
    np.testing.assert_allclose(banded.drawing.colors, whole.drawing.colors, atol=1.01 / 255)
    assert banded.mse == pytest.approx(whole.mse, rel=0.01)
