# SPDX-License-Identifier: Apache-2.0
"""Messages of the command line on standard error: errors, warnings, the log, the summary."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from typing import Any

from livecl.errors import readable


def say(message: str) -> None:
    """Write a line to standard error, above the progress bar if there is one."""
    from tqdm import tqdm

    tqdm.write(message, file=sys.stderr)


def complain(message: str, command: str = "livecl") -> None:
    """Write the error that ended the work, as one line."""
    say(f"{command}: error: {readable(message)}")


def write_standard(data: bytes) -> None:
    """Write to standard output.

    Raises OSError if it fails; the rest is then discarded, so that Python does not retry at exit.
    """
    try:
        sys.stdout.flush()
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
    except OSError:
        with contextlib.suppress(OSError):  # where standard output is not the process's own
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise


class _Handler(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        level = "" if record.levelno < logging.WARNING else f"{record.levelname.lower()}: "
        say(f"livecl: {level}{record.getMessage()}")


@contextlib.contextmanager
def messages(*, quiet: bool, verbose: bool) -> Iterator[None]:
    """Context manager: show the library's log and warnings on standard error, one line each.

    If `quiet`, neither; if `verbose`, also the progress of the work.
    """
    log, handler = logging.getLogger("livecl"), _Handler()
    level = log.level

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        if not quiet:
            say(f"livecl: warning: {message}")

    with warnings.catch_warnings():
        warnings.showwarning = show
        log.addHandler(handler)
        log.setLevel(logging.CRITICAL if quiet else logging.INFO if verbose else logging.WARNING)
        try:
            yield
        finally:
            log.removeHandler(handler)
            log.setLevel(level)
