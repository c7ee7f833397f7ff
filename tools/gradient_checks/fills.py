# SPDX-License-Identifier: Apache-2.0
"""Gradients of stops and geometry of the double build against central differences."""

from __future__ import annotations

import numpy as np
from reference import differences
from reference.composite import squared_error
from reference.fill_rounding import fills_tolerances
from support.case_losses import Losses

from gradient_checks.findings import ENTRIES, LOSSES, RELATIVE, Finding, least
from livecl.drawing import LINEAR, SOLID, Fills
from livecl.rendering.fills import place_maps

#: Parts of the gradients of fills.
FILL_PARTS = ("geometry", "stop_positions", "stop_colors")
#: Stops nearer to each other than this are not moved: differences err by about (step / width)^2 of the derivative.
NEAR = 0.05
#: Points are moved up to this entry of A, 1 / px: the third derivative of narrower gradients is too large.
STEEP = 10.0


def fill_differences(index: int, losses: Losses, rng: np.random.Generator) -> list[Finding]:
    """Return the differences of some entries of the double build's gradients of fills from central differences."""
    drawing, pieces = losses.case.drawing, losses.case.pieces
    error = squared_error(losses.rasterizer.forward(drawing, pieces), losses.target)[1]
    d_images = losses.d_image, losses.weight[..., None] * error
    gradients, findings = losses.gradients(), []
    for part in FILL_PARTS:
        entries = _entries(drawing.fills, part, rng)
        for loss, found, d_image, expected in zip(
            LOSSES, gradients, d_images, _differences(losses, part, entries), strict=True
        ):
            assert found.fills is not None
            gradient = getattr(found.fills, part)
            norm = max(float(np.linalg.norm(gradient)), least(d_image))
            what, own = f"differences: d_{part}, {loss}", gradient.ravel()[entries]
            finding = Finding.of(index, what, own, expected, RELATIVE * norm, norm=norm)
            if finding.of_rounding > 1:
                # The formula of differences.py weighs what happens within half a step by 2, and within one by -1.
                doubt = getattr(fills_tolerances(drawing, pieces, d_image, differences.STEP)[1], part)
                kinks = 3 * doubt.ravel()[entries]
                finding = Finding.of(index, what, own, expected, RELATIVE * norm, kinks, norm=norm)
            findings.append(finding)
    return findings


def _differences(losses: Losses, part: str, entries: list[int]) -> np.ndarray:
    fills = losses.case.drawing.fills

    def of(values: np.ndarray) -> np.ndarray:
        return losses(fills=fills.with_numbers(**{part: values}))

    if not entries:
        return np.zeros((len(LOSSES), 0))
    function = differences.of_quadratic if part == "stop_colors" else differences.by_small_steps
    return function(of, getattr(fills, part), entries)


def _entries(fills: Fills, part: str, rng: np.random.Generator) -> list[int]:
    """Return some entries that have a derivative: not of equal points, nor of stops at a step or at an end."""
    movable = np.ones(getattr(fills, part).shape, bool)
    if part == "geometry":
        maps, regular = place_maps(fills)
        movable[(fills.kinds == SOLID) | ~regular | (np.abs(maps).max(axis=(1, 2)) > STEEP)] = False
        movable[fills.kinds == LINEAR, 2] = False
    elif part == "stop_positions":
        places = fills.stop_positions
        same = fills.stop_layers[1:] == fills.stop_layers[:-1]
        near = same & (np.diff(places) < NEAR)
        movable[1:][near] = False
        movable[:-1][near] = False
        movable &= (places > NEAR) & (places < 1 - NEAR)
    candidates = np.flatnonzero(movable)
    return sorted(rng.choice(candidates, min(ENTRIES, len(candidates)), replace=False).tolist())
