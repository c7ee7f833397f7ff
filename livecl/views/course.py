# SPDX-License-Identifier: Apache-2.0
"""`Course`: record the drawing during training, and show it as a film."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import scaled
from livecl.drawing.checks import check_number, check_whole
from livecl.drawing.drawing import Drawing
from livecl.files import write_atomically
from livecl.run.callbacks import OnStep, Step, tell_stage_end
from livecl.run.result import Result
from livecl.views.films import save_mp4
from livecl.views.frames import MAX_GIF_HOLD, MIN_GIF_FRAME, encode_gif, render_frames

#: Longer side, px, to which smaller drawings are enlarged in a film, by a whole factor.
MIN_SIDE = 240


@dataclasses.dataclass(frozen=True)
class Frame:
    """The drawing after a step: stage, from 0, and iteration, from 1."""

    stage: int
    iteration: int
    drawing: Drawing


class Course:
    """Records the drawings of a run: pass it as `on_step`.

    A drawing takes a few kilobytes, and nothing is rendered. Stages and revisions that the run does not keep are not
    part of the course (:meth:`on_stage`).

    Parameters
    ----------
    every : int
        Record the drawing after every N-th step, and after the first and the last step of each stage.
    on_step : callable, optional
        Another callback, which is called first; if it returns true, the run stops.
    """

    def __init__(self, every: int = 10, *, on_step: OnStep | None = None) -> None:
        check_whole("every", every, 1)
        self.every = every
        self._on_step = on_step
        self._frames: list[Frame] = []
        self._attempt: list[Frame] = []

    def __call__(self, step: Step) -> bool | None:
        """Record the drawing if it is due; return the other callback's value."""
        stopped = None if self._on_step is None else self._on_step(step)
        if step.iteration == 1 or step.iteration == step.iterations or step.iteration % self.every == 0:
            if self._attempt and self._attempt[-1].stage != step.stage:
                self._attempt = []
            frames = self._attempt if step.kind == "revise" else self._frames
            frames.append(Frame(step.stage, step.iteration, step.drawing))
        return stopped

    def on_stage(self, step: Step, kept: bool) -> None:
        """Add the frames of a stage that is kept; drop those of one that is not."""
        tell_stage_end(self._on_step, step, kept)
        if kept:
            self._frames += self._attempt
        else:
            self._frames = [frame for frame in self._frames if frame.stage != step.stage]
        self._attempt = []

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The drawings recorded."""
        return tuple(self._frames)

    def drawings(self, *, step: int = 1, result: Result | None = None) -> list[Drawing]:
        """Return each `step`-th drawing, and the last one: that of the result, if given.

        With a result, all are on the canvas that its errors are measured on, which may be smaller than its own;
        without, on that of the steps (`Options.pixels_per_path`).

        Raises
        ------
        ValueError
            If nothing has been recorded, or `step` is below 1.
        """
        check_whole("step", step, 1)
        kept = [frame.drawing for frame in self._frames]
        if result is not None:
            size = result.working_size or result.drawing.size
            kept = [scaled(drawing, size) for drawing in (*kept, result.drawing)]
        if not kept:
            raise ValueError("course: it is empty; pass it to livecl.vectorize as on_step")
        chosen = kept[::step]
        return chosen if chosen[-1] is kept[-1] else [*chosen, kept[-1]]

    def save_gif(
        self,
        path: str | os.PathLike[str],
        *,
        result: Result | None = None,
        step: int = 1,
        fps: float = 20.0,
        hold: float = 2.0,
        scale: float | None = None,
        device: int | str | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        """Write the course as a GIF that loops, replacing an existing file atomically.

        Parameters
        ----------
        path : path
            File to write.
        result : Result, optional
            Result of the run; its drawing is shown last.
        step : int
            Show every `step`-th drawing.
        fps : float
            Drawings per second, at most 50.
        hold : float
            Additional time for which the last drawing is shown, seconds, at most 600.
        scale : float, optional
            Pixels of the film for each px of the canvas; by default 1, or the whole number that brings a smaller
            drawing's longer side near 240.
        device : int, str or None
            OpenCL device that renders.
        progress : callable, optional
            Called with the number of pictures done and that of all.

        Raises
        ------
        ValueError
            If nothing has been recorded, or a number is out of range.
        """
        drawings = self.drawings(step=step, result=result)
        if not 0 < fps <= 1 / MIN_GIF_FRAME:
            raise ValueError(
                f"fps: got {fps!r}, wanted more than 0 and at most {1 / MIN_GIF_FRAME:g} pictures a second"
            )
        check_number("hold", hold, 0, MAX_GIF_HOLD)
        pictures = list(_rendered(drawings, scale, device, progress))
        durations = [1 / fps] * len(pictures)
        durations[-1] += hold
        write_atomically(path, encode_gif(pictures, durations))

    def save_mp4(
        self,
        path: str | os.PathLike[str],
        *,
        result: Result | None = None,
        step: int = 1,
        fps: float = 20.0,
        hold: float = 2.0,
        scale: float | None = None,
        device: int | str | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        """Write the course as an MP4 film, replacing an existing file atomically.

        Parameters
        ----------
        path, result, step, fps, hold, scale, device, progress
            As for :meth:`save_gif`, with `fps` up to 1000 and `hold` up to 3600.

        Raises
        ------
        ValueError
            If nothing has been recorded, or a number is out of range.
        LiveclError
            If ffmpeg is not there, which comes with the extra ``video``, or fails.
        """
        drawings = self.drawings(step=step, result=result)
        save_mp4(path, _rendered(drawings, scale, device, progress), fps=fps, hold=hold)


def _rendered(
    drawings: Sequence[Drawing],
    scale: float | None,
    device: int | str | None,
    progress: Callable[[int, int], None] | None,
) -> Iterator[NDArray[np.float32]]:
    """Render drawings, over white, and report after each."""
    if scale is None:
        scale = max(1, MIN_SIDE // max(drawings[0].size))
    for done, picture in enumerate(render_frames(drawings, scale, device), start=1):
        yield picture
        if progress is not None:
            progress(done, len(drawings))
