# SPDX-License-Identifier: Apache-2.0
"""The training loop, Algorithm 1 of the paper, with checkpoints."""

from __future__ import annotations

import math
import time

import numpy as np

from livecl import interruption
from livecl.errors import LiveclError
from livecl.run.callbacks import OnStep, step_of, tell_stage_end
from livecl.run.checkpoint import Checkpoints
from livecl.run.control import CALLBACK, Stopped
from livecl.run.record import Record
from livecl.run.result import Stage
from livecl.run.run import Run
from livecl.svg import quantize


class Loop:
    """Train a run to its end, or until it is stopped.

    Parameters
    ----------
    run : Run
        The run; :func:`livecl.interruption.check` tells when to stop.
    on_step : callable, optional
        Called after each iteration; the run stops if it returns true. Its method `on_stage(step, kept)`, if it has one,
        is called at the end of each stage.
    checkpoints : Checkpoints, optional
        Saves the run periodically.
    record : Record, optional
        Outcomes of the stages before, for a resumed run.

    Attributes
    ----------
    stopped : str or None
        The reason if the run was stopped before its end.
    """

    def __init__(
        self,
        run: Run,
        on_step: OnStep | None = None,
        checkpoints: Checkpoints | None = None,
        record: Record | None = None,
    ) -> None:
        self.run = run
        self.record = Record() if record is None else record
        self.stopped: str | None = None
        self._on_step = on_step
        self._checkpoints = Checkpoints(None, {}, None) if checkpoints is None else checkpoints
        self._counted = time.perf_counter()

    def train(self) -> None:
        """Train until the run is finished or should stop; the last state is saved in the checkpoint, if there is one.

        Raises LiveclError or MemoryError if the run fails; the state saved is then one from which it can be resumed.
        """
        self._counted = time.perf_counter()
        try:
            while not self.run.finished:  # for n in N, and a refinement before, revisions after
                interruption.check()
                self._train_phase()
                self._save_if_due()
        except Stopped as stop:
            self.stopped = stop.reason
            self._save()
        except (LiveclError, MemoryError):
            self._save()
            raise
        if self._checkpoints.written:
            self._save()

    def _train_phase(self) -> None:
        """Train one phase: the body of Algorithm 1's outer loop."""
        run, loss = self.run, math.nan
        if not run.progress.placed:
            with run.all_or_nothing():
                if not run.begin():  # p, c = init(n, w); P = concat([P; p]); C = concat([C; c])
                    self._note(extends=True)
                    return
        while not run.trained:  # for j = 1 to t
            loss = run.step()  # render, loss, and the descent of P and C
            self.record.iterations += 1
            if self._on_step is not None and self._on_step(step_of(run, loss)):
                raise Stopped(CALLBACK)
            interruption.check()
            self._save_if_due()
        with run.all_or_nothing():
            run.untangle()
            step, revised = step_of(run, loss), run.revising
            kept = run.end()
            self._note(extends=revised)
        tell_stage_end(self._on_step, step, kept)

    def stages(self) -> list[Stage]:
        """Return the outcome of each stage; for the current one, its present drawing or the one before if better.

        A revision counts for the stage before it, as does a stage without improvement yet. Not interrupted.
        """
        with interruption.interruptible(None):
            return self._stages()

    def _stages(self) -> list[Stage]:
        run, finished = self.run, self.record.stages
        if finished and (run.finished or not run.progress.placed):
            self._count()
            return self.record.lengthened()
        stage = self._outcome()
        if finished and run.visible_mse(stage.drawing) >= run.visible_mse(finished[-1].drawing):
            self._count()
            return self.record.lengthened()
        return self.record.with_stage(stage, extends=run.revising)

    def salvaged_stages(self) -> list[Stage]:
        """Return the stages of a failed run, even if the device no longer works; none without paths."""
        drawing, stages = self.run.state.drawing, self.record.stages
        if np.isfinite(drawing.points).all() and np.isfinite(drawing.colors).all():
            try:
                stages = self.stages()
            except (LiveclError, MemoryError):
                unknown = Stage(quantize(drawing), math.nan, self.record.iterations, self.record.seconds)
                stages = stages or [unknown]
        return stages if stages and stages[-1].paths else []

    def _note(self, *, extends: bool) -> None:
        """Record the outcome of a stage that has ended."""
        self.record = Record(self.record.with_stage(self._outcome(), extends=extends))

    def _outcome(self) -> Stage:
        """Return the outcome of the current stage if it ended now."""
        drawing = self.run.outcome()
        self._count()
        return Stage(drawing, self.run.mse(drawing), self.record.iterations, self.record.seconds)

    def _count(self) -> None:
        """Add the time since the last call to that of the current stage."""
        now = time.perf_counter()
        self.record.seconds += now - self._counted
        self._counted = now

    def _save_if_due(self) -> None:
        if self._checkpoints.due:
            self._save()

    def _save(self) -> None:
        self._count()
        if self.record.stages or self.run.progress.placed:  # otherwise there is nothing to resume from
            self._checkpoints.write(self.run.progress, self.record)


def train(run: Run, on_step: OnStep | None = None) -> list[Stage]:
    """Train a run to the end of its schedule and revisions, or until the callback stops it.

    Returns
    -------
    list of Stage
        Outcome of each stage; revisions count for the last stage.
    """
    loop = Loop(run, on_step)
    loop.train()
    return loop.stages()
