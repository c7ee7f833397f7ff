# SPDX-License-Identifier: Apache-2.0
"""Where runs begin that tests save, stop and resume; saving, loading and comparing how far they have come."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl import Drawing, Options
from livecl.drawing.assembly import empty_drawing
from livecl.run.callbacks import Step
from livecl.run.checkpoint import Checkpoints, load_checkpoint
from livecl.run.loop import train
from livecl.run.progress import Progress
from livecl.run.record import Record
from livecl.run.run import Run

SCHEDULE = (1, 2)


def disc_and_ring() -> NDArray[np.float32]:
    """Return a disc with a bar across it and a ring beside it, 24 x 27, with soft edges."""
    rows, columns = (np.indices((24 * 4, 27 * 4)) + 0.5) / 4
    picture = np.ones((24 * 4, 27 * 4, 3))
    distance = np.hypot(rows - 11, columns - 10)
    picture[distance < 8] = (0.8, 0.2, 0.1)
    picture[(np.abs(rows - 12) < 2) & (np.abs(columns - 11) < 9)] = (0.1, 0.2, 0.7)
    ring = np.hypot(rows - 17, columns - 20)
    picture[(ring > 2) & (ring < 5)] = (0.2, 0.7, 0.2)
    return picture.reshape(24, 4, 27, 4, 3).mean(axis=(1, 3)).astype(np.float32)


def start(options: Options, seed: int = 0) -> Progress:
    return Progress.start(empty_drawing((24, 27)), options, SCHEDULE, seed)


def save(progress: Progress, path: Path) -> None:
    Checkpoints(path, {}, None).write(progress, Record())


def load(path: Path) -> Progress:
    return load_checkpoint(path, {})[0]


def equal(one: Any, other: Any) -> bool:
    """Compare values field by field, arrays with their types and to the last bit."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, np.random.Generator):
        return bool(one.bit_generator.state == other.bit_generator.state)
    if dataclasses.is_dataclass(one):
        return all(equal(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one))
    return bool(one == other)


def assert_equal(one: Progress, other: Progress) -> None:
    for part, same in ((one, other), (one.state, other.state)):
        for field in dataclasses.fields(part):
            assert equal(getattr(part, field.name), getattr(same, field.name)), field.name


def stopped_and_resumed(
    target: NDArray[np.float32], progress: Progress, stop: tuple[int, int], path: Path, device: int
) -> Drawing:
    """Return the drawing of a run that is stopped after a stage's iteration, saved, loaded and trained to its end."""

    def stopping(step: Step) -> bool:
        return (step.stage, step.iteration) == stop

    first = Run(target, progress, device)
    train(first, stopping)
    save(first.progress, path)
    return train(Run(target, load(path), device))[-1].drawing
