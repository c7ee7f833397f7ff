# SPDX-License-Identifier: Apache-2.0
"""A picture in layers, into which a new layer can be tried at any depth.

With C_k the picture of the background and the k lowest layers, and T_k the transmittance of all layers above them, a
new layer of alpha v and colour c between the two changes the picture by

    v T_k (c - C_k),

so that what it does to the squared error is known without compositing anything again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.image.alpha import error_seen

FloatArray = NDArray[np.floating[Any]]
Window = tuple[slice, slice]

#: Numbers that grounds and transmittances of all depths may take: 256 MiB. A picture of more layers counts as one.
MOST_NUMBERS = 1 << 26
#: Depths that are tried beside the top: below the layers that the new one overlaps most.
MOST_DEPTHS = 8
#: Overlap, px^2, that counts, and share by which a lower depth must be better than the top.
LEAST_OVERLAP, LEAST_ADVANTAGE = 1.0, 0.01
#: Transmittance up to which what lies below counts as hidden.
LEAST_SEEN = 0.02
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
    def hidden(self) -> NDArray[np.bool_]:
        """Pixels where layers hide all that may lie below them: (H, W)."""
        return np.asarray(self._transmittances[0] <= LEAST_SEEN)

    @property
    def order(self) -> NDArray[np.intp]:
        """Paint order: the layers given, by their numbers, and those inserted, numbered on in the order they came."""
        return np.array([*self._fixed, *self._ids], dtype=np.intp)

    def try_layers(self, alphas: Sequence[NDArray[Any]], color: FloatArray, roughly: bool = False) -> list[Trial]:
        """Return new layers of one paint, each at the depth where it removes most error.

        Parameters
        ----------
        alphas : sequence of (H, W) array
            Opacity times coverage of each layer that is to be tried by itself.
        color : (C,) array
            Colour of the paint.
        roughly : bool
            Look only at every second pixel in each direction, where there are many.

        Notes
        -----
        A layer of alpha v takes the error E to E - v d, d = T_k (c - C_k), and so removes v (2 E . d) - v^2 |d|^2 of
        its square: what does not depend on v is found once for all layers.
        """
        top = len(self._ids)
        alphas = [np.asarray(alpha, dtype=np.float32) for alpha in alphas]
        together = np.maximum.reduce(alphas)
        window = window_of(together)
        if window is None:
            return [Trial(top, alpha, color, 0.0) for alpha in alphas]
        area = 1.0
        if roughly and np.count_nonzero(together) > LARGE:
            area, (rows, columns) = 4.0, window
            window = slice(rows.start, rows.stop, 2), slice(columns.start, columns.stop, 2)
        depths = [top, *self._depths_below(together, window, LEAST_OVERLAP / area)]
        residual = error_seen(self.target[window] - self.image[window])
        linear, square = np.empty((2, len(depths), *residual.shape[:2]), np.float32)
        for number, depth in enumerate(depths):
            missing = error_seen(color.astype(np.float32) - self._grounds[depth][window])
            seen = self._transmittances[depth][window]
            linear[number] = 2 * seen * np.einsum("hwc,hwc->hw", residual, missing)
            square[number] = seen * seen * np.einsum("hwc,hwc->hw", missing, missing)
        followers = self._followers(color.astype(np.float32), depths, window)
        trials = []
        for alpha in alphas:
            share = alpha[window]
            gains = area * (share * (linear - share * square)).sum(axis=(1, 2))
            for number, removed in enumerate(followers):
                gains[number] += removed(area * share)
            number = int(np.argmax(gains))
            if gains[number] <= gains[0] + LEAST_ADVANTAGE * abs(gains[0]):
                number = 0
            trials.append(Trial(depths[number], alpha, color, float(gains[number])))
        return trials

    def _followers(
        self, color: NDArray[Any], depths: list[int], window: Window
    ) -> list[Callable[[NDArray[Any]], float]]:
        """Return for each depth what other layers will remove, following a layer of some alpha within the window.

        Here they stay as they are.
        """
        return []

    def _depths_below(self, alpha: NDArray[Any], window: Window, least: float) -> list[int]:
        """Return the depths below the layers that an alpha (H, W) overlaps most."""
        share = alpha[window]
        overlaps = np.array([float(np.einsum("hw,hw->", share, other[window])) for other in self._alphas])
        return [int(k) for k in np.argsort(-overlaps, kind="stable")[:MOST_DEPTHS] if overlaps[k] > least]

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
