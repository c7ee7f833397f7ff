# SPDX-License-Identifier: Apache-2.0
"""The outer loop: stage after stage to the end, or to where it is stopped, with checkpoints on the way."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from livecl.errors import LiveclError
from livecl.run.checkpoint import Checkpoints, Record
from livecl.run.control import CALLBACK, Control, Stopped, Watch
from livecl.run.result import Stage
from livecl.run.stages import Step, Vectorizer
from livecl.svg import quantize

OnStep = Callable[[Step], bool | None]


class Loop:
    """Goes on from a vectorizer's state.

    Parameters
    ----------
    vectorizer : Vectorizer
        The run.
    on_step : callable, optional
        Called after each iteration; the run stops where it returns true.
    watch : Watch, optional
        Tells when to stop.
    checkpoints : Checkpoints, optional
        Where the run is saved now and then.
    record : Record, optional
        How far it had come before.

    Attributes
    ----------
    stopped : str or None
        Why the run stopped before its end.
    """

    def __init__(
        self,
        vectorizer: Vectorizer,
        on_step: OnStep | None = None,
        watch: Watch | None = None,
        checkpoints: Checkpoints | None = None,
        record: Record | None = None,
    ) -> None:
        self.vectorizer = vectorizer
        self.record = Record() if record is None else record
        self.stopped: str | None = None
        self._on_step = on_step
        self._watch = Watch(Control()) if watch is None else watch
        self._checkpoints = Checkpoints(None, {}, None) if checkpoints is None else checkpoints
        self._counted = time.perf_counter()

    def run(self) -> None:
        """Work until all is done, or the run is to stop; its last state is then in the checkpoint, if there is one.

        Raises
        ------
        LiveclError, MemoryError
            If the run fails; the state is one that it can go on from, and is in the checkpoint.
        """
        self._counted = time.perf_counter()
        try:
            while not self.vectorizer.finished:
                self._watch.check()
                self._work_on_stage()
                self._save_if_due()
        except Stopped as stop:
            self.stopped = stop.reason
            self._save()
        except (LiveclError, MemoryError):
            self._save()
            raise
        if self._checkpoints.written:
            self._save()

    def stages(self) -> list[Stage]:
        """Return the outcome of each stage; of one under way as it stands, or as it began where that is better.

        A revision counts for the stage before it, and so does a stage that has done no good yet.
        """
        finished, state = self.record.stages, self.vectorizer.state
        if finished and (self.vectorizer.finished or not state.placed):
            return [*finished[:-1], self._lengthened(finished[-1])]
        stage = self._outcome()
        better = not finished or self.vectorizer.error(stage.drawing) < self.vectorizer.error(finished[-1].drawing)
        if not better:
            return [*finished[:-1], self._lengthened(finished[-1])]
        return self._with(stage, replaces=state.stage >= len(state.schedule))

    def salvaged_stages(self) -> list[Stage]:
        """Return what there is of a run that has failed, whether the device still works or not; none for no paths."""
        drawing, stages = self.vectorizer.state.drawing, self.record.stages
        if np.isfinite(drawing.points).all() and np.isfinite(drawing.colors).all():
            try:
                stages = self.stages()
            except (LiveclError, MemoryError):
                unknown = Stage(quantize(drawing), math.nan, self.record.iterations, self.record.seconds)
                stages = stages or [unknown]
        return stages if stages and stages[-1].paths else []

    def _work_on_stage(self) -> None:
        vectorizer = self.vectorizer
        if not vectorizer.state.placed:
            with vectorizer.all_or_nothing():
                if not vectorizer.begin(self._watch.check):
                    self._note(replaces=True)
                    return
        while vectorizer.state.iteration < vectorizer.state.options.iterations:
            loss = vectorizer.step()
            self.record.iterations += 1
            if self._on_step is not None and self._on_step(self._told(loss)):
                raise Stopped(CALLBACK)
            self._watch.check()
            self._save_if_due()
        revision = vectorizer.state.stage >= len(vectorizer.state.schedule)
        with vectorizer.all_or_nothing():
            vectorizer.end()
            self._note(replaces=revision)

    def _note(self, *, replaces: bool) -> None:
        """Put down the outcome of a stage that has ended."""
        self.record = Record(self._with(self._outcome(self._watch.check), replaces))

    def _outcome(self, check: Callable[[], None] = lambda: None) -> Stage:
        """Return the stage under way as it would end now."""
        drawing = self.vectorizer.outcome(check)
        self._count()
        return Stage(drawing, self.vectorizer.mse(drawing), self.record.iterations, self.record.seconds)

    def _with(self, stage: Stage, replaces: bool) -> list[Stage]:
        """Return the finished stages with one more, or with one that `replaces` the last and adds to what it took."""
        finished = self.record.stages
        if not (replaces and finished):
            return [*finished, stage]
        iterations, seconds = finished[-1].iterations + stage.iterations, finished[-1].seconds + stage.seconds
        return [*finished[:-1], Stage(stage.drawing, stage.mse, iterations, seconds)]

    def _lengthened(self, stage: Stage) -> Stage:
        """Return a finished stage with what has been done in vain since."""
        self._count()
        return Stage(
            stage.drawing, stage.mse, stage.iterations + self.record.iterations, stage.seconds + self.record.seconds
        )

    def _count(self) -> None:
        """Add the time since the last call to that of the stage under way."""
        now = time.perf_counter()
        self.record.seconds += now - self._counted
        self._counted = now

    def _save_if_due(self) -> None:
        if self._checkpoints.due:
            self._save()

    def _save(self) -> None:
        self._count()
        if self.record.stages or self.vectorizer.state.placed:  # else there is nothing to go on from
            self._checkpoints.write(self.vectorizer.state, self.record)

    def _told(self, loss: float) -> Step:
        state = self.vectorizer.state
        num_stages = len(state.schedule) + state.options.revisions
        place = (state.stage, num_stages, state.iteration, state.options.iterations)
        return Step(*place, state.drawing.num_layers, loss, self.vectorizer)


def run(vectorizer: Vectorizer, on_step: OnStep | None = None) -> list[Stage]:
    """Go on from the vectorizer's state to the end of its schedule and revisions, or until the callback stops it.

    Returns
    -------
    list of Stage
        Outcome of each stage that was worked on; revisions count for the last stage.
    """
    loop = Loop(vectorizer, on_step)
    loop.run()
    return loop.stages()
