# SPDX-License-Identifier: Apache-2.0
"""Gain of a new layer at any depth, in closed form, without compositing again.

With C_k the picture of the background and the k lowest layers, and T_k the transmittance of all layers above them, a
new layer of alpha v and colour c between the two changes the picture by

    v T_k (c - C_k),

so that its effect on the squared error is known without compositing anything again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import Window
from livecl.image.errors import visible_error
from livecl.layering.componentwise.opacities import Opacities
from livecl.layering.stack import NOWHERE, WHOLE, LayerStack, RealArray, meet, window_of, window_within


@dataclasses.dataclass(frozen=True, kw_only=True)
class Trying:
    """Effort of trying a layer at several depths.

    Trying depths halves the error of faces (docs/quality.md, "Choices of the default method"), measured with these
    values; no comparison of other values is recorded.
    """

    max_depths: int = 8  # depths tried beside the top: directly below the layers that the new one overlaps most
    min_overlap: float = 1.0  # least overlap, px^2, with a layer for the depth below it to be tried
    min_advantage: float = 0.01  # relative advantage in gain that a lower depth needs over the top
    #: Share of covered pixels in a window below which only these are evaluated; affects the time only.
    sparse: float = 0.3
    large: int = 500  # least number of pixels of a layer that may be tried roughly


@dataclasses.dataclass(frozen=True)
class Trial:
    """Trial of a layer: depth (layers below it), alpha (h, w) in a window, colour (C,), squared error removed."""

    depth: int
    window: Window
    alpha: NDArray[Any]
    color: RealArray
    gain: float


class Painting:
    """Stack of layers in which new ones are tried, against a target (H, W, C), RGB or premultiplied RGBA.

    With `follow`, the opacities of translucent layers adapt to new layers (opacities.py).
    """

    def __init__(
        self, target: NDArray[Any], stack: LayerStack, follow: bool = False, trying: Trying = Trying()
    ) -> None:
        self._trying = trying
        self.target: NDArray[Any] = target.astype(np.float32)
        self.stack = stack
        self.opacities = Opacities(self.target, stack) if follow else None

    @property
    def error(self) -> RealArray:
        """Visible squared error, summed over the channels: (H, W)."""
        return np.asarray(np.square(visible_error(self.target - self.stack.image)).sum(axis=-1))

    def try_layers(
        self, alphas: Sequence[NDArray[Any]], color: RealArray, within_window: Window = WHOLE, roughly: bool = False
    ) -> list[Trial]:
        """Try layers of one colour (C,), each alone, at the depth where it removes most squared error.

        `alphas` (h, w) are opacity times coverage within a window, 0 elsewhere. With `roughly`, large windows are
        sampled at every second pixel in each direction.

        Notes
        -----
        A layer of alpha v takes the error E to E - v d, d = T_k (c - C_k), and so removes v (2 E . d) - v^2 |d|^2 of
        its square: the factors independent of v are computed once for all layers.
        """
        stack, top = self.stack, len(self.stack)
        alphas = [np.asarray(alpha, dtype=np.float32) for alpha in alphas]
        together = np.maximum.reduce(alphas)
        covered = window_of(together)
        if covered == NOWHERE:
            return [Trial(top, NOWHERE, alpha[NOWHERE], color, 0.0) for alpha in alphas]
        alphas, together = [alpha[covered] for alpha in alphas], together[covered]
        whole = window = window_within(covered, within_window)
        area, shares = 1.0, alphas
        if roughly and np.count_nonzero(together) > self._trying.large:
            area, (rows, columns) = 4.0, window
            window = slice(rows.start, rows.stop, 2), slice(columns.start, columns.stop, 2)
            together, shares = together[::2, ::2], [alpha[::2, ::2] for alpha in alphas]
        depths = [top, *self._depths_below(together, window, self._trying.min_overlap / area)]
        # Of a window that is mostly empty, as that of thin lines, the pixels covered are looked at one by one.
        pixels = together > 0 if np.count_nonzero(together) < self._trying.sparse * together.size else ...
        shares = [share[pixels] for share in shares]
        residual = visible_error(self.target[window][pixels] - stack.image[window][pixels])
        linear, square = np.empty((2, len(depths), *residual.shape[:-1]), np.float32)
        for number, depth in enumerate(depths):
            interruption.check()
            missing = visible_error(color.astype(np.float32) - stack.grounds[depth][window][pixels])
            seen = stack.transmittances[depth][window][pixels]
            linear[number] = 2 * seen * np.einsum("...c,...c->...", residual, missing)
            square[number] = seen * seen * np.einsum("...c,...c->...", missing, missing)
        followers = []
        if self.opacities is not None:
            followers = self.opacities.followers(color.astype(np.float32), depths, window, pixels)
        trials = []
        for alpha, share in zip(alphas, shares, strict=True):
            gains = area * (share * (linear - share * square)).sum(axis=tuple(range(1, linear.ndim)))
            for number, removed in enumerate(followers):
                gains[number] += removed(area * share)
            number = int(np.argmax(gains))
            if gains[number] <= gains[0] + self._trying.min_advantage * abs(gains[0]):
                number = 0
            trials.append(Trial(depths[number], whole, alpha, color, float(gains[number])))
        return trials

    def _depths_below(self, share: NDArray[Any], window: Window, least: float) -> list[int]:
        """Return the depths below the layers that an alpha (h, w) within a window overlaps most."""
        overlaps = np.zeros(len(self.stack))
        for k, (alpha, own) in enumerate(zip(self.stack.alphas, self.stack.windows, strict=True)):
            if meet(window, own):
                overlaps[k] = np.einsum("hw,hw->", share, alpha[window])
        return [int(k) for k in np.argsort(-overlaps, kind="stable")[: self._trying.max_depths] if overlaps[k] > least]

    def insert(self, trial: Trial) -> Window:
        """Insert a layer where it was tried; return the changed window."""
        self.stack.insert(trial.depth, trial.window, trial.alpha, trial.color)
        if self.opacities is None:
            return trial.window
        self.opacities.follow()
        return WHOLE
