# SPDX-License-Identifier: Apache-2.0
"""`Strokes`: widths, caps and joins of a drawing's stroked layers, in packed arrays."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, Int32Array
from livecl.drawing.checks import checked_floats, checked_integers
from livecl.geometry.strokes import CAPS, JOINS

#: Largest width accepted, px.
MAX_WIDTH = 1e5
#: Default miter limit, as in SVG.
DEFAULT_MITER_LIMIT = 4.0
#: Largest miter limit accepted: it allows miters at corners down to a hundredth of a degree.
MAX_MITER = 1e4


@dataclasses.dataclass(frozen=True, eq=False, init=False)
class Strokes:
    """Strokes of N layers with S subpaths; a layer with a width is stroked with its paint, and not filled.

    In a stroked layer, subpaths may be open: of an open subpath's points (two rows or more), the last row is the end of
    its line, and its handles are ignored. The arrays are read-only copies.

    Parameters
    ----------
    widths : (N,) array_like
        Width of each layer's stroke, px; 0 for a filled layer.
    caps, joins : (N,) array_like of int
        Shapes of ends and of corners, indices into ``livecl.geometry.strokes.CAPS`` (butt, round, square) and ``JOINS``
        (miter, round, bevel); 0 for filled layers.
    miter_limits : (N,) array_like
        Largest length of a miter in widths, at least 1 (SVG's ``stroke-miterlimit``).
    is_open : (S,) array_like of bool
        Whether each subpath is open; never in a filled layer.

    Raises
    ------
    ValueError
        If shapes or numbers are not usable; the message names the argument.
    """

    widths: FloatArray
    caps: Int32Array
    joins: Int32Array
    miter_limits: FloatArray
    is_open: NDArray[np.bool_]

    def __init__(
        self,
        *,
        widths: ArrayLike,
        caps: ArrayLike = 0,
        joins: ArrayLike = 0,
        miter_limits: ArrayLike = DEFAULT_MITER_LIMIT,
        is_open: ArrayLike,
    ) -> None:
        widths = checked_floats("strokes.widths", widths, (-1,), 0.0, MAX_WIDTH)
        num = len(widths)
        indices = []
        for name, value, known in (("caps", caps, CAPS), ("joins", joins, JOINS)):
            array = checked_integers(f"strokes.{name}", value)
            if array.shape not in ((), (num,)) or np.any((array < 0) | (array >= len(known))):
                raise ValueError(f"strokes.{name}: got {array}, wanted indices into {known}, one for each layer")
            indices.append(np.where(widths > 0, np.broadcast_to(array, num), 0).astype(np.int32))
        limits = checked_floats("strokes.miter_limits", miter_limits, None, 1.0, MAX_MITER)
        if limits.shape not in ((), (num,)):
            raise ValueError(f"strokes.miter_limits: shape {limits.shape}, wanted ({num},)")
        limits = np.where(widths > 0, np.broadcast_to(limits, num), DEFAULT_MITER_LIMIT)
        opened = np.array(is_open)
        if opened.ndim != 1 or (opened.dtype != np.bool_ and opened.size):
            raise ValueError(f"strokes.is_open: got {opened.dtype} {opened.shape}, wanted one boolean for each subpath")
        self._hold(widths, *indices, limits, opened.astype(np.bool_))

    def _hold(self, *arrays: NDArray[Any]) -> None:
        for field, array in zip(dataclasses.fields(self), arrays, strict=True):
            array.setflags(write=False)
            self.__dict__[field.name] = array

    @classmethod
    @functools.lru_cache(maxsize=256)
    def none(cls, num_layers: int, num_subpaths: int) -> Strokes:
        """Return the strokes of N filled layers, all of width 0."""
        return cls(widths=np.zeros(num_layers), is_open=np.zeros(num_subpaths, bool))

    def __len__(self) -> int:
        """Return the number of layers, N."""
        return len(self.widths)

    @functools.cached_property
    def any(self) -> bool:
        """Whether any layer is stroked."""
        return bool(self.widths.any())

    @property
    def stroked_layers(self) -> NDArray[np.intp]:
        """Indices of the stroked layers, ascending: (K,)."""
        return np.flatnonzero(self.widths)

    def moved(self, widths: FloatArray, pens: Strokes | None = None) -> Strokes:
        """Return strokes of other widths, unchecked, for inner loops; widths of 0 stay 0, others stay above 0.

        Caps, joins and miter limits are those of `pens`, if given.
        """
        strokes = object.__new__(Strokes)
        strokes.__dict__.update(self.__dict__, widths=widths)
        if pens is not None:
            strokes.__dict__.update(caps=pens.caps, joins=pens.joins, miter_limits=pens.miter_limits)
        return strokes

    def quantized(self, precision: int) -> Strokes:
        """Return the strokes as in a saved SVG: widths rounded to `precision` decimals, but not to 0."""
        if not self.any:
            return self
        unit = 10.0**-precision
        return self.with_widths(np.where(self.widths > 0, np.maximum(np.round(self.widths, precision), unit), 0))

    def subset(self, layers: ArrayLike, subpaths: ArrayLike) -> Strokes:
        """Return the strokes of some layers (K,), whose subpaths are `subpaths` (T,), by index."""
        rows = np.asarray(layers, dtype=np.int64)
        return Strokes(
            widths=self.widths[rows],
            caps=self.caps[rows],
            joins=self.joins[rows],
            miter_limits=self.miter_limits[rows],
            is_open=self.is_open[np.asarray(subpaths, dtype=np.int64)],
        )

    def with_widths(self, widths: FloatArray) -> Strokes:
        """Return a copy with other widths (N,), checked."""
        return dataclasses.replace(self, widths=widths)


def concatenate_strokes(parts: Sequence[Strokes]) -> Strokes:
    """Concatenate the strokes of the layers of several drawings."""
    names = [field.name for field in dataclasses.fields(Strokes)]
    return Strokes(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})


def checked_strokes(strokes: Strokes | None, layer_offsets: Int32Array, subpath_offsets: Int32Array) -> Strokes:
    """Return strokes that fit the given offsets; None and strokes without a width fit any."""
    num_layers, num_subpaths = len(layer_offsets) - 1, int(layer_offsets[-1])
    if strokes is None:
        return Strokes.none(num_layers, num_subpaths)
    if not isinstance(strokes, Strokes):
        raise ValueError(f"strokes: got {type(strokes).__name__}, wanted livecl.drawing.Strokes")
    if (len(strokes), len(strokes.is_open)) != (num_layers, num_subpaths):
        if not strokes.any:
            return Strokes.none(num_layers, num_subpaths)
        raise ValueError(
            f"strokes: got those of {len(strokes)} layers and {len(strokes.is_open)} subpaths, wanted {num_layers} and "
            f"{num_subpaths}"
        )
    filled = np.repeat(strokes.widths == 0, np.diff(layer_offsets))
    if (strokes.is_open & filled).any():
        raise ValueError("strokes.is_open: open subpaths must belong to layers with a width")
    if (strokes.is_open & (np.diff(subpath_offsets) < 2)).any():
        raise ValueError("strokes.is_open: an open subpath must have two or more rows, the last one its end")
    return strokes
