# SPDX-License-Identifier: Apache-2.0
"""Progress bars on standard error, disabled if it is no terminal; the progress of a run in the log."""

from __future__ import annotations

import logging
import shutil
import time
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from typing_extensions import Self

    from livecl.batch.summary import Outcome
    from livecl.run.callbacks import Step

#: Seconds between two renders for the error that the progress bar shows.
MSE_INTERVAL = 0.5

_log = logging.getLogger(__name__)

T = TypeVar("T")


class _Progress:
    """Base class of the progress bars, context managers that close them; if `quiet`, none is shown."""

    def __init__(self, total: int | None, unit: str, *, quiet: bool) -> None:
        from tqdm import tqdm

        width, height = shutil.get_terminal_size()  # has a fallback for terminals without a size
        self._bar: tqdm[Any] = tqdm(
            total=total,
            disable=True if quiet else None,
            unit=unit,
            ncols=width - 1,
            nrows=height,
            leave=False,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()


class RunProgress(_Progress):
    """A progress bar over all iterations of all stages."""

    def __init__(self, *, quiet: bool) -> None:
        super().__init__(None, "it", quiet=quiet)
        self._bar.set_description("preparing")
        self._next_mse = 0.0
        self._per_stage = 1
        self._mse = ""

    def __call__(self, step: Step) -> None:
        """Move the bar to an iteration; the error, which costs a render, is updated a few times a second only."""
        if self._bar.disable:
            return
        now = time.monotonic()
        if now >= self._next_mse:
            self._next_mse = now + MSE_INTERVAL
            self._mse = f"{step.mse:.3g}"
        self._per_stage = max(self._per_stage, step.iterations)
        self._bar.total = step.num_stages * self._per_stage
        self._bar.set_description(step.name, refresh=False)
        self._bar.set_postfix_str(f"paths {step.paths}, MSE {self._mse}", refresh=False)
        done = step.stage + step.iteration / step.iterations  # a stage may end early
        self._bar.update(round(done * self._per_stage) - self._bar.n)

    def on_stage(self, step: Step, kept: bool) -> None:
        """Log the end of a stage."""
        if _log.isEnabledFor(logging.INFO):
            taken_back = "" if kept else ", taken back"
            _log.info("%s: %d paths, MSE %.3g%s", step.name, step.drawing.num_layers, step.mse, taken_back)


class OutputProgress(_Progress):
    """A progress bar over the parts, `unit`, of an output, the file `name`: frames, pictures, a plot."""

    def __init__(self, name: str, unit: str, *, quiet: bool) -> None:
        super().__init__(1, unit, quiet=quiet)
        self._bar.set_description(name)

    def show(self, done: int, total: int) -> None:
        """Move the bar to a part."""
        self._bar.total = total
        self._bar.update(done - self._bar.n)


class PictureProgress(_Progress):
    """A progress bar over consecutive pictures."""

    def __init__(self, total: int, *, quiet: bool) -> None:
        super().__init__(total, "picture", quiet=quiet)

    def counted(self, images: Iterable[T]) -> Iterator[T]:
        """Yield pictures; each is counted once it has been processed."""
        for image in images:
            yield image
            self._bar.update()


class BatchProgress(PictureProgress):
    """A progress bar over the pictures of a batch."""

    _failed = 0

    def show(self, outcome: Outcome) -> None:
        """Count a picture."""
        _log.info("%s: %s %s", outcome.file, outcome.status, outcome.message)
        if outcome.status == "failed":
            self._failed += 1
            self._bar.set_postfix_str(f"{self._failed} failed", refresh=False)
        self._bar.update()
