# SPDX-License-Identifier: Apache-2.0
"""Search in a separate process, limited in memory and time, which is restarted when a case crashes it.

The current case is in a file, so that it is known after a crash.
"""

from __future__ import annotations

import collections
import faulthandler
import importlib
import multiprocessing
import os
import pickle
import resource
import tempfile
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from fuzzing.kind import Kind
from fuzzing.search import MAX_CHARACTERS, Finding, Search

#: Counts of the cases that went well, and the findings by their places.
Outcome = tuple[collections.Counter[str], dict[str, Finding]]
#: A worker hangs in native code if it finishes no case in this multiple, of wall time, of a case's limit on processor
#: time: machines may be busy.
PATIENCE = 12


def kind_of(module: str) -> Kind:
    """Return the kind that a module defines."""
    kind: Kind = importlib.import_module(module).KIND
    return kind


def hunt(module: str, seed: int, cases: int) -> Outcome:
    """Search among cases of a kind. Counts of a lost worker are lost."""
    counts: collections.Counter[str] = collections.Counter()
    found: dict[str, Finding] = {}
    tried, turn = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        while tried < cases:
            # Further workers have seeds that no one is likely to give.
            own_seed = seed + turn * 1_000_003
            outcome, crash, done = _watched(module, own_seed, cases - tried, Path(folder))
            if outcome is not None:
                counts += outcome[0]
                return counts, {**found, **outcome[1]}
            kept = Path(folder) / "found"
            found |= pickle.loads(kept.read_bytes()) if kept.exists() else {}
            found.setdefault(crash, Finding(crash, pickle.loads((Path(folder) / "case").read_bytes())))
            kept.unlink(missing_ok=True)
            tried, turn = tried + done, turn + 1
    return counts, found


def _watched(module: str, seed: int, cases: int, folder: Path) -> tuple[Outcome | None, str, int]:
    """Run a worker; return its outcome, or how it was lost, and after how many cases."""
    spawn = multiprocessing.get_context("spawn")
    number, (mine, theirs) = spawn.Value("q", 0, lock=False), spawn.Pipe(duplex=False)
    process = spawn.Process(target=_work, args=(module, seed, cases, folder, number, theirs), daemon=True)
    process.start()
    theirs.close()
    last, hangs = -1, False
    while not mine.poll(PATIENCE * kind_of(module).seconds):
        if number.value == last:
            hangs = True
            process.kill()
            break
        last = number.value
    try:
        outcome: Outcome | None = None if hangs else mine.recv()
    except EOFError:
        outcome = None
    process.join()
    reason = "hangs in native code" if hangs else f"worker ended with code {process.exitcode}"
    lines = (folder / "crash").read_text(encoding="utf-8").splitlines()
    trace = [line.strip() for line in lines if line.lstrip().startswith("File")][:1]
    return outcome, f"{reason}; {' '.join(trace)}"[:MAX_CHARACTERS], max(number.value, 1)


def _work(module: str, seed: int, cases: int, folder: Path, number: Any, pipe: Connection) -> None:
    """Search, and send the outcome."""
    with (folder / "crash").open("w", encoding="utf-8") as crash:
        faulthandler.enable(crash)
        devnull = os.open(os.devnull, os.O_WRONLY)
        os.dup2(devnull, 2)  # codecs in C print there
        kind = kind_of(module)
        limit_memory(kind.megabytes)

        def note(case: Any) -> None:
            (folder / "case").write_bytes(pickle.dumps(case))
            number.value += 1

        def keep() -> None:
            (folder / "found").write_bytes(pickle.dumps(search.found))

        search = Search(kind, note, keep)
        search.run(seed=seed, most=cases)
        pipe.send((search.counts, search.found))


def limit_memory(megabytes: int) -> None:
    """Limit the process's address space to this much more than it has."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
    most = pages * resource.getpagesize() + megabytes * 1_000_000
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))
