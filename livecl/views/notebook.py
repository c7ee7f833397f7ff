# SPDX-License-Identifier: Apache-2.0
"""`LiveView`: show the drawing in a notebook during training."""

from __future__ import annotations

import html
import signal
import threading
import time
from types import FrameType, TracebackType
from typing import Any

from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.run.callbacks import OnStep, Step, tell_stage_end
from livecl.views.report.markup import STAGE_PRECISION, drawing_svg


class LiveView:
    """Shows the drawing of a run as SVG in a notebook, and updates it in place: pass it as `on_step`.

    As a context manager it also makes an interrupt (the notebook's stop button, Ctrl-C) end the run after the current
    step, so that :func:`livecl.vectorize` returns the drawing so far; a second one interrupts at once::

        with LiveView() as view:
            result = livecl.vectorize(image, paths=8, on_step=view)

    Parameters
    ----------
    interval : float
        Least time between two updates, s; the last drawing of each stage is always shown.
    width : int, optional
        Width of the drawing in the notebook, px (default: its own).
    on_step : callable, optional
        Another callback, which is called first; if it returns true, the run stops.

    Raises
    ------
    LiveclError
        If IPython is not installed, or the program does not run in IPython.
    ValueError
        If a number is out of range.
    """

    def __init__(
        self,
        interval: float = 0.3,
        *,
        width: int | None = None,
        on_step: OnStep | None = None,
    ) -> None:
        if not interval >= 0:
            raise ValueError(f"interval: got {interval!r}, wanted a number of seconds of at least 0")
        if width is not None and not width >= 1:
            raise ValueError(f"width: got {width!r}, wanted at least 1 px")
        try:
            from IPython import get_ipython
        except ImportError as error:
            raise LiveclError("a live view needs a notebook: pip install notebook") from error
        if get_ipython() is None:
            raise LiveclError("a live view needs a notebook, or an IPython shell with a display: there is none here")
        self.interval = interval
        self.width = width
        self.interrupted = False
        self._on_step = on_step
        self._handle: Any = None
        self._next = 0.0
        self._handler_before: Any = None

    def __enter__(self) -> LiveView:
        """Handle interrupts, if in the main thread."""
        self.interrupted = False
        if threading.current_thread() is threading.main_thread():
            self._handler_before = signal.signal(signal.SIGINT, self._interrupt)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Restore the former handler of interrupts."""
        if self._handler_before is not None:
            signal.signal(signal.SIGINT, self._handler_before)
            self._handler_before = None

    def __call__(self, step: Step) -> bool:
        """Show the drawing if it is due; return whether the run should stop."""
        stopped = bool(self._on_step is not None and self._on_step(step)) or self.interrupted
        now = time.monotonic()
        if stopped or now >= self._next or step.iteration == step.iterations:
            self._show(step.drawing, _caption(step, stopped))
            self._next = time.monotonic() + self.interval
        return stopped

    def on_stage(self, step: Step, kept: bool) -> None:
        """Show the drawing with which the run continues if a stage is not kept."""
        tell_stage_end(self._on_step, step, kept)
        if not kept:
            self._show(step.drawing, f"{step.name}, taken back, paths {step.drawing.num_layers}")

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if self.interrupted:
            raise KeyboardInterrupt
        self.interrupted = True

    def _show(self, drawing: Drawing, caption: str) -> None:
        from IPython.display import DisplayHandle

        height, width = drawing.size
        svg = drawing_svg(drawing, STAGE_PRECISION, f'width="{self.width or width}" role="img" aria-label="Drawing"')
        data = {
            "text/html": f"{svg}<div>{html.escape(caption)}</div>",
            "text/plain": f"{width} x {height} px, {caption}",
        }
        if self._handle is None:
            self._handle = DisplayHandle()
            self._handle.display(data, raw=True)
        else:
            self._handle.update(data, raw=True)


def _caption(step: Step, stopped: bool) -> str:
    place = f"{step.name}, step {step.iteration} of {step.iterations}"
    return f"{place}, paths {step.paths}, loss {step.loss:.3g}{', stopped' if stopped else ''}"
