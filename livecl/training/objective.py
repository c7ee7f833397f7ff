# SPDX-License-Identifier: Apache-2.0
"""Objective of a run: the pixel loss (eq. 2 or its plain mean) and the Xing loss (eq. 4)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.options import Options
from livecl.rendering.gradients import Gradients
from livecl.rendering.pipeline import DistanceWeight
from livecl.rendering.rasterizer import DeviceImage, Rasterizer
from livecl.training.state import State
from livecl.training.xing import xing_loss

#: Flattening tolerance for the distance weight, px: a fortieth of tau, where the weight falls to 0. It needs a quarter
#: of the lines of the picture (cost and gain: docs/notes/performance.md).
DISTANCE_TOLERANCE = 0.25


class Objective:
    """Loss and gradient of a run's drawing; the target is (H, W, 3), or (H, W, 4) premultiplied."""

    def __init__(self, rasterizer: Rasterizer, target: NDArray[Any]) -> None:
        self._rasterizer = rasterizer
        self._target = rasterizer.upload(target)
        self._ones = rasterizer.upload(np.ones(target.shape[:2]))
        self._kept: tuple[Any, DeviceImage] = (None, self._ones)  # `State.kept_weight`, and its copy on the device
        self._num_pixels = target.shape[0] * target.shape[1]
        self._pieces: tuple[Any, NDArray[np.int32]] = (None, np.zeros(0, np.int32))  # of the picture, of the distance

    def warm_up(self, drawing: Drawing, options: Options) -> None:
        """Launch once each kernel that a step needs."""
        self._rasterizer.forward(drawing)
        if options.loss == "mse" or options.variant == "released":
            self._rasterizer.loss_and_gradients(drawing, self._target, self._ones)
        else:
            self._rasterizer.loss_and_gradients(drawing, self._target, DistanceWeight(options.tau))
        if options.loss != "mse" and options.variant == "released":
            self._rasterizer.distance_weight_on_device(drawing, options.tau)

    def evaluate(self, state: State) -> tuple[float, Gradients]:
        """Return the loss of the state's drawing and its gradient; the distance weight is a constant in it."""
        options, drawing = state.options, state.drawing
        weight, scale = self._weight(state)
        finish = self._rasterizer.begin_loss(drawing, self._target, weight, state.pieces, scale)
        if options.xing_weight == 0:
            return finish()
        xing, d_xing = self._xing(state)  # while the device works
        loss, gradients = finish()
        gradients.points[:] += options.xing_weight * d_xing
        return loss + options.xing_weight * xing, gradients

    def released_weight(self, state: State, stage: int) -> NDArray[Any]:
        """Weight of the authors' program: closeness to a stage's paths, scaled to 1, plus earlier ones'; at most 1."""
        newest = int(np.searchsorted(state.drawing.stages, stage))
        pieces = self._distance_pieces(state)
        on_device = self._rasterizer.distance_weight_on_device(state.drawing, state.options.tau, pieces, newest)
        closest = self._rasterizer.download(on_device)[..., 0]
        weight = closest / max(float(closest.max()), 1e-12)
        return weight if state.kept_weight is None else np.minimum(weight + state.kept_weight, 1)

    def _weight(self, state: State) -> tuple[DeviceImage | DistanceWeight, float]:
        """Weight of each pixel's error, and a common factor: of the mean over pixels and RGB, or of eq. (1) and (2)."""
        if state.options.loss == "mse":
            if state.kept_weight is not self._kept[0]:
                kept = state.kept_weight
                self._kept = kept, self._ones if kept is None else self._rasterizer.upload(kept)
            return self._kept[1], 1 / (3 * self._num_pixels)
        if state.options.variant == "paper":
            return DistanceWeight(state.options.tau, self._distance_pieces(state)), 1 / 3
        return self._rasterizer.upload(self.released_weight(state, state.stage)), 1 / self._num_pixels

    def _distance_pieces(self, state: State) -> NDArray[np.int32]:
        """Numbers of lines for the distance weight; the error falls with the square of their number."""
        if self._pieces[0] is not state.pieces:
            share = np.sqrt(self._rasterizer.tolerance / DISTANCE_TOLERANCE)
            self._pieces = state.pieces, np.ceil(state.pieces * share).astype(np.int32)
        return self._pieces[1]

    def _xing(self, state: State) -> tuple[float, NDArray[np.float64]]:
        """Xing loss and its gradient by (anchor, handle, handle): of all paths, or the newest (released program)."""
        drawing, first = state.drawing, 0
        if state.options.variant == "released":
            first = int(drawing.segment_offsets[np.searchsorted(drawing.stages, state.stage)])
        cubics = drawing.cubics[first:]
        if drawing.strokes.is_open.any():
            ends = drawing.subpath_offsets[1:][drawing.strokes.is_open] - 1 - first  # last rows, which are no segments
            cubics[ends[ends >= 0]] = 0
        value, d_cubics = xing_loss(cubics)
        d_points = np.zeros_like(drawing.points)
        d_points[first:] = d_cubics[:, :3]
        d_points[drawing.next_segments[first:], 0] += d_cubics[:, 3]
        return value, d_points
