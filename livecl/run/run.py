# SPDX-License-Identifier: Apache-2.0
"""`Run`: a vectorization under way, with all that its phases work on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.geometry.outlines import circle
from livecl.image.background import TRAIN, WHITE, target_over
from livecl.layering.context import Context
from livecl.layering.merging import merge_neighbors
from livecl.layering.pruning import needed_layers
from livecl.rendering.rasterizer import Rasterizer
from livecl.run.phases import MAX_FAILURES, Grow, Phase, plan_of
from livecl.svg import quantize
from livecl.training import step as training
from livecl.training.objective import Objective
from livecl.training.state import FREE, State


class Run(Context):
    """A vectorization under way: the target, the device's rasterizer, and the state that says where it stands.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array
        Straight colours in [0, 1]; alpha is laid over the drawing's background, and is a part of the target where the
        drawing has none.
    state : State
        Where to go on; :meth:`State.start` for a new run.
    device : int, str or None
        OpenCL device.
    check : callable
        Called several times a second in placement and merging, and after each step; raises to interrupt the run.

    Attributes
    ----------
    plan : tuple of Phase
        Phases of the whole run; `state.stage` is the index of the one under way.
    """

    def __init__(
        self,
        image: NDArray[np.floating],
        state: State,
        device: int | str | None = None,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        if state.drawing.size != image.shape[:2]:
            raise ValueError(f"image: {image.shape[:2]} pixels, wanted the drawing's {state.drawing.size}")
        self.state = state
        self.plan = plan_of(state.schedule, state.options.revisions, state.options.fills)
        trained = state.options.background == TRAIN
        straight = np.asarray(image, dtype=np.float32)
        target = target_over(straight, WHITE if trained else state.drawing.background)
        super().__init__(Rasterizer(state.drawing.size, device), target, state.options, check)
        self.objective = Objective(self.rasterizer, self.target)

    def warm_up(self) -> None:
        """Compile the kernels of a step: runtimes compile a kernel when it is first launched."""
        height, width = self.rasterizer.size
        outline = [circle((width / 2, height / 2), min(height, width) / 4, 4)]
        disc = Drawing.from_outlines([outline], (0, 0, 0, 1), self.rasterizer.size)
        self.rasterizer.coverages(disc)
        self.objective.warm_up(disc.replace(background=self.state.drawing.background), self.state)

    @property
    def phase(self) -> Phase | None:
        """The phase under way, or about to begin; None after the last."""
        return self.plan[self.state.stage] if self.state.stage < len(self.plan) else None

    @property
    def revising(self) -> bool:
        """Whether all stages of the schedule are behind the run."""
        return self.state.stage >= len(self.state.schedule)

    @property
    def finished(self) -> bool:
        """Whether no phase is left, or revisions have failed too often or have no layer to replace."""
        state = self.state
        spent = self.revising and (state.failures >= MAX_FAILURES or not state.free.any())
        return self.phase is None or spent

    @property
    def trained(self) -> bool:
        """Whether the phase under way has done all its iterations."""
        return self.state.iteration >= self.state.options.iterations

    @contextlib.contextmanager
    def all_or_nothing(self) -> Iterator[None]:
        """Context manager: restore the state if the block is left by an exception."""
        before = self.state.copy()
        try:
            yield
        except BaseException:
            self.state = before
            raise

    def begin(self) -> bool:
        """Begin the next phase; return False where it is left out, since no path is worth placing."""
        if self.phase is None:
            raise ValueError("begin: the run is finished")
        if not self.phase.begin(self):
            return False
        self.state.pieces = self.rasterizer.pieces(self.state.drawing)
        self.state.placed = True
        return True

    def step(self) -> float:
        """Do one iteration: loss, gradient, Adam. Returns the loss.

        Raises
        ------
        LiveclError
            If loss or gradient are not finite; the state is as it was before.
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
        if options.untangle and training.untangles_now(state):
            training.untangle_outlines(state)
        return loss

    def end(self) -> bool:
        """End the phase under way and go on to the next; return whether its drawing is kept."""
        phase, state, options = self.phase, self.state, self.state.options
        if phase is None:
            raise ValueError("end: the run is finished")
        kept = phase.end(self)
        state.stage, state.iteration, state.placed = state.stage + 1, 0, False
        if options.target_mse > 0 or options.path_gain > 0:
            before, state.error = state.error, self.visible_mse(state.drawing)
            if state.error <= options.target_mse:
                state.stage = len(self.plan)
            elif isinstance(phase, Grow) and before - state.error < options.path_gain * phase.count:
                self.end_growth()
        return kept

    def end_growth(self) -> None:
        """Leave out the stages of the schedule that are left: only revisions are."""
        self.state.stage = max(self.state.stage, len(self.state.schedule))

    def keep_if_better(self, improvement: float = 0.0) -> bool:
        """Return whether the drawing's error is lower, by a share, than that of the fallback, which it else becomes."""
        state = self.state
        fallback = state.fallback
        if fallback is None:
            raise ValueError("the phase has no drawing to fall back to")
        kept = self.visible_mse(state.drawing) < self.visible_mse(fallback.drawing) * (1 - improvement)
        if not kept:
            state.restore(fallback)
            state.pieces = self.rasterizer.pieces(state.drawing)
        state.fallback = None
        return kept

    def outcome(self) -> Drawing:
        """Return the drawing as it would be saved now: rounded, without layers that come to nothing.

        When the run is finished, neighbours are merged. In the middle of a revision that has not paid yet it is the
        drawing before; of a run that started from a drawing it is that one where nothing better was found.
        """
        state = self.state
        best, free = state.drawing, state.free
        if state.fallback is not None and self.visible_mse(state.fallback.drawing) < self.visible_mse(state.drawing):
            best, free = state.fallback.drawing, state.fallback.holds == FREE
        least = max(state.options.prune, state.options.path_gain) if self.finished else 0.0
        best = quantize(best)
        if self.finished and state.options.merge and not best.fills.any_gradients:
            merged = merge_neighbors(self, best, free, least)
            best, free = quantize(merged.drawing), (merged.sources < 0) | free[merged.sources]
        drawing = needed_layers(self, best, least, free)
        if state.start_drawing is not None:
            start = quantize(state.start_drawing)
            if self.visible_mse(start) < self.visible_mse(drawing):
                return start
        return drawing
