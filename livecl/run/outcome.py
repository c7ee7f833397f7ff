# SPDX-License-Identifier: Apache-2.0
"""Outcome of a run: the steps from the trained drawing to the saved one."""

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
class FinalDrawing:
    """A drawing in the last steps of a run, rounded as in the SVG.

    Attributes
    ----------
    drawing : Drawing
        Layers, rounded.
    holds : (N,) int
        Holds of the layers, as of :attr:`livecl.training.state.State.holds`.
    """

    drawing: Drawing
    holds: NDArray[np.int8]

    @property
    def free(self) -> NDArray[np.bool_]:
        """Layers (N,) that may be merged and dropped."""
        return np.asarray(self.holds == FREE)

    @property
    def unlocked(self) -> NDArray[np.bool_]:
        """Layers (N,) whose colours and outlines may change."""
        return np.asarray(self.holds != LOCKED)

    def of(self, drawing: Drawing, sources: NDArray[np.intp]) -> FinalDrawing:
        """Return the outcome with another drawing; `sources` are its layers' former indices, -1 for new, free ones."""
        return FinalDrawing(quantize(drawing), np.where(sources < 0, np.int8(FREE), self.holds[sources]))


def least_gain(context: Context) -> float:
    """Return the mean squared error that a layer must remove to be worth keeping."""
    return max(context.options.prune, context.options.path_gain)


def merged(context: Context, outcome: FinalDrawing) -> FinalDrawing:
    """Merge neighbours of one colour, if that saves more than the error that it adds."""
    if not (context.options.merge and can_merge(outcome.drawing)):
        return outcome
    found = merge_neighbors(context, outcome.drawing, outcome.free, least_gain(context))
    return outcome.of(found.drawing, found.sources)


def edited(context: Context, outcome: FinalDrawing) -> FinalDrawing:
    """Reduce colours to the palette, and make outlines editable."""
    recolored = with_few_colors(context, outcome.drawing, outcome.unlocked)
    return FinalDrawing(quantize(editable(context, recolored, outcome.unlocked)), outcome.holds)


def with_borders(context: Context, outcome: FinalDrawing) -> FinalDrawing:
    """Replace an outlined shape, found as two nested shapes, by one shape with a fill and a stroke."""
    if context.options.strokes != "auto":
        return outcome
    from livecl.editing import bordered  # loads SciPy

    return outcome.of(*bordered(context, outcome.drawing, outcome.free))


#: Steps of a finished run; pruning follows.
FINISHING: tuple[Callable[[Context, FinalDrawing], FinalDrawing], ...] = (merged, edited, with_borders)


def saved_drawing(
    context: Context, drawing: Drawing, holds: NDArray[np.int8], *, finished: bool, trim: bool
) -> Drawing:
    """Return a drawing as saved: rounded, and pruned; of a `finished` run, also merged and edited.

    With `trim`, it is trimmed to the page.
    """
    outcome = FinalDrawing(quantize(drawing), holds)
    for step in FINISHING if finished else ():
        outcome = step(context, outcome)
    needed = needed_layers(context, outcome.drawing, least_gain(context) if finished else 0.0, outcome.free)
    return quantize(trimmed(needed)) if trim else needed
