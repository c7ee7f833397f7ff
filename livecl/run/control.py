# SPDX-License-Identifier: Apache-2.0
"""`Control`: time limit of a run, external stop, checkpoint file."""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable

from livecl.drawing.checks import python_number

#: Reasons to stop: the time limit is reached, or the caller's `on_step` returned true.
TIME_LIMIT, CALLBACK = "time limit", "callback"


class Stopped(Exception):
    """Signals that the run should stop; raised by :meth:`Watch.check` and caught by the run.

    Attributes
    ----------
    reason : str
        The reason, in a few words.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


@dataclasses.dataclass(frozen=True, kw_only=True)
class Control:
    """Time limit, stop and checkpoint of a run; they decide how far it gets, and change no numbers.

    Parameters
    ----------
    time_limit : float, optional
        Seconds after which the run ends with the best drawing so far.
    stop : callable, optional
        Called several times a second; if it returns a reason, as a few words, the run ends in the same way.
    checkpoint : path, optional
        File from which the run can be resumed after it was stopped or killed. It is written periodically, and when the
        run stops. It is not deleted at the end of the run, so that the result is safe until it is saved: delete it
        then. Only one run may use it at a time.
    period : float, optional
        Least time between two writings, seconds (default: 5, or a hundred times the time of writing if longer).
    resume : bool
        Resume from the checkpoint, if it exists; the results are those of a run that was never stopped. A checkpoint of
        another picture, other options, another version or device is refused.

    Raises
    ------
    ValueError
        If a value is not usable; the message names it.
    """

    time_limit: float | None = None
    stop: Callable[[], str | None] | None = None
    checkpoint: str | os.PathLike[str] | None = None
    period: float | None = None
    resume: bool = False

    def __post_init__(self) -> None:
        for name in ("time_limit", "period"):
            value = python_number(getattr(self, name))
            object.__setattr__(self, name, value)
            if value is not None and not (isinstance(value, (int, float)) and math.isfinite(value) and value >= 0):
                raise ValueError(f"{name}: got {value!r}, wanted a number of seconds")
        if self.resume and self.checkpoint is None:
            raise ValueError("resume: needs a checkpoint; give the file as checkpoint")


class Watch:
    """Stops a run by raising :class:`Stopped`; the time limit counts from its construction."""

    def __init__(self, control: Control) -> None:
        self._stop = control.stop
        self._end = math.inf if control.time_limit is None else time.monotonic() + control.time_limit

    def check(self) -> None:
        """Raise :class:`Stopped` if the run should stop."""
        if self._stop is not None and (reason := self._stop()):
            raise Stopped(reason)
        if time.monotonic() >= self._end:
            raise Stopped(TIME_LIMIT)
