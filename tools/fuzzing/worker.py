# SPDX-License-Identifier: Apache-2.0
"""A process that tries cases one after the other, and the one that watches over it.

The number of the case being tried is in shared memory, so that it is known also when the worker has crashed.
"""

from __future__ import annotations

import collections
import dataclasses
import faulthandler
import importlib
import multiprocessing
import os
import resource
import signal
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from fuzzing.kind import Kind, source

#: Wall time without a further case after which a worker is taken to hang in native code, in units of the limit on a
#: case's processor time: a busy machine is slow too.
PATIENCE = 12
#: Outcomes after which their counts are sent: those of a worker that is lost are lost with it.
SENT_TOGETHER = 100
#: Length of a finding's text.
MOST_CHARACTERS = 300


@dataclasses.dataclass(frozen=True)
class Finding:
    """A case that went wrong: its number, and what happened; `where` is the same for what is likely the same defect."""

    number: int
    where: str
    what: str


class TooLongError(BaseException):
    """A case took too much processor time. Not an `Exception`, so that no reader takes it for damage."""


def kind_of(module: str) -> Kind:
    """Return the kind that a module defines."""
    kind: Kind = importlib.import_module(module).KIND
    return kind


def tried(kind: Kind, case: Any, number: int) -> Finding | str:
    """Check a case and return what became of it."""
    try:
        return strictly_checked(kind, case)
    except (Exception, TooLongError) as error:
        return Finding(number, *described(error))


def strictly_checked(kind: Kind, case: Any) -> str:
    """Check a case, where a numeric warning within livecl is an error; no other is shown."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.filterwarnings("error", category=RuntimeWarning, module="livecl")
        return kind.check(case)


def described(error: BaseException) -> tuple[str, str]:
    """Return the place that an error comes from, among livecl's files where there is one, and what it says."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "livecl" in Path(frame.filename).parts] or frames
    place = f"{Path(own[-1].filename).name}:{own[-1].lineno}"
    return f"{type(error).__name__} at {place}", " ".join(f"{type(error).__name__}: {error}".split())[:MOST_CHARACTERS]


def work(module: str, seed: int, numbers: range, current: Any, pipe: Connection, crash_file: str) -> None:
    """Try the cases of some numbers; send each finding, and the counts of all other outcomes."""
    with open(crash_file, "w", encoding="utf-8") as crash:  # noqa: PTH123  # faulthandler wants a file that stays open
        faulthandler.enable(crash)
        devnull = os.open(os.devnull, os.O_WRONLY)
        os.dup2(devnull, 2)  # codecs in C print there
        kind = kind_of(module)
        limit_memory(kind.megabytes)
        signal.signal(signal.SIGPROF, _stop)
        counts: collections.Counter[str] = collections.Counter()
        for number in numbers:
            current.value = number
            try:
                signal.setitimer(signal.ITIMER_PROF, kind.seconds)
                outcome = tried(kind, kind.make(source(module, seed, number)), number)
                signal.setitimer(signal.ITIMER_PROF, 0)
            except TooLongError as error:
                outcome = Finding(number, *described(error))
            if isinstance(outcome, Finding):
                pipe.send(outcome)
                continue
            counts[outcome] += 1
            if counts.total() >= SENT_TOGETHER:
                pipe.send(counts)
                counts.clear()
        pipe.send(counts)


def limit_memory(megabytes: int) -> None:
    """Allow the process so much address space beyond what it has."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
    most = pages * resource.getpagesize() + megabytes * 1_000_000
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


def watched(module: str, seed: int, numbers: range) -> Iterator[Finding | collections.Counter[str]]:
    """Have cases tried by a worker, which is started again after each crash; yield findings and counts."""
    spawn = multiprocessing.get_context("spawn")
    patience = PATIENCE * kind_of(module).seconds
    first = numbers.start
    while first < numbers.stop:
        current, (mine, theirs) = spawn.Value("q", first, lock=False), spawn.Pipe(duplex=False)
        with tempfile.NamedTemporaryFile("r", encoding="utf-8", suffix=".txt") as crash:
            process = spawn.Process(
                target=work, args=(module, seed, range(first, numbers.stop), current, theirs, crash.name), daemon=True
            )
            process.start()
            theirs.close()
            last, hangs = -1, False
            while True:
                try:
                    if mine.poll(patience):
                        yield mine.recv()
                        continue
                except EOFError:
                    break
                if current.value == last:
                    hangs = True
                    process.kill()
                    break
                last = current.value
            process.join()
            if process.exitcode == 0:
                return
            number = current.value
            reason = "hangs in native code" if hangs else f"worker ended with code {process.exitcode}"
            trace = [line.strip() for line in crash.read().splitlines() if line.lstrip().startswith("File")][:1]
            yield Finding(number, f"{reason} {' '.join(trace)}", f"{reason}; {' '.join(trace)}"[:MOST_CHARACTERS])
        first = number + 1


def _stop(*_: Any) -> None:
    raise TooLongError("took too much processor time")
