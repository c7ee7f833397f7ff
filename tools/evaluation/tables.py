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

from livecl.files import write_atomically

Row = dict[str, Any]

#: Columns of results.csv, in their order. `asked` is empty where the method chooses the number of paths itself.
COLUMNS = (
    "picture",
    "group",
    "method",
    "asked",
    "paths",
    "segments",
    "parameters",
    "bytes",
    "seconds",
    "compile_seconds",
    "mse",
    "psnr",
    "ssim",
    "own_mse",
    "own_psnr",
    "own_ssim",
    "renders_mse",
    "renders_max",
    "in_one_region",
    "self_crossing",
    "needless",
    "mergeable",
    "nearly_opaque",
    "stages",
    "svg",
)

#: Columns of the summary after method, paths asked and group: heading, format of its value.
SUMMARY: dict[str, tuple[str, Callable[[Any], str]]] = {
    "pictures": ("n", str),
    "mse_mean": ("MSE mean", "{:.2e}".format),
    "mse_median": ("median", "{:.2e}".format),
    "psnr_mean": ("PSNR", "{:.1f}".format),
    "ssim_mean": ("SSIM", "{:.3f}".format),
    "own_mse_mean": ("own MSE", "{:.2e}".format),
    "in_one_region": ("1 region", "{:.0%}".format),
    "self_crossing": ("crossing", "{:.1%}".format),
    "needless": ("needless", str),
    "mergeable": ("mergeable", str),
    "nearly_opaque": ("n. opaque", str),
    "paths_mean": ("paths", "{:.1f}".format),
    "segments_mean": ("cubics", "{:.0f}".format),
    "parameters_mean": ("params", "{:.0f}".format),
    "bytes_mean": ("bytes", "{:.0f}".format),
    "seconds_mean": ("s", "{:.2f}".format),
}


def write_results(output: Path, rows: Sequence[Row], facts: Row) -> list[Row]:
    """Write results.csv and results.json, with the facts about the whole; return the summary."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
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

    `in_one_region` and `self_crossing` are shares of all layers; `needless`, `mergeable`, `nearly_opaque` are sums.
    """
    rows = list(rows)
    groups = sorted({row["group"] for row in rows})
    methods = list(dict.fromkeys(row["method"] for row in rows))
    counts = sorted({row["asked"] for row in rows}, key=lambda count: (count is None, count))
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
                    summary.append({"group": group, "asked": count, "method": method, **_statistics(chosen)})
    return summary


def format_summary(summary: Sequence[Row]) -> str:
    """Return the summary as a text table."""
    lines = [["pictures", "asked", "method", *(heading for heading, _ in SUMMARY.values())]]
    for row in summary:
        asked = "-" if row["asked"] is None else str(row["asked"])
        shown = ["-" if row[name] is None else show(row[name]) for name, (_, show) in SUMMARY.items()]
        lines.append([row["group"], asked, row["method"], *shown])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    left = {0, 2}
    return "\n".join(
        "  ".join(
            cell.ljust(width) if index in left else cell.rjust(width)
            for index, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    )


def _statistics(rows: Sequence[Row]) -> Row:
    def values(name: str) -> list[float]:
        return [row[name] for row in rows if row[name] is not None]

    def mean(name: str) -> float | None:
        return statistics.fmean(values(name)) if values(name) else None

    layers = sum(values("paths"))
    return {
        "pictures": len(rows),
        "mse_median": statistics.median(values("mse")),
        **{name: sum(row[name] for row in rows) for name in ("needless", "mergeable", "nearly_opaque")},
        **{name: sum(values(name)) / layers if layers else None for name in ("in_one_region", "self_crossing")},
        **{name: mean(name.removesuffix("_mean")) for name in SUMMARY if name.endswith("_mean")},
    }
