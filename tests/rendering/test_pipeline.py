# SPDX-License-Identifier: Apache-2.0
"""Pipeline: losses under the distance weight and under weights that leave most pixels out, whole and in bands."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RasterizerFor
from reference.composite import squared_error
from support import drawings

from livecl.opencl.device import OpenDevice
from livecl.rendering.pipeline import DistanceWeight
from livecl.rendering.rasterizer import Gradients, Rasterizer

CASES = {**drawings.CASES, **drawings.CROWDS}
EPSILON = np.finfo(np.float64).eps


def _target(case: drawings.Case) -> np.ndarray:
    channels = 4 if case.drawing.background is None else 3
    return np.random.default_rng(3).uniform(size=(*case.drawing.size, channels))


def _assert_close(found: Gradients, expected: Gradients, num_terms: int) -> None:
    """Gradients are sums over pixels in the same order, of terms that are off by some roundings each."""
    for name in ("points", "colors", "background"):
        wanted = getattr(expected, name)
        if wanted is None:
            assert getattr(found, name) is None
        else:
            scale = np.abs(wanted).max(initial=0)
            np.testing.assert_allclose(getattr(found, name), wanted, rtol=0, atol=num_terms * EPSILON * scale)


@pytest.mark.parametrize("name", CASES)
def test_distance_weight_found_on_the_way_is_that_of_the_image(rasterizer_for: RasterizerFor, name: str) -> None:
    case = CASES[name]()
    drawing, target, num_pixels = case.drawing, _target(case), case.drawing.size[0] * case.drawing.size[1]
    rasterizer = rasterizer_for(drawing.size, np.float64)
    weight = DistanceWeight(4.0, np.maximum(case.pieces // 2, 1))
    image = rasterizer.distance_weight(drawing, weight.tau, weight.pieces)
    expected_loss, expected = rasterizer.loss_and_gradients(drawing, target, image, case.pieces, scale=1 / 3)
    loss, found = rasterizer.loss_and_gradients(drawing, target, weight, case.pieces, scale=1 / 3)
    assert loss == pytest.approx(expected_loss, rel=num_pixels * EPSILON)
    _assert_close(found, expected, num_pixels)


def test_distance_weight_in_bands(device: int) -> None:
    case = drawings.CASES["33x50"]()
    drawing, target, weight = case.drawing, _target(case), DistanceWeight(6.0, case.pieces)
    num_pixels = drawing.size[0] * drawing.size[1]
    expected_loss, expected = Rasterizer(drawing.size, device, np.float64).loss_and_gradients(
        drawing, target, weight, case.pieces
    )
    banded = Rasterizer(drawing.size, device, np.float64, max_tiles=11)
    for _ in range(2):
        loss, found = banded.loss_and_gradients(drawing, target, weight, case.pieces)
        assert loss == pytest.approx(expected_loss, rel=num_pixels * EPSILON)
        _assert_close(found, expected, num_pixels)


@pytest.mark.parametrize("name", ["translucent", "holes", "rgba", "hidden below opaque", *drawings.CROWDS])
def test_pixels_without_weight_have_no_say(rasterizer_for: RasterizerFor, name: str) -> None:
    case = CASES[name]()
    drawing, target, num_pixels = case.drawing, _target(case), case.drawing.size[0] * case.drawing.size[1]
    rasterizer = rasterizer_for(drawing.size, np.float64)
    weight = np.zeros(drawing.size)
    weight[5:8, 6:15] = np.random.default_rng(4).uniform(size=(3, 9))
    image = rasterizer.forward(drawing, pieces=case.pieces)
    error, d_error = squared_error(image, target)
    expected = rasterizer.backward(weight[..., None] * d_error)  # leaves gradients of all tiles behind
    rasterizer.loss_and_gradients(drawing, target, np.ones(drawing.size), case.pieces)
    loss, found = rasterizer.loss_and_gradients(drawing, target, weight, case.pieces)
    assert loss == pytest.approx(np.sum(weight * error), rel=num_pixels * EPSILON)
    _assert_close(found, expected, num_pixels)
    assert rasterizer.loss_and_gradients(drawing, target, 0 * weight, case.pieces)[0] == 0


@pytest.mark.parametrize("tau", [0.0, float("nan"), float("inf")])
def test_wrong_tau(tau: float) -> None:
    with pytest.raises(ValueError, match=r"tau: got .*, wanted a positive number"):
        DistanceWeight(tau)


def test_work_groups_and_copies_as_for_a_gpu(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    case = drawings.CASES["33x50"]()
    target, weight = _target(case), DistanceWeight(6.0, case.pieces)
    expected_loss, expected = Rasterizer(case.drawing.size, device).loss_and_gradients(
        case.drawing, target, weight, case.pieces
    )
    monkeypatch.setattr(OpenDevice, "is_cpu", property(lambda self: False))
    rasterizer = Rasterizer(case.drawing.size, device)
    moved = case.drawing.moved(case.drawing.points + 1, case.drawing.colors, case.drawing.background)
    for drawing in (moved, case.drawing):
        loss, found = rasterizer.loss_and_gradients(drawing, target, weight, case.pieces)
    assert loss == expected_loss
    for name in ("points", "colors", "background"):
        assert np.array_equal(getattr(found, name), getattr(expected, name))
