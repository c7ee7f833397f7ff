# SPDX-License-Identifier: Apache-2.0
"""The float build against the double build, and the double build against central differences.

Losses and tolerances are those of the tests (tests/test_gradients.py, tests/reference/rounding.py).
"""

from __future__ import annotations

import numpy as np
from reference import differences
from reference.composite import squared_error
from reference.fill_rounding import fills_tolerances
from reference.places import same_numbers
from reference.rounding import (
    SNAP,
    colors_tolerance,
    coverage_tolerance,
    image_tolerance,
    points_rounding,
    share_of_kinks,
    share_of_snapped,
)
from support.case_losses import Losses

from gradient_checks.fills import FILL_PARTS, fill_differences
from gradient_checks.findings import ENTRIES, LOSSES, RELATIVE, Finding, FloatArray, least
from gradient_checks.scenes import Scene, random_scene
from livecl.rendering.rasterizer import Rasterizer


class Comparer:
    """Compares the gradients of random drawings, with rasterizers that are built once for each size.

    Parameters
    ----------
    seed : int
        Seed of the drawings.
    device : int, str or None
        OpenCL device; it must have double precision.
    fills : bool
        Whether the drawings have gradient fills.
    """

    def __init__(self, seed: int, device: int | str | None = None, fills: bool = False) -> None:
        self.seed, self.device, self.fills = seed, device, fills
        self._rasterizers: dict[tuple[tuple[int, int], type], Rasterizer] = {}

    def _losses(self, scene: Scene, dtype: type) -> Losses:
        key = scene.case.drawing.size, dtype
        if key not in self._rasterizers:
            self._rasterizers[key] = Rasterizer(key[0], device=self.device, dtype=dtype)
        return Losses(self._rasterizers[key], scene.case)

    def single_with_double(self, index: int) -> list[Finding]:
        """Return the differences of image and gradients between the float and the double build."""
        with same_numbers():
            return self._single_with_double(index)

    def _single_with_double(self, index: int) -> list[Finding]:
        scene = random_scene(self.seed, index, self.fills)
        drawing, pieces = scene.case.drawing, scene.case.pieces
        single, double = self._losses(scene, np.float32), self._losses(scene, np.float64)
        image, allowed = double.rasterizer.forward(drawing, pieces), image_tolerance(drawing, pieces)
        rendered = single.rasterizer.forward(drawing, pieces)
        finding = Finding.of(index, "image", rendered, image, allowed)
        if finding.of_rounding > 1:  # only then, as it takes long
            finding = Finding.of(index, "image", rendered, image, allowed, share_of_snapped(drawing, pieces))
        findings = [finding]
        # The quadratic loss's own d_image is linear in the image: 2 weight (image - target) over a background, and
        # without one up to 6 weight times an error that all four channels have.
        factor = 2 if image.shape[2] == 3 else 6
        d_error = single.weight[..., None] * squared_error(image, single.target)[1]
        d_images = single.d_image, d_error + factor / 2 * allowed * np.sign(d_error)
        gradients = single.gradients(), double.gradients()
        for loss, d_image, found, exact in zip(LOSSES, d_images, *gradients, strict=True):
            layers, what = drawing.segment_layers, f"d_points, {loss}"
            rounding = points_rounding(drawing, pieces, d_image)[layers][:, None, None]
            finding = Finding.of(index, what, found.points, exact.points, rounding)
            if finding.of_rounding > 1:
                kinks = self._kinks(scene, d_image)[layers][:, None, None]
                finding = Finding.of(index, what, found.points, exact.points, rounding, kinks)
            findings.append(finding)
            tolerance = colors_tolerance(drawing, pieces, d_image)
            findings.append(Finding.of(index, f"d_colors, {loss}", found.colors, exact.colors, tolerance))
            if exact.background is not None and found.background is not None:
                findings.append(
                    Finding.of(index, f"d_background, {loss}", found.background, exact.background, tolerance)
                )
            if exact.fills is not None and found.fills is not None:
                variance, doubt = fills_tolerances(drawing, pieces, d_image)
                for part in FILL_PARTS:
                    numbers = (getattr(fills, part) for fills in (found.fills, exact.fills, variance, doubt))
                    findings.append(Finding.of(index, f"d_{part}, {loss}", *numbers))
        return findings

    @staticmethod
    def _kinks(scene: Scene, d_image: FloatArray) -> FloatArray:
        drawing, pieces = scene.case.drawing, scene.case.pieces
        shares = share_of_kinks(drawing, pieces, d_image, SNAP + coverage_tolerance(drawing, pieces))
        return np.where(scene.on_borders, 0.0, shares)

    def double_with_differences(self, index: int) -> list[Finding]:
        """Return the differences of some entries of the double build's gradients from central differences."""
        scene = random_scene(self.seed, index, self.fills)
        drawing = scene.case.drawing
        losses, rng = self._losses(scene, np.float64), np.random.default_rng([self.seed, index, 1])
        points = rng.choice(drawing.points.size, min(ENTRIES, drawing.points.size), replace=False)
        colors = rng.choice(drawing.colors.size, min(ENTRIES, drawing.colors.size), replace=False)
        by_points = differences.by_small_steps(lambda x: losses(points=x), drawing.points, points.tolist())
        by_colors = differences.of_quadratic(lambda x: losses(colors=x), drawing.colors, colors.tolist())
        image = losses.rasterizer.forward(drawing, scene.case.pieces)
        d_images = losses.d_image, losses.weight[..., None] * squared_error(image, losses.target)[1]
        findings = []
        for k, (loss, gradients) in enumerate(zip(LOSSES, losses.gradients(), strict=True)):
            what = f"differences: d_points, {loss}"
            norm = max(float(np.linalg.norm(gradients.points)), least(d_images[k]))
            found = gradients.points.ravel()[points]
            finding = Finding.of(index, what, found, by_points[k], RELATIVE * norm, norm=norm)
            if finding.of_rounding > 1:
                # A step of a control point moves A by up to its length times the outline in the pixel, some px.
                band = np.where(scene.on_borders, -1.0, 10 * differences.STEP)
                kinks = share_of_kinks(drawing, scene.case.pieces, d_images[k], band)
                allowed = kinks[drawing.segment_layers[points // 6]]
                finding = Finding.of(index, what, found, by_points[k], RELATIVE * norm, allowed, norm=norm)
            findings.append(finding)
            norm = max(float(np.linalg.norm(gradients.colors)), least(d_images[k]))
            found = gradients.colors.ravel()[colors]
            what = f"differences: d_colors, {loss}"
            findings.append(Finding.of(index, what, found, by_colors[k], RELATIVE * norm, norm=norm))
        return findings + (fill_differences(index, losses, rng) if drawing.fills.any_gradients else [])
