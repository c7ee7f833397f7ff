# SPDX-License-Identifier: Apache-2.0
"""Progress bars on standard error, off where that is no terminal."""

from __future__ import annotations

import shutil
import time
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from tqdm import tqdm

    from livecl.options import Options
    from livecl.vectorizer import Step

#: Seconds between two renders for the error that the progress bar shows.
MSE_INTERVAL = 0.5


class RunProgress:
    """A progress bar over all iterations of all stages."""

    def __init__(self, num_stages: int, options: Options, *, quiet: bool) -> None:
        from tqdm import tqdm

        width, height = shutil.get_terminal_size()  # a size also where the terminal has none
        self._bar: tqdm[NoReturn] = tqdm(
            total=(num_stages + options.revisions) * options.iterations,
            disable=True if quiet else None,
            unit="it",
            ncols=width - 1,
            nrows=height,
            leave=False,
        )
        self._num_stages = num_stages
        self._next_mse = 0.0
        self._mse = ""

    def __enter__(self) -> RunProgress:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def show(self, step: Step) -> None:
        """Move the bar to an iteration; the error costs a render and is shown a few times a second only."""
        if self._bar.disable:
            return
        now = time.monotonic()
        if now >= self._next_mse:
            self._next_mse = now + MSE_INTERVAL
            self._mse = f"{step.mse:.3g}"
        revision = step.stage - self._num_stages
        text = f"stage {step.stage + 1}/{self._num_stages}" if revision < 0 else f"revision {revision + 1}"
        self._bar.set_description(text, refresh=False)
        self._bar.set_postfix_str(f"paths {step.paths}, MSE {self._mse}", refresh=False)
        self._bar.update(step.stage * step.iterations + step.iteration - self._bar.n)
