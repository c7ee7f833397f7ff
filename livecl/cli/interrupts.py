# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C and SIGTERM, for the command line: asked once they may wait for work to be brought to an end, twice not."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any

#: The signals, and how messages name that they came.
REASONS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
#: What a shell adds to a signal's number for the exit code of a process that it ended.
SIGNALLED = 128


class Interrupted(KeyboardInterrupt):
    """One of the signals came, and is not waited with."""

    def __init__(self, number: int) -> None:
        super().__init__(REASONS[signal.Signals(number)])
        self.number = number

    @property
    def exit_code(self) -> int:
        """Exit code of the process, as shells have it."""
        return SIGNALLED + self.number


class Interrupts:
    """Takes the signals for a while, if in the main thread; a context manager.

    Attributes
    ----------
    pending : Interrupted or None
        What came while it was to wait.
    """

    def __init__(self) -> None:
        self.pending: Interrupted | None = None
        self._waits = False
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interrupts:
        """Take the signals, but for those that the process was started to ignore."""
        if threading.current_thread() is threading.main_thread():
            for number in REASONS:
                if signal.getsignal(number) not in (signal.SIG_IGN, None):
                    self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        """Give the signals back to whoever had them."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    @contextlib.contextmanager
    def waiting(self) -> Iterator[None]:
        """Within, the first signal is only noted; a second, and one after, raises :class:`Interrupted`."""
        self._waits = True
        try:
            yield
        finally:
            self._waits = False

    def reason(self) -> str | None:
        """Return why the work is to come to an end, if it is; a `Control.stop`."""
        return None if self.pending is None else str(self.pending)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        interrupted = Interrupted(number)
        if not self._waits or self.pending is not None:
            for each in self._before:  # whoever asks once more gets what the system does
                signal.signal(each, signal.SIG_DFL)
            raise interrupted
        self.pending = interrupted
