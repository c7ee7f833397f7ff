# SPDX-License-Identifier: Apache-2.0
"""Interruption of long computations: `check()`, called several times a second, raises to stop the work."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar

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


@contextlib.contextmanager
def interruptible(asked: Callable[[], None] | None) -> Iterator[None]:
    """Context manager: within it, in this thread, :func:`check` calls `asked`; None for nothing."""
    token = _asked.set(asked)
    try:
        yield
    finally:
        _asked.reset(token)
