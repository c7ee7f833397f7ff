# SPDX-License-Identifier: Apache-2.0
"""A run that is under way: how a stage places paths, trains all of them, and is closed."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Callable, Iterator
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.geometry.outlines import circle
from livecl.image.background import TRAIN, WHITE, target_over
from livecl.image.errors import mse, visible_mse
from livecl.image.reading import as_image
from livecl.layering.merging import merge_neighbors
from livecl.layering.placement import place_paths
from livecl.layering.pruning import least_useful, needed_layers
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg import quantize
from livecl.training import step as training
from livecl.training.objective import Objective
from livecl.training.state import FREE, State

Picture = ArrayLike | str | os.PathLike[str] | bytes | BinaryIO | Any
#: A revision takes out one path in so many, and is kept if it lowers the error by at least such a share.
REVISED_SHARE, LEAST_IMPROVEMENT = 16, 0.002
#: Rise of the mean squared error that a merge may cost in a revision: the path that it sets free may be worth more.
MERGING_LOSS = 1e-4
#: Revisions in a row that may fail.
MAX_FAILURES = 3


@dataclasses.dataclass(frozen=True)
class Step:
    """What a callback is told of an iteration.

    Attributes
    ----------
    stage, num_stages : int
        Stage under way, from 0 on, and how many there are; revisions at the end count as stages, and may end early.
    iteration, iterations : int
        Steps of the stage done, and how many there are.
    paths : int
        Layers of the drawing.
    loss : float
        Loss before the step, Xing loss included.
    """

    stage: int
    num_stages: int
    iteration: int
    iterations: int
    paths: int
    loss: float
    _vectorizer: Vectorizer = dataclasses.field(repr=False)

    @property
    def drawing(self) -> Drawing:
        """The drawing after the step."""
        return self._vectorizer.state.drawing

    @property
    def image(self) -> NDArray[np.float32]:
        """Picture of the drawing after the step, as :meth:`livecl.Rasterizer.forward` returns it; renders it."""
        return self._vectorizer.rasterizer.forward(self.drawing)

    @property
    def mse(self) -> float:
        """Mean squared error of the drawing after the step; renders it."""
        return self._vectorizer.mse(self.drawing)


class Vectorizer:
    """A run that is under way: what is on the device, and the state that says where it stands.

    Parameters
    ----------
    image : picture
        Target, as :func:`livecl.image.as_image` takes it; straight alpha is laid over the drawing's background, and is
        a part of the target where the drawing has none.
    state : State
        Where to go on; :meth:`State.start` for a new run.
    device : int, str or None
        OpenCL device.
    """

    def __init__(self, image: Picture, state: State, device: int | str | None = None) -> None:
        image = as_image(image)
        if state.drawing.size != image.shape[:2]:
            raise ValueError(f"image: {image.shape[:2]} pixels, wanted the drawing's {state.drawing.size}")
        self.state = state
        trained = state.options.background == TRAIN
        self.target: NDArray[np.float32] = target_over(image, WHITE if trained else state.drawing.background)
        self.rasterizer = Rasterizer(state.drawing.size, device)
        self.objective = Objective(self.rasterizer, self.target)

    def mse(self, drawing: Drawing) -> float:
        """Return the mean over pixels and channels of the squared difference from the target."""
        return mse(self.rasterizer.forward(drawing), self.target)

    def error(self, drawing: Drawing) -> float:
        """Return what drawings are compared by: without a background, the error that is seen over one."""
        return visible_mse(self.rasterizer.forward(drawing), self.target)

    def warm_up(self) -> None:
        """Have the device compile what a step needs: runtimes compile a kernel when it is first launched."""
        height, width = self.rasterizer.size
        outline = [circle((width / 2, height / 2), min(height, width) / 4, 4)]
        disc = Drawing.from_outlines([outline], (0, 0, 0, 1), self.rasterizer.size)
        self.rasterizer.coverages(disc)
        self.objective.warm_up(disc.replace(background=self.state.drawing.background), self.state)

    @property
    def finished(self) -> bool:
        """Whether all stages and revisions are done."""
        state, options = self.state, self.state.options
        rounds = state.stage - len(state.schedule)
        if rounds < 0:
            return False
        return rounds >= options.revisions or state.failures >= MAX_FAILURES or not state.free.any()

    @contextlib.contextmanager
    def all_or_nothing(self) -> Iterator[None]:
        """Return the state to what it was if what is done within does not come to its end."""
        before = self.state.copy()
        try:
            yield
        except BaseException:
            self.state = before
            raise

    def begin(self, check: Callable[[], None] = lambda: None) -> bool:
        """Place the paths of the stage, or of the revision, that is about to start; a refinement adds none.

        Parameters
        ----------
        check : callable
            Called several times a second; what it raises ends the placement, half done.

        Returns
        -------
        bool
            False where nothing is left that is worth a path: the stage is left out, and so are all after it.
        """
        state = self.state
        if state.stage < len(state.schedule) and state.schedule[state.stage] == 0:
            state.fallback, count = state.fall_back(), 0
        elif state.stage >= len(state.schedule):
            state.fallback = state.fall_back()
            if state.options.merge and state.failures % 2 == 0:
                self._merge(MERGING_LOSS, check)
            self._take_out()
            count = self._num_missing()
        else:
            if state.stage and state.options.variant == "released":
                state.kept_weight = self.objective.released_weight(state, state.stage - 1)
            count = state.schedule[state.stage]
        if count:
            placement = place_paths(self.target, state.drawing, count, state.options, state.rng, self.rasterizer, check)
            placed = placement.drawing.num_layers
            if not placed and state.stage < len(state.schedule):
                state.schedule = state.schedule[: state.stage]
                return False
            state.add(placement.drawing.replace(stages=np.full(placed, self._stage_of_new())), placement.order)
        state.pieces = self.rasterizer.pieces(state.drawing)
        state.placed = True
        return True

    def _stage_of_new(self) -> int:
        """Stage that new layers are labelled with: the run's, counted on from the drawing that it started from."""
        state = self.state
        if state.stage >= len(state.schedule):
            return int(state.drawing.stages.max(initial=0))
        return state.stage + (0 if state.start_drawing is None else int(state.start_drawing.stages.max(initial=0)))

    def end(self) -> None:
        """Close the stage; of a refinement or a revision, keep the better drawing."""
        state, options = self.state, self.state.options
        if state.fallback is not None:
            revision = state.stage >= len(state.schedule)
            wanted = self.error(state.fallback.drawing) * (1 - LEAST_IMPROVEMENT if revision else 1)
            if self.error(state.drawing) < wanted:
                state.failures = 0
            else:
                state.restore(state.fallback)
                state.pieces = self.rasterizer.pieces(state.drawing)
                state.failures += revision
            state.fallback = None
        state.stage, state.iteration, state.placed = state.stage + 1, 0, False
        if options.target_mse > 0 or options.path_gain > 0:
            self._end_early()

    def _end_early(self) -> None:
        """Leave out the stages to come, and revisions too, where the error is as low as asked for."""
        state, options = self.state, self.state.options
        before, state.error = state.error, self.mse(state.drawing)
        growing = state.stage <= len(state.schedule)
        if state.error <= options.target_mse:
            state.stage = len(state.schedule) + options.revisions
        elif growing and before - state.error < options.path_gain * state.schedule[state.stage - 1]:
            state.schedule = state.schedule[: state.stage]  # so that revisions do not place what is left out

    def outcome(self, check: Callable[[], None] = lambda: None) -> Drawing:
        """Return the drawing as it would be saved now: rounded, without layers that come to nothing.

        Where all is done, neighbours are merged, and `check` called before each try; what it raises ends that.

        In the middle of a revision that has not paid yet it is the drawing before; of a run that started from a drawing
        it is that one where nothing better was found.
        """
        state = self.state
        best, free = state.drawing, state.free
        if state.fallback is not None and self.error(state.fallback.drawing) < self.error(state.drawing):
            best, free = state.fallback.drawing, state.fallback.holds == FREE
        least = max(state.options.prune, state.options.path_gain) if self.finished else 0.0
        best = quantize(best)
        if self.finished and state.options.merge:
            merged = merge_neighbors(best, self.rasterizer, self.target, state.options, free, least, check)
            best, free = quantize(merged.drawing), (merged.sources < 0) | free[merged.sources]
        drawing = needed_layers(best, self.rasterizer, self.target, least, free)
        if state.start_drawing is not None:
            start = quantize(state.start_drawing)
            if self.error(start) < self.error(drawing):
                return start
        return drawing

    def _num_missing(self) -> int:
        """Return how many layers fewer there are than were asked for."""
        state = self.state
        return sum(state.schedule) - int(np.sum(state.holds == FREE))

    def _merge(self, tolerance: float, check: Callable[[], None]) -> None:
        """Merge neighbours of one colour."""
        state = self.state
        merged = merge_neighbors(
            state.drawing, self.rasterizer, self.target, state.options, state.free, tolerance, check
        )
        if merged.drawing.num_layers < state.drawing.num_layers:
            state.replace_layers(merged.drawing, merged.sources)

    def _take_out(self) -> None:
        """Remove the least useful layers, after failures the next ones in that order."""
        state = self.state
        order = least_useful(state.drawing, self.rasterizer, self.target)
        order = order[state.free[order]]
        count = min(len(order), max(1, state.drawing.num_layers // REVISED_SHARE))
        start = state.failures * count % max(1, len(order) - count + 1)
        state.keep_layers(np.setdiff1d(np.arange(state.drawing.num_layers), order[start : start + count]))

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
        training.hold_locked(state, gradients)
        training.move(state, gradients)
        state.iteration += 1
        if options.untangle and training.untangles_now(state):
            training.untangle_outlines(state)
        return loss
