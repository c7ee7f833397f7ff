#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fuzzing: random input to what livecl takes from outside, to find what is neither read well nor refused in a line.

A case is made of its kind, the seed and its number, and of nothing else. Cases run in a process of their own, limited
in memory and time, which is started again where it crashes. With --search, Hypothesis chooses the cases and makes those
that go wrong as small as it can, in this process. docs/reliability.md tells what has to hold of each kind.
"""

from __future__ import annotations

import argparse
import collections
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(1, str(ROOT / "tests"))  # the reference renderer, and makers of picture files

try:
    from fuzzing.kind import source
    from fuzzing.worker import Finding, kind_of, watched
except ModuleNotFoundError as error:
    sys.exit(f"fuzz: error: {error}; install the extra dev: pip install -e '.[dev]'")

#: Kinds, and the share of the cases that a run of all gives to each: some take longer.
KINDS = {"pictures": 1.0, "svgs": 1.0, "options": 0.5, "drawings": 0.1, "runs": 0.002}
EPILOG = """\
examples:
  tools/fuzz.py --cases 20000 --seed 1
  tools/fuzz.py --kind svgs --cases 100000
  tools/fuzz.py --kind svgs --seed 1 --case 4711     one case again, with its traceback
  tools/fuzz.py --search --kind svgs --cases 2000    the smallest case that goes wrong

exit codes: 0 nothing found, 1 something found, 2 bad arguments
"""


def module_of(name: str) -> str:
    """Return the name of the module that defines a kind."""
    return f"fuzzing.{name}"


def hunt(name: str, seed: int, numbers: range, folder: Path) -> int:
    """Try cases of a kind; print a line for each place with findings, and the counts; return the number of places."""
    start = time.perf_counter()
    counts: collections.Counter[str] = collections.Counter()
    places: collections.Counter[str] = collections.Counter()
    module = module_of(name)
    for report in watched(module, seed, numbers):
        if not isinstance(report, Finding):
            counts += report
            continue
        places[report.where] += 1
        if places[report.where] > 1:
            continue
        kind = kind_of(module)
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / f"{name}-{seed}-{report.number}{kind.suffix}"
        file.write_bytes(kind.dump(kind.make(source(module, seed, report.number))))
        print(f"{name}: {report.what} [--kind {name} --seed {seed} --case {report.number}; {file}]", flush=True)
    for where, count in places.items():
        if count > 1:
            print(f"{name}: {count} times: {where}")
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    print(
        f"{name}: {len(numbers)} cases, seed {seed}, {time.perf_counter() - start:.0f} s: {outcomes or 'no outcome'}; "
        f"{sum(places.values())} findings at {len(places)} places",
        flush=True,
    )
    return len(places)


def hunt_smallest(name: str, seed: int, cases: int, folder: Path) -> int:
    """Have Hypothesis look for cases; print the smallest of each place with findings, and the counts; as `hunt`."""
    try:
        from fuzzing.search import cases_of, search
    except ModuleNotFoundError as error:
        sys.exit(f"fuzz: error: --search: {error}; install the extra test: pip install -e '.[test]'")
    start = time.perf_counter()
    kind = kind_of(module_of(name))
    counts, found = search(kind, cases_of(name, kind), seed=seed, most=cases)
    for i, one in enumerate(found):
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / f"{name}-{seed}-smallest-{i}{kind.suffix}"
        file.write_bytes(kind.dump(one.case))
        sometimes = "" if one.always else "not each time: "
        print(f"{name}: {sometimes}{one.what} [{file}]\n{name}: case: {one.case!r:.2000}", flush=True)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    print(
        f"{name}: search among {cases} cases, seed {seed}, {time.perf_counter() - start:.0f} s: "
        f"{outcomes or 'no outcome'}; findings at {len(found)} places",
        flush=True,
    )
    return len(found)


def again(name: str, seed: int, number: int) -> int:
    """Try one case in this process, an error with its traceback."""
    kind = kind_of(module_of(name))
    case = kind.make(source(module_of(name), seed, number))
    print(f"case: {case!r:.2000}")
    print(kind.check(case))
    return 0


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kind", choices=(*KINDS, "all"), default="all", help="what is tried (default: all)")
    parser.add_argument("--cases", type=int, default=1000, metavar="N", help="how many of each kind (default: 1000)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the cases (default: 0)")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first case (default: 0)")
    parser.add_argument("--case", type=int, metavar="N", help="try one case, in this process")
    parser.add_argument(
        "--search", action="store_true", help="have Hypothesis look for the smallest case that goes wrong"
    )
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "fuzz", metavar="DIR", help="where inputs with findings are kept"
    )
    arguments = parser.parse_args()
    if arguments.case is not None:
        if arguments.kind == "all" or arguments.search:
            parser.error("--case: goes with --kind, and not with --search")
        return again(arguments.kind, arguments.seed, arguments.case)
    if arguments.search and arguments.first:
        parser.error("--search: --first numbers the other way's cases")
    kinds = KINDS if arguments.kind == "all" else {arguments.kind: 1.0}
    found = 0
    for name, part in kinds.items():
        cases = max(1, round(part * arguments.cases))
        if arguments.search:
            found += hunt_smallest(name, arguments.seed, cases, arguments.out)
        else:
            found += hunt(name, arguments.seed, range(arguments.first, arguments.first + cases), arguments.out)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
