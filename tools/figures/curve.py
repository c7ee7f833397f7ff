# SPDX-License-Identifier: Apache-2.0
"""The loss curve of a training."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from livecl.files import write_atomically

#: Steps whose mean is one point of a line.
WINDOW = 25


def plot_training(losses: np.ndarray, file: Path) -> None:
    """Draw cross-entropy and divergence (steps, 2), nats a picture, as PNG; ImportError without matplotlib."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 3), layout="constrained")
    axes = figure.subplots()
    window = min(WINDOW, len(losses))
    whole = len(losses) // window * window
    means = losses[:whole].reshape(-1, window, 2).mean(axis=1)
    steps = (np.arange(len(means)) + 0.5) * window
    for index, label in enumerate(("cross-entropy", "divergence")):
        axes.plot(steps, means[:, index], label=label)
    axes.set(xlabel="step", ylabel="nats a picture", yscale="log")
    axes.grid(visible=True, which="both", alpha=0.25)
    axes.legend()
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=100)
    write_atomically(file, png.getvalue())
