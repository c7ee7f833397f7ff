# SPDX-License-Identifier: Apache-2.0
"""A painting without background, in which the opacities of its layers follow what is added.

Paint of one colour over or under translucent paint of the same adds to its alpha everywhere. So a wider layer beneath,
which on opaque layers would be seen only around them, spoils them here, unless their opacity falls. In training it
does; so a new layer is judged by what it removes after that.

Where layers do not change their order, the picture is linear in the opacity of each: that of layer k changed by a
factor 1 + s changes the picture by s d_k, with d_k = a_k T_k (c_k - C_k) (livecl/painting.py). Of an error r,

    s = (r . d_k) / |d_k|^2    removes    2 s (r . d_k) - s^2 |d_k|^2,

more than without a new layer, whose change x leaves r - x.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.painting import Painting, Trial, Window, over, window_of
from livecl.transparency import error_seen

#: Alpha from which on a layer counts as opaque and stays so, least factor of the others' opacities, and rounds in which
#: they are set, one after the other.
OPAQUE, LEAST_FACTOR, ROUNDS = 0.95, 0.2, 4
WHOLE = slice(None), slice(None)


class TransparentPainting(Painting):
    """Layers over nothing, for a target of premultiplied RGBA; see :class:`livecl.painting.Painting`."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        # What layers do to the picture, that times the error, and its square; until something is inserted.
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
        change = self._change(k, window)
        residual = error_seen(self.target[window] - self.image[window])
        step = self._step(k, float(np.sum(residual * change)), float(np.sum(change * change)))
        self._alphas[k] = self._alphas[k] * np.float32(1 + step)
        for i in range(k, len(self._alphas)):
            self._grounds[i + 1][window] = over(self._grounds[i][window], self._alphas[i][window], self._colors[i])
        for i in reversed(range(k + 1)):
            self._transmittances[i][window] = self._transmittances[i + 1][window] * (1 - self._alphas[i][window])

    def _follower(
        self, depth: int, lower: list[int], window: Window, missing: NDArray[Any], area: float
    ) -> Callable[[NDArray[Any]], float]:
        """What the layer above a new one would remove, or below one on top the layer that it overlaps most."""
        following = [depth] if depth < len(self._alphas) else lower[:1]
        if not following or self._alphas[following[0]].max() >= OPAQUE:
            return super()._follower(depth, lower, window, missing, area)
        k = following[0]
        if k not in self._changes:
            own = self._change(k, WHOLE)
            product = float(np.sum(error_seen(self.target - self.image) * own))
            self._changes[k] = own, product, float(np.sum(own * own))
        own, product, square = self._changes[k]
        both = self._transmittances[depth][window] * np.einsum("hwc,hwc->hw", missing, own[window])
        alone = self._removed(k, product, square)
        return lambda share: self._removed(k, product - area * float(np.sum(share * both)), square) - alone

    def _removed(self, k: int, product: float, square: float) -> float:
        """Error that a layer would remove by changing its opacity."""
        step = self._step(k, product, square)
        return 2 * step * product - step**2 * square

    def _change(self, k: int, window: Window) -> NDArray[Any]:
        """What layer k does to the picture, as it is seen."""
        visible = self._alphas[k][window] * self._transmittances[k + 1][window]
        return np.asarray(visible[..., None] * error_seen(self._colors[k] - self._grounds[k][window]))

    def _step(self, k: int, product: float, square: float) -> float:
        """Share by which a layer's opacity should rise, as far as it can: the step s above."""
        most = 1 / float(self._alphas[k].max())
        return float(np.clip(product / max(square, 1e-9), LEAST_FACTOR - 1, most - 1))
