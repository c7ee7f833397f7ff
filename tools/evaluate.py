#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run methods over folders of pictures, and compare the results.

Measures of each saved SVG: MSE, PSNR, SSIM in resvg's picture, MSE in our own, the difference of the two, size,
seconds, cleanness of layers, and, if the true SVG is beside the picture, whole shapes and colours (livecl/quality).
Written to the output folder: results.csv, results.json, sheets/*.png (worst first; things-*.png show matched shapes),
runs/ (all SVGs). With the same output folder, it continues where it stopped; a run is repeated if picture, options or
program have changed.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from evaluation.methods import METHODS, VTRACER, Method, parse_method
from evaluation.runs import AUTO, SHAPES, THINGS, Row, Run, execute_all, picture_name, plan, source_digest
from evaluation.sheets import write_sheets
from evaluation.tables import format_summary, write_results

import livecl
from livecl.image.source import SUFFIXES
from livecl.quality import DISTURBANCES

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130

EPILOG = f"""\
methods: {", ".join(METHODS)}, and those defined by --method:
  --method few:iterations=50                      the default method with 50 iterations a stage
  --method s8:preset=paper,segments=8,xing_weight=1
  --method all-at-once:stages=one
  --method coarse:preset=vtracer,filter_speckle=16

exit codes: 0 done, 1 some runs failed (they are listed), 2 bad arguments, 130 interrupted.
Seconds are only comparable between runs with the same --processes on an otherwise idle machine.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    parser = build_parser()
    arguments = parser.parse_args(argv)
    try:
        pictures = find_pictures(arguments.pictures)
        methods = chosen_methods(arguments.methods, arguments.method)
        if arguments.disturb:
            methods += [method.under(kind) for method in methods for kind in DISTURBANCES]
        check_packages(methods)
        planned = plan(
            pictures,
            methods,
            arguments.paths,
            seed=arguments.seed,
            device=arguments.device,
            output=arguments.output,
        )
        arguments.output.mkdir(parents=True, exist_ok=True)
    except (ValueError, OSError) as error:
        print(f"evaluate: error: {error}", file=sys.stderr)
        return BAD_INPUT
    try:
        rows, failures = work(planned, arguments.processes)
        report(arguments.output, rows, failures, {picture_name(picture): picture for picture in pictures})
    except KeyboardInterrupt:
        print("evaluate: interrupted; finished runs are kept, start again to go on", file=sys.stderr)
        return INTERRUPTED
    return FAILED if failures else 0


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("pictures", nargs="+", type=Path, metavar="FOLDER_OR_FILE", help="pictures, or folders of them")
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="DIR", help="folder to write to")
    parser.add_argument(
        "--paths",
        type=path_counts,
        default=(8, 16, 32, 64),
        metavar="N,N,...",
        help='numbers of paths; "things" and "shapes": as many as the true SVG\'s; "auto": as the method chooses',
    )
    parser.add_argument("--methods", default="", metavar="NAME,NAME,...", help="methods by name (live,diffvg)")
    parser.add_argument(
        "--method", action="append", default=[], metavar="NAME:KEY=VALUE,...", help="a further method, see below"
    )
    parser.add_argument("--separate", action="store_true", help=argparse.SUPPRESS)  # always so now
    parser.add_argument("--disturb", action="store_true", help="each method on JPEGs and on noisy pictures, too")
    parser.add_argument("--processes", type=positive, default=os.cpu_count() or 1, metavar="N", help="runs at a time")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of all runs (0)")
    parser.add_argument("--device", metavar="D", help="OpenCL device: index or part of its name")
    return parser


def path_counts(text: str) -> tuple[int | str, ...]:
    """Parse numbers of paths, as "8,16,32,auto": ascending numbers, followed by words."""
    parts = dict.fromkeys(text.split(","))
    words = [part for part in parts if part in (AUTO, THINGS, SHAPES)]
    return (*sorted({positive(part) for part in parts if part not in words}), *words)


def positive(text: str) -> int:
    """Return a whole number of at least 1."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"got {text}, wanted a whole number of at least 1")
    return number


def find_pictures(given: Sequence[Path]) -> list[Path]:
    """Return the picture files; ValueError if there are none, or two with the same folder's and file's name."""
    found: list[Path] = []
    for path in given:
        if path.is_dir():
            inside = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES)
            if not inside:
                raise ValueError(f"{path}: no pictures in this folder")
            found.extend(inside)
        elif path.is_file():
            found.append(path)
        else:
            raise ValueError(f"{path}: there is no such file or folder")
    names: dict[str, Path] = {}
    for picture in found:
        other = names.setdefault(picture_name(picture), picture)
        if other.resolve() != picture.resolve():
            raise ValueError(f"{picture} and {other} have the same name; evaluate them into two output folders")
    return list(names.values())


def chosen_methods(names: str, definitions: Sequence[str]) -> list[Method]:
    """Return the methods named and defined (default: live and diffvg); ValueError for unknown ones."""
    defined = [parse_method(text) for text in definitions]
    known = {**METHODS, **{method.name: method for method in defined}}
    wanted = [name for name in names.split(",") if name] or ([] if defined else ["live", "diffvg"])
    if unknown := [name for name in wanted if name not in known]:
        raise ValueError(f"no method {', '.join(unknown)}; there are {', '.join(known)}, and --method defines others")
    return [known[name] for name in dict.fromkeys([*wanted, *(method.name for method in defined)])]


def check_packages(methods: Sequence[Method]) -> None:
    """Raise ValueError if an optional package that is needed is not installed."""
    needed = {"resvg_py": "test"}
    if any(method.preset == VTRACER for method in methods):
        needed["vtracer"] = "vtracer"
    for package, extra in needed.items():
        if importlib.util.find_spec(package) is None:
            raise ValueError(f"{package} is not installed: pip install 'livecl[{extra}]'")


def work(planned: Sequence[Run], processes: int) -> tuple[list[Row], list[str]]:
    """Execute the missing runs; return the rows in the order of the plan, and a line for each failure."""
    rows_of: dict[Path, list[Row]] = {}
    failures: list[str] = []
    missing, keys = [], []
    for run in planned:
        try:
            kept, key = run.kept_rows(), run.key()
        except OSError as error:
            failures.append(f"{run.title}: {error}")
            continue
        if kept is not None:
            rows_of[run.folder] = kept
        else:
            missing.append(run)
            keys.append(key)
    say(f"{len(rows_of)} runs are done already, {len(missing)} to do")
    start = time.perf_counter()
    for number, (run, outcome) in enumerate(execute_all(missing, keys, processes), start=1):
        if isinstance(outcome, BaseException):
            line = f"{run.title}: {type(outcome).__name__}: {outcome}"
            failures.append(line)
        else:
            rows_of[run.folder] = outcome
            last = outcome[-1]
            line = f"{run.title}: {last['paths']} paths, MSE {last['mse']:.2e}, {last['seconds']:.1f} s"
        say(f"[{number}/{len(missing)}, {time.perf_counter() - start:.0f} s] {line}")
    return [row for run in planned for row in rows_of.get(run.folder, [])], failures


def report(output: Path, rows: Sequence[Row], failures: Sequence[str], pictures: dict[str, Path]) -> None:
    """Write tables, plot and contact sheets; print the summary and the failures."""
    facts = {
        "version": livecl.__version__,
        "source": source_digest(),
        "command": sys.argv,
        "failures": list(failures),
    }
    summary = write_results(output, rows, facts)
    if rows:
        write_sheets(output, rows, pictures)
        print(format_summary(summary))
    for line in failures:
        print(f"failed: {line}")


def say(line: str) -> None:
    """Print a line about the progress."""
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
