# SPDX-License-Identifier: Apache-2.0
"""The results of a run of the benchmark: kept in a file, completed, searched for failures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from benchmark.limit import Floor

Results = dict[str, Any]

#: Version of the layout of results.
FORMAT = 1


def save(results: Results, path: Path) -> None:
    """Write results as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


def load(path: Path) -> Results:
    """Read results.

    Raises
    ------
    ValueError
        If the file does not hold any of this format.
    """
    try:
        results: Results = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError) as error:
        raise ValueError(f"{path}: {error}") from error
    if not isinstance(results, dict) or results.get("format") != FORMAT:
        raise ValueError(f"{path}: no results of this benchmark, or of another version")
    return results


def put_limits(results: Results) -> None:
    """Add to each case its limit on the reference machine, and how many times the limit it takes."""
    for found in results["cases"].values():
        if "floor" in found:
            found["limit_ms"] = Floor(**found["floor"]).limit_ms(results["machine"])
            if "time" in found:
                found["times_limit"] = found["time"]["scaled_ms"] / found["limit_ms"]


def failures(results: Results) -> list[str]:
    """Return what failed, a line each: checks, and cases that could not be measured."""
    there = results.get("other", {}).get("cases", {})
    named = [*results["cases"].items(), *((f"{name}, other checkout", found) for name, found in there.items())]
    return [f"{name}: {found['failed']}" for name, found in named if "failed" in found]
