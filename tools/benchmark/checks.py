# SPDX-License-Identifier: Apache-2.0
"""Checks of a case before it is timed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from reference.coverage import winding_area  # the exact coverage that the tests compare the kernels with
from reference.flatten import flatten

from benchmark.package import training
from livecl.drawing.drawing import Drawing
from livecl.opencl.device import open_device
from livecl.options import Options
from livecl.rendering.rasterizer import Gradients, Rasterizer
from livecl.training.xing import xing_loss

#: Relative error of one rounding in float32.
UNIT = 2.0**-24
#: Number of standard deviations of rounding allowed, as in the tests.
DEVIATIONS = 5
#: A loss is a sum of squares: its relative error is that of a pixel's error, 2 x rounding / contrast, with contrasts of
#: a hundredth and more, and of a sum in a fixed order of up to a million pixels, whose roundings add up like a root.
LOSS_TOLERANCE = DEVIATIONS * UNIT * (2 * 100 + 1000)
#: The distance weight of a step may be measured with coarser lines, a fortieth of tau away from the curve.
STEP_LOSS_TOLERANCE = 1 / 40


#: If |A| in double precision is farther than this from 0 and 1, the pixel has an outline.
EXACT = 1e-9


class CheckError(Exception):
    """A case fails its check; the message has the value found and the value expected."""


def gradient_tolerance(side: int) -> float:
    """Return the rounding error of a gradient, over its norm, and of the signed area A of a pixel (coverage.cl).

    A vertex's coordinates of up to `side` px are off by UNIT x side x the root of some ten roundings, coverage by twice
    that, and with it the colour under a layer and the share of the outline in a pixel: of order 1 each.
    """
    return DEVIATIONS * UNIT * side * 10**0.5 * 2


def check_step(
    image: NDArray[np.float32], drawing: Drawing, device: int | str | None, *, exact: bool = True
) -> dict[str, Any]:
    """Check one iteration on a scene.

    The float build's loss against NumPy's from the image it renders, its gradient against the double build's, and the
    loss of a step against both parts of the paper's loss.

    Parameters
    ----------
    image : (H, W, 3) float32
        Target.
    drawing : Drawing
        The scene.
    device : int, str or None
        OpenCL device.
    exact : bool
        Whether to compare with the double build, if the device supports it: it needs twice the memory and time.

    Returns
    -------
    dict
        The errors found.

    Raises
    ------
    CheckError
        If one of them is too large.
    """
    options = Options.paper()
    single = Rasterizer(drawing.size, device)
    pieces = single.pieces(drawing)
    rendered = single.forward(drawing, pieces)
    weight = single.distance_weight(drawing, options.tau, pieces)
    loss, _ = single.loss_and_gradients(drawing, image, weight, pieces, scale=1 / 3)
    found = {
        "weight_sum": _within("sum of the distance weight", float(weight.sum(dtype=np.float64)), 1, LOSS_TOLERANCE)
    }
    error = rendered.astype(np.float64) - image
    recomputed = float(np.sum(weight[..., None].astype(np.float64) * error * error) / 3)
    found["loss"] = _within("loss, against NumPy's", loss, recomputed, LOSS_TOLERANCE)
    if exact and open_device(device).device.double_fp_config:
        double = Rasterizer(drawing.size, device, dtype=np.float64)
        tolerance = gradient_tolerance(max(drawing.size))
        certain = weight * ~doubtful_pixels(drawing, pieces, tolerance)
        _, gradients = single.loss_and_gradients(drawing, image, certain, pieces, scale=1 / 3)
        _, wanted = double.loss_and_gradients(drawing, image, certain, pieces, scale=1 / 3)
        found |= _compare(gradients, wanted, tolerance)
    step_loss = training(image, drawing, device).step()
    wanted_loss = recomputed + options.xing_weight * xing_loss(drawing.cubics)[0]
    found["step_loss"] = _within("loss of a step", step_loss, wanted_loss, STEP_LOSS_TOLERANCE)
    return found


def doubtful_pixels(drawing: Drawing, pieces: NDArray[np.int32], band: float) -> NDArray[np.bool_]:
    """Return the pixels where the gradients of both precisions may differ and both be right: (H, W).

    There a layer's abs(A) lies within rounding, `band`, of a kink of min(abs(A), 1), at 0 or 1; on one side the outline
    counts in the pixel, on the other it does not, or with the other sign. One such pixel, in which windings of 1 and -1
    nearly cancelled (A = 1.9e-5), was 3 % of the gradient of 256 paths at 1024x1024.
    """
    doubtful = np.zeros(drawing.size, bool)
    for outlines in flatten(drawing, pieces):
        area = np.abs(winding_area(outlines, drawing.size))
        from_kink = np.minimum(area, np.abs(area - 1))
        doubtful |= (from_kink > EXACT) & (from_kink <= band)
    return doubtful


def check_error(mse: float, at_most: float | None) -> dict[str, Any]:
    """Check the final error of a run; without a bound, only report it."""
    if at_most is not None and not mse <= at_most:
        raise CheckError(f"mean squared error: {mse:.3g}, wanted at most {at_most:.3g}")
    return {"mse": mse}


def _within(what: str, value: float, wanted: float, tolerance: float) -> float:
    """Return the relative error of a number, if it is within the tolerance."""
    error = abs(value - wanted) / abs(wanted) if wanted else abs(value)
    if not error <= tolerance:  # nor if it is not a number
        raise CheckError(f"{what}: {value:.9g}, wanted {wanted:.9g} within {tolerance:.1g} of it")
    return error


def _compare(found: Gradients, wanted: Gradients, tolerance: float) -> dict[str, float]:
    """Return the errors of the gradients of points and colours over their norms; CheckError if too large."""
    errors = {}
    for name in ("points", "colors"):
        exact = getattr(wanted, name)
        norm = max(float(np.linalg.norm(exact)), 1e-300)
        errors[name] = float(np.linalg.norm(getattr(found, name) - exact)) / norm
        if not errors[name] <= tolerance:
            raise CheckError(f"gradient of the {name}: off by {errors[name]:.2g} of its norm, wanted {tolerance:.2g}")
    return errors
