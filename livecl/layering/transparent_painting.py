# SPDX-License-Identifier: Apache-2.0
"""A painting without background, in which the opacities of its layers follow what is added.

Paint of one colour over or under translucent paint of the same adds to its alpha everywhere. So a wider layer beneath,
which on opaque layers would be seen only around them, spoils them here, unless their opacity falls. In training it
does; so a new layer is judged by what it removes after that.

Where layers do not change their order, the picture is linear in the opacity of each: that of layer k changed by a
factor 1 + s changes the picture by s d_k, with d_k = a_k T_k (c_k - C_k) (livecl/layering/painting.py). Of an error r,

    s = (r . d_k) / |d_k|^2    removes    2 s (r . d_k) - s^2 |d_k|^2,

more than without a new layer, whose change x leaves r - x.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.image.alpha import error_seen
from livecl.layering.painting import Painting, Trial, Window, over, window_of

#: Alpha from which on a layer counts as opaque and stays so, least factor of the others' opacities, and rounds in which
#: they are set, one after the other.
OPAQUE, LEAST_FACTOR, ROUNDS = 0.95, 0.2, 4
#: Squared change of a picture below which a layer does nothing.
LEAST_SQUARE = 1e-9
WHOLE = slice(None), slice(None)


class TransparentPainting(Painting):
    """Layers over nothing, for a target of premultiplied RGBA; see :class:`livecl.layering.painting.Painting`."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        # d_k, r . d_k and |d_k|^2 of layers, until something is inserted.
        self._changes: dict[int, tuple[NDArray[Any], float, float]] = {}

    def insert(self, trial: Trial) -> None:
        """Put a new layer where it was tried, and set the opacities of all translucent layers anew."""
        super().insert(trial)
        for _ in range(ROUNDS):
            for k, alpha in enumerate(self._alphas):
                window = window_of(alpha)
                if window is not None and alpha.max() < OPAQUE:
                    self._set_opacity(k, window)
        self._changes = {}

    def _set_opacity(self, k: int, window: Window) -> None:
        """Give a layer the opacity that leaves least error."""
        _, product, square = self._change(k, window)
        self._alphas[k] = self._alphas[k] * np.float32(1 + self._step(k, product, square))
        for i in range(k, len(self._alphas)):
            self._grounds[i + 1][window] = over(self._grounds[i][window], self._alphas[i][window], self._colors[i])
        for i in reversed(range(k + 1)):
            self._transmittances[i][window] = self._transmittances[i + 1][window] * (1 - self._alphas[i][window])

    def _followers(
        self, color: NDArray[Any], depths: list[int], window: Window
    ) -> list[Callable[[NDArray[Any]], float]]:
        """Return what the layer above a new one will remove, or below one on top the layer that it overlaps most."""
        following = [depths[1] if depth == len(self._alphas) and len(depths) > 1 else depth for depth in depths]
        return [self._follower(k, color, depth, window) for k, depth in zip(following, depths, strict=True)]

    def _follower(self, k: int, color: NDArray[Any], depth: int, window: Window) -> Callable[[NDArray[Any]], float]:
        if k == len(self._alphas) or self._alphas[k].max() >= OPAQUE:
            return lambda share: 0.0
        if k not in self._changes:
            self._changes[k] = self._change(k, WHOLE)
        own, product, square = self._changes[k]
        missing = error_seen(color - self._grounds[depth][window])
        both = self._transmittances[depth][window] * np.einsum("hwc,hwc->hw", missing, own[window])
        alone = self._removed(k, product, square)
        return lambda share: self._removed(k, product - float(np.sum(share * both)), square) - alone

    def _change(self, k: int, window: Window) -> tuple[NDArray[Any], float, float]:
        """Return d_k, r . d_k and |d_k|^2 within a window."""
        visible = self._alphas[k][window] * self._transmittances[k + 1][window]
        change = np.asarray(visible[..., None] * error_seen(self._colors[k] - self._grounds[k][window]))
        residual = error_seen(self.target[window] - self.image[window])
        return change, float(np.sum(residual * change)), float(np.sum(change * change))

    def _step(self, k: int, product: float, square: float) -> float:
        """Return the step s above, as far as the opacity can go."""
        most = 1 / float(self._alphas[k].max())
        return float(np.clip(product / max(square, LEAST_SQUARE), LEAST_FACTOR - 1, most - 1))

    def _removed(self, k: int, product: float, square: float) -> float:
        """Return the error that a layer removes by that step."""
        step = self._step(k, product, square)
        return 2 * step * product - step**2 * square
