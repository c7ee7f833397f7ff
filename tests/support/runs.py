# SPDX-License-Identifier: Apache-2.0
"""What tests of whole runs share: a picture of three shapes, quick options, a run that is about to begin."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from reference.rounding import UNIT

import livecl
from livecl import Drawing, Options
from livecl.drawing.assembly import empty_drawing
from livecl.image.background import background_for
from livecl.run.progress import Progress
from livecl.run.run import Run
from livecl.training.state import FREE
from support.shapes import build, circle, rectangle

#: Samples of a pixel along each axis in the pictures drawn here.
SAMPLES = 8


def three_shapes(side: int = 40, shift: float = 0.0) -> NDArray[np.float64]:
    """Return a disc, a rectangle that overlaps it and an ellipse on it, `shift` px to the left, box-filtered."""
    rows, columns = (np.indices((side * SAMPLES, side * SAMPLES)) + 0.5) * 40 / (side * SAMPLES)
    columns = columns + shift
    picture = np.ones((side * SAMPLES, side * SAMPLES, 3))
    picture[np.hypot(columns - 15, rows - 19) < 12.3] = (0.9, 0.2, 0.1)
    picture[(columns > 20.3) & (columns < 36.6) & (rows > 6.2) & (rows < 20.9)] = (0.1, 0.3, 0.8)
    picture[np.hypot((columns - 12) / 1.4, rows - 27) < 5.2] = (0.2, 0.7, 0.3)
    return picture.reshape(side, SAMPLES, side, SAMPLES, 3).mean(axis=(1, 3))


SMALL = three_shapes(24)

QUICK = Options.paper(iterations=6)


def mse_of(drawing: Drawing, target: NDArray[Any], device: int) -> float:
    image = livecl.render(drawing, device).astype(np.float64)
    return float(np.mean((image - target.astype(np.float32).astype(np.float64)) ** 2))


def about(mse: float) -> Any:
    """Return what compares as a mean of squared differences, each of which is rounded by a unit in single precision."""
    return pytest.approx(mse, rel=1e-9, abs=2 * UNIT * np.sqrt(mse))


def new_run(options: Options, schedule: tuple[int, ...], device: int, target: NDArray[Any] = SMALL) -> Run:
    drawing = empty_drawing(target.shape[:2], background_for(options.background, target))
    return Run(target, Progress.start(drawing, options, schedule, 0), device)


def started(holds: list[int], device: int, **changes: Any) -> Run:
    """Return a run at its first revision, with four layers on the picture of three shapes, (24, 24)."""
    shapes = [circle((9, 11), 7), rectangle(12, 4, 22, 12), circle((7, 16), 3), circle((20, 20), 1)]
    colors = [(0.9, 0.2, 0.1, 1), (0.1, 0.3, 0.8, 1), (0.2, 0.7, 0.3, 1), (0.95, 0.95, 0.95, 1)]
    drawing = build([([shape], color) for shape, color in zip(shapes, colors, strict=True)], (24, 24))
    drawing = drawing.replace(stages=[0, 1, 1, 1])
    progress = Progress.start(
        empty_drawing((24, 24)), Options(placement="region", iterations=1, prune=0.0, **changes), (1, 3), 0
    )
    state = progress.state
    state.add(drawing, np.arange(4))
    state.holds, state.stage, progress.asked = np.array(holds, np.int8), 2, holds.count(FREE)
    run = Run(SMALL, progress, device)
    state.pieces = run.rasterizer.pieces(drawing)
    return run


def scripted(run: Run, errors: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the run see these errors, one after the other."""
    values = iter(errors)
    monkeypatch.setattr(run, "visible_mse", lambda _: next(values))
