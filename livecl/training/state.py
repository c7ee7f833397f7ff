# SPDX-License-Identifier: Apache-2.0
"""`State`: everything that a run needs to go on, in one object that can be saved."""

from __future__ import annotations

import copy
import dataclasses
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import concatenate
from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.options import Options
from livecl.training.adam import Adam
from livecl.training.archive import (
    UNREADABLE,
    Arrays,
    adam_arrays,
    adam_from,
    drawing_arrays,
    drawing_from,
    fill_arrays,
    fills_from,
    read_archive,
    write_archive,
)
from livecl.training.fills import FillMoments

_FORMAT = 4

#: Permissions of a layer: everything; moving and colouring; nothing.
FREE, KEPT, LOCKED = 0, 1, 2


@dataclasses.dataclass(frozen=True)
class Fallback:
    """A drawing with the moments and the holds that belong to it."""

    drawing: Drawing
    points: Adam
    colors: Adam
    fills: FillMoments
    holds: NDArray[np.int8]


@dataclasses.dataclass
class State:
    """A run between two iterations.

    Attributes
    ----------
    drawing : Drawing
        Layers so far, as trained: neither rounded nor snapped to 8 bits.
    options : Options
        Parameters of the method.
    schedule : tuple of int
        Paths that each stage adds; 0 for a refinement. Revisions follow.
    stage, iteration : int
        The stage or revision that is under way, and its steps so far.
    points, colors, background : Adam
        Moments of the control points, by segment, of the colours, by layer, and of the background.
    fills : FillMoments
        Moments of gradient fills.
    pieces : (M,) int
        Lines that each segment is flattened into.
    rng : numpy.random.Generator
        Source of whatever is random.
    holds : (N,) int8
        FREE, KEPT (is not dropped, merged or replaced) or LOCKED (stays as it is), for each layer.
    start_drawing : Drawing or None
        Drawing to start from, if any.
    kept_weight : (H, W) float or None
        Distance weight that earlier stages left (the released program's loss); or 0 where layers will show that a later
        stage places (placement by structure): what is there now does not follow the picture there.
    hidden : (M, 3) bool or None
        Control points that no pixel decides on, which stay where they are (placement by structure).
    asked : int
        Paths that the stages begun so far were to add: revisions keep their number.
    error : float
        Visible mean squared error after the last stage, where `Options.target_mse` or `Options.path_gain` need it.
    placed : bool
        Whether the paths of the stage are placed: it has begun.
    failures : int
        Revisions in a row that did not lower the error.
    fallback : Fallback or None
        State to return to if the refinement or revision under way does not lower the error.
    """

    drawing: Drawing
    options: Options
    schedule: tuple[int, ...]
    stage: int
    iteration: int
    points: Adam
    colors: Adam
    background: Adam
    fills: FillMoments
    pieces: NDArray[np.int32]
    rng: np.random.Generator
    holds: NDArray[np.int8]
    start_drawing: Drawing | None = None
    kept_weight: NDArray[Any] | None = None
    asked: int = 0
    hidden: NDArray[np.bool_] | None = None
    error: float = float("inf")
    placed: bool = False
    failures: int = 0
    fallback: Fallback | None = None

    @classmethod
    def start(
        cls,
        drawing: Drawing,
        options: Options,
        schedule: tuple[int, ...],
        seed: int,
        locked: NDArray[np.bool_] | None = None,
    ) -> State:
        """Return the state before the first stage, from a drawing whose layers are kept, some of them, (N,), locked."""
        return cls(
            drawing=drawing,
            options=options,
            schedule=schedule,
            stage=0,
            iteration=0,
            points=Adam.start(drawing.points.shape),
            colors=Adam.start(drawing.colors.shape),
            background=Adam.start((1, 3)),
            fills=FillMoments.start(drawing.fills),
            pieces=np.ones(drawing.num_segments, np.int32),
            rng=np.random.default_rng(seed),
            holds=np.where(np.zeros(drawing.num_layers, bool) if locked is None else locked, LOCKED, KEPT).astype(
                np.int8
            ),
            start_drawing=drawing if drawing.num_layers else None,
        )

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Layers that stay as they are: (N,)."""
        return self.holds == LOCKED

    @property
    def locked_segments(self) -> NDArray[np.bool_]:
        """Segments of layers that stay as they are: (M,)."""
        return self.locked[self.drawing.segment_layers]

    @property
    def free(self) -> NDArray[np.bool_]:
        """Layers that may be dropped, merged or replaced: (N,)."""
        return self.holds == FREE

    def add(self, new: Drawing, order: NDArray[np.intp]) -> None:
        """Add layers; `order` (N + K,) is the paint order of all, the new ones being numbered from N on."""
        drawing = concatenate(self.drawing, new)
        segments = np.concatenate([np.flatnonzero(drawing.segment_layers == layer) for layer in order])
        self.points.extend(new.num_segments)
        self.colors.extend(new.num_layers)
        before = self.drawing
        self.drawing = drawing.layer_subset(order)
        sources = np.where(order < before.num_layers, order, -1)
        self.fills = self.fills.followed(before.fills, self.drawing.fills, sources)
        self.points, self.colors = self.points.subset(segments), self.colors.subset(order)
        self.holds = np.concatenate([self.holds, np.full(new.num_layers, FREE, np.int8)])[order]

    def keep_layers(self, layers: NDArray[Any]) -> None:
        """Take out all layers but these (K,)."""
        segments = np.isin(self.drawing.segment_layers, layers)
        before, self.drawing = self.drawing, self.drawing.layer_subset(layers)
        self.fills = self.fills.followed(before.fills, self.drawing.fills, np.arange(before.num_layers)[layers])
        self.points, self.colors = self.points.subset(segments), self.colors.subset(layers)
        self.holds = self.holds[layers]
        self.pieces = self.pieces[segments]

    def replace_layers(self, drawing: Drawing, sources: NDArray[np.intp]) -> None:
        """Go on with another drawing: `sources` (N,) has the number that each layer had before, -1 for a new one."""
        old = np.arange(self.drawing.num_segments)
        ranges = [old[self.drawing.segment_layers == layer] for layer in range(self.drawing.num_layers)]
        counts = np.diff(drawing.segment_offsets)
        segments = np.concatenate(
            [old[:0], *(ranges[k] if k >= 0 else np.full(n, -1) for k, n in zip(sources, counts, strict=True))]
        )
        self.points, self.colors = self.points.subset(segments), self.colors.subset(sources)
        self.points.forget(segments < 0)
        self.colors.forget(sources < 0)
        self.holds = np.where(sources < 0, FREE, self.holds[sources]).astype(np.int8)
        self.fills = self.fills.followed(self.drawing.fills, drawing.fills, sources)
        self.drawing = drawing
        self.pieces = np.ones(drawing.num_segments, np.int32)  # until they are chosen

    def replace_fills(self, drawing: Drawing) -> None:
        """Go on with the same layers filled otherwise."""
        self.fills = self.fills.followed(self.drawing.fills, drawing.fills, np.arange(drawing.num_layers))
        self.drawing = drawing

    def fall_back(self) -> Fallback:
        """Return the state for :meth:`restore`."""
        points, colors = self.points.subset(slice(None)), self.colors.subset(slice(None))
        return Fallback(self.drawing, points, colors, self.fills.copy(), self.holds)

    def restore(self, fallback: Fallback) -> None:
        """Return to an earlier drawing."""
        self.drawing, self.points, self.colors = fallback.drawing, fallback.points, fallback.colors
        self.fills, self.holds = fallback.fills, fallback.holds

    def copy(self) -> State:
        """Return a state that does not change with this one; drawings and other arrays are never changed in place."""
        return dataclasses.replace(
            self,
            points=self.points.subset(slice(None)),
            colors=self.colors.subset(slice(None)),
            background=self.background.subset(slice(None)),
            fills=self.fills.copy(),
            rng=copy.deepcopy(self.rng),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the state to a file, replacing an existing one atomically."""
        write_archive(path, *self.parts())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> State:
        """Read a state that :meth:`save` wrote.

        Raises
        ------
        LiveclError
            If the file is not one.
        """
        try:
            return cls.of_parts(*read_archive(path))
        except UNREADABLE as error:
            raise LiveclError(f"{os.fspath(path)!r} is not a saved state of livecl: {error}") from error

    def parts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return all that makes the state as facts, which JSON can hold, and arrays by name."""
        arrays: dict[str, Any] = {"pieces": self.pieces, "holds": self.holds, **drawing_arrays("", self.drawing)}
        for name in ("points", "colors", "background"):
            arrays |= adam_arrays(name, getattr(self, name))
        arrays |= fill_arrays("", self.drawing, self.fills)
        if self.kept_weight is not None:
            arrays["kept_weight"] = self.kept_weight
        if self.hidden is not None:
            arrays["hidden"] = self.hidden
        if self.start_drawing is not None:
            arrays |= drawing_arrays("start.", self.start_drawing)
        if self.fallback is not None:
            arrays |= drawing_arrays("fallback.", self.fallback.drawing) | {"fallback.holds": self.fallback.holds}
            arrays |= adam_arrays("fallback.points", self.fallback.points)
            arrays |= adam_arrays("fallback.colors", self.fallback.colors)
            arrays |= fill_arrays("fallback.", self.fallback.drawing, self.fallback.fills)
        facts = {
            "format": _FORMAT,
            "size": self.drawing.size,
            "options": dataclasses.asdict(self.options),
            "schedule": self.schedule,
            "stage": self.stage,
            "iteration": self.iteration,
            "asked": self.asked,
            "error": self.error,
            "placed": self.placed,
            "failures": self.failures,
            "rng": self.rng.bit_generator.state,
        }
        return facts, arrays

    @classmethod
    def of_parts(cls, facts: dict[str, Any], arrays: Arrays) -> State:
        """Return the state that :meth:`parts` took apart; raises one of `UNREADABLE` where they make none."""
        if facts["format"] != _FORMAT:
            raise ValueError(f"format {facts['format']}, wanted {_FORMAT}")
        rng = np.random.default_rng()
        rng.bit_generator.state = facts["rng"]
        fallback = None
        if "fallback.points" in arrays:
            earlier = drawing_from("fallback.", arrays, facts["size"])
            fallback = Fallback(
                earlier,
                adam_from("fallback.points", arrays),
                adam_from("fallback.colors", arrays),
                fills_from("fallback.", arrays, earlier),
                arrays["fallback.holds"],
            )
        drawing = drawing_from("", arrays, facts["size"])
        return cls(
            drawing=drawing,
            fills=fills_from("", arrays, drawing),
            options=Options(**facts["options"]),
            schedule=tuple(facts["schedule"]),
            stage=facts["stage"],
            iteration=facts["iteration"],
            points=adam_from("points", arrays),
            colors=adam_from("colors", arrays),
            background=adam_from("background", arrays),
            pieces=arrays["pieces"],
            rng=rng,
            holds=arrays["holds"],
            start_drawing=drawing_from("start.", arrays, facts["size"]) if "start.points" in arrays else None,
            kept_weight=arrays.get("kept_weight"),
            asked=facts["asked"],
            hidden=arrays.get("hidden"),
            error=facts["error"],
            placed=facts["placed"],
            failures=facts["failures"],
            fallback=fallback,
        )
