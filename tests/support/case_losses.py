# SPDX-License-Identifier: Apache-2.0
"""Two losses of a case's picture at once, and their gradients."""

from __future__ import annotations

import zlib

import numpy as np
from reference.composite import squared_error

from livecl.rendering.rasterizer import Gradients, Rasterizer
from support.drawings import Case


class Losses:
    """A linear and a quadratic loss of a case's image, with random weights."""

    def __init__(self, rasterizer: Rasterizer, case: Case) -> None:
        rng = np.random.default_rng(zlib.crc32(case.drawing.points.tobytes()))
        shape = (*case.drawing.size, 4 if case.drawing.background is None else 3)
        self.rasterizer, self.case = rasterizer, case
        self.d_image = rng.normal(size=shape)
        self.target = rng.uniform(size=shape)
        self.weight = rng.uniform(0.2, 1.0, size=case.drawing.size)

    def __call__(self, **changes: np.ndarray) -> np.ndarray:
        """Both losses, (2,), of the drawing with some arguments changed."""
        image = self.rasterizer.forward(self.case.drawing.replace(**changes), pieces=self.case.pieces)
        error, _ = squared_error(image, self.target)
        return np.array([np.sum(image * self.d_image), np.sum(self.weight * error)])

    def gradients(self) -> tuple[Gradients, Gradients]:
        """Gradients of both losses, as the rasterizer gives them."""
        drawing, pieces = self.case.drawing, self.case.pieces
        self.rasterizer.forward(drawing, pieces=pieces)
        linear = self.rasterizer.backward(self.d_image)
        _, quadratic = self.rasterizer.loss_and_gradients(drawing, self.target, self.weight, pieces=pieces)
        return linear, quadratic
