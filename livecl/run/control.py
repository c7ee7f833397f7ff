# SPDX-License-Identifier: Apache-2.0
"""`Control`: time limit of a run, a stop from outside, and the checkpoint file."""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable

from livecl.drawing.checks import python_number

#: Why a run stopped: the time that it was given is over, or the caller's `on_step` asked for it.
TIME_LIMIT, CALLBACK = "time limit", "callback"


class Stopped(Exception):
    """Raised within a run that is to end, by :meth:`Watch.check`, and caught there.

    Attributes
    ----------
    reason : str
        Why.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


@dataclasses.dataclass(frozen=True, kw_only=True)
class Control:
    """Time limit, stop and checkpoint of a run; they change no number of its results, only how far it comes.

    Parameters
    ----------
    time_limit : float, optional
        Seconds after which the run ends with the best drawing so far.
    stop : callable, optional
        Asked several times a second; the run ends likewise when it returns a reason, as a few words.
    checkpoint : path, optional
        File from which the run can go on after it was stopped or killed. It is written now and then, and when the run
        stops; one that has been written stays when the run is done, so that the result is safe until it is saved:
        delete it then. Only one run may use it at a time.
    period : float, optional
        Least seconds between two writings; where not given 5, and more where they would take more than a hundredth of
        the time.
    resume : bool
        Go on from the checkpoint, if it is there; a run so resumed ends with the numbers of one that was never
        stopped. A checkpoint of anything but the same picture, options, version and device is refused.

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
    """Tells a run, as often as it asks, whether it is to stop; its clock starts when it is made."""

    def __init__(self, control: Control) -> None:
        self._stop = control.stop
        self._end = math.inf if control.time_limit is None else time.monotonic() + control.time_limit

    def check(self) -> None:
        """Raise :class:`Stopped` if the run is to stop."""
        if self._stop is not None and (reason := self._stop()):
            raise Stopped(reason)
        if time.monotonic() >= self._end:
            raise Stopped(TIME_LIMIT)
