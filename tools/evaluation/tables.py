# SPDX-License-Identifier: Apache-2.0
"""Tables: every result in CSV and JSON, and the means and medians of each kind of picture."""

from __future__ import annotations

import csv
import io
import json
import statistics
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmark.report import table

from livecl.files import write_atomically

Row = dict[str, Any]

#: Columns of the summary after method, paths asked and group: heading, format of its value.
SUMMARY: dict[str, tuple[str, Callable[[Any], str]]] = {
    "pictures": ("n", str),
    "mse_mean": ("MSE mean", "{:.2e}".format),
    "mse_median": ("median", "{:.2e}".format),
    "ssim_mean": ("SSIM", "{:.3f}".format),
    "in_one_region": ("1 region", "{:.0%}".format),
    "self_crossing": ("crossing", "{:.1%}".format),
    "needless": ("needless", str),
    "mergeable": ("mergeable", str),
    "gradients": ("grad.", "{:.1%}".format),
    "colored": ("colours", "{:.1%}".format),
    "paths_mean": ("paths", "{:.1f}".format),
    "segments_mean": ("cubics", "{:.0f}".format),
    "seconds_mean": ("s", "{:.2f}".format),
    "overlap": ("IoU", "{:.3f}".format),
    "found": (">=.9", "{:.0%}".format),
    "hidden_overlap": ("hidden", "{:.3f}".format),
    "missed": ("missed", "{:.0%}".format),
    "extra": ("extra", "{:.0%}".format),
    "layers_a_thing": ("layers/thing", "{:.2f}".format),
    "cubics_ratio": ("cubics/artist's", "{:.2f}".format),
    "delta_e_mean": ("dE x4", "{:.2f}".format),
    "numbers_ratio": ("numbers/artist's", "{:.2f}".format),
    "shapes_drawn": ("shapes", "{:.0%}".format),
    "shapes_of_found": ("of found", "{:.0%}".format),
    "shapes_false": ("false", "{:.0%}".format),
    "joins_smooth": ("smooth", "{:.0%}".format),
    "joins_all_smooth": ("of all", "{:.0%}".format),
    "corners_kept": ("corners", "{:.0%}".format),
    "corners_all_kept": ("of all", "{:.0%}".format),
    "sides_straight": ("straight", "{:.0%}".format),
    "sides_all_straight": ("of all", "{:.0%}".format),
    "level_exact": ("level", "{:.0%}".format),
    "displacement": ("edge px", "{:.3f}".format),
    "edge_missed": ("missed", "{:.1%}".format),
    "line_distance_mean": ("lines px", "{:.2f}".format),
    "line_width_off_mean": ("widths off", "{:.1%}".format),
    "line_nodes_mean": ("nodes", "{:.2f}".format),
    "more_layers": ("layers x", "{:.2f}".format),
    "more_cubics": ("cubics x", "{:.2f}".format),
}


def write_results(output: Path, rows: Sequence[Row], facts: Row) -> list[Row]:
    """Write results.csv and results.json, with the facts of the evaluation; return the summary."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({**row, "stages": " ".join(map(str, row["stages"]))})
    write_atomically(output / "results.csv", text.getvalue())
    summary = summarize(rows)
    whole = {**facts, "summary": summary, "rows": list(rows)}
    write_atomically(output / "results.json", json.dumps(whole, indent=1, allow_nan=False) + "\n")
    return summary


def summarize(rows: Iterable[Row]) -> list[Row]:
    """Return means and medians for each kind of picture, number of paths and method, and for all kinds together.

    `in_one_region`, `self_crossing` and `gradients` are shares of all layers, `colored` of the opaque ones; `needless`,
    `mergeable` and `nearly_opaque` are sums. `overlap`, `found`, `missed`, `extra` and `layers_a_thing` are over all
    true things. The scores of outlines are shares of the counts of livecl/quality/outlines.py; `displacement` is
    weighted by length, `numbers_ratio` is of all numbers. `more_layers` and `more_cubics` are ratios of a method's
    counts on disturbed pictures to those on the clean ones.
    """
    rows = list(rows)
    groups = sorted({row["group"] for row in rows})
    methods = list(dict.fromkeys(row["method"] for row in rows))
    counts = sorted({row["asked"] for row in rows}, key=lambda count: (count is None, isinstance(count, str), count))
    summary = []
    for group in [*groups, *(["all"] if len(groups) > 1 else [])]:
        for count in counts:
            for method in methods:
                chosen = [
                    row
                    for row in rows
                    if group in (row["group"], "all") and row["asked"] == count and row["method"] == method
                ]
                if chosen:
                    names = {"group": group, "asked": count, "method": method}
                    summary.append({**names, **_statistics(chosen), **_growth(chosen, rows)})
    return summary


def _growth(chosen: Sequence[Row], rows: Sequence[Row]) -> Row:
    """Return the ratios of layers and cubics on disturbed pictures to those on the clean ones."""
    cleans = {(row["picture"], row["method"], row["asked"]): row for row in rows}
    pairs = [(row, cleans.get((row["picture"], row["method"].partition("+")[0], row["asked"]))) for row in chosen]
    both = [(row, clean) for row, clean in pairs if clean is not None and clean is not row]
    return {
        f"more_{name}": sum(row[key] for row, _ in both) / max(1, sum(clean[key] for _, clean in both))
        if both
        else None
        for name, key in (("layers", "paths"), ("cubics", "segments"))
    }


def format_summary(summary: Sequence[Row]) -> str:
    """Return the summary as a Markdown table, without empty columns."""
    columns = {name: column for name, column in SUMMARY.items() if any(row[name] is not None for row in summary)}
    rows = []
    for row in summary:
        shown = ["-" if row[name] is None else show(row[name]) for name, (_, show) in columns.items()]
        rows.append([row["group"], str(row["asked"] or "-"), row["method"], *shown])
    return table("Summary", ["pictures", "asked", "method", *(heading for heading, _ in columns.values())], rows)


def _statistics(rows: Sequence[Row]) -> Row:
    def values(name: str) -> list[float]:
        return [row[name] for row in rows if row.get(name) is not None]

    def mean(name: str) -> float | None:
        return statistics.fmean(values(name)) if values(name) else None

    def share(name: str, whole: str) -> float | None:
        return sum(values(name)) / sum(values(whole)) if sum(values(whole)) else None

    def weighted(name: str, weight: str) -> float | None:
        total = sum(values(weight))
        return sum(row[name] * row[weight] for row in rows if row.get(weight)) / total if total else None

    known = [row for row in rows if row.get("things")]
    things = sum(row["things"] for row in known)
    artist = sum(row["true_segments"] for row in known)
    return {
        "pictures": len(rows),
        "mse_median": statistics.median(values("mse")),
        **{name: sum(row[name] for row in rows) for name in ("needless", "mergeable", "nearly_opaque")},
        **{name: share(name, "paths") for name in ("in_one_region", "self_crossing", "gradients")},
        "colored": share("colored", "opaque"),
        "numbers_ratio": share("numbers", "true_numbers"),
        "shapes_drawn": share("shapes_drawn", "shapes"),
        "shapes_of_found": share("shapes_drawn", "shapes_found"),
        "shapes_false": share("shapes_false", "shapes_written"),
        "joins_smooth": share("joins_smooth", "joins"),
        "corners_kept": share("corners_kept", "corners"),
        "sides_straight": share("sides_straight", "sides"),
        "joins_all_smooth": share("joins_all_smooth", "joins_all"),
        "corners_all_kept": share("corners_all_kept", "corners_all"),
        "sides_all_straight": share("sides_all_straight", "sides_all"),
        "level_exact": share("level_exact", "level"),
        "displacement": weighted("displacement", "edge"),
        "edge_missed": share("edge_missed", "edge"),
        "overlap": weighted("overlap", "things"),
        "hidden_overlap": weighted("hidden_overlap", "hidden"),
        **{name: share(name, "things") for name in ("found", "missed", "extra")},
        "layers_a_thing": sum(row["paths"] for row in known) / things if things else None,
        "cubics_ratio": sum(row["segments"] for row in known) / artist if artist else None,
        **{name: mean(name.removesuffix("_mean")) for name in SUMMARY if name.endswith("_mean")},
    }
