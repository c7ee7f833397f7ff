# SPDX-License-Identifier: Apache-2.0
"""Search for failing cases with Hypothesis, which shrinks each.

Shrinking means fewer and simpler choices: fewer changes of a picture file, but not a smaller file.
"""

from __future__ import annotations

import collections
import dataclasses
import signal
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, Verbosity, given, settings
from hypothesis import seed as seeded
from hypothesis import strategies as st
from hypothesis.errors import Flaky

from fuzzing.kind import Kind

#: Length of a finding's text.
MAX_CHARACTERS = 300
#: Difference of the seeds of consecutive searches.
FURTHER = 15_485_863


@dataclasses.dataclass(frozen=True)
class Finding:
    """The smallest case that fails at a place; `always` is False if it did not fail again."""

    what: str
    case: Any
    always: bool = True


class TooLongError(Exception):
    """A case took too much processor time."""


class _Stopped(BaseException):
    """Raised within a case that takes too long. Not an `Exception`, so that no reader takes it for damage."""


class Search:
    """Searches for failing cases.

    Parameters
    ----------
    kind : Kind
        Cases, and the check of each.
    before : callable
        Called with each case before it is checked.
    after : callable
        Called when a case fails at a new place.

    Attributes
    ----------
    counts : Counter
        Outcomes of the cases without failure.
    found : dict of Finding
        The smallest failing case by place.
    """

    def __init__(
        self, kind: Kind, before: Callable[[Any], None] = lambda case: None, after: Callable[[], None] = lambda: None
    ) -> None:
        self.counts: collections.Counter[str] = collections.Counter()
        self.found: dict[str, Finding] = {}
        self._kind, self._before, self._after = kind, before, after

    def run(self, *, seed: int, most: int) -> None:
        """Try cases, `most` besides those that are tried to make one smaller; the same seed gives the same ones.

        Hypothesis looks no further than some seconds after the first finding: then other cases are tried, as many,
        until there is nothing new among them.
        """
        for cases, number in ((self._kind.cases, most - most // 2), (self._kind.others, most // 2)):
            turn = 0
            while number and self._search(cases, seed + turn * FURTHER, number):
                turn += 1

    def _search(self, cases: st.SearchStrategy[Any], seed: int, most: int) -> bool:
        """Try cases, and return whether one fails at a new place."""
        known = set(self.found)

        @seeded(seed)
        @settings(
            max_examples=most,
            database=None,  # earlier findings are reproduced by their seed
            deadline=None,
            phases=(Phase.generate, Phase.shrink),
            suppress_health_check=list(HealthCheck),
            verbosity=Verbosity.quiet,
        )
        @given(cases)
        def holds(case: Any) -> None:
            self._before(case)
            try:
                self.counts[checked(self._kind, case)] += 1
            except Exception as error:
                where, what = described(error)
                if where in known:
                    return
                is_new = where not in self.found
                self.found[where] = Finding(what, case)
                if is_new:
                    self._after()
                raise

        try:
            holds()  # Hypothesis tries the smallest case of each place last
        except Flaky:
            self.found |= {
                where: dataclasses.replace(one, always=False) for where, one in self.found.items() if where not in known
            }
        except Exception:
            if len(self.found) == len(known):  # no case's error
                raise
        return len(self.found) > len(known)


def checked(kind: Kind, case: Any) -> str:
    """Check a case within its time; a numeric warning within livecl is an error, others are not shown."""
    usual = signal.signal(signal.SIGPROF, _stop)
    signal.setitimer(signal.ITIMER_PROF, kind.seconds)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.filterwarnings("error", category=RuntimeWarning, module="livecl")
            return kind.check(case)
    except _Stopped:
        raise TooLongError("took too much processor time") from None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, usual)


def described(error: BaseException) -> tuple[str, str]:
    """Return the origin of an error, in livecl's files if possible, and its message."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "livecl" in Path(frame.filename).parts] or frames
    place = f"{Path(own[-1].filename).name}:{own[-1].lineno}"
    return f"{type(error).__name__} at {place}", " ".join(f"{type(error).__name__}: {error}".split())[:MAX_CHARACTERS]


def _stop(*_: Any) -> None:
    raise _Stopped
