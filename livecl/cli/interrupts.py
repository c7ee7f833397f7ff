# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C and SIGTERM on the command line: the first signal ends the run cleanly, a second one aborts."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any

#: Signals, and their names in messages.
REASONS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
#: Offset that shells add to a signal's number for the exit code of a process.
SIGNALLED = 128


class Interrupted(KeyboardInterrupt):
    """A signal arrived and aborts the work."""

    def __init__(self, number: int) -> None:
        super().__init__(REASONS[signal.Signals(number)])
        self.number = number

    @property
    def exit_code(self) -> int:
        """Exit code of the process, by the convention of shells."""
        return SIGNALLED + self.number


class Interrupts:
    """Context manager that handles the signals, if in the main thread.

    Attributes
    ----------
    pending : Interrupted or None
        The deferred signal.
    """

    def __init__(self) -> None:
        self.pending: Interrupted | None = None
        self._waits = False
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interrupts:
        """Install handlers, except for signals that the process was started to ignore."""
        if threading.current_thread() is threading.main_thread():
            for number in REASONS:
                if signal.getsignal(number) not in (signal.SIG_IGN, None):
                    self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        """Restore the former handlers."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    @contextlib.contextmanager
    def waiting(self) -> Iterator[None]:
        """Defer the first signal; a second one, and one afterwards, raises :class:`Interrupted`."""
        self._waits = True
        try:
            yield
        finally:
            self._waits = False

    def reason(self) -> str | None:
        """Return the reason to stop, or None; a `Control.stop`."""
        return None if self.pending is None else str(self.pending)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        interrupted = Interrupted(number)
        if not self._waits or self.pending is not None:
            for each in self._before:  # a further signal has the system's default effect
                signal.signal(each, signal.SIG_DFL)
            raise interrupted
        self.pending = interrupted
