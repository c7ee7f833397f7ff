# SPDX-License-Identifier: Apache-2.0
"""`Gradients`: the gradient of a loss with respect to a drawing."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.rendering.fills import FillGradients


@dataclasses.dataclass(frozen=True)
class Gradients:
    """Gradient of a scalar loss with respect to a drawing.

    Attributes
    ----------
    points : (M, 3, 2) float64
        Loss per pixel of displacement.
    colors : (N, 4) float64
        Loss per unit of straight RGBA.
    background : (3,) float64 or None
        Loss per unit of colour; None if the drawing has no background.
    fills : FillGradients or None
        Of gradient fills: geometry, offsets and colours of stops; None if all layers are solid. The rows of `colors` of
        layers with a gradient are 0.
    widths : (N,) float64 or None
        Loss per pixel of each stroke's width; None if all layers are filled.
    """

    points: NDArray[np.float64]
    colors: NDArray[np.float64]
    background: NDArray[np.float64] | None
    fills: FillGradients | None = None
    widths: NDArray[np.float64] | None = None
