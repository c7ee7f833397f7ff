# SPDX-License-Identifier: Apache-2.0
"""Kinds of input for the fuzzer: sources of cases, and the check of each."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable
from typing import Any

from hypothesis import strategies as st

#: Random numbers that Hypothesis chooses one by one: it can make them smaller, but prefers the ends of ranges.
CHOSEN = st.randoms(use_true_random=False)
#: Evenly distributed random numbers, of which Hypothesis chooses the seed only.
EVEN = st.integers(0, 2**64).map(random.Random)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of input.

    Parameters
    ----------
    cases : SearchStrategy
        Cases that can be shrunk. They are pickled.
    others : SearchStrategy
        Cases that cannot be shrunk, but are more realistic.
    check : callable
        Passes a case to livecl and returns the outcome in a word, such as "read" or "refused"; raises any exception on
        failure.
    suffix : str
        Suffix of the saved file, if a case is the content of a file.
    seconds : float
        Limit on a case's processor time.
    megabytes : int
        Limit on a worker's address space beyond that at its start.
    """

    cases: st.SearchStrategy[Any]
    others: st.SearchStrategy[Any]
    check: Callable[[Any], str]
    suffix: str = ".pickle"
    seconds: float = 10.0
    megabytes: int = 2000


def one_line(error: Exception) -> None:
    """Raise AssertionError unless an error's message is one readable line."""
    message = str(error)
    assert message.strip(), f"{type(error).__name__} without a message"
    assert message.isprintable(), f"message of unprintable characters: {message!r:.300}"
    assert len(message) < 400, f"message of {len(message)} characters: {message!r:.300}"
