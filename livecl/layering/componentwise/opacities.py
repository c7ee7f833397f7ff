# SPDX-License-Identifier: Apache-2.0
"""Adapt the opacities of translucent layers to a new layer, in drawings without background.

Paint of one colour over or under translucent paint of the same colour adds to its alpha everywhere. A wider layer
beneath, which under opaque layers would be visible only around them, therefore spoils translucent ones unless their
opacity falls. Training lowers it; so a new layer is judged by the error removed after that adjustment.

Where layers do not change their order, the picture is linear in the opacity of each: that of layer k changed by a
factor 1 + s changes the picture by s d_k, with d_k = a_k T_k (c_k - C_k) (painting.py). Of an error r,

    s = (r . d_k) / |d_k|^2    removes    2 s (r . d_k) - s^2 |d_k|^2,

more than without a new layer, whose change x leaves r - x.
"""

from __future__ import annotations

from collections.abc import Callable
from types import EllipsisType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import Window
from livecl.image.errors import visible_error
from livecl.layering.contributions import in_window
from livecl.layering.stack import NOWHERE, WHOLE, LayerStack
from livecl.options import OPAQUE_FROM

#: Squared change of the picture below which a layer has no effect: far below one level of 255 in one pixel.
MIN_SQUARE = 1e-9
#: Mask (h, w) of the pixels used within a window, or an ellipsis for all of them.
Chosen = NDArray[np.bool_] | EllipsisType


class Opacities:
    """Opacities of the translucent layers of a stack, for a target (H, W, 4) of premultiplied RGBA, float32.

    Layers whose alpha reaches `OPAQUE_FROM` anywhere count as opaque, and stay so. No comparison of other values is
    recorded.

    Attributes
    ----------
    min_factor : float
        Least factor by which an opacity changes in one step.
    rounds : int
        Rounds of coordinate descent over the opacities.
    """

    min_factor: ClassVar[float] = 0.2
    rounds: ClassVar[int] = 4

    def __init__(self, target: NDArray[Any], stack: LayerStack) -> None:
        self._target, self._stack = target, stack
        # d_k, r . d_k and |d_k|^2 of layers, until something is inserted.
        self._changes: dict[int, tuple[NDArray[Any], float, float]] = {}

    def follow(self) -> None:
        """Refit the opacities of all translucent layers after an insertion."""
        for _ in range(self.rounds):
            for k, window in enumerate(self._stack.windows):
                if window != NOWHERE and self._stack.alphas[k].max() < OPAQUE_FROM:
                    _, product, square = self._change(k, window)
                    self._stack.scale(k, 1 + self._step(k, product, square))
        self._changes = {}

    def followers(
        self, color: NDArray[Any], depths: list[int], window: Window, pixels: Chosen
    ) -> list[Callable[[NDArray[Any]], float]]:
        """Return for each depth the gain of the layer that adapts to a new one, as a function of the new alpha.

        That is the layer above the new one, or, if the new one is on top, the layer below that it overlaps most.
        """
        following = [depths[1] if depth == len(self._stack) and len(depths) > 1 else depth for depth in depths]
        return [self._follower(k, color, depth, window, pixels) for k, depth in zip(following, depths, strict=True)]

    def _follower(
        self, k: int, color: NDArray[Any], depth: int, window: Window, pixels: Chosen
    ) -> Callable[[NDArray[Any]], float]:
        if k == len(self._stack) or self._stack.alphas[k].max() >= OPAQUE_FROM:
            return lambda share: 0.0
        if k not in self._changes:
            self._changes[k] = self._change(k, WHOLE)
        own, product, square = self._changes[k]
        missing = visible_error(color - self._stack.grounds[depth][window][pixels])
        seen = self._stack.transmittances[depth][window][pixels]
        both = seen * np.einsum("...c,...c->...", missing, own[window][pixels])
        alone = self._removed(k, product, square)
        return lambda share: self._removed(k, product - float(np.sum(share * both)), square) - alone

    def _change(self, k: int, window: Window) -> tuple[NDArray[Any], float, float]:
        """Return d_k, r . d_k and |d_k|^2 within a window."""
        stack = self._stack
        visible = stack.alphas[k][window] * stack.transmittances[k + 1][window]
        change = np.asarray(
            visible[..., None] * visible_error(in_window(stack.colors[k], window) - stack.grounds[k][window])
        )
        residual = visible_error(self._target[window] - stack.image[window])
        return change, float(np.sum(residual * change)), float(np.sum(change * change))

    def _step(self, k: int, product: float, square: float) -> float:
        """Return the step s above, clipped to valid opacities."""
        most = 1 / float(self._stack.alphas[k].max())
        return float(np.clip(product / max(square, MIN_SQUARE), self.min_factor - 1, most - 1))

    def _removed(self, k: int, product: float, square: float) -> float:
        """Return the squared error that a layer removes by that step."""
        step = self._step(k, product, square)
        return 2 * step * product - step**2 * square
