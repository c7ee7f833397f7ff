# SPDX-License-Identifier: Apache-2.0
"""Report the results of a run of the benchmark: facts and Markdown tables."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from benchmark.calibration import REFERENCE_GFLOPS
from benchmark.cases import CASES

Results = dict[str, Any]


def text(results: Results) -> str:
    """Return the whole report."""
    machine = results["machine"]
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    facts = (
        f"commit {machine['commit']}; {results['when']}",
        f"device: {machine['device']}; driver {machine['driver']}",
        f"{machine['cores']} cores, load before the run {machine['load']:.2f}, {machine['gflops']:.0f} GFLOP/s",
        f"{machine['system']}; {packages}",
    )
    parts = ["\n".join(f"- {line}" for line in facts), times(results)]
    if "other" in results:
        parts.append(ratios(results))
    parts += filter(None, (by_case(results, *about) for about in BREAKDOWNS))
    if failed := failures(results):
        parts.append("\n".join(["Failed, and not timed:", "", *(f"- {line}" for line in failed)]))
    return "\n\n".join(parts) + "\n"


def times(results: Results) -> str:
    """Return the table of times and memory."""
    head = ("case", "median ms", "min ms", f"ms at {REFERENCE_GFLOPS:.0f} GFLOP/s", "wanted", "MB", "MB wanted")
    rows = []
    for name, found in results["cases"].items():
        case, time = CASES[name], found.get("time", {})
        measured = (time.get("median_ms"), time.get("minimum_ms"), time.get("scaled_ms"), case.goal_ms)
        rows.append([case.title, *map(number, (*measured, found.get("memory_mb"), case.goal_mb))])
    return table("Times", head, rows)


def ratios(results: Results) -> str:
    """Return the times of this and another checkout, measured in turns, side by side.

    The spread is that of the ratios of neighbouring turns: ratios nearer to 1 than it are not significant.
    """
    rows = []
    for name, there in results["other"]["cases"].items():
        here, row = results["cases"][name], [CASES[name].title]
        for turns in ("turns_processor_ms", "turns_ms"):
            found = sorted(a / b for a, b in zip(here.get(turns, []), there.get(turns, []), strict=False))
            row += map(number, [statistics.median(found), found[0], found[-1]] if found else [None] * 3)
        errors = (found.get("checked", {}).get("mse") for found in (here, there))
        rows.append([*row, number(CASES[name].goal_ratio), *("-" if e is None else f"{e:.1e}" for e in errors)])
    spread = ("lowest turn", "highest turn")
    head = ("case", "processor time, here / there", *spread, "time", *spread, "wanted", "MSE here", "there")
    title = f"This checkout ({results['machine']['commit']}) against another ({results['other']['commit']})"
    return table(title, head, rows)


def by_case(results: Results, title: str, rows_of: Callable[[Results], dict[str, float]]) -> str:
    """Return a table with a column for each case that has this part, and the union of their rows."""
    columns = {
        name: {**rows, "(all)": sum(rows.values())}
        for name, found in results["cases"].items()
        if (rows := rows_of(found))
    }
    labels = dict.fromkeys(label for rows in columns.values() for label in rows if label != "(all)")
    rows = [[label, *(number(rows.get(label)) for rows in columns.values())] for label in (*labels, "(all)")]
    return table(title, ["ms", *columns], rows) if columns else ""


BREAKDOWNS: tuple[tuple[str, Callable[[Results], dict[str, float]]], ...] = (
    ("Parts of a whole run", lambda found: found.get("parts", {})),
    ("Host steps of an iteration", lambda found: found.get("host", {}).get("ms", {})),
    ("Kernels of an iteration, by the device's clock", lambda found: found.get("kernels", {}).get("ms", {})),
)


def failures(results: Results) -> list[str]:
    """Return the failures, one line each: checks, and cases that could not be measured."""
    there = results.get("other", {}).get("cases", {})
    named = [*results["cases"].items(), *((f"{name}, other checkout", found) for name, found in there.items())]
    return [f"{name}: {found['failed']}" for name, found in named if "failed" in found]


def table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table with a title; the first column is text, the others are numbers."""
    rule = ["---", *["--:"] * (len(head) - 1)]
    return "\n".join([f"**{title}**", "", *("| " + " | ".join(row) + " |" for row in (head, rule, *rows))])


def number(value: float | None, digits: int = 3) -> str:
    """Format a number to significant digits, without an exponent; a dash for None."""
    if value is None:
        return "-"
    places = 0 if value == 0 else digits - 1 - math.floor(math.log10(abs(value)))
    return f"{round(value, places):.{max(places, 0)}f}"
