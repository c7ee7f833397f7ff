# SPDX-License-Identifier: Apache-2.0
"""The outer loop: stages that place paths, and iterations that train all of them."""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing import Drawing, concatenate, empty_drawing
from livecl.errors import LiveclError
from livecl.image import over_background
from livecl.objective import Objective
from livecl.optimizers import decayed, settling
from livecl.options import Options
from livecl.placement import place_paths
from livecl.rasterizer import Gradients, Rasterizer
from livecl.result import Result, Stage
from livecl.revision import least_useful, needed_layers
from livecl.schedule import parse_schedule
from livecl.state import State
from livecl.svg import quantize
from livecl.untangle import untangle

#: Steps after which the numbers of lines that flatten the segments are looked at again.
PIECES_PERIOD = 10
#: Steps between two looks for outlines that cross themselves.
UNTANGLE_PERIOD = 25
#: Opacity from which on a fill is meant to be opaque.
OPAQUE_FROM = 0.9
#: A revision takes out one path in so many, and is kept if it lowers the error by at least such a share.
REVISED_SHARE, LEAST_IMPROVEMENT = 16, 0.002
#: Revisions in a row that may fail.
MAX_FAILURES = 3
#: Steps over which the learning rate decays by the factor that the options name.
DECAY_PERIOD = 500


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
    def mse(self) -> float:
        """Mean squared error of the drawing after the step; renders it."""
        return self._vectorizer.mse(self.drawing)


class Vectorizer:
    """A run that is under way: what is on the device, and the state that says where it stands.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        Target in [0, 1]; straight alpha is laid over the background.
    state : State
        Where to go on; :meth:`State.start` for a new run.
    device : int, str or None
        OpenCL device.
    """

    def __init__(self, image: ArrayLike, state: State, device: int | str | None = None) -> None:
        image = checked_image(image)
        if state.drawing.size != image.shape[:2]:
            raise ValueError(f"image: {image.shape[:2]} pixels, wanted the drawing's {state.drawing.size}")
        self.state = state
        if image.shape[2] == 4:
            image = over_background(image, state.options.background_color())
        self.target: NDArray[np.float32] = image
        self.rasterizer = Rasterizer(state.drawing.size, device)
        self.objective = Objective(self.rasterizer, image)

    def mse(self, drawing: Drawing) -> float:
        """Return the mean over pixels and channels of the squared difference from the target."""
        difference = self.rasterizer.forward(drawing) - self.target
        return float(np.mean(np.square(difference, dtype=np.float64)))

    def warm_up(self) -> None:
        """Have the device compile what a step needs: runtimes compile a kernel when it is first launched."""
        drawing, options, rng = self.state.drawing, self.state.options, np.random.default_rng(0)
        new = place_paths(self.target, drawing, 1, options, rng, self.rasterizer).drawing
        self.objective.warm_up(concatenate(drawing, new), self.state)

    @property
    def finished(self) -> bool:
        """Whether all stages and revisions are done."""
        state, options = self.state, self.state.options
        rounds = state.stage - len(state.schedule)
        return rounds >= options.revisions or (rounds >= 0 and state.failures >= MAX_FAILURES)

    def begin(self) -> None:
        """Place the paths of the stage, or of the revision, that is about to start."""
        state = self.state
        if state.stage >= len(state.schedule):
            count = self._revised()
            self._take_out(count)
        else:
            if state.stage and state.options.variant == "released":
                state.kept_weight = self.objective.released_weight(state, state.stage - 1)
            count = state.schedule[state.stage]
        placement = place_paths(self.target, state.drawing, count, state.options, state.rng, self.rasterizer)
        stage = state.stage if state.stage < len(state.schedule) else state.drawing.stages.max(initial=0)
        state.add(placement.drawing.replace(stages=np.full(count, stage)), placement.order)
        state.pieces = self.rasterizer.pieces(state.drawing)

    def end(self) -> None:
        """Close the stage; of a revision, keep the better drawing."""
        state, options = self.state, self.state.options
        if state.fallback is not None:
            if self.mse(state.drawing) < (1 - LEAST_IMPROVEMENT) * self.mse(state.fallback.drawing):
                state.failures = 0
            else:
                state.restore(state.fallback)
                state.pieces = self.rasterizer.pieces(state.drawing)
                state.failures += 1
            state.fallback = None
        state.stage, state.iteration = state.stage + 1, 0
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
            state.stage = len(state.schedule)

    def best_drawing(self) -> Drawing:
        """Return the drawing, or in the middle of a revision that has not paid yet, the one before it."""
        state = self.state
        if state.fallback is not None and self.mse(state.fallback.drawing) < self.mse(state.drawing):
            return state.fallback.drawing
        return state.drawing

    def _revised(self) -> int:
        """Number of paths that a revision places anew."""
        return max(1, self.state.drawing.num_layers // REVISED_SHARE)

    def _take_out(self, count: int) -> None:
        """Remember the drawing, then remove its least useful layers; after failures, the next ones in that order."""
        state = self.state
        order = least_useful(state.drawing, self.rasterizer, self.target)
        start = state.failures * count % max(1, len(order) - count + 1)
        state.fallback = state.fall_back()
        state.keep_layers(np.setdiff1d(np.arange(len(order)), order[start : start + count]))

    def step(self) -> float:
        """Do one iteration: loss, gradient, Adam. Returns the loss.

        Raises
        ------
        LiveclError
            If loss or gradient are not finite; the state is as it was before.
        """
        state, options = self.state, self.state.options
        if state.iteration % PIECES_PERIOD == 0:
            self._choose_pieces()
        loss, gradients = self.objective.evaluate(state)
        if not (np.isfinite(loss) and np.isfinite(gradients.points).all() and np.isfinite(gradients.colors).all()):
            raise LiveclError(f"loss or gradient is not finite in stage {state.stage + 1}, step {state.iteration + 1}")
        self._move(state.drawing, gradients)
        state.iteration += 1
        if options.untangle and self._untangles_now():
            self._untangle()
        return loss

    def _untangles_now(self) -> bool:
        """Now and then in the second half of a stage, when paths have found their places, and after its last step."""
        iteration, iterations = self.state.iteration, self.state.options.iterations
        return iteration == iterations or (2 * iteration > iterations and iteration % UNTANGLE_PERIOD == 0)

    def _untangle(self) -> None:
        """Take the loops out of all outlines; for Adam, what moves is new."""
        state, drawing = self.state, self.state.drawing
        points, cubics = drawing.points.copy(), drawing.cubics
        for first, end in itertools.pairwise(drawing.subpath_offsets):
            points[first:end] = untangle(cubics[first:end])[:, :3]
        moved = (points != drawing.points).any(axis=(1, 2))
        if moved.any():
            state.points.forget(moved)
            state.drawing = drawing.moved(points, drawing.colors, drawing.background)

    def _choose_pieces(self) -> None:
        """Flatten finer where a segment has grown, and coarser where it has shrunk to a quarter."""
        needed = self.rasterizer.pieces(self.state.drawing)
        held = self.state.pieces
        if np.any(needed > held) or np.any(2 * needed < held):
            self.state.pieces = needed

    def _move(self, drawing: Drawing, gradients: Gradients) -> None:
        """One step of Adam; colours stay within [0, 1]."""
        state, options = self.state, self.state.options

        settled = settling(state.iteration / options.iterations, options.settle)

        def rate(base: float, ages: NDArray[np.int64]) -> ArrayLike:
            return base * settled * (1 if options.decay == 1 else decayed(ages, options.decay, DECAY_PERIOD))

        points = drawing.points + state.points.step(gradients.points, rate(options.learning_rate, state.points.ages))
        color_rate = rate(options.color_learning_rate, state.colors.ages)
        colors = np.clip(drawing.colors + state.colors.step(gradients.colors, color_rate), 0, 1)
        if options.opacity == "opaque":
            colors[:, 3] = drawing.colors[:, 3]
        elif options.opacity == "snap" and 2 * state.iteration >= options.iterations:
            colors[colors[:, 3] > OPAQUE_FROM, 3] = 1
        background = drawing.background
        if options.background == "train" and background is not None and gradients.background is not None:
            change = state.background.step(gradients.background[None], options.color_learning_rate)
            background = np.clip(background + change[0], 0, 1)
        state.drawing = drawing.moved(points, colors, background)


def checked_image(image: ArrayLike) -> NDArray[np.float32]:
    """Return an image as (H, W, 3) or (H, W, 4) float32 in [0, 1]; grey (H, W) gets three equal channels.

    Raises
    ------
    ValueError
        If it is of another shape, or holds numbers that are not finite and within [0, 1].
    """
    array = np.asarray(image)
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, axis=2)
    if array.ndim != 3 or array.shape[2] not in (3, 4) or 0 in array.shape:
        raise ValueError(f"image: shape {array.shape}, wanted (H, W, 3), or (H, W, 4) with straight alpha")
    if not np.issubdtype(array.dtype, np.floating):
        raise ValueError(
            f"image: numbers of type {array.dtype}, wanted floats in [0, 1] (livecl.read_image makes them)"
        )
    if not np.all((array >= 0) & (array <= 1)):
        raise ValueError("image: all numbers must be finite and within [0, 1]")
    return array.astype(np.float32)


def vectorize(
    image: ArrayLike,
    paths: int | Literal["auto"] | None = None,
    schedule: str | Sequence[int] | None = None,
    options: Options | None = None,
    device: int | str | None = None,
    seed: int = 0,
    on_step: Callable[[Step], bool | None] | None = None,
) -> Result:
    """Turn a picture into a drawing of few closed paths, layer by layer.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        Target in [0, 1]; straight alpha is laid over the background.
    paths : int or "auto", optional
        Number of paths, at most; 8 where neither this nor a list of stages is given. "auto" goes on as long as further
        paths gain enough (`Options.path_gain`).
    schedule : "exp" or sequence of int, optional
        Paths that each stage adds, see :func:`livecl.schedule.parse_schedule`.
    options : Options, optional
        Parameters of the method.
    device : int, str or None
        OpenCL device, see :func:`livecl.device.choose_device`.
    seed : int
        Seed of whatever is random.
    on_step : callable, optional
        Called with a :class:`Step` after each iteration; where it returns true the run stops there.

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        If an argument is not usable; the message names it.
    DeviceError, KernelBuildError
        If the device cannot be had.
    LiveclError
        If the loss stops being finite.
    """
    options = Options() if options is None else options
    stages = parse_schedule(schedule, paths)
    if paths == "auto":
        options = options.choosing_paths()
    target = checked_image(image)
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise ValueError(f"seed: got {seed!r}, wanted a whole number of at least 0")
    start = time.perf_counter()
    drawing = empty_drawing((target.shape[0], target.shape[1]), options.background_color())
    vectorizer = Vectorizer(target, State.start(drawing, options, stages, seed), device)
    vectorizer.warm_up()
    compiled = time.perf_counter()
    outcomes = run(vectorizer, on_step)
    return Result(
        drawing=outcomes[-1].drawing,
        mse=outcomes[-1].mse,
        stages=tuple(outcomes),
        seconds=sum(outcome.seconds for outcome in outcomes),
        compile_seconds=compiled - start,
        device=str(vectorizer.rasterizer.device.info),
        options=options,
    )


def run(vectorizer: Vectorizer, on_step: Callable[[Step], bool | None] | None = None) -> list[Stage]:
    """Go on from the vectorizer's state to the end of its schedule and revisions, or until the callback stops it.

    Returns
    -------
    list of Stage
        Outcome of each stage that was worked on; revisions count for the last stage.
    """
    state = vectorizer.state
    outcomes: list[Stage] = []
    stopped = False
    while not vectorizer.finished and not stopped:
        start = time.perf_counter()
        first = state.iteration
        if first == 0:
            vectorizer.begin()
        while state.iteration < state.options.iterations and not stopped:
            loss = vectorizer.step()
            if on_step is not None:
                stopped = bool(on_step(_step_of(vectorizer, loss)))
        steps, revision = state.iteration - first, state.stage >= len(state.schedule)
        if not stopped:
            vectorizer.end()
        seconds = time.perf_counter() - start
        if revision and outcomes:
            before = outcomes.pop()
            steps, seconds = steps + before.iterations, seconds + before.seconds
        least = max(state.options.prune, state.options.path_gain) if vectorizer.finished else 0.0
        drawing = needed_layers(quantize(vectorizer.best_drawing()), vectorizer.rasterizer, vectorizer.target, least)
        outcomes.append(Stage(drawing, vectorizer.mse(drawing), steps, seconds))
    return outcomes


def _step_of(vectorizer: Vectorizer, loss: float) -> Step:
    state = vectorizer.state
    num_stages = len(state.schedule) + state.options.revisions
    place = (state.stage, num_stages, state.iteration, state.options.iterations)
    return Step(*place, state.drawing.num_layers, loss, vectorizer)
