#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fuzzing: random input to livecl's readers and options, which must be read right or refused in one line.

Hypothesis chooses the cases and shrinks those that fail, in a separate process, limited in memory and time, which is
restarted when it crashes. docs/reliability.md has the requirements of each kind.
"""

from __future__ import annotations

import argparse
import pickle
import sys
import time
from pathlib import Path

import with_tests  # noqa: F401  # the reference renderer, and makers of picture files

try:
    from fuzzing.worker import hunt, kind_of
except ModuleNotFoundError as error:
    sys.exit(f"fuzz: error: {error}; install the extra test: pip install -e '.[test]'")

ROOT = Path(__file__).resolve().parent.parent
#: Kinds, and the share of the cases that a run of all gives to each: some take longer.
KINDS = {"pictures": 1.0, "svgs": 1.0, "options": 0.5, "drawings": 0.1, "runs": 0.01}
EPILOG = """\
examples:
  tools/fuzz.py --cases 20000 --seed 1
  tools/fuzz.py --kind svgs --cases 100000
  tools/fuzz.py --kind svgs --case out/fuzz/svgs-1-0.svg     one case again, with its traceback

exit codes: 0 nothing found, 1 something found, 2 bad arguments
"""


def module_of(name: str) -> str:
    """Return the name of the module that defines a kind."""
    return f"fuzzing.{name}"


def report(name: str, seed: int, cases: int, folder: Path) -> int:
    """Search; print and save the smallest case of each place with findings; return the number of places."""
    start = time.perf_counter()
    counts, found = hunt(module_of(name), seed, cases)
    suffix = kind_of(module_of(name)).suffix
    for i, one in enumerate(found.values()):
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / f"{name}-{seed}-{i}{suffix}"
        file.write_bytes(pickle.dumps(one.case) if suffix == ".pickle" else one.case)
        sometimes = "" if one.always else "not each time: "
        print(f"{name}: {sometimes}{one.what} [{file}]\n{name}: case: {one.case!r:.2000}", flush=True)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    print(
        f"{name}: {cases} cases, seed {seed}, {time.perf_counter() - start:.0f} s: {outcomes or 'no outcome'}; "
        f"findings at {len(found)} places",
        flush=True,
    )
    return len(found)


def again(name: str, file: Path) -> int:
    """Try one case in this process, an error with its traceback."""
    kind, data = kind_of(module_of(name)), file.read_bytes()
    case = pickle.loads(data) if kind.suffix == ".pickle" else data
    print(f"case: {case!r:.2000}")
    print(kind.check(case))
    return 0


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kind", choices=(*KINDS, "all"), default="all", help="kind of input (default: all)")
    parser.add_argument(
        "--cases", type=int, default=1000, metavar="N", help="number of cases of each kind (default: 1000)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the cases (default: 0)")
    parser.add_argument("--case", type=Path, metavar="FILE", help="try a saved case, in this process")
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "fuzz", metavar="DIR", help="folder for failing cases"
    )
    arguments = parser.parse_args()
    if arguments.case is not None:
        if arguments.kind == "all" or not arguments.case.is_file():
            parser.error("--case: wanted a file, and its --kind")
        return again(arguments.kind, arguments.case)
    kinds = KINDS if arguments.kind == "all" else {arguments.kind: 1.0}
    counts = {name: max(1, round(part * arguments.cases)) for name, part in kinds.items()}
    return 1 if sum(report(name, arguments.seed, cases, arguments.out) for name, cases in counts.items()) else 0


if __name__ == "__main__":
    sys.exit(main())
