# SPDX-License-Identifier: Apache-2.0
"""What a kind of input is to the fuzzer: cases made of random numbers, and what must hold of each."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable
from typing import Any


@dataclasses.dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of input.

    Parameters
    ----------
    make : callable
        Makes a case from a source of random numbers, and from nothing else, so that the numbers of seed and case are
        enough to make it again.
    check : callable
        Gives a case to livecl and returns what became of it in a word, such as "read" or "refused"; raises whatever it
        likes where something is wrong.
    dump : callable
        Returns the bytes that a case is saved as, for people.
    suffix : str
        Of the saved file's name.
    seconds : float
        Most processor time that a case may take.
    megabytes : int
        Most address space that a worker may take beyond what it has at its start.
    """

    make: Callable[[random.Random], Any]
    check: Callable[[Any], str]
    dump: Callable[[Any], bytes]
    suffix: str
    seconds: float = 10.0
    megabytes: int = 2000


def source(module: str, seed: int, number: int) -> random.Random:
    """Return what the case of a kind's module is made from: text as a seed gives the same numbers on any machine."""
    return random.Random(f"{module} {seed} {number}")


def one_line(error: Exception) -> None:
    """Raise AssertionError unless an error's message is a line for people."""
    message = str(error)
    assert message.strip(), f"{type(error).__name__} without a message"
    assert message.isprintable(), f"message of unprintable characters: {message!r:.300}"
    assert len(message) < 400, f"message of {len(message)} characters: {message!r:.300}"
