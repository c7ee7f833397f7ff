# SPDX-License-Identifier: Apache-2.0
"""Callbacks of a run: each step, and at the end of a stage whether it was kept."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.run.phases import Kind, Revise
from livecl.run.run import Run


@dataclasses.dataclass(frozen=True)
class Step:
    """Argument of callbacks: an iteration of a run.

    Attributes
    ----------
    kind : "refine", "stroke", "grow", "thin", "revise" or "recolor"
        Kind of the stage: it trains the start drawing, draws strokes, adds paths, turns thin layers into strokes,
        replaces the least useful layers, or trains outlines in the reduced set of colours.
    stage, num_stages : int
        Current stage, from 0, and the number planned: those of the schedule, then revisions, then recoloring. Some may
        be skipped.
    iteration, iterations : int
        Steps of the stage done, and its planned number: a stage may end early.
    paths : int
        Layers of the drawing.
    loss : float
        Loss before the step, Xing loss included.
    """

    kind: Kind
    stage: int
    num_stages: int
    iteration: int
    iterations: int
    paths: int
    loss: float
    _run: Run = dataclasses.field(repr=False)

    @property
    def name(self) -> str:
        """Name of the current stage: "stage 2/4", "thin layers", "revision 1" or "recoloring"."""
        if self.kind in ("thin", "recolor"):
            return "thin layers" if self.kind == "thin" else "recoloring"
        phase = self._run.plan[self.stage]
        if isinstance(phase, Revise):
            return f"revision {phase.number + 1}"
        return f"stage {self.stage + 1}/{self._run.num_stages}"

    @property
    def drawing(self) -> Drawing:
        """The drawing after the step; at the end of a stage, the one with which the run continues.

        On the canvas that the step works on, which may be smaller than the picture: see `Options.pixels_per_path`.
        """
        return self._run.state.drawing

    @property
    def image(self) -> NDArray[np.float32]:
        """Image of the drawing, as of :meth:`livecl.Rasterizer.forward`; costs a render."""
        return self._run.rasterizer.forward(self.drawing)

    @property
    def mse(self) -> float:
        """Mean squared error of the drawing over pixels and channels; costs a render."""
        return self._run.mse(self.drawing)


OnStep = Callable[[Step], bool | None]


def step_of(run: Run, loss: float) -> Step:
    """Return the step just done, for callbacks."""
    state = run.state
    kind = run.plan[state.stage].kind
    place = (state.stage, len(run.plan), state.iteration, state.length)
    return Step(kind, *place, state.drawing.num_layers, loss, run)


def tell_stage_end(on_step: OnStep | None, step: Step, kept: bool) -> None:
    """Call the callback's `on_stage(step, kept)`, if it has such a method.

    `step` is the last one of the stage; `kept` is False if the run returns to the drawing before it.
    """
    on_stage: Any = getattr(on_step, "on_stage", None)
    if on_stage is not None:
        on_stage(step, kept)
