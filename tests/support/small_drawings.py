# SPDX-License-Identifier: Apache-2.0
"""Small drawings painted from known masks, and the layers that structure finds in them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from skimage.draw import polygon2mask

from livecl.layering.structure.layers import find_layers
from livecl.layering.structure.parts import with_parts
from support.found import flat_regions

SIZE = (96, 96)
FINE = 4  # samples of a pixel's side
RED, GREEN, BLUE, YELLOW = (0.9, 0.2, 0.2), (0.2, 0.7, 0.3), (0.15, 0.3, 0.75), (0.97, 0.85, 0.25)
WHITE, GREY = (1.0, 1.0, 1.0), (0.6, 0.6, 0.6)

Mask = NDArray[np.bool_]


def _samples() -> tuple[NDArray[Any], NDArray[Any]]:
    rows, columns = np.indices((FINE * SIZE[0], FINE * SIZE[1]))
    return (columns + 0.5) / FINE, (rows + 0.5) / FINE


X, Y = _samples()


def disc(x: float, y: float, radius: float) -> Mask:
    return np.asarray(np.hypot(X - x, Y - y) <= radius)


def box(left: float, top: float, right: float, bottom: float) -> Mask:
    return np.asarray((left <= X) & (right >= X) & (top <= Y) & (bottom >= Y))


def picture(*layers: tuple[Mask, Any], ground: Any = WHITE) -> NDArray[np.float64]:
    """Paint layers over a ground, at 8 bits, each pixel the mean of its samples."""
    image = np.ones((*X.shape, 3)) * ground
    for mask, color in layers:
        image[mask] = color
    mean = image.reshape(SIZE[0], FINE, SIZE[1], FINE, 3).mean(axis=(1, 3))
    return np.asarray(np.round(255 * mean) / 255)


def found(image: NDArray[Any], ground: Any = WHITE) -> list[tuple[Mask, NDArray[Any]]]:
    layers = find_layers(with_parts(flat_regions(image), np.array(ground)), np.array(ground))
    result = []
    for layer in layers:
        mask = np.zeros(SIZE, bool)
        for points in layer.outlines:
            mask ^= polygon2mask(SIZE, points[:, ::-1] - 0.5)
        result.append((mask, layer.color))
    return result


def overlap(mask: Mask, wanted: Mask) -> float:
    whole = wanted.reshape(SIZE[0], FINE, SIZE[1], FINE).mean(axis=(1, 3)) >= 0.5
    return float((mask & whole).sum() / (mask | whole).sum())


def check(image: NDArray[Any], *wanted: tuple[Mask, Any], ground: Any = WHITE, least: float = 0.95) -> None:
    """The layers are these and no others, in this order."""
    layers = found(image, ground)
    assert len(layers) == len(wanted)
    for (mask, color), (shape, paint) in zip(layers, wanted, strict=True):
        assert np.abs(color - paint).max() < 0.02
        assert overlap(mask, shape) > least
