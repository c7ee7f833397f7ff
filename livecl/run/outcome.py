# SPDX-License-Identifier: Apache-2.0
"""Outcome of a run: the steps from the drawing as trained to the drawing as saved, in their order."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.editing import editable, with_few_colors
from livecl.layering.context import Context
from livecl.layering.revision.merging import can_merge, merge_neighbors
from livecl.layering.revision.pruning import needed_layers
from livecl.layering.revision.trimming import trimmed
from livecl.svg import quantize
from livecl.training.state import FREE, LOCKED


@dataclasses.dataclass(frozen=True, eq=False)
class Outcome:
    """A drawing on its way out of a run, rounded as SVG is written.

    Attributes
    ----------
    drawing : Drawing
        Layers, rounded.
    holds : (N,) int
        What may change of each layer, as of :attr:`livecl.training.state.State.holds`.
    """

    drawing: Drawing
    holds: NDArray[np.int8]

    @property
    def free(self) -> NDArray[np.bool_]:
        """Layers (N,) that may be merged and left out."""
        return np.asarray(self.holds == FREE)

    @property
    def unlocked(self) -> NDArray[np.bool_]:
        """Layers (N,) whose colours and outlines may change."""
        return np.asarray(self.holds != LOCKED)

    def of(self, drawing: Drawing, sources: NDArray[np.intp]) -> Outcome:
        """Return the outcome that has another drawing, whose layers come from these; those from none are free."""
        return Outcome(quantize(drawing), np.where(sources < 0, np.int8(FREE), self.holds[sources]))


def least_gain(context: Context) -> float:
    """Return the mean squared error that a layer must remove to be worth keeping."""
    return max(context.options.prune, context.options.path_gain)


def merged(context: Context, outcome: Outcome) -> Outcome:
    """Merge neighbours of one colour, where that is worth more than the error that it adds."""
    if not (context.options.merge and can_merge(outcome.drawing)):
        return outcome
    found = merge_neighbors(context, outcome.drawing, outcome.free, least_gain(context))
    return outcome.of(found.drawing, found.sources)


def edited(context: Context, outcome: Outcome) -> Outcome:
    """Reduce colours to the palette, and make outlines editable."""
    recolored = with_few_colors(context, outcome.drawing, outcome.unlocked)
    return Outcome(quantize(editable(context, recolored, outcome.unlocked)), outcome.holds)


def outlined(context: Context, outcome: Outcome) -> Outcome:
    """Explain an outline around a fill, found as two shapes, as one shape with a fill and a stroke."""
    if context.options.strokes != "auto":
        return outcome
    from livecl.editing import bordered  # loads SciPy

    return outcome.of(*bordered(context, outcome.drawing, outcome.free))


#: Steps of a finished run; pruning follows.
FINISHING: tuple[Callable[[Context, Outcome], Outcome], ...] = (merged, edited, outlined)


def saved_drawing(
    context: Context, drawing: Drawing, holds: NDArray[np.int8], *, finished: bool, trim: bool
) -> Drawing:
    """Return a drawing as it is saved: rounded, without needless layers; of a `finished` run, merged and editable.

    It is trimmed to the page if `trim` says so.
    """
    outcome = Outcome(quantize(drawing), holds)
    for step in FINISHING if finished else ():
        outcome = step(context, outcome)
    needed = needed_layers(context, outcome.drawing, least_gain(context) if finished else 0.0, outcome.free)
    return quantize(trimmed(needed)) if trim else needed
