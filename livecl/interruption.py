# SPDX-License-Identifier: Apache-2.0
"""Interruption of long computations: `check()`, called several times a second, raises to stop the work."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")

#: Seconds after which whoever waits for work that has no pieces asks again.
PATIENCE = 0.1

_asked: ContextVar[Callable[[], None] | None] = ContextVar("asked", default=None)


def check() -> None:
    """Stop the running computation by an exception, if it was interrupted.

    Any work that may take a tenth of a second calls this between its pieces. Inside :func:`interruptible` it calls the
    given function, elsewhere it does nothing. Its exceptions leave nothing half done: callers change their state only
    once they have a complete new one.
    """
    asked = _asked.get()
    if asked is not None:
        asked()


def apart(work: Callable[[], T]) -> T:
    """Call a function that has no pieces, such as a compiler, and return its result.

    Inside :func:`interruptible` it runs in a thread of its own: what interrupts the caller ends the waiting for it, not
    the work. Its exceptions are raised here.
    """
    if _asked.get() is None:
        return work()
    future: Future[T] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:
            future.set_exception(error)

    thread = threading.Thread(target=run)
    thread.start()
    while thread.is_alive():
        thread.join(PATIENCE)
        check()
    return future.result()


@contextlib.contextmanager
def interruptible(asked: Callable[[], None] | None) -> Iterator[None]:
    """Context manager: within it, in this thread, :func:`check` calls `asked`; None for nothing."""
    token = _asked.set(asked)
    try:
        yield
    finally:
        _asked.reset(token)
