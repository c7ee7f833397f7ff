# SPDX-License-Identifier: Apache-2.0
"""`Drawing`: a canvas with layers of closed cubic Bézier paths, in packed arrays."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, Int32Array
from livecl.drawing import checks
from livecl.drawing.colors import format_rgb
from livecl.drawing.fills import MAX_COORDINATE, Fills, checked_fills
from livecl.drawing.labels import layer_labels, select_layers
from livecl.drawing.strokes import Strokes, checked_strokes
from livecl.errors import name_hint

if TYPE_CHECKING:
    from livecl.svg.writer import LayerStyle

#: Expectations in messages on wrong arguments.
WANTED_DRAWING = "a livecl.Drawing, as of livecl.read_svg"


@dataclasses.dataclass(frozen=True, eq=False, init=False, repr=False)
class Drawing:
    """Layers of closed cubic Bézier paths over a background.

    A row of `points` is a segment (anchor, handle, handle): the next row's anchor ends it, the subpath's first anchor
    ends the subpath's last segment. A subpath is a closed run of segments; a layer is one or more subpaths, filled
    together by the nonzero rule with one fill; layer 0 is painted first. The arrays are read-only copies: use
    :meth:`replace` to change one.

    Parameters
    ----------
    points : (M, 3, 2) array_like
        Control points (x, y), px, y down; pixel centres lie at (column + 0.5, row + 0.5).
    colors : (N, 4) array_like
        Straight RGBA in [0, 1] of each layer's fill; A is the opacity. For layers with a gradient, it is set to the
        gradient's mean, so that it is opaque only if the gradient is.
    size : (int, int)
        Height and width of the canvas, px.
    background : (3,) array_like or None
        Opaque RGB in [0, 1] below all layers; None for a transparent canvas.
    subpath_offsets : (S + 1,) array_like of int, optional
        Subpath s has the segments ``subpath_offsets[s]:subpath_offsets[s + 1]``.
    layer_offsets : (N + 1,) array_like of int, optional
        Layer n has the subpaths ``layer_offsets[n]:layer_offsets[n + 1]``.
        Without offsets, the M segments are shared equally by the N layers, one subpath each.
    stages : (N,) array_like of int, optional
        Stage of the run that added each layer (default: 0).
    names : (N,) sequence of str, optional
        Name of each layer, "" for none (the default). Reduced to one line of at most 120 printable characters.
    fills : Fills, optional
        Kind, geometry and stops of gradients; by default, all layers are solid.
    strokes : Strokes, optional
        Width, caps and joins of the layers that are stroked instead of filled; by default, all are filled.
    groups : (N,) sequence of sequence of str, optional
        Names of the groups around each layer, the outermost first (default: none). Neighbouring layers of one group are
        written as a group; names are cleaned as those of layers.

    Raises
    ------
    ValueError
        If shapes, offsets or numbers do not fit together; the message names the argument.
    """

    points: FloatArray
    colors: FloatArray
    size: tuple[int, int]
    background: FloatArray | None
    subpath_offsets: Int32Array
    layer_offsets: Int32Array
    stages: Int32Array
    names: tuple[str, ...]
    fills: Fills
    strokes: Strokes
    groups: tuple[tuple[str, ...], ...]

    def __init__(
        self,
        *,
        points: ArrayLike,
        colors: ArrayLike,
        size: tuple[int, int],
        background: ArrayLike | None = (1.0, 1.0, 1.0),
        subpath_offsets: ArrayLike | None = None,
        layer_offsets: ArrayLike | None = None,
        stages: ArrayLike | None = None,
        names: Sequence[str] | None = None,
        fills: Fills | None = None,
        strokes: Strokes | None = None,
        groups: Sequence[Sequence[str]] | None = None,
    ) -> None:
        floats = checks.checked_floats
        values: dict[str, Any] = {"size": checks.checked_size(size)}
        values["points"] = floats("points", points, (-1, 3, 2), -MAX_COORDINATE, MAX_COORDINATE)
        values["colors"] = floats("colors", colors, (-1, 4), 0.0, 1.0)
        values["background"] = None if background is None else floats("background", background, (3,), 0.0, 1.0)
        num_segments, num_layers = len(values["points"]), len(values["colors"])
        if (subpath_offsets is None) != (layer_offsets is None):
            raise ValueError("subpath_offsets and layer_offsets must be given together, or neither")
        if subpath_offsets is None:
            if num_layers and (num_segments % num_layers or not num_segments):
                raise ValueError(
                    f"points: {num_segments} segments cannot be shared equally by {num_layers} layers; "
                    "give subpath_offsets and layer_offsets"
                )
            subpath_offsets = np.linspace(0, num_segments, num_layers + 1)
            layer_offsets = np.arange(num_layers + 1)
        if not num_layers and num_segments:
            raise ValueError(f"points: {num_segments} segments belong to no layer, as colors is empty")
        values["subpath_offsets"] = checks.checked_offsets("subpath_offsets", subpath_offsets, None, num_segments)
        num_subpaths = len(values["subpath_offsets"]) - 1
        values["layer_offsets"] = checks.checked_offsets("layer_offsets", layer_offsets, num_layers, num_subpaths)
        values["stages"] = checks.checked_integers("stages", np.zeros(num_layers) if stages is None else stages)
        if values["stages"].shape != (num_layers,):
            raise ValueError(f"stages: shape {values['stages'].shape}, wanted ({num_layers},)")
        values["names"] = ("",) * num_layers if names is None else checks.checked_names(names, num_layers)
        values["groups"] = ((),) * num_layers if groups is None else checks.checked_groups(groups, num_layers)
        values["fills"] = checked_fills(fills, num_layers)
        values["strokes"] = checked_strokes(strokes, values["layer_offsets"], values["subpath_offsets"])
        ends = values["subpath_offsets"][1:][values["strokes"].is_open] - 1
        values["points"][ends, 1:] = values["points"][ends, :1]  # unused handles
        if values["fills"].any_gradients:
            values["colors"][values["fills"].gradient_layers] = values["fills"].mean_colors()
        for value in values.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(values)

    @classmethod
    def from_outlines(
        cls,
        outlines: Sequence[Sequence[ArrayLike]],
        colors: ArrayLike,
        size: tuple[int, int],
        background: ArrayLike | None = (1.0, 1.0, 1.0),
        stages: ArrayLike | None = None,
        names: Sequence[str] | None = None,
        fills: Fills | None = None,
        strokes: Strokes | None = None,
        groups: Sequence[Sequence[str]] | None = None,
    ) -> Drawing:
        """Make a drawing from the outlines of its layers.

        Parameters
        ----------
        outlines : sequence of sequence of (s, 3, 2) array_like
            Subpaths of each layer, bottom first: closed runs of segments (anchor, handle, handle), px.
        colors : (N, 4) or (4,) array_like
            Straight RGBA in [0, 1] of each layer's fill, or of all.
        size, background, stages, names, fills, strokes, groups
            As for :class:`Drawing`.
        """
        subpaths = [np.asarray(subpath, dtype=np.float64) for outline in outlines for subpath in outline]
        return cls(
            points=np.concatenate([np.zeros((0, 3, 2)), *subpaths]),
            colors=np.broadcast_to(np.reshape(colors, (-1, 4)), (len(outlines), 4)),
            size=size,
            background=background,
            subpath_offsets=np.cumsum([0, *map(len, subpaths)]),
            layer_offsets=np.cumsum([0, *map(len, outlines)]),
            stages=stages,
            names=names,
            fills=fills,
            strokes=strokes,
            groups=groups,
        )

    def subpaths(self, layer: int | None = None) -> list[slice]:
        """Return the segments of each subpath of a layer, or of all layers: slices of `points` and `cubics`."""
        first, end = (0, None) if layer is None else self.layer_offsets[layer : layer + 2]
        offsets = self.subpath_offsets[first : None if end is None else end + 1].tolist()
        return [slice(start, stop) for start, stop in itertools.pairwise(offsets)]

    @property
    def num_layers(self) -> int:
        """Number of layers, N."""
        return len(self.colors)

    @property
    def num_segments(self) -> int:
        """Number of cubic segments, M."""
        return len(self.points)

    @functools.cached_property
    def segment_offsets(self) -> Int32Array:
        """First segment of each layer, and M at the end: (N + 1,) int."""
        return self.subpath_offsets[self.layer_offsets]

    @functools.cached_property
    def segment_layers(self) -> Int32Array:
        """Layer of each segment: (M,) int."""
        return np.repeat(np.arange(self.num_layers, dtype=np.int32), np.diff(self.segment_offsets))

    @functools.cached_property
    def next_segments(self) -> Int32Array:
        """Segment whose anchor ends each segment: (M,) int, a permutation."""
        following = np.arange(1, self.num_segments + 1, dtype=np.int32)
        following[self.subpath_offsets[1:] - 1] = self.subpath_offsets[:-1]
        return following

    @property
    def cubics(self) -> FloatArray:
        """The four control points of every segment: (M, 4, 2)."""
        return np.concatenate([self.points, self.points[self.next_segments, :1]], axis=1)

    def replace(self, **changes: Any) -> Drawing:
        """Return a copy with some arguments changed.

        Raises
        ------
        TypeError
            If there is no such argument; the message names the nearest.
        ValueError
            If a value is not usable, or does not fit the other arguments.
        """
        for name in changes:
            if name not in self.__dataclass_fields__:
                raise TypeError(f"Drawing: there is no argument {name!r}; {name_hint(name, self.__dataclass_fields__)}")
        try:
            return dataclasses.replace(self, **changes)
        except ValueError as error:
            argument, _, reason = str(error).partition(": ")
            if argument in changes or argument not in self.__dataclass_fields__:
                raise
            given = f"{' and '.join(changes)}: the drawing's own {argument} no longer fit"
            raise ValueError(f"{given} ({reason}); give these too") from error

    def moved(
        self,
        points: FloatArray,
        colors: FloatArray,
        background: FloatArray | None,
        fills: Fills | None = None,
        strokes: Strokes | None = None,
    ) -> Drawing:
        """Return the drawing with other numbers and the same structure, unchecked, for inner loops.

        The arrays are not copied; the caller must not change them afterwards. `fills` have the same kinds and numbers
        of stops (:meth:`Fills.moved`), or are None for those of this drawing; likewise `strokes`
        (:meth:`Strokes.moved`).
        """
        drawing = object.__new__(Drawing)
        drawing.__dict__.update(self.__dict__, points=points, colors=colors, background=background)
        if fills is not None and fills.any_gradients:
            colors = colors.copy()
            colors[fills.gradient_layers] = fills.mean_colors()
            drawing.__dict__.update(colors=colors, fills=fills)
        if strokes is not None:
            drawing.__dict__.update(strokes=strokes)
        return drawing

    def same_structure(self, other: Drawing) -> bool:
        """Return whether `other` shares this drawing's offsets: one was made from the other by :meth:`moved`."""
        return (
            self.subpath_offsets is other.subpath_offsets
            and self.layer_offsets is other.layer_offsets
            and self.fills.kinds is other.fills.kinds
            and self.strokes.is_open is other.strokes.is_open
        )

    def layer_subset(self, keep: ArrayLike) -> Drawing:
        """Return the drawing of some of its layers, by mask or by index.

        Parameters
        ----------
        keep : (N,) array_like of bool or (K,) array_like of int
            Layers to keep, as a mask or as indices in the wanted paint order.

        Returns
        -------
        Drawing
            K layers on the same canvas.
        """
        layers = np.arange(self.num_layers)[np.asarray(keep)]
        subpaths = _ranges(self.layer_offsets, layers)
        segments = _ranges(self.subpath_offsets, subpaths)
        return self.replace(
            points=self.points[segments],
            colors=self.colors[layers],
            subpath_offsets=_offsets(np.diff(self.subpath_offsets)[subpaths]),
            layer_offsets=_offsets(np.diff(self.layer_offsets)[layers]),
            stages=self.stages[layers],
            names=[self.names[layer] for layer in layers],
            groups=[self.groups[layer] for layer in layers],
            fills=self.fills.subset(layers),
            strokes=self.strokes.subset(layers, subpaths),
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each layer, by default made of colour, shape and place, such as ``orange circle left``."""
        return layer_labels(self)

    def select(self, spec: int | str) -> NDArray[np.int64]:
        """Select layers by index, name or colour.

        Parameters
        ----------
        spec : int or str
            The first that matches of: an index from 0, the bottom layer, also as text; a whole label, or a group's
            name; ignoring case, a part of a label, or the colour of the fill or of a stop, to 8 bits: ``#rrggbb``, a
            CSS name.

        Returns
        -------
        (K,) int64
            Indices of at least one layer, ascending.

        Raises
        ------
        ValueError
            If no layer matches; the message lists the labels.
        """
        return select_layers(self, spec)

    def save_svg(self, path: str | os.PathLike[str], precision: int = 3, layers: LayerStyle = "inkscape") -> None:
        """Write the drawing as SVG, replacing an existing file atomically; see :func:`livecl.svg.save_svg`."""
        from livecl.svg.writer import save_svg

        save_svg(self, path, precision, layers)

    def __repr__(self) -> str:
        ground = "no background" if self.background is None else f"background {format_rgb(self.background)}"
        (height, width), layers, segments = self.size, self.num_layers, self.num_segments
        return f"<Drawing of {layers} layers, {segments} segments, {width} x {height} px, {ground}>"

    def _repr_svg_(self) -> str:
        from livecl.svg.writer import format_svg

        return format_svg(self)


def _offsets(counts: Int32Array) -> Int32Array:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def _ranges(offsets: Int32Array, items: NDArray[Any]) -> NDArray[Any]:
    """Return the indices of all members of the given items, in their order."""
    parts = [np.arange(offsets[i], offsets[i + 1]) for i in items]
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)
