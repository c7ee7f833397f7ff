# SPDX-License-Identifier: Apache-2.0
"""Interruption: long computations ask, several times a second, whether they are to go on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar

_asked: ContextVar[Callable[[], None] | None] = ContextVar("asked", default=None)


def check() -> None:
    """Raise what ends the computation under way, if it is to end.

    Whatever may take a tenth of a second calls this between its pieces, from wherever it is: within
    :func:`interruptible` it calls what was given there, elsewhere it does nothing. What it raises leaves nothing behind
    that is half done: callers change their state when they have all of a new one.
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
