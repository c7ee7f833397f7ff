# SPDX-License-Identifier: Apache-2.0
"""`State`: the variables of training, and all that a step depends on."""

from __future__ import annotations

import copy
import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import concatenate
from livecl.drawing.drawing import Drawing
from livecl.options import Options
from livecl.training.adam import Adam
from livecl.training.archive import (
    Arrays,
    adam_arrays,
    adam_from,
    drawing_arrays,
    drawing_from,
    fill_arrays,
    fills_from,
)
from livecl.training.fills import FillMoments

_FORMAT = 6
#: Fields that JSON holds as they are, and those of moments.
_FACTS, _ADAMS = ("stage", "iteration", "length", "keeps_colors"), ("points", "colors", "widths", "background")

#: Holds of a layer: free; trained but never dropped, merged or replaced; unchanged.
FREE, KEPT, LOCKED = 0, 1, 2


@dataclasses.dataclass(frozen=True)
class Fallback:
    """A drawing with its moments, holds and visible mean squared error."""

    drawing: Drawing
    points: Adam
    colors: Adam
    widths: Adam
    fills: FillMoments
    holds: NDArray[np.int8]
    error: float


@dataclasses.dataclass
class State:
    """A drawing in training, between two iterations."""

    drawing: Drawing  # layers so far, neither rounded nor quantized to 8 bits
    options: Options  # parameters of the method
    #: The stage or revision that is under way, and its steps so far.
    stage: int
    iteration: int
    length: int  # its total number of steps, as now planned
    #: Moments of the control points, by segment, of colours and widths of strokes, by layer, and of the background.
    points: Adam
    colors: Adam
    widths: Adam
    background: Adam
    fills: FillMoments  # moments of gradient fills
    pieces: NDArray[np.int32]  # (M,), lines that each segment is flattened into
    rng: np.random.Generator  # source of all random choices
    #: (N,): FREE, KEPT (is not dropped, merged or replaced) or LOCKED (does not change), for each layer.
    holds: NDArray[np.int8]
    #: (H, W): distance weight of earlier stages (the released program's loss); or 0 at pixels of layers that a later
    #: stage places (placement by structure), as present layers do not follow the picture there.
    kept_weight: NDArray[Any] | None = None
    #: (M, 3): control points that no pixel depends on, which are not moved (placement by structure).
    hidden: NDArray[np.bool_] | None = None
    keeps_colors: bool = False  # whether the colours of solid layers are fixed, as those of a palette
    losses: tuple[float, ...] = ()  # losses of its last steps

    @classmethod
    def start(cls, drawing: Drawing, options: Options, seed: int, locked: NDArray[np.bool_] | None = None) -> State:
        """Return the state before the first stage; the drawing's layers are KEPT, those of `locked` (N,) LOCKED."""
        return cls(
            drawing=drawing,
            options=options,
            stage=0,
            iteration=0,
            length=options.iterations,
            points=Adam.start(drawing.points.shape),
            colors=Adam.start(drawing.colors.shape),
            widths=Adam.start((drawing.num_layers, 1)),
            background=Adam.start((1, 3)),
            fills=FillMoments.start(drawing.fills),
            pieces=np.ones(drawing.num_segments, np.int32),
            rng=np.random.default_rng(seed),
            holds=np.full(drawing.num_layers, np.where(False if locked is None else locked, LOCKED, KEPT), np.int8),
        )

    def begin_phase(self, length: int) -> None:
        """Begin a phase of `length` steps."""
        self.iteration, self.length, self.losses = 0, length, ()

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Locked layers: (N,)."""
        return self.holds == LOCKED

    @property
    def locked_segments(self) -> NDArray[np.bool_]:
        """Segments of locked layers: (M,)."""
        return self.locked[self.drawing.segment_layers]

    @property
    def free(self) -> NDArray[np.bool_]:
        """Layers that may be dropped, merged or replaced: (N,)."""
        return self.holds == FREE

    def add(self, new: Drawing, order: NDArray[np.intp]) -> None:
        """Add layers; `order` (N + K,) is the paint order of all, with the new ones numbered from N."""
        drawing = concatenate(self.drawing, new)
        segments = np.concatenate([np.flatnonzero(drawing.segment_layers == layer) for layer in order])
        self.points.extend(new.num_segments)
        self.colors.extend(new.num_layers)
        self.widths.extend(new.num_layers)
        before = self.drawing
        self.drawing = drawing.layer_subset(order)
        sources = np.where(order < before.num_layers, order, -1)
        self.fills = self.fills.followed(before.fills, self.drawing.fills, sources)
        self._take(segments, order)
        self.holds = np.concatenate([self.holds, np.full(new.num_layers, FREE, np.int8)])[order]

    def _take(self, segments: NDArray[Any], layers: NDArray[Any]) -> None:
        """Keep the moments of some segments and layers, by index or mask."""
        self.points = self.points.subset(segments)
        self.colors, self.widths = self.colors.subset(layers), self.widths.subset(layers)

    def keep_layers(self, layers: NDArray[Any]) -> None:
        """Remove all layers but these (K,)."""
        segments = np.isin(self.drawing.segment_layers, layers)
        before, self.drawing = self.drawing, self.drawing.layer_subset(layers)
        self.fills = self.fills.followed(before.fills, self.drawing.fills, np.arange(before.num_layers)[layers])
        self._take(segments, layers)
        self.holds = self.holds[layers]
        self.pieces = self.pieces[segments]

    def replace_layers(self, drawing: Drawing, sources: NDArray[np.intp]) -> None:
        """Replace the drawing; `sources` (N,) has each layer's former index, -1 for a new one."""
        old = np.arange(self.drawing.num_segments)
        ranges = [old[self.drawing.segment_layers == layer] for layer in range(self.drawing.num_layers)]
        counts = np.diff(drawing.segment_offsets)
        segments = np.concatenate(
            [old[:0], *(ranges[k] if k >= 0 else np.full(n, -1) for k, n in zip(sources, counts, strict=True))]
        )
        self._take(segments, sources)
        self.points.forget(segments < 0)
        for moments in (self.colors, self.widths):
            moments.forget(sources < 0)
        self.holds = np.where(sources < 0, FREE, self.holds[sources]).astype(np.int8)
        self.fills = self.fills.followed(self.drawing.fills, drawing.fills, sources)
        if self.hidden is not None and len(self.hidden) == self.drawing.num_segments:
            self.hidden = self.hidden[segments] & (segments >= 0)[:, None]
        self.drawing = drawing
        self.pieces = np.ones(drawing.num_segments, np.int32)  # until they are chosen

    def replace_fills(self, drawing: Drawing) -> None:
        """Replace the fills of the layers."""
        self.fills = self.fills.followed(self.drawing.fills, drawing.fills, np.arange(drawing.num_layers))
        self.drawing = drawing

    def recolor(self, drawing: Drawing) -> None:
        """Replace the colours of the layers, and fix them."""
        self.drawing, self.keeps_colors = drawing, True
        self.colors = Adam.start(drawing.colors.shape)

    def fall_back(self, error: float) -> Fallback:
        """Return the drawing, whose visible mean squared error is `error`, for :meth:`restore`."""
        points, colors, widths = (moments.subset(slice(None)) for moments in (self.points, self.colors, self.widths))
        return Fallback(self.drawing, points, colors, widths, self.fills.copy(), self.holds, error)

    def restore(self, fallback: Fallback) -> None:
        """Return to an earlier drawing."""
        self.drawing, self.points, self.colors = fallback.drawing, fallback.points, fallback.colors
        self.widths, self.fills, self.holds = fallback.widths, fallback.fills, fallback.holds

    def copy(self) -> State:
        """Return an independent copy; drawings and arrays that are never changed in place are shared."""
        return dataclasses.replace(
            self,
            **{name: getattr(self, name).subset(slice(None)) for name in _ADAMS},
            fills=self.fills.copy(),
            rng=copy.deepcopy(self.rng),
        )

    def parts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the state as facts, which JSON can hold, and arrays by name."""
        arrays: dict[str, Any] = {"pieces": self.pieces, "holds": self.holds, **drawing_arrays("", self.drawing)}
        for name in _ADAMS:
            arrays |= adam_arrays(name, getattr(self, name))
        arrays |= fill_arrays("", self.drawing, self.fills)
        if self.kept_weight is not None:
            arrays["kept_weight"] = self.kept_weight
        if self.hidden is not None:
            arrays["hidden"] = self.hidden
        facts = {
            "format": _FORMAT,
            "size": self.drawing.size,
            "options": dataclasses.asdict(self.options),
            "losses": self.losses,
            "rng": self.rng.bit_generator.state,
            **{name: getattr(self, name) for name in _FACTS},
        }
        return facts, arrays

    @classmethod
    def of_parts(cls, facts: dict[str, Any], arrays: Arrays) -> State:
        """Return the state from its :meth:`parts`; raises one of `UNREADABLE` if they are invalid."""
        if facts["format"] != _FORMAT:
            raise ValueError(f"format {facts['format']}, wanted {_FORMAT}")
        rng = np.random.default_rng()
        rng.bit_generator.state = facts["rng"]
        drawing = drawing_from("", arrays, facts["size"])
        moments: dict[str, Any] = {name: adam_from(name, arrays) for name in _ADAMS}
        return cls(
            drawing=drawing,
            fills=fills_from("", arrays, drawing),
            options=Options(**facts["options"]),
            losses=tuple(facts["losses"]),
            pieces=arrays["pieces"],
            rng=rng,
            holds=arrays["holds"],
            kept_weight=arrays.get("kept_weight"),
            hidden=arrays.get("hidden"),
            **moments,
            **{name: facts[name] for name in _FACTS},
        )
