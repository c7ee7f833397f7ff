# SPDX-License-Identifier: Apache-2.0
"""`Progress`: the complete state of a run between two iterations, which a checkpoint holds."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.options import Options
from livecl.training.archive import (
    Arrays,
    adam_arrays,
    adam_from,
    drawing_arrays,
    drawing_from,
    fill_arrays,
    fills_from,
)
from livecl.training.state import Fallback, State

#: Fields that JSON holds as they are.
_FACTS = ("placed", "asked", "failures", "error")


@dataclasses.dataclass
class Progress:
    """A run between two iterations: the state of training, and the bookkeeping of the phases."""

    state: State  # drawing and moments, stage and iteration
    #: Paths added by each stage; 0 for a refinement. Revisions follow.
    schedule: tuple[int, ...]
    start_drawing: Drawing | None = None  # drawing to start from, if any
    placed: bool = False  # whether the stage has begun: its paths are placed
    asked: int = 0  # paths requested by the stages begun so far: revisions keep this number
    failures: int = 0  # revisions in a row without (enough) gain
    #: Visible mean squared error after the last stage, if `Options.target_mse` or `Options.path_gain` need it.
    error: float = float("inf")
    fallback: Fallback | None = None  # drawing to return to if the current phase does not lower the error

    @classmethod
    def start(
        cls,
        drawing: Drawing,
        options: Options,
        schedule: tuple[int, ...],
        seed: int,
        locked: NDArray[np.bool_] | None = None,
    ) -> Progress:
        """Return the progress before the first stage; layers of the drawing are KEPT, those of `locked` (N,) LOCKED."""
        state = State.start(drawing, options, seed, locked)
        return cls(state, schedule, drawing if drawing.num_layers else None)

    def copy(self) -> Progress:
        """Return an independent copy."""
        return dataclasses.replace(self, state=self.state.copy())

    def parts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the progress as facts, which JSON can hold, and arrays by name."""
        facts, arrays = self.state.parts()
        facts |= {
            "schedule": self.schedule,
            **{name: getattr(self, name) for name in _FACTS},
            "fallback_error": None if self.fallback is None else self.fallback.error,
        }
        if self.start_drawing is not None:
            arrays |= drawing_arrays("start.", self.start_drawing)
        if self.fallback is not None:
            arrays |= drawing_arrays("fallback.", self.fallback.drawing) | {"fallback.holds": self.fallback.holds}
            for name in ("points", "colors", "widths"):
                arrays |= adam_arrays(f"fallback.{name}", getattr(self.fallback, name))
            arrays |= fill_arrays("fallback.", self.fallback.drawing, self.fallback.fills)
        return facts, arrays

    @classmethod
    def of_parts(cls, facts: dict[str, Any], arrays: Arrays) -> Progress:
        """Return the progress from its :meth:`parts`; raises one of `UNREADABLE` if they are invalid."""
        fallback = None
        if "fallback.points" in arrays:
            moments = {name: adam_from(f"fallback.{name}", arrays) for name in ("points", "colors", "widths")}
            earlier = drawing_from("fallback.", arrays, facts["size"])
            fallback = Fallback(
                drawing=earlier,
                fills=fills_from("fallback.", arrays, earlier),
                holds=arrays["fallback.holds"],
                error=facts["fallback_error"],
                **moments,
            )
        return cls(
            state=State.of_parts(facts, arrays),
            schedule=tuple(facts["schedule"]),
            start_drawing=drawing_from("start.", arrays, facts["size"]) if "start.points" in arrays else None,
            fallback=fallback,
            **{name: facts[name] for name in _FACTS},
        )
