# SPDX-License-Identifier: Apache-2.0
"""What is told of a run of the benchmark: facts and tables, made from its results."""

from __future__ import annotations

from collections.abc import Callable

from benchmark.cases import CASES, CURVES, Case
from benchmark.limit import REFERENCE_GFLOPS
from benchmark.results import Results, failures
from benchmark.table import Table, number

#: What times are stated for.
REFERENCE = f"{REFERENCE_GFLOPS:.0f} GFLOP/s"


def facts(results: Results) -> list[str]:
    """Return what the figures depend on, a line each."""
    machine = results["machine"]
    copies = ", ".join(
        f"{rate:.1f} GB/s for {int(size) / 2**20:g} MiB" for size, rate in machine["copy_gigabytes"].items()
    )
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    return [
        f"livecl {machine['livecl']}, commit {machine['commit'] or 'unknown'}; {results['when']}",
        f"device: {machine['device']}; driver {machine['driver']}; {machine['compute_units']} compute units",
        f"processor: {machine['processor']}, {machine['cores']} cores; load before the run {machine['load']:.2f}",
        f"{machine['system']}; Python {machine['python']}; {packages}",
        f"calibration: {machine['reference_gflops']:.0f} GFLOP/s reference, {machine['peak_gflops']:.0f} GFLOP/s peak, "
        f"copy {copies}",
    ]


def tables(results: Results) -> list[Table]:
    """Return all tables that the results give."""
    found = [_times(results)]
    makers = (_to_error, _host, _kernels, _counts, _operations, *(_curve(name) for name in CURVES), _cores)
    return found + [table for make in makers if (table := make(results)) is not None]


def _times(results: Results) -> Table:
    compared = results.get("compared")
    rows = []
    for name, found in results["cases"].items():
        case, time = CASES[name], found.get("time", {})
        row = {
            "case": title(case),
            "median ms": number(time.get("median_ms")),
            "min ms": number(time.get("minimum_ms")),
            "GFLOP/s": number(time.get("gflops")),
            f"ms at {REFERENCE}": number(time.get("scaled_ms")),
            "wanted": number(case.goal_ms),
            "limit ms": number(found.get("limit_ms")),
            "x limit": number(found.get("times_limit")),
            "MB": number(found.get("memory_mb")),
            "MB wanted": number(case.goal_mb),
            "checked": "no" if "failed" in found else "yes",
        }
        if compared:
            other = compared["cases"].get(name, {}).get("time", {}).get("scaled_ms")
            row[f"{compared['name']} ms"] = number(other)
            row["ratio"] = number(time["scaled_ms"] / other if other and time else None)
        rows.append(row)
    return Table("Times", list(rows[0]), [list(row.values()) for row in rows])


def title(case: Case) -> str:
    """Return what a case is called in tables."""
    if case.kind == "step":
        layers = "covering layers" if case.picture == "covers" else "path" if case.paths == 1 else "paths"
        return f"{case.paths} {layers}, {case.side}x{case.side}"
    return {
        "emoji": "emoji, 5 x 500 iterations",
        "startup-warm": "start-up, warm",
        "startup-cold": "start-up, cold",
        "import": "import livecl",
    }[case.name]


def _to_error(results: Results) -> Table | None:
    found = {name: case["to_error"] for name, case in results["cases"].items() if "to_error" in case}
    if not found:
        return None
    bounds = list(next(iter(found.values())))
    rows = [
        [title(CASES[name]), *(number(reached[bound] and reached[bound]["scaled_ms"]) for bound in bounds)]
        for name, reached in found.items()
    ]
    return Table(f"Until the mean squared error is at most ..., ms at {REFERENCE}", ["case", *bounds], rows)


def _by_case(results: Results, name: str, rows_of: Callable[[Results], dict[str, float]], head: str) -> Table | None:
    """Table with a column for each case that has such a part, and the union of their rows."""
    columns = {case: rows_of(found) for case, found in results["cases"].items() if rows_of(found)}
    if not columns:
        return None
    labels = dict.fromkeys(label for rows in columns.values() for label in rows)
    rows = [[label, *(number(rows.get(label)) for rows in columns.values())] for label in labels]
    return Table(name, [head, *columns], rows)


def _host(results: Results) -> Table | None:
    def rows(found: Results) -> dict[str, float]:
        if "host" not in found:
            return {}
        host = dict(found["host"]["ms"])
        host["(all)"] = sum(host.values())
        host["(measuring adds)"] = found["host"]["overhead_ms"]
        if "placement" in found:
            host["placement, once a stage"] = found["placement"]["median_ms"]
        return host

    return _by_case(results, "Host steps, ms of an iteration", rows, "step")


def _kernels(results: Results) -> Table | None:
    def rows(found: Results) -> dict[str, float]:
        kernels = dict(found.get("kernels", {}).get("ms", {}))
        return {**kernels, "(all)": sum(kernels.values())} if kernels else {}

    return _by_case(results, "Kernels, ms of an iteration by the device's clock", rows, "kernel")


def _counts(results: Results) -> Table | None:
    return _by_case(results, "What is in the scenes", lambda found: found.get("counts", {}), "count")


def _operations(results: Results) -> Table | None:
    def rows(found: Results) -> dict[str, float]:
        return {name: 1e-6 * count for name, count in found.get("operations", {}).items()}

    return _by_case(results, "Operations that an iteration cannot do without, millions", rows, "for")


def _curve(quantity: str) -> Callable[[Results], Table | None]:
    def make(results: Results) -> Table | None:
        points = CURVES[quantity]
        found = {name: results["cases"].get(name, {}).get("time") for name in points}
        if not results.get("curves") or not all(found.values()):
            return None
        first = next(iter(points))
        rows = [
            [
                title(CASES[name]),
                number(amount / points[first]),
                number(found[name]["scaled_ms"]),
                number(found[name]["scaled_ms"] / found[first]["scaled_ms"]),
            ]
            for name, amount in points.items()
        ]
        return Table(f"Time against {quantity}", ["case", f"x {quantity}", f"ms at {REFERENCE}", "x time"], rows)

    return make


def _cores(results: Results) -> Table | None:
    cores = results.get("cores")
    if not cores:
        return None
    first = next(iter(cores.values()))["median_ms"]
    rows = [
        [count, number(time["median_ms"]), number(first / time["median_ms"]), number(time["gflops"])]
        for count, time in cores.items()
    ]
    return Table("Time against cores", ["cores", "median ms", "times as fast", "reference GFLOP/s"], rows)


def checkout_table(results: Results) -> Table | None:
    """Return the times of this and another checkout, measured in turns, side by side."""
    other = results.get("other")
    if not other:
        return None
    rows = []
    for name, there in other["cases"].items():
        here = results["cases"].get(name, {}).get("time", {}).get("scaled_ms")
        theirs = there.get("time", {}).get("scaled_ms")
        ratio = here / theirs if here and theirs else None
        rows.append([title(CASES[name]), number(here), number(theirs), number(ratio)])
    head = ["case", f"here ({results['machine']['commit']})", f"there ({other['commit']})", "here / there"]
    return Table(f"Against another checkout, ms at {REFERENCE}", head, rows)


def text(results: Results, *, markdown: bool) -> str:
    """Return the whole report."""
    found = tables(results)
    if (table := checkout_table(results)) is not None:
        found.insert(1, table)
    parts = ["\n".join(f"- {line}" if markdown else line for line in facts(results))]
    parts += [table.markdown() if markdown else table.text() for table in found]
    if failed := failures(results):
        parts.append("\n".join(["Failed, and not timed:", *(f"- {line}" for line in failed)]))
    return "\n\n".join(parts) + "\n"
