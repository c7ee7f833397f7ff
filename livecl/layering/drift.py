# SPDX-License-Identifier: Apache-2.0
"""Detect shading: whether colour drifts smoothly, as in a gradient, or jumps between flat colours."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from scipy import ndimage

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray
from livecl.layering.stack import window_of

#: Largest range of colour in 3 x 3 pixels that counts as flat; largest second difference of colour on a ramp (two
#: values rounded to 8 bits, and the middle one twice).
FLAT, BEND = 0.6 / 255, 2.1 / 255
#: Share of flat pixels below which colour counts as drifting. Above it, colour drifts if as many pixels slope, or if
#: smooth changes make up more than `DRIFT_SHARE` of all changes.
FLAT_SHARE, DRIFT_SHARE = 0.1, 0.5


def _within(extreme: np.ufunc, image: FloatArray) -> FloatArray:
    """Return the largest or the smallest values within 3 x 3 pixels, by `np.maximum` or `np.minimum`: (H, W, C).

    By shifted views: a third of the time of ndimage's filters.
    """
    for axis in (0, 1):
        interruption.check()
        values = np.moveaxis(image, axis, 0)
        found = values.copy()
        extreme(found[1:], values[:-1], out=found[1:])
        extreme(found[:-1], values[1:], out=found[:-1])
        image = np.moveaxis(found, 0, axis)
    return image


@dataclasses.dataclass(frozen=True, eq=False)
class Changes:
    """Colour changes from pixel to pixel."""

    flat: BoolArray  # (H, W), pixels whose 3 x 3 neighbourhood has one colour
    smooth: BoolArray  # (H, W), pixels whose second differences of colour are within rounding
    right: FloatArray  # (H, W - 1), largest change of a channel to the pixel on the right
    down: FloatArray  # (H - 1, W), the same to the pixel below

    @classmethod
    def of(cls, image: FloatArray) -> Changes:
        """Measure the colour changes of a picture (H, W, C)."""
        span = _within(np.maximum, image) - _within(np.minimum, image)
        bend = np.zeros(image.shape[:2])
        for axis in (0, 1):
            interruption.check()
            bends = ndimage.convolve1d(image, [1.0, -2.0, 1.0], axis=axis, mode="nearest")
            bend = np.maximum(bend, np.abs(bends).max(axis=-1))
        interruption.check()
        down, right = (np.abs(np.diff(image, axis=axis)).max(axis=-1) for axis in (0, 1))
        return cls(span.max(axis=-1) <= FLAT, bend <= BEND, right, down)

    @functools.cached_property
    def _sloping(self) -> BoolArray:
        """Pixels with a smooth but not flat 3 x 3 neighbourhood."""
        return np.asarray(ndimage.minimum_filter(self.smooth, 3) & ~self.flat)

    def drift(self, own: BoolArray) -> bool:
        """Whether colour drifts smoothly within some pixels (H, W), not jumping from one flat colour to another."""
        window = window_of(own)
        own, smooth = own[window], self.smooth[window]
        flat = np.count_nonzero(self.flat[window][own])
        if flat < FLAT_SHARE * np.count_nonzero(own) or flat <= np.count_nonzero(self._sloping[window][own]):
            return True
        drifts = jumps = 0.0
        across, along = self.right[window[0]], self.down[:, window[1]]
        across = across[:, window[1].start :][:, : max(own.shape[1] - 1, 0)]
        along = along[window[0].start :][: max(len(own) - 1, 0)]
        for change, first, second in ((across, np.s_[:, :-1], np.s_[:, 1:]), (along, np.s_[:-1], np.s_[1:])):
            both = own[first] & own[second]
            even = smooth[first] & smooth[second]
            drifts += float(change[both & even].sum())
            jumps += float(change[both & ~even].sum())
        return drifts > DRIFT_SHARE * (drifts + jumps)
