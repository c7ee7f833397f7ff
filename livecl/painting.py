# SPDX-License-Identifier: Apache-2.0
"""A picture in layers, into which a new layer can be tried at any depth.

With C_k the picture of the background and the k lowest layers, and T_k the transmittance of all layers above them, a
new layer of alpha v and colour c between the two changes the picture by

    v T_k (c - C_k),

so that what it does to the squared error is known without compositing anything again.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.transparency import error_seen

FloatArray = NDArray[np.floating[Any]]
Window = tuple[slice, slice]

#: Numbers that grounds and transmittances of all depths may take: 256 MiB. A picture of more layers counts as one.
MOST_NUMBERS = 1 << 26
#: Depths that are tried beside the top: below the layers that the new one overlaps most.
MOST_DEPTHS = 8
#: Overlap, px^2, that counts, and share by which a lower depth must be better than the top.
LEAST_OVERLAP, LEAST_ADVANTAGE = 1.0, 0.01
#: Pixels from which on a layer is large enough to be tried roughly.
LARGE = 500


@dataclasses.dataclass(frozen=True)
class Trial:
    """A new layer: depth (layers below it), alpha (H, W), colour (C,), and the squared error that it removes."""

    depth: int
    alpha: NDArray[Any]
    color: FloatArray
    gain: float


class Painting:
    """Layers of known alpha and colour over a background, and the target that they are to come close to.

    Parameters
    ----------
    target : (H, W, C) array
        The picture wanted: RGB, or premultiplied RGBA.
    image : (H, W, C) array
        The picture so far.
    background : (C,) array
        Colour beneath the layers.
    alphas : (N, H, W) array
        Opacity times coverage of each layer.
    colors : (N, C) array
        Colours of the layers' paints; alpha is 1.
    """

    def __init__(
        self,
        target: NDArray[Any],
        image: NDArray[Any],
        background: ArrayLike,
        alphas: NDArray[Any],
        colors: NDArray[Any],
    ) -> None:
        self.target: NDArray[Any] = target.astype(np.float32)
        self._ids = list(range(len(colors)))
        self._fixed: list[int] = []
        self._alphas = [np.asarray(alpha, dtype=np.float32) for alpha in alphas]
        self._colors = [np.asarray(color, dtype=np.float32) for color in colors]
        ground: NDArray[Any] = np.broadcast_to(np.asarray(background), self.target.shape)
        if (len(alphas) + 1) * (self.target.size + self.target[..., 0].size) > MOST_NUMBERS:
            self._fixed, self._ids, self._alphas, self._colors, ground = self._ids, [], [], [], image
        grounds = [np.array(ground, dtype=np.float32)]
        for alpha, color in zip(self._alphas, self._colors, strict=True):
            grounds.append(over(grounds[-1], alpha, color))
        transmittances = [np.ones(self.target.shape[:2], np.float32)]
        for alpha in reversed(self._alphas):
            transmittances.append(transmittances[-1] * (1 - alpha))
        self._grounds, self._transmittances = grounds, transmittances[::-1]

    @property
    def image(self) -> FloatArray:
        """The picture of all layers, (H, W, C)."""
        return self._grounds[-1]

    @property
    def error(self) -> FloatArray:
        """Squared difference from the target, as it is seen, summed over the channels: (H, W)."""
        return np.asarray(np.square(error_seen(self.target - self.image)).sum(axis=-1))

    @property
    def order(self) -> NDArray[np.intp]:
        """Paint order: the layers given, by their numbers, and those inserted, numbered on in the order they came."""
        return np.array([*self._fixed, *self._ids], dtype=np.intp)

    def try_layer(self, alpha: NDArray[Any], color: FloatArray, roughly: bool = False) -> Trial:
        """Return a new layer of an alpha (H, W) and a paint's colour (C,) at the depth where it removes most error.

        Roughly, of a large layer only every second pixel in each direction is looked at.
        """
        top = len(self._ids)
        window = window_of(alpha)
        if window is None:
            return Trial(top, alpha, color, 0.0)
        area = 1.0
        if roughly and np.count_nonzero(alpha) > LARGE:
            area, (rows, columns) = 4.0, window
            window = slice(rows.start, rows.stop, 2), slice(columns.start, columns.stop, 2)
        share = alpha[window]
        residual = error_seen(self.target[window] - self.image[window])
        overlaps = np.array([float(np.sum(share * other[window])) for other in self._alphas])
        lower = [
            int(k) for k in np.argsort(-overlaps, kind="stable")[:MOST_DEPTHS] if area * overlaps[k] > LEAST_OVERLAP
        ]
        best = Trial(top, alpha, color, -np.inf)
        for depth in [top, *lower]:
            visible = share * self._transmittances[depth][window]
            change = visible[..., None] * error_seen(color.astype(np.float32) - self._grounds[depth][window])
            gain = area * float(np.sum(change * (2 * residual - change)))
            gain += self._follow_gain(depth, lower, window, change, area)
            if gain > best.gain + (LEAST_ADVANTAGE * abs(best.gain) if best.depth == top and depth != top else 0.0):
                best = Trial(depth, alpha, color, gain)
        return best

    def _follow_gain(self, depth: int, lower: list[int], window: Window, change: NDArray[Any], area: float) -> float:
        """Error that another layer would remove, following a new one; here they stay as they are."""
        return 0.0

    def insert(self, trial: Trial) -> None:
        """Put a new layer where it was tried: only within its own window anything changes."""
        depth, alpha, grounds = trial.depth, trial.alpha.astype(np.float32), self._grounds
        self._ids.insert(depth, len(self._fixed) + len(self._ids))
        self._alphas.insert(depth, alpha)
        self._colors.insert(depth, trial.color.astype(np.float32))
        grounds.insert(depth + 1, grounds[depth].copy())
        self._transmittances.insert(depth, self._transmittances[depth].copy())
        window = window_of(alpha)
        if window is None:
            return
        for k in range(depth, len(self._alphas)):
            grounds[k + 1][window] = over(grounds[k][window], self._alphas[k][window], self._colors[k])
        for transmittance in self._transmittances[: depth + 1]:
            transmittance[window] *= 1 - alpha[window]


def over(ground: NDArray[Any], alpha: NDArray[Any], color: NDArray[Any]) -> NDArray[Any]:
    """Return what a layer of an alpha (H, W) and a colour (C,) shows over (H, W, C)."""
    return np.asarray(ground + alpha[..., None] * (color - ground))


def window_of(alpha: NDArray[Any]) -> Window | None:
    """Return the rows and columns that hold all that is covered."""
    rows, columns = np.flatnonzero(alpha.any(axis=1)), np.flatnonzero(alpha.any(axis=0))
    if not len(rows):
        return None
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
