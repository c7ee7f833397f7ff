# SPDX-License-Identifier: Apache-2.0
"""Stack of rendered layers: the composite below and the transmittance above each depth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl import interruption
from livecl.arrays import Window
from livecl.layering.contributions import in_window

RealArray = NDArray[np.floating[Any]]

#: Most numbers held for the composites and transmittances of all depths: 256 MiB. Pictures of more layers are treated
#: as one layer.
MAX_NUMBERS = 1 << 26
#: Transmittance up to which the layers below count as hidden.
MIN_SEEN = 0.02
WHOLE: Window = slice(None), slice(None)
NOWHERE: Window = slice(0, 0), slice(0, 0)


class LayerStack:
    """Layers over a background, all arrays in single precision.

    Parameters
    ----------
    background : (C,) array_like
        Colour beneath the layers.
    alphas : (N, H, W) array
        Opacity times coverage of each layer.
    colors : sequence of (C,) or (H, W, C) array
        Colours of the layers' paints; alpha is 1.
    image : (H, W, C) array
        The picture of all layers.

    Attributes
    ----------
    alphas, colors, windows : list
        Alpha (H, W), colour, (C,) or (H, W, C), and covered window of each layer, bottom first.
    grounds : list of (H, W, C)
        Picture of the background and the k lowest layers, by depth k: N + 1 of them.
    transmittances : list of (H, W)
        Transmittance of all layers from depth k on: N + 1 of them.
    """

    def __init__(
        self, background: ArrayLike, alphas: NDArray[Any], colors: Sequence[NDArray[Any]], image: NDArray[Any]
    ) -> None:
        self._ids = list(range(len(colors)))
        self._fixed: list[int] = []
        self.alphas = [np.asarray(alpha, dtype=np.float32) for alpha in alphas]
        self.colors = [np.asarray(color, dtype=np.float32) for color in colors]
        ground: NDArray[Any] = np.broadcast_to(np.asarray(background), image.shape)
        if (len(alphas) + 1) * (image.size + image[..., 0].size) > MAX_NUMBERS:
            self._fixed, self._ids, self.alphas, self.colors, ground = self._ids, [], [], [], image
        self.windows = [window_of(alpha) for alpha in self.alphas]
        self.grounds = [np.array(ground, dtype=np.float32)]
        for alpha, color in zip(self.alphas, self.colors, strict=True):
            interruption.check()
            self.grounds.append(over(self.grounds[-1], alpha, color))
        transmittances = [np.ones(image.shape[:2], np.float32)]
        for alpha in reversed(self.alphas):
            interruption.check()
            transmittances.append(transmittances[-1] * (1 - alpha))
        self.transmittances = transmittances[::-1]

    def __len__(self) -> int:
        return len(self.alphas)

    @property
    def image(self) -> RealArray:
        """Composite of all layers, (H, W, C)."""
        return self.grounds[-1]

    @property
    def hidden(self) -> NDArray[np.bool_]:
        """Pixels where layers hide anything below them: (H, W)."""
        return np.asarray(self.transmittances[0] <= MIN_SEEN)

    @property
    def order(self) -> NDArray[np.intp]:
        """Paint order: the given layers by index, then those inserted, numbered in order of insertion."""
        return np.array([*self._fixed, *self._ids], dtype=np.intp)

    def insert(self, depth: int, window: Window, alpha: NDArray[Any], color: NDArray[Any]) -> None:
        """Insert a layer, (h, w) within a window, above the `depth` lowest; nothing changes outside the window."""
        whole = np.zeros(self.image.shape[:2], np.float32)
        whole[window] = alpha
        self._ids.insert(depth, len(self._fixed) + len(self._ids))
        self.alphas.insert(depth, whole)
        self.colors.insert(depth, color.astype(np.float32))
        self.windows.insert(depth, window)
        self.grounds.insert(depth + 1, self.grounds[depth].copy())
        self.transmittances.insert(depth, self.transmittances[depth].copy())
        self._composite(depth, window)
        for transmittance in self.transmittances[: depth + 1]:
            transmittance[window] *= 1 - whole[window]

    def scale(self, layer: int, factor: float) -> None:
        """Multiply the opacity of a layer."""
        window = self.windows[layer]
        self.alphas[layer] = self.alphas[layer] * np.float32(factor)
        self._composite(layer, window)
        for k in reversed(range(layer + 1)):
            self.transmittances[k][window] = self.transmittances[k + 1][window] * (1 - self.alphas[k][window])

    def _composite(self, first: int, window: Window) -> None:
        """Composite the layers from a given one up again, within a window."""
        for k in range(first, len(self)):
            ground = self.grounds[k][window]
            if meet(window, self.windows[k]):
                ground = over(ground, self.alphas[k][window], in_window(self.colors[k], window))
            self.grounds[k + 1][window] = ground


def over(ground: NDArray[Any], alpha: NDArray[Any], color: NDArray[Any]) -> NDArray[Any]:
    """Composite a layer of alpha (H, W) and a colour, (C,) or (H, W, C), over an image (H, W, C)."""
    return np.asarray(ground + alpha[..., None] * (color - ground))


def window_of(alpha: NDArray[Any]) -> Window:
    """Return the bounding window (rows, columns) of the covered pixels (H, W); empty if there are none."""
    rows, columns = np.flatnonzero(alpha.any(axis=1)), np.flatnonzero(alpha.any(axis=0))
    if not len(rows):
        return NOWHERE
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def meet(one: Window, other: Window) -> bool:
    """Whether two windows overlap; None as a bound is that of the picture."""
    return all(
        (a.start or 0) < (np.inf if b.stop is None else b.stop)
        and (b.start or 0) < (np.inf if a.stop is None else a.stop)
        for a, b in zip(one, other, strict=True)
    )


def window_within(window: Window, outer: Window) -> Window:
    """Convert a window relative to the part `outer` of a picture to one of the picture."""
    rows, columns = (
        slice(inner.start + (whole.start or 0), inner.stop + (whole.start or 0))
        for inner, whole in zip(window, outer, strict=True)
    )
    return rows, columns
