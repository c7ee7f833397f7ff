# SPDX-License-Identifier: Apache-2.0
"""The paper's plot: mean squared error against the number of paths, a line for each method."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from livecl.files import write_atomically


def plot_error(summary: Sequence[dict[str, Any]], file: Path) -> None:
    """Draw the mean error of each kind of picture, as PNG; ImportError without matplotlib.

    A method that chooses the number of paths itself is one point, at the mean number that it chose.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullLocator, ScalarFormatter

    groups = list(dict.fromkeys(row["group"] for row in summary))
    methods = list(dict.fromkeys(row["method"] for row in summary))
    figure = Figure(figsize=(4.6 * len(groups), 4), layout="constrained")
    for axes, group in zip(figure.subplots(1, len(groups), squeeze=False)[0], groups, strict=True):
        ticks: set[int] = set()
        for index, method in enumerate(methods):
            rows = [row for row in summary if (row["group"], row["method"]) == (group, method)]
            paths = [row["paths_mean"] if row["asked"] is None else row["asked"] for row in rows]
            ticks.update(row["asked"] for row in rows if row["asked"] is not None)
            axes.plot(paths, [row["mse_mean"] for row in rows], marker="o", color=f"C{index}", label=method)
        pictures = max(row["pictures"] for row in summary if row["group"] == group)
        axes.set(title=f"{group} ({pictures})", xlabel="paths", xscale="log", yscale="log")
        if ticks:
            axes.set_xticks(sorted(ticks))
            axes.xaxis.set_major_formatter(ScalarFormatter())
            axes.xaxis.set_minor_locator(NullLocator())
        axes.grid(visible=True, which="both", alpha=0.25)
    figure.axes[0].set_ylabel("MSE in resvg's picture, mean")
    figure.axes[0].legend()
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=120)
    write_atomically(file, png.getvalue())
