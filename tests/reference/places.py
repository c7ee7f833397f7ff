# SPDX-License-Identifier: Apache-2.0
"""Places t of pixel centres in gradients, and how far single precision may lie from them.

With UNIT of each result, there are roundings of

    A, origin, o, 1 / w     1 of each, of the numbers that the host hands over (see `same_numbers`)
    q = p - origin          1 of each coordinate, shared by the pixels of a column or a row
    u = A q                 1 of each product, 1 of the sum          v likewise
    t = |(u, v)|            2 squares, a sum and a root: 2 of t at most, as the root halves those before it
    s = (t - o) / w         1 of the difference, 1 of the product by 1 / w, of up to 1 where it counts
    c + s (c' - c)          4 of up to 1: difference, product, sum, and that of the stop before

An error of t moves s by 1 / w of it, and a colour by c' - c of that.
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import RADIAL, Drawing, Fills
from livecl.rendering import device_drawing
from livecl.rendering.fills import pack_fills, place_maps

FloatArray = NDArray[np.float64]

#: Relative error of one rounding in float32.
UNIT = 2.0**-24

#: Standard deviations allowed. One in 2 million lies beyond 5, and some 100 000 numbers are compared.
DEVIATIONS = 5

#: Variance of a rounding of a number of size 1: it is spread evenly over +-UNIT.
ROUNDING = UNIT**2 / 3

#: Roundings of a share s, and of a colour for each stop.
SHARE_ROUNDINGS, STOP_ROUNDINGS = 3, 4

#: Two stops nearer to each other than this are a step.
STEP = 1e-12


@contextlib.contextmanager
def same_numbers() -> Iterator[None]:
    """Have all rasterizers take the numbers of fills as single precision has them.

    An error of these is shared by all pixels of a layer, and is one of the input: sums over pixels are compared without
    it.
    """

    def rounded(fills: Fills) -> FloatArray:
        return pack_fills(fills).astype(np.float32).astype(np.float64)

    with mock.patch.object(device_drawing, "pack_fills", rounded):
        yield


@dataclasses.dataclass(frozen=True)
class Between:
    """Pixels between two neighbouring stops of a gradient.

    Attributes
    ----------
    stop : int
        Number of the lower stop in the drawing's fills.
    width : float
        w, 0 for a step.
    step : (4,) float
        c' - c.
    share : (H, W) float
        s.
    inside : (H, W) bool
        Where t, or what rounding may make of it, is between the stops.
    doubtful : (H, W) bool
        Where rounding may bring t from one side of a stop to the other.
    variance : (H, W) float
        Of s, where inside.
    """

    stop: int
    width: float
    step: FloatArray
    share: FloatArray
    inside: NDArray[np.bool_]
    doubtful: NDArray[np.bool_]
    variance: FloatArray


@dataclasses.dataclass(frozen=True)
class Places:
    """Places of all pixel centres in a layer's gradient.

    Attributes
    ----------
    t, x, y, u, v : (H, W) float
        Place; q, px; A q.
    variance : (H, W) float
        Of t.
    radial : bool
        Whether t = |(u, v)|.
    between : list of Between
        Of each two neighbouring stops.
    """

    t: FloatArray
    x: FloatArray
    y: FloatArray
    u: FloatArray
    v: FloatArray
    variance: FloatArray
    radial: bool
    between: list[Between]

    @property
    def color_variance(self) -> FloatArray:
        """Variance of a component of the colour, (H, W), beside steps that are taken at the wrong pixel."""
        roundings = (1 + STOP_ROUNDINGS * len(self.between)) * ROUNDING
        moved = [np.where(part.inside, part.variance, 0) * np.max(part.step**2) for part in self.between if part.width]
        return roundings + np.sum(moved, axis=0)

    @property
    def doubtful_steps(self) -> FloatArray:
        """What a component of the colour may be off by where rounding takes a step at the wrong pixel: (H, W)."""
        return np.sum([part.doubtful * np.max(np.abs(part.step)) for part in self.between if not part.width], axis=0)


def gradient_places(drawing: Drawing, moved: float = 0.0) -> dict[int, Places]:
    """Return the places of the layers with a gradient, by layer.

    With `moved`, pixels are doubtful too that a move of a point by as many px, or of a stop, takes past a stop.
    """
    maps, regular = place_maps(drawing.fills)
    return {
        int(layer): _places(drawing, int(layer), maps[layer] if regular[layer] else None, moved)
        for layer in drawing.fills.gradient_layers
    }


def _places(drawing: Drawing, layer: int, matrix: FloatArray | None, moved: float) -> Places:
    fills, (row, column) = drawing.fills, np.indices(drawing.size) + 0.5
    x, y = column - fills.geometry[layer, 0, 0], row - fills.geometry[layer, 0, 1]
    if matrix is None:  # all of the last stop's colour
        t, u, v, variance = np.full(drawing.size, 2.0), *np.zeros((3, *drawing.size))
        band = np.zeros(drawing.size)
    else:
        u, v = matrix[0, 0] * x + matrix[0, 1] * y, matrix[1, 0] * x + matrix[1, 1] * y
        terms = (matrix[:, 0] ** 2).sum() * x**2 + (matrix[:, 1] ** 2).sum() * y**2
        origin = np.sum((matrix * fills.geometry[layer, 0]) ** 2)
        variance = ROUNDING * (3 * terms + origin + u**2 + v**2)
        t = u
        if fills.kinds[layer] == RADIAL:
            t = np.hypot(u, v)
            variance = variance + ROUNDING * 2 * t**2
        # A point's move by e changes A q by up to |A| e (1 + |A q|).
        band = DEVIATIONS * np.sqrt(variance) + moved * (1 + np.linalg.norm(matrix) * (1 + np.hypot(u, v)))
    own = fills.stops(layer)
    numbers = range(own.start, own.stop)
    between = [_between(fills, stop, t, variance, band) for stop in numbers[:-1]]
    return Places(t, x, y, u, v, variance, bool(fills.kinds[layer] == RADIAL), between)


def _between(fills: Fills, stop: int, t: FloatArray, variance: FloatArray, band: FloatArray) -> Between:
    low, high = fills.stop_positions[stop : stop + 2]
    width, band = float(high - low), band + UNIT
    doubtful = (np.abs(t - low) <= band) | (np.abs(t - high) <= band)
    inside = (t >= low - band) & (t <= high + band)
    if width <= STEP:
        width, share = 0.0, np.where(t < low, 0.0, 1.0)
        moved = np.zeros_like(t)
    else:
        share = np.clip((t - low) / width, 0, 1)
        moved = (variance + ROUNDING * low**2) / width**2 + SHARE_ROUNDINGS * ROUNDING
    step = fills.stop_colors[stop + 1] - fills.stop_colors[stop]
    return Between(stop, width, step, share, inside, doubtful, moved)
