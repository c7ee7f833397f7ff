# SPDX-License-Identifier: Apache-2.0
"""Phases of a run: refine a drawing to start from, grow it by new paths, revise it at the end, leave few colours.

Each phase begins by changing the layers, is trained by the loop (:mod:`livecl.run.loop`), and ends by a decision:
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
from livecl.editing import with_few_colors
from livecl.layering.fills.choice import shaded
from livecl.layering.placement import place_paths
from livecl.layering.revision.merging import can_merge, merge_neighbors
from livecl.layering.revision.pruning import least_useful
from livecl.layering.strokes.pens import with_fewer_pens
from livecl.layering.strokes.redrawing import redrawn
from livecl.run.work import Work
from livecl.training.state import FREE, KEPT

Kind = Literal["refine", "stroke", "grow", "thin", "revise", "recolor"]


class Phase(abc.ABC):
    """A part of a run: changes layers, is trained, and is kept or taken back."""

    kind: ClassVar[Kind]

    @abc.abstractmethod
    def begin(self, run: Work) -> bool:
        """Change the layers; return whether there is anything to train: False leaves the phase out."""

    def end(self, run: Work) -> bool:
        """Return whether the trained drawing is kept; if not, the drawing before is restored. Kept where not judged."""
        return True


@dataclasses.dataclass(frozen=True)
class Refine(Phase):
    """Train the layers of a drawing that the run starts from; kept if the error falls."""

    kind: ClassVar[Kind] = "refine"

    def begin(self, run: Work) -> bool:
        """Remember the drawing as fallback."""
        run.remember()
        return True

    def end(self, run: Work) -> bool:
        """Keep the better drawing."""
        return run.keep_if_better()


@dataclasses.dataclass(frozen=True)
class Stroke(Phase):
    """Draw line art as strokes, which later phases keep.

    In a flat picture, the shapes that strokes leave are placed with them: without what lies beside them, strokes would
    be trained to the wrong width.
    """

    kind: ClassVar[Kind] = "stroke"

    def begin(self, run: Work) -> bool:
        """Place the strokes; False where there are none, or shapes are cheaper."""
        from livecl.layering.strokes.finding import find_strokes  # loads SciPy

        state = run.state
        found = find_strokes(run, state.drawing.background) if run.lines is None else run.lines.strokes
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
        return True


@dataclasses.dataclass(frozen=True)
class Redraw(Phase):
    """Draw the strokes, as they have been trained, with fewer nodes and pens, and train them again.

    In a flat picture they are kept if they are no dearer than shapes.
    """

    kind: ClassVar[Kind] = "stroke"

    def begin(self, run: Work) -> bool:
        """Choose caps, join lines and fit them anew; False where nothing is better."""
        from livecl.layering.strokes.ends import with_best_ends  # loads SciPy

        state = run.state
        changed, sources = with_fewer_pens(run, with_best_ends(run, state.drawing))
        changed = redrawn(run, changed)
        if changed is state.drawing:
            run.keep_worthwhile_strokes()
            state.stage += 1
            return False
        kept = state.holds[sources]
        state.replace_layers(changed, np.where(changed.strokes.widths > 0, -1, sources))
        state.holds = kept
        return True

    def end(self, run: Work) -> bool:
        """Keep the strokes, or begin again without them."""
        return run.keep_worthwhile_strokes()


@dataclasses.dataclass(frozen=True)
class Grow(Phase):
    """Add paths where the drawing lacks most: n of Algorithm 1. Their worth is judged at the end of the run."""

    count: int  # paths to add, at most
    kind: ClassVar[Kind] = "grow"

    def begin(self, run: Work) -> bool:
        """Place the paths; where none is worth placing, no later one is either: the other stages are left out too."""
        state, start = run.state, run.progress.start_drawing
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
    """Merge neighbours of one colour, place the least useful layers anew; kept if the error falls by enough.

    Attributes
    ----------
    share : int
        Layers for each one that is replaced; at least one is.
    min_improvement : float
        Share by which the error must fall.
    least_gain : float
        Share of the error that a revision must remove for another one to be likely worth its time. Of 12 photographs of
        32 paths, it leaves out a tenth of the work for .8 % of the error (docs/performance.md).
    merging_loss : float
        Rise of the mean squared error that merges may cost: the path that each sets free may be worth more.
    max_failures : int
        Revisions in a row that may come to nothing before the run ends: one with merges and one without. One that
        lowers the error by less than `least_gain`, or than the layers that it replaces must be worth (`Options.prune`),
        is kept and counts.

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
        """Take layers out, and place as many as are missing."""
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
        """Keep a drawing that is better by enough; count failures."""
        before = run.progress.fallback
        kept = run.keep_if_better(self.min_improvement)
        gain = before.error - run.visible_mse(run.state.drawing) if kept and before is not None else 0.0
        worth = self._share_of(run.state.drawing.num_layers) * max(run.options.prune, run.options.path_gain)
        if before is not None:
            worth = max(worth, self.least_gain * before.error)
        run.progress.failures = 0 if kept and gain >= worth else run.progress.failures + 1
        return kept

    def _share_of(self, num_layers: int) -> int:
        """Return how many of some layers are replaced."""
        return max(1, num_layers // self.share)

    def _replaced(self, run: Work) -> NDArray[np.intp]:
        """Return the layers to replace: the least useful, after failures the next ones in that order."""
        state = run.state
        order = least_useful(run, state.drawing)
        order = order[state.free[order]]
        count = min(len(order), self._share_of(state.drawing.num_layers))
        start = run.progress.failures * count % max(1, len(order) - count + 1)
        return order[start : start + count]


@dataclasses.dataclass(frozen=True)
class Thin(Phase):
    """Explain thin layers as strokes, and train them."""

    kind: ClassVar[Kind] = "thin"

    def begin(self, run: Work) -> bool:
        """Replace the layers; False where none is a stroke at a lower price."""
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
        """Keep the strokes if the error that they have added is worth the numbers that they have saved."""
        from livecl.layering.strokes.thinning import worth

        fallback = run.progress.fallback
        return run.keep_if_better(rise=0.0 if fallback is None else worth(fallback.drawing, run.state.drawing))


@dataclasses.dataclass(frozen=True)
class Recolor(Phase):
    """Leave as many colours as `Options.colors` asks for, and train outlines with these."""

    kind: ClassVar[Kind] = "recolor"

    def begin(self, run: Work) -> bool:
        """Choose the colours, which stay."""
        run.state.recolor(with_few_colors(run, run.state.drawing, ~run.state.locked))
        return True


def plan_of(schedule: Sequence[int], revisions: int, strokes: str = "off", recolors: bool = False) -> tuple[Phase, ...]:
    """Return the phases of a run.

    One for each stage of the schedule, of which 0 refines, then revisions; strokes are drawn before paths
    are added, or in place of them; where the number of colours is limited, they are chosen at the end.
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
    """Add up to `count` layers, labelled with a stage, and return how many were worth it.

    With `refills`, all layers that may change are filled anew: trained, they may be worth a gradient that they were not
    when placed.
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


def _last_of_many(run: Work) -> bool:
    """Whether the stage that begins adds the last of the paths asked for, and others came before it."""
    counts = [count for count in run.progress.schedule if count]
    return len(counts) > 1 and run.progress.asked + counts[-1] == sum(counts)


def _refilled(run: Work) -> bool:
    """Whether the last stage has filled the layers of those before it anew."""
    counts = [count for count in run.progress.schedule if count]
    return len(counts) > 1 and run.progress.asked == sum(counts)


def fill(run: Work, layers: NDArray[np.bool_]) -> None:
    """Give some layers, (N,) bool, the fills that are worth most to them."""
    drawing = shaded(run, run.state.drawing, layers)
    if drawing is not run.state.drawing:
        run.state.replace_fills(drawing)
