# SPDX-License-Identifier: Apache-2.0
"""`Run`: a vectorization in progress, phase after phase."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.editing import with_few_colors
from livecl.errors import LiveclError
from livecl.run.outcome import saved_drawing
from livecl.run.phases import Grow, Phase, Recolor, Revise, Stroke, plan_of
from livecl.run.preparation import warm_up
from livecl.run.progress import Progress
from livecl.run.work import Work
from livecl.svg import quantize
from livecl.training import step as training
from livecl.training.ending import EARLIEST, judge_progress

#: Divisor of the steps of a stage followed by others: its layers are trained further with theirs.
EARLY_SHARE = 4
#: Number of paths from which on stages of a run by regions are shortened: errors of 12 photographs of 32 paths fell by
#: 7 %; those of three drawings of 8 and 24 paths rose by 27 %, as each layer matters more there.
MANY_PATHS = 32


class Run(Work):
    """A vectorization in progress; parameters as for :class:`livecl.run.work.Work`.

    Attributes
    ----------
    plan : tuple of Phase
        Phases of the whole run; `state.stage` is the index of the current one.
    """

    def __init__(
        self,
        image: NDArray[np.floating],
        progress: Progress,
        device: int | str | None = None,
    ) -> None:
        super().__init__(image, progress, device)
        recolors = bool(self.options.colors and not self.options.palette)
        self.plan = plan_of(progress.schedule, self.options.revisions, self.options.strokes, recolors)
        self.num_stages = sum(phase.kind not in ("thin", "revise", "recolor") for phase in self.plan)

    def warm_up(self) -> None:
        """Compile the kernels of a step: runtimes compile a kernel when it is first launched."""
        warm_up(self.rasterizer, self.objective, self.options, self.state.drawing.background)

    @property
    def phase(self) -> Phase | None:
        """The current phase, or the next one; None after the last."""
        index = self._index
        return self.plan[index] if index < len(self.plan) else None

    @property
    def finished(self) -> bool:
        """Whether no phase is left."""
        return self.phase is None

    @property
    def _index(self) -> int:
        """Index of the phase, skipping revisions if they have failed too often or have no layer to replace."""
        index = self.state.stage
        if not self.progress.placed and (self.progress.failures >= Revise.max_failures or not self.state.free.any()):
            while index < len(self.plan) and isinstance(self.plan[index], Revise):
                index += 1
        return index

    @property
    def trained(self) -> bool:
        """Whether the current phase has done all its iterations."""
        return self.state.iteration >= self.state.length

    def begin(self) -> bool:
        """Begin the next phase; return False if it is skipped, as no path is worth placing."""
        phase = self.phase
        if phase is None:
            raise ValueError("begin: the run is finished")
        self.state.stage = self._index
        if not phase.begin(self):
            return False
        state = self.state
        if self.options.palette:
            state.recolor(with_few_colors(self, state.drawing, ~state.locked))
        state.pieces = self.rasterizer.pieces(state.drawing)
        state.begin_phase(self._planned_length(phase))
        self.progress.placed = True
        return True

    def step(self) -> float:
        """Do one iteration: loss, gradient, Adam. Returns the loss.

        Raises LiveclError if loss or gradient are not finite; the state is as it was before.
        """
        state, options = self.state, self.state.options
        if state.iteration % training.PIECES_PERIOD == 0:
            training.choose_pieces(state, self.rasterizer)
        loss, gradients = self.objective.evaluate(state)
        if not (np.isfinite(loss) and np.isfinite(gradients.points).all() and np.isfinite(gradients.colors).all()):
            raise LiveclError(f"loss or gradient is not finite in stage {state.stage + 1}, step {state.iteration + 1}")
        training.hold_still(state, gradients)
        training.move(state, gradients)
        state.iteration += 1
        if options.end_early:
            judge_progress(state, loss, self._limit)
        if options.untangle and training.untangles_now(state) and not self.trained:
            training.untangle_outlines(state)
        return loss

    def untangle(self) -> None:
        """Take the loops out of the outlines of a phase that is trained, but for those that show something."""
        if self.options.untangle and self.state.iteration:
            training.untangle_outlines(self.state, self.visible_mse)

    def _planned_length(self, phase: Phase) -> int:
        """Return the number of steps of a phase: fewer if a later phase certainly trains its layers further.

        That is so of strokes, which are fitted before and redrawn afterwards; if whole shapes are still missing; and
        with many paths by regions if revisions follow and stages are not judged by their gain.
        """
        options, state = self.options, self.state
        early = min(max(EARLIEST, options.iterations // EARLY_SHARE), options.iterations)
        if options.end_early and isinstance(phase, Stroke):
            return early
        followed = any(isinstance(later, Grow) for later in self.plan[state.stage + 1 :])
        if not (options.end_early and isinstance(phase, Grow) and followed):
            return options.iterations
        certain = options.placement == "region" and options.revisions > 0 and not options.path_gain
        certain &= sum(self.progress.schedule) >= MANY_PATHS
        if options.placement == "structure":
            certain = state.kept_weight is not None and not state.kept_weight.all()  # visible layers are missing
        return early if certain else options.iterations

    @property
    def _limit(self) -> float:
        """Loss below which a revision is kept."""
        fallback, options = self.progress.fallback, self.options
        if fallback is None or not self.revising or options.loss != "mse" or options.xing_weight:
            return np.inf
        return fallback.error * (1 - Revise.min_improvement)

    def end(self) -> bool:
        """End the current phase and advance to the next; return whether its drawing is kept."""
        phase, progress, state, options = self.phase, self.progress, self.state, self.state.options
        if phase is None:
            raise ValueError("end: the run is finished")
        kept = phase.end(self)
        state.stage, progress.placed = state.stage + 1, False
        state.begin_phase(options.iterations)
        if options.target_mse > 0 or options.path_gain > 0:
            before, progress.error = progress.error, self.visible_mse(state.drawing)
            if progress.error <= options.target_mse:
                left = range(state.stage, len(self.plan))
                state.stage = next((k for k in left if isinstance(self.plan[k], Recolor)), len(self.plan))
            elif isinstance(phase, Grow) and before - progress.error < options.path_gain * phase.count:
                self.end_growth()
        return kept

    def outcome(self) -> Drawing:
        """Return the drawing as it would be saved now: rounded, without negligible layers.

        When the run is finished, neighbours are merged and outlines made editable. During a revision without an
        improvement yet, it is the drawing before it; without any improvement, a run from a drawing returns that.
        """
        state, start, fallback = self.state, self.progress.start_drawing, self.progress.fallback
        best, holds = state.drawing, state.holds
        if fallback is not None and fallback.error < self.visible_mse(state.drawing):
            best, holds = fallback.drawing, fallback.holds
        trim = self.finished and self.options.trim and start is None
        drawing = saved_drawing(self, best, holds, finished=self.finished, trim=trim)
        if start is not None:
            start = quantize(start)
            if self.visible_mse(start) < self.visible_mse(drawing):
                return start
        return drawing
