# SPDX-License-Identifier: Apache-2.0
"""`Work`: the state of a run that its phases change, and the context of their decisions."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl.image.background import TRAIN, WHITE, target_over
from livecl.layering.context import Context
from livecl.rendering.rasterizer import Rasterizer
from livecl.run.progress import Progress
from livecl.training.objective import Objective
from livecl.training.state import State

if TYPE_CHECKING:
    from livecl.layering.strokes.finding import LineArt
    from livecl.layering.strokes.line_work import LineWork


class Work(Context):
    """Target, rasterizer and progress of a run.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array
        Straight colours in [0, 1]; composited over the drawing's background, or, without one, with alpha as a part of
        the target.
    progress : Progress
        State to continue from; :meth:`Progress.start` for a new run.
    device : int, str or None
        OpenCL device.

    Attributes
    ----------
    num_stages : int
        Phases of the run's plan before the first revision.
    """

    num_stages: int

    def __init__(
        self,
        image: NDArray[np.floating],
        progress: Progress,
        device: int | str | None = None,
    ) -> None:
        drawing, options = progress.state.drawing, progress.state.options
        if drawing.size != image.shape[:2]:
            raise ValueError(f"image: {image.shape[:2]} pixels, wanted the drawing's {drawing.size}")
        straight = np.asarray(image, dtype=np.float32)
        target = target_over(straight, WHITE if options.background == TRAIN else drawing.background)
        super().__init__(Rasterizer(drawing.size, device), target, options)
        self.progress = progress
        self.objective = Objective(self.rasterizer, target)

    @functools.cached_property
    def lines(self) -> LineWork | None:
        """The strokes of a flat picture that are worth their price; None if there are none or it is not flat."""
        if not self._draws_lines:
            return None
        from livecl.layering.strokes.line_work import line_work  # loads SciPy

        return line_work(self, self.state.drawing.background, sum(self.progress.schedule))

    @functools.cached_property
    def line_art(self) -> LineArt:
        """The strokes of a picture that is not flat, and how much of its ink they explain."""
        from livecl.layering.strokes.finding import find_line_art  # loads SciPy

        return find_line_art(self, self.state.drawing.background)

    @property
    def is_line_art(self) -> bool:
        """Whether the picture, which is not flat, is lines on paper alone, so that no paths are added to them."""
        from livecl.layering.strokes.rules import RULES

        wanted = self.options.strokes == "auto" and not self._draws_lines and self.options.path_gain > 0
        return wanted and self.state.drawing.strokes.any and self.line_art.explained >= RULES.line_art

    @functools.cached_property
    def edge_offset(self) -> float:
        """Distance, px, that edges of a flat picture may lie off, where lines and outlines of it compete; else 0."""
        if not self._draws_lines:
            return 0.0
        from livecl.layering.strokes.line_work import edge_offset_of  # loads SciPy

        return edge_offset_of(self, self.state.drawing.background, sum(self.progress.schedule))

    @property
    def _draws_lines(self) -> bool:
        """Whether strokes compete with the shapes of a flat picture."""
        return self.options.strokes == "auto" and self.options.placement == "structure"

    @property
    def state(self) -> State:
        """Drawing and moments."""
        return self.progress.state

    @property
    def revising(self) -> bool:
        """Whether all stages of the schedule are done."""
        return self.state.stage >= self.num_stages

    @contextlib.contextmanager
    def all_or_nothing(self) -> Iterator[None]:
        """Context manager: restore the progress if the block is left by an exception."""
        before = self.progress.copy()
        try:
            yield
        except BaseException:
            self.progress = before
            raise

    def end_growth(self) -> None:
        """Skip the remaining stages of the schedule; revisions follow."""
        self.state.stage = self.num_stages

    def remember(self) -> None:
        """Make the drawing the fallback of the current phase."""
        self.progress.fallback = self.state.fall_back(self.visible_mse(self.state.drawing))

    def keep_worthwhile_strokes(self) -> bool:
        """Return whether the strokes of a flat picture are kept; if not, restore the drawing without them."""
        state, fallback = self.state, self.progress.fallback
        if self.lines is None or fallback is None:
            return True
        kept = self.lines.worthwhile(self, state.drawing)
        if not kept:
            state.restore(fallback)
            state.pieces = self.rasterizer.pieces(state.drawing)
            self.progress.error = fallback.error
        self.progress.fallback = None
        return kept

    def keep_if_better(self, improvement: float = 0.0, rise: float = 0.0) -> bool:
        """Return whether the drawing is better than the fallback; if not, restore that.

        Better: its error is lower by the share `improvement`, or higher by less than `rise`.
        """
        state, fallback = self.state, self.progress.fallback
        if fallback is None:
            raise ValueError("the phase has no fallback")
        kept = self.visible_mse(state.drawing) < fallback.error * (1 - improvement) + rise
        if not kept:
            state.restore(fallback)
            state.pieces = self.rasterizer.pieces(state.drawing)
        self.progress.fallback = None
        return kept
