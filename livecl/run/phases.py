# SPDX-License-Identifier: Apache-2.0
"""Phases of a run: refine a start drawing, add paths or strokes, revise the drawing, reduce its colours.

Each phase begins by changing the layers, is trained by the loop (:mod:`livecl.run.loop`), and ends with a decision:
:meth:`Phase.end` returns whether the trained drawing is kept.
"""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.drawing import Drawing
from livecl.editing import with_few_colors
from livecl.layering.fills.choice import shaded
from livecl.layering.placement import place_paths
from livecl.layering.revision.merging import can_merge, merge_neighbors
from livecl.layering.revision.pruning import least_useful
from livecl.layering.strokes.pens import with_best_shades, with_fewer_pens
from livecl.layering.strokes.redrawing import redrawn
from livecl.run.work import Work
from livecl.training.state import FREE, KEPT

Kind = Literal["refine", "stroke", "grow", "thin", "revise", "recolor"]


class Phase(abc.ABC):
    """A part of a run: changes layers, is trained, and is kept or undone."""

    kind: ClassVar[Kind]

    @abc.abstractmethod
    def begin(self, run: Work) -> bool:
        """Change the layers; return whether there is anything to train: if False, the phase is skipped."""

    def end(self, run: Work) -> bool:
        """Return whether the trained drawing is kept (by default it is); if not, the drawing before is restored."""
        return True


@dataclasses.dataclass(frozen=True)
class Refine(Phase):
    """Train the layers of a drawing that the run starts from; kept if the error falls."""

    kind: ClassVar[Kind] = "refine"

    def begin(self, run: Work) -> bool:
        """Make the drawing the fallback."""
        run.remember()
        return True

    def end(self, run: Work) -> bool:
        """Keep the better drawing."""
        return run.keep_if_better()


@dataclasses.dataclass(frozen=True)
class Stroke(Phase):
    """Draw line art as strokes, which later phases keep.

    In a flat picture, the remaining shapes are placed with them: without their neighbours, strokes would be trained to
    the wrong width. So is the paper of a scan.
    """

    kind: ClassVar[Kind] = "stroke"

    def begin(self, run: Work) -> bool:
        """Place the strokes; False if there are none, or shapes are cheaper."""
        state = run.state
        found = _found_strokes(run)
        if not found.num_layers:
            state.stage += 1
            return False
        if run.lines is not None:
            run.remember()
        before = state.drawing.num_layers
        state.add(found, np.arange(before + found.num_layers))
        state.holds[before:] = KEPT
        if run.lines is not None:
            place(run, sum(run.progress.schedule), state.stage)
        elif run.is_line_art and run.line_art.paper.num_layers:
            paper = run.line_art.paper
            state.add(paper, np.roll(np.arange(state.drawing.num_layers + 1), 1))
            state.holds[0] = KEPT
            fill(run, np.arange(state.drawing.num_layers) == 0)
        return True


@dataclasses.dataclass(frozen=True)
class Redraw(Phase):
    """Redraw the trained strokes with fewer nodes and pens, and train them again.

    In a flat picture they are kept unless shapes are cheaper.
    """

    kind: ClassVar[Kind] = "stroke"

    def begin(self, run: Work) -> bool:
        """Choose caps, join lines and fit them anew; False if there are no strokes."""
        from livecl.layering.strokes.ends import with_best_ends  # loads SciPy

        state = run.state
        if not _found_strokes(run).num_layers:
            state.stage += 1
            return False
        changed, sources = with_fewer_pens(run, with_best_shades(run, with_best_ends(run, state.drawing)))
        changed = redrawn(run, changed)
        if changed is not state.drawing:
            kept = state.holds[sources]
            state.replace_layers(changed, np.where(changed.strokes.widths > 0, -1, sources))
            state.holds = kept
        return True

    def end(self, run: Work) -> bool:
        """Keep the strokes, or start again without them."""
        return run.keep_worthwhile_strokes()


@dataclasses.dataclass(frozen=True)
class Grow(Phase):
    """Add paths where the error is largest: n of Algorithm 1. Their worth is judged at the end of the run."""

    count: int  # paths to add, at most
    kind: ClassVar[Kind] = "grow"

    def begin(self, run: Work) -> bool:
        """Place the paths; if none is worth placing, all later growing stages are skipped as well."""
        state, start = run.state, run.progress.start_drawing
        if run.is_line_art:
            run.end_growth()
            return False
        if state.stage and state.options.variant == "released":
            state.kept_weight = run.objective.released_weight(state, state.stage - 1)
        start_stage = 0 if start is None else int(start.stages.max(initial=0))
        refills = run.options.revisions > 0 and _last_of_many(run) and run.options.placement == "region"
        if not place(run, self.count, state.stage + start_stage, refills=refills):
            run.end_growth()
            return False
        run.progress.asked += self.count
        return True


@dataclasses.dataclass(frozen=True)
class Revise(Phase):
    """Merge neighbours of one colour and place the least useful layers anew; kept if the error falls enough.

    Attributes
    ----------
    share : int
        One of this many layers is replaced, and at least one.
    min_improvement : float
        Least relative decrease of the error.
    least_gain : float
        Relative decrease of the error below which another revision is unlikely to be worth its time. On 12 photographs
        of 32 paths, it saves a tenth of the work for .8 % of the error (docs/performance.md).
    merging_loss : float
        Largest rise of the mean squared error by merges: the path that each sets free may be worth more.
    max_failures : int
        Number of failed revisions in a row that ends the run: one with merges and one without. A revision that lowers
        the error by less than `least_gain`, or than the replaced layers must be worth (`Options.prune`), is kept but
        counts as failed.

    Notes
    -----
    Revisions took faces at 8 paths from .00187 to .00157 (docs/quality.md, "Choices of the default method"), with these
    values; no comparison of other values is recorded.
    """

    number: int  # revisions before this one
    share: ClassVar[int] = 16
    min_improvement: ClassVar[float] = 0.002
    least_gain: ClassVar[float] = 0.02
    merging_loss: ClassVar[float] = 1e-4
    max_failures: ClassVar[int] = 2
    kind: ClassVar[Kind] = "revise"

    def begin(self, run: Work) -> bool:
        """Remove layers, and place as many new ones."""
        state = run.state
        run.remember()
        if state.options.merge and run.progress.failures % 2 == 0 and can_merge(state.drawing):
            merged = merge_neighbors(run, state.drawing, state.free, self.merging_loss)
            if merged.drawing.num_layers < state.drawing.num_layers:
                state.replace_layers(merged.drawing, merged.sources)
        interruption.check()
        state.keep_layers(np.setdiff1d(np.arange(state.drawing.num_layers), self._replaced(run)))
        missing = run.progress.asked - int(np.sum(state.holds == FREE))
        if missing:
            place(run, missing, int(state.drawing.stages.max(initial=0)))
        if not self.number and not _refilled(run):
            fill(run, state.free)
        return True

    def end(self, run: Work) -> bool:
        """Keep the drawing if it is better by enough; count failures."""
        before = run.progress.fallback
        kept = run.keep_if_better(self.min_improvement)
        gain = before.error - run.visible_mse(run.state.drawing) if kept and before is not None else 0.0
        worth = self._share_of(run.state.drawing.num_layers) * max(run.options.prune, run.options.path_gain)
        if before is not None:
            worth = max(worth, self.least_gain * before.error)
        run.progress.failures = 0 if kept and gain >= worth else run.progress.failures + 1
        return kept

    def _share_of(self, num_layers: int) -> int:
        """Return the number of layers to replace."""
        return max(1, num_layers // self.share)

    def _replaced(self, run: Work) -> NDArray[np.intp]:
        """Return the layers to replace: the least useful; after a failure, the next ones in that order."""
        state = run.state
        order = least_useful(run, state.drawing)
        order = order[state.free[order]]
        count = min(len(order), self._share_of(state.drawing.num_layers))
        start = run.progress.failures * count % max(1, len(order) - count + 1)
        return order[start : start + count]


@dataclasses.dataclass(frozen=True)
class Thin(Phase):
    """Replace thin layers by strokes, and train them."""

    kind: ClassVar[Kind] = "thin"

    def begin(self, run: Work) -> bool:
        """Replace the layers; False if no stroke is cheaper."""
        from livecl.layering.strokes.thinning import thinned  # loads SciPy

        state = run.state
        before = state.drawing
        changed = thinned(run, before, state.free)
        if changed is before:
            state.stage += 1
            return False
        run.remember()
        new = changed.strokes.widths != before.strokes.widths
        state.replace_layers(changed, np.where(new, -1, np.arange(changed.num_layers)))
        return True

    def end(self, run: Work) -> bool:
        """Keep the strokes if the numbers saved are worth the error added."""
        from livecl.layering.strokes.thinning import worth

        fallback = run.progress.fallback
        return run.keep_if_better(rise=0.0 if fallback is None else worth(fallback.drawing, run.state.drawing))


@dataclasses.dataclass(frozen=True)
class Recolor(Phase):
    """Reduce the colours to `Options.colors`, and train the outlines with these."""

    kind: ClassVar[Kind] = "recolor"

    def begin(self, run: Work) -> bool:
        """Choose the colours and fix them."""
        run.state.recolor(with_few_colors(run, run.state.drawing, ~run.state.locked))
        return True


def plan_of(schedule: Sequence[int], revisions: int, strokes: str = "off", recolors: bool = False) -> tuple[Phase, ...]:
    """Return the phases of a run.

    One for each stage of the schedule (0 refines), then revisions. Strokes are drawn before paths are added, or in
    place of them. A limited number of colours is chosen at the end.
    """
    last: list[Phase] = [Recolor()] if recolors else []
    stages: list[Phase] = [Grow(count) if count else Refine() for count in schedule]
    if strokes != "off":
        first = next((index for index, phase in enumerate(stages) if isinstance(phase, Grow)), len(stages))
        stages[first:first] = [Stroke(), Redraw()]
        if strokes == "only":
            return (*stages[: first + 2], *last)
        stages.append(Thin())
    return (*stages, *(Revise(number) for number in range(revisions)), *last)


def place(run: Work, count: int, stage: int, *, refills: bool = False) -> int:
    """Add up to `count` layers, labelled with a stage, that are worth it; return their number.

    With `refills`, the fills of all layers that may change are chosen anew: after training, a gradient may be worth its
    price that was not before.
    """
    state = run.state
    lines = run.lines if state.drawing.strokes.any else None
    placement = place_paths(run, state.drawing, count, state.rng, sum(run.progress.schedule), lines)
    placed = placement.drawing.num_layers
    if placed:
        state.add(placement.drawing.replace(stages=np.full(placed, stage)), placement.order)
        if refills:
            fill(run, state.free)
        elif run.options.placement == "region" and state.drawing.background is not None:
            fill(run, placement.order >= state.drawing.num_layers - placed)
        if placement.weight is not None:
            state.kept_weight = placement.weight
        if placement.hidden_points is not None:
            state.hidden = placement.hidden_points(state.drawing)
    return placed


def _found_strokes(run: Work) -> Drawing:
    """Return the strokes found in the picture."""
    from livecl.layering.strokes.finding import kept_strokes  # loads SciPy

    return kept_strokes(run, run.line_art) if run.lines is None else run.lines.strokes


def _last_of_many(run: Work) -> bool:
    """Whether the stage that begins adds the last paths of the schedule, and is not the first."""
    counts = [count for count in run.progress.schedule if count]
    return len(counts) > 1 and run.progress.asked + counts[-1] == sum(counts)


def _refilled(run: Work) -> bool:
    """Whether the last stage has chosen the fills of all earlier layers anew."""
    counts = [count for count in run.progress.schedule if count]
    return len(counts) > 1 and run.progress.asked == sum(counts)


def fill(run: Work, layers: NDArray[np.bool_]) -> None:
    """Choose the best fills for some layers, (N,) bool."""
    drawing = shaded(run, run.state.drawing, layers)
    if drawing is not run.state.drawing:
        run.state.replace_fills(drawing)
