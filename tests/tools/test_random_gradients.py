# SPDX-License-Identifier: Apache-2.0
"""Gradients of random drawings of every kind (tools/check_gradients.py)."""

from __future__ import annotations

import check_gradients
import numpy as np
import pytest
from gradient_checks.comparisons import Comparer
from gradient_checks.findings import Finding, table
from gradient_checks.scenes import random_scene
from reference.rounding import points_rounding, share_of_kinks

from livecl.opencl.device import open_device


def _check(device: int, drawings: int, by_differences: int) -> None:
    if not open_device(device).device.double_fp_config:
        pytest.skip("the device has no double precision")
    comparer = Comparer(0, device)
    findings = [finding for index in range(drawings) for finding in comparer.single_with_double(index)]
    findings += [finding for index in range(by_differences) for finding in comparer.double_with_differences(index)]
    wrong = [check_gradients.describe(finding, 0) for finding in findings if not finding.of_allowed <= 1]
    assert not wrong, "\n".join([table(findings), *wrong])


@pytest.mark.slow
def test_random_drawings(device: int) -> None:
    _check(device, drawings=120, by_differences=10)


@pytest.mark.full
def test_ten_thousand_random_drawings(device: int) -> None:
    _check(device, drawings=10_000, by_differences=600)


def test_a_scene_does_not_depend_on_those_before() -> None:
    scene, again = random_scene(3, 40), random_scene(3, 40)
    assert scene.case.drawing.points.tobytes() == again.case.drawing.points.tobytes()
    assert random_scene(3, 41).case.drawing.points.tobytes() != scene.case.drawing.points.tobytes()
    assert random_scene(4, 40).case.drawing.points.tobytes() != scene.case.drawing.points.tobytes()


def test_scenes_are_of_all_kinds() -> None:
    scenes = [random_scene(0, index) for index in range(300)]
    assert {kind for scene in scenes for kind in scene.kinds} >= {"blob", "tiny", "large", "tangle", "on borders"}
    assert {scene.case.drawing.background is None for scene in scenes} == {False, True}
    opacities = np.concatenate([scene.case.drawing.colors[:, 3] for scene in scenes])
    assert {0.0, 1.0} < set(opacities)
    assert max(scene.case.drawing.num_layers for scene in scenes) > 32


def test_an_error_is_found() -> None:
    # A hundredth of the gradient's norm off in one number: neither rounding nor a kink explains it.
    scene = random_scene(0, 0)
    drawing, pieces = scene.case.drawing, scene.case.pieces
    d_image = np.random.default_rng(0).normal(size=(*drawing.size, 3))
    exact = np.random.default_rng(1).normal(size=drawing.points.shape)
    rounding = points_rounding(drawing, pieces, d_image)[drawing.segment_layers][:, None, None]
    found = exact.copy()
    found[0, 0, 0] += 0.01 * np.linalg.norm(exact)
    finding = Finding.of(0, "d_points", found, exact, rounding)
    assert finding.of_allowed > 1
    assert finding.relative == pytest.approx(0.01)
    assert not Finding.of(0, "d_points", np.full(3, np.nan), np.ones(3), 1.0).of_allowed <= 1
    assert Finding.of(0, "d_points", np.zeros(3), np.zeros(3), 0.0).of_allowed == 0


def test_the_share_of_kinks_is_what_a_flip_would_change() -> None:
    # On random drawings the band is empty for nearly all layers, and the whole outline counts where it is all there is.
    scene = random_scene(0, 1)
    drawing, pieces = scene.case.drawing, scene.case.pieces
    d_image = np.ones((*drawing.size, 4 if drawing.background is None else 3))
    none = share_of_kinks(drawing, pieces, d_image, np.full(drawing.num_layers, -1.0))
    everything = share_of_kinks(drawing, pieces, d_image, np.full(drawing.num_layers, np.inf))
    assert not none.any()
    assert np.all(everything >= none)
    assert everything.any()


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert check_gradients.main(["--drawings", "2", "--differences", "1", "--worst", "1"]) == 0
    printed = capsys.readouterr().out
    assert "2 drawings of seed 0, 1 by differences" in printed
    assert "| image |" in printed
    with pytest.raises(SystemExit) as exited:
        check_gradients.main(["--drawings", "0"])
    assert exited.value.code == 2
