#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Benchmark: time, memory and floor of named cases, each checked before it is timed.

The machine is calibrated first and during the measurements, and times are stated for a machine whose reference rate is
60 GFLOP/s as well. docs/performance.md tells what is measured and how to read it.
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
from benchmark.cases import CASES, CORES_CASE, CURVES, EXTREME, Case, chosen_cases
from benchmark.request import Request
from benchmark.results import FORMAT, failures, load, put_limits, save

ROOT = Path(__file__).resolve().parent.parent
EPILOG = f"""\
cases: {", ".join(CASES)}
Without --cases, all but {", ".join(EXTREME)}. A number is that of the paths, after @ stands the canvas's side.

examples:
  tools/bench.py --cases 5,emoji
  tools/bench.py --save before; tools/bench.py --compare before
  tools/bench.py --cases 32,256 --compare-checkout ../other
  tools/bench.py --curves --markdown

exit codes: 0 done, 1 a check failed or a case could not be measured, 2 bad arguments
"""


class Bench:
    """Sends requests to subprocesses and collects the answers.

    Parameters
    ----------
    folder : path
        Where scenes are kept; those that are there already are used again.
    device, photo, repeats
        As in `Request`.
    """

    def __init__(self, folder: Path, device: str | None, photo: str | None, repeats: int | None) -> None:
        self.folder = folder
        self.device = device
        self.photo = photo
        self.repeats = repeats

    def ask(self, verb: str, case: str = "", root: Path = ROOT, **environment: str) -> dict[str, Any]:
        """Return the answer of a process of its own; where it has none, what it failed with."""
        request = Request(
            verb=verb,
            root=str(root),
            folder=str(self.folder),
            device=self.device,
            case=case,
            photo=self.photo,
            repeats=self.repeats,
        )
        request.answer_file.unlink(missing_ok=True)
        command = [sys.executable, str(ROOT / "tools" / "bench.py"), "--worker", request.to_json()]
        ended = subprocess.run(
            command, env={**os.environ, **environment}, stderr=subprocess.PIPE, text=True, check=False
        )
        if ended.returncode or not request.answer_file.is_file():
            lines = ended.stderr.strip().splitlines() or [f"ended with {ended.returncode}"]
            print(ended.stderr, end="", file=sys.stderr)
            return {"failed": lines[-1]}
        answer: dict[str, Any] = json.loads(request.answer_file.read_text(encoding="utf-8"))
        return answer

    def prepared(self, case: Case) -> dict[str, Any]:
        """Make a case's scene, unless it is there, and return what is in it."""
        kept = self.folder / f"{case.name}.json"
        if kept.is_file():
            found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
            return found
        answer = self.ask("prepare", case.name)
        if "failed" not in answer:
            kept.write_text(json.dumps(answer), encoding="utf-8")
        return answer

    def measured(self, case: Case, roots: list[Path], rounds: int) -> list[dict[str, Any]]:
        """Return the results of a case for each checkout: checked, then timed in turns.

        All start from the same scene, which this checkout makes.
        """
        scene = self.prepared(case)
        if "failed" in scene:
            return [scene for _ in roots]
        results = [{**scene, **self.ask("check", case.name, root)} for root in roots]
        times: list[list[dict[str, Any]]] = [[] for _ in roots]
        for turn in range(rounds):
            for index in range(len(roots)) if turn % 2 == 0 else reversed(range(len(roots))):
                if "failed" not in results[index]:
                    results[index] |= (answer := self.ask("time", case.name, roots[index]))
                    times[index] += [answer["time"]] if "time" in answer else []
        for result, rows in zip(results, times, strict=True):
            if len(rows) > 1:
                result["time"] = merged(rows)
        return results


def merged(times: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the times of several processes as one: medians of the medians, the smallest minimum."""
    median = {key: statistics.median(time[key] for time in times) for key in times[0]}
    return {
        **median,
        "repeats": sum(time["repeats"] for time in times),
        "minimum_ms": min(time["minimum_ms"] for time in times),
    }


def core_counts() -> list[int]:
    """Return 1, 2, 4, ... and the number of this machine's cores."""
    cores = os.cpu_count() or 1
    return sorted({*(2**k for k in range(cores.bit_length()) if 2**k <= cores), cores})


def run(arguments: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Measure what is asked for and return the results."""
    bench = Bench(folder, arguments.device, arguments.photo, arguments.repeats)
    cases = chosen_cases(arguments.cases)
    if arguments.curves:
        more = [CASES[name] for curve in CURVES.values() for name in curve]
        cases += [case for case in dict.fromkeys(more) if case not in cases]
    machine = bench.ask("machine")
    if "failed" in machine:
        raise SystemExit(f"bench.py: {machine['failed']}")
    results: dict[str, Any] = {
        "format": FORMAT,
        "when": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "arguments": sys.argv[1:],
        "machine": machine,
        "cases": {},
        "curves": arguments.curves,
    }
    roots = [ROOT]
    if arguments.compare_checkout is not None:
        roots.append(arguments.compare_checkout.resolve())
        there = bench.ask("machine", root=roots[1])
        results["other"] = {"commit": there.get("commit"), "cases": {}}
    for case in cases:
        print(f"bench.py: {report.title(case)} ...", file=sys.stderr, flush=True)
        found = bench.measured(case, roots, arguments.rounds if len(roots) > 1 else 1)
        results["cases"][case.name] = found[0]
        if len(roots) > 1:
            results["other"]["cases"][case.name] = found[1]
    if arguments.curves and "failed" not in bench.prepared(CASES[CORES_CASE]):
        results["cores"] = {}
        for count in core_counts():
            answer = bench.ask("time", CORES_CASE, POCL_MAX_PTHREAD_COUNT=str(count))
            if "time" in answer:
                results["cores"][str(count)] = answer["time"]
    put_limits(results)
    return results


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", metavar="LIST", help="cases to measure, such as 5,256,emoji")
    parser.add_argument("--curves", action="store_true", help="also time against paths, pixels and cores")
    parser.add_argument("--device", metavar="DEVICE", help="OpenCL device, by index or part of its name")
    parser.add_argument("--photo", metavar="FILE", help="picture to take for the photograph")
    parser.add_argument(
        "--repeats", type=_positive, metavar="N", help="repeats of each case; else what fits two seconds"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all results as JSON")
    parser.add_argument("--markdown", action="store_true", help="print the report as Markdown")
    parser.add_argument("--save", metavar="NAME", help="keep the results under a name")
    parser.add_argument("--compare", metavar="NAME", help="put the results kept under a name beside these")
    parser.add_argument(
        "--compare-checkout",
        type=Path,
        metavar="PATH",
        help="measure the package of another checkout in turns with this one",
    )
    parser.add_argument("--rounds", type=_positive, default=3, metavar="N", help="turns of each checkout (3)")
    parser.add_argument(
        "--folder",
        type=Path,
        default=Path("out/benchmarks"),
        metavar="DIR",
        help="where --save keeps results (%(default)s)",
    )
    parser.add_argument(
        "--scenes",
        type=Path,
        metavar="DIR",
        help="keep scenes there, or use those that are there; else they are made anew",
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
        compared = None if arguments.compare is None else load(arguments.folder / f"{arguments.compare}.json")
    except ValueError as error:
        parser.error(str(error))
    if arguments.compare_checkout is not None and not (arguments.compare_checkout / "livecl").is_dir():
        parser.error(f"--compare-checkout: no checkout of livecl in {arguments.compare_checkout}")
    if arguments.scenes is not None:
        arguments.scenes.mkdir(parents=True, exist_ok=True)
        results = run(arguments, arguments.scenes)
    else:
        with tempfile.TemporaryDirectory() as folder:
            results = run(arguments, Path(folder))
    for path in (arguments.json, arguments.save and arguments.folder / f"{arguments.save}.json"):
        if path:
            save(results, path)
    if compared is not None:
        results["compared"] = {"name": arguments.compare, "cases": compared["cases"]}
    print(report.text(results, markdown=arguments.markdown), end="")
    return 1 if failures(results) else 0


if __name__ == "__main__":
    sys.exit(main())
