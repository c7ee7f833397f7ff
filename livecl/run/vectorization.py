# SPDX-License-Identifier: Apache-2.0
"""Vectorize a picture at its full size: check the arguments, run all stages, return the result."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import empty_drawing
from livecl.errors import LiveclError
from livecl.image.background import background_for, target_over
from livecl.image.errors import mse
from livecl.interruption import interruptible
from livecl.opencl.device import choose_device, list_devices
from livecl.run.beginning import Beginning
from livecl.run.callbacks import OnStep
from livecl.run.checkpoint import Checkpoints, identity_of, load_checkpoint
from livecl.run.coarse import coarsened, enlarged, refined
from livecl.run.control import Control, Stopped, Watch
from livecl.run.loop import Loop
from livecl.run.preparation import Preparation
from livecl.run.record import Record
from livecl.run.result import Result, RunError, Stage
from livecl.run.run import Run


def vectorize_pixels(
    image: NDArray[np.float32],
    beginning: Beginning,
    device: int | str | None = None,
    on_step: OnStep | None = None,
    control: Control | None = None,
    preparation: Preparation | None = None,
) -> Result:
    """Vectorize a picture at its full size; :func:`livecl.vectorize` reduces it to the working size first.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) float32
        Straight RGB or RGBA in [0, 1].
    beginning : Beginning
        Paths, options, seed and start drawing.
    device, on_step, control
        As for :func:`livecl.vectorize`.
    preparation : Preparation, optional
        Kernels being compiled for this run, if any.

    Returns
    -------
    Result

    Raises
    ------
    ValueError, DeviceError, KernelBuildError, CheckpointError, RunError
        As :func:`livecl.vectorize`.
    """
    begin = time.perf_counter()
    control = Control() if control is None else control
    with interruptible(Watch(control).check):  # starts the clock
        try:
            pixels, progress = coarsened(image, beginning, beginning.progress(image))
            if preparation is not None:
                preparation.wait()
        except Stopped as stopped:  # before the placement is known: nothing to resume from
            if beginning.start is None:
                return _nothing_of(image, beginning, device, (stopped.reason, begin))
        run = Run(pixels, progress, device)
        info = run.rasterizer.device.info
        identity = identity_of(progress, run.target, beginning.seed, info)
        record = Record()
        if control.resume and control.checkpoint is not None and Path(control.checkpoint).exists():
            run.progress, record = load_checkpoint(control.checkpoint, identity)
        if not run.finished:
            run.warm_up()
        compiled = time.perf_counter()
        loop = Loop(run, on_step, Checkpoints(control.checkpoint, identity, control.period), record)

        def result_of(stages: Sequence[Stage], stopped: str | None) -> Result:
            return Result(
                drawing=stages[-1].drawing,
                mse=stages[-1].mse,
                stages=tuple(stages),
                seconds=sum(stage.seconds for stage in stages),
                compile_seconds=compiled - begin,
                device=str(info),
                options=beginning.options,
                stopped=stopped,
            )

        try:
            loop.train()
            result = result_of(loop.stages(), loop.stopped)
            return result if pixels is image else refined(result, image, device)
        except (LiveclError, MemoryError) as error:
            message = str(error) or "out of memory"
            stages = loop.salvaged_stages()
            size = (image.shape[0], image.shape[1])
            raise RunError(message, enlarged(result_of(stages, message), size) if stages else None) from error


def _nothing_of(
    image: NDArray[np.float32], beginning: Beginning, device: int | str | None, stop: tuple[str, float]
) -> Result:
    """Return the result of a run stopped before it began; `stop` has the reason, and the start time in seconds."""
    reason, begin = stop
    background = background_for(beginning.options.background, image)
    drawing = empty_drawing((image.shape[0], image.shape[1]), background)
    target = target_over(image, drawing.background)
    blank = np.zeros(target.shape, np.float32) if drawing.background is None else drawing.background
    error = mse(np.broadcast_to(blank, target.shape), target)
    seconds = time.perf_counter() - begin
    return Result(
        drawing=drawing,
        mse=error,
        stages=(Stage(drawing, error, 0, 0.0),),
        seconds=0.0,
        compile_seconds=seconds,
        device=str(list_devices()[choose_device(device)]),
        options=beginning.options,
        stopped=reason,
    )
