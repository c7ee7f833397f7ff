#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Benchmark: time and memory of named cases, each checked before it is timed.

The machine's rate is measured in between, and times are also stated for a machine of 60 GFLOP/s. docs/performance.md
has the method, and explains the tables.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmark import report
from benchmark.cases import CASES, EXTREME, Case, chosen_cases

ROOT = Path(__file__).resolve().parent.parent
EPILOG = f"""\
cases: {", ".join(CASES)}
Without --cases, all but {", ".join(EXTREME)}. A number is that of the paths; after @ is the canvas's side.

examples:
  tools/bench.py --cases 5,emoji
  tools/bench.py --cases 32,256 --compare-checkout ../other

exit codes: 0 done, 1 a check failed or a case could not be measured, 2 bad arguments
"""


class Bench:
    """Sends requests to subprocesses and collects the answers.

    Parameters
    ----------
    folder : path
        Folder for scenes.
    settings
        Device, photo and repeats, as for `benchmark.worker.Worker`.
    """

    def __init__(self, folder: Path, **settings: Any) -> None:
        self.folder = folder
        self.settings = settings

    def ask(self, verb: str, case: str = "", root: Path = ROOT, **more: Any) -> dict[str, Any]:
        """Return the answer of a separate process, or its error."""
        request = {"verb": verb, "root": str(root), "folder": str(self.folder), "case": case, **self.settings, **more}
        answer_file = self.folder / "answer.json"
        answer_file.unlink(missing_ok=True)
        # The checkout to measure, and this one for its references.
        paths = os.pathsep.join(map(str, (root, ROOT / "tests")))
        command = [sys.executable, str(ROOT / "tools" / "bench.py"), "--worker", json.dumps(request)]
        # Waiting threads of linear algebra would count as work; the commands use one, too.
        environment = {"OPENBLAS_NUM_THREADS": "1", **os.environ, "PYTHONPATH": paths}
        ended = subprocess.run(command, env=environment, stderr=subprocess.PIPE, text=True, check=False)
        if ended.returncode or not answer_file.is_file():
            lines = ended.stderr.strip().splitlines() or [f"ended with {ended.returncode}"]
            print(ended.stderr, end="", file=sys.stderr)
            return {"failed": lines[-1]}
        answer: dict[str, Any] = json.loads(answer_file.read_text(encoding="utf-8"))
        return answer

    def measured(self, case: Case, roots: list[Path], rounds: int) -> list[dict[str, Any]]:
        """Return the results of a case for each checkout: checked, then timed in turns.

        All start from the same scene, which this checkout makes.
        """
        scene = self.ask("prepare", case.name)
        if "failed" in scene:
            return [scene for _ in roots]
        results = [self.ask("check", case.name, root) for root in roots]
        times: list[list[dict[str, Any]]] = [[] for _ in roots]
        for turn in range(1 if len(roots) == 1 and case.kind != "run" else rounds):
            for index in range(len(roots)) if turn % 2 == 0 else reversed(range(len(roots))):
                if "failed" not in results[index]:
                    results[index] |= (answer := self.ask("time", case.name, roots[index], judged=index == 0))
                    times[index] += [answer["time"]] if "time" in answer else []
        for result, rows in zip(results, times, strict=True):
            if rows:
                result["turns_ms"] = [row["median_ms"] for row in rows]
                result["turns_processor_ms"] = [row["processor_ms"] for row in rows]
                result["time"] = merged(rows)
        if len(roots) == 1 and "failed" not in results[0]:
            results[0] |= self.ask("break_down", case.name)
        return results


def merged(times: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the times of several processes as one: medians of the medians, the smallest minimum."""
    median = {key: statistics.median(time[key] for time in times) for key in times[0]}
    return {
        **median,
        "repeats": sum(time["repeats"] for time in times),
        "minimum_ms": min(time["minimum_ms"] for time in times),
    }


def run(arguments: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Measure the requested cases and return the results."""
    bench = Bench(folder, device=arguments.device, photo=arguments.photo, repeats=arguments.repeats)
    machine = bench.ask("machine")
    if "failed" in machine:
        raise SystemExit(f"bench.py: {machine['failed']}")
    when = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    results: dict[str, Any] = {"when": when, "arguments": sys.argv[1:], "machine": machine, "cases": {}}
    roots = [ROOT]
    if arguments.compare_checkout is not None:
        roots.append(arguments.compare_checkout.resolve())
        results["other"] = {"commit": bench.ask("machine", root=roots[1]).get("commit"), "cases": {}}
    for case in chosen_cases(arguments.cases):
        print(f"bench.py: {case.title} ...", file=sys.stderr, flush=True)
        found = bench.measured(case, roots, arguments.rounds)
        results["cases"][case.name] = found[0]
        if len(roots) > 1:
            results["other"]["cases"][case.name] = found[1]
    return results


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", metavar="LIST", help="cases to measure, such as 5,256,emoji")
    parser.add_argument("--device", metavar="DEVICE", help="OpenCL device, by index or part of its name")
    parser.add_argument("--photo", metavar="FILE", help="picture for the photograph")
    parser.add_argument(
        "--repeats", type=_positive, metavar="N", help="repeats of each case; else what fits two seconds"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all results as JSON")
    parser.add_argument(
        "--compare-checkout",
        type=Path,
        metavar="PATH",
        help="measure the package of another checkout in turns with this one",
    )
    parser.add_argument(
        "--rounds", type=_positive, default=3, metavar="N", help="turns of each checkout, and whole runs (3)"
    )
    parser.add_argument("--worker", metavar="REQUEST", help=argparse.SUPPRESS)
    return parser


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}: wanted a whole number of at least 1")
    return number


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark; return its exit code."""
    parser = build_parser()
    arguments = parser.parse_args(argv)
    if arguments.worker is not None:
        from benchmark import worker

        worker.main(arguments.worker)
        return 0
    try:
        chosen_cases(arguments.cases)
    except ValueError as error:
        parser.error(str(error))
    if arguments.compare_checkout is not None and not (arguments.compare_checkout / "livecl").is_dir():
        parser.error(f"--compare-checkout: no checkout of livecl in {arguments.compare_checkout}")
    with tempfile.TemporaryDirectory() as folder:
        results = run(arguments, Path(folder))
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    print(report.text(results), end="")
    return 1 if report.failures(results) else 0


if __name__ == "__main__":
    sys.exit(main())
