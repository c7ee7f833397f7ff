# SPDX-License-Identifier: Apache-2.0
"""Vectorization of all pixels of a picture: checks of the arguments, the run of all stages, the result."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.image.background import TRAIN, background_for, target_over
from livecl.options import Options
from livecl.run.callbacks import OnStep
from livecl.run.checkpoint import Checkpoints, identity_of, load_checkpoint
from livecl.run.control import Control, Watch
from livecl.run.loop import Loop
from livecl.run.progress import Progress
from livecl.run.record import Record
from livecl.run.result import Result, RunError, Stage
from livecl.run.run import Run
from livecl.schedule import MAX_AUTO_PATHS, MAX_DEFAULT_PATHS, growing_schedule, parse_schedule

#: Colours of a flat picture are read off it: they are hardly trained.
STRUCTURE_COLOR_RATE = 2e-4


def vectorize_pixels(
    image: NDArray[np.float32],
    paths: int | Literal["auto"] | None = None,
    schedule: str | Sequence[int] | None = None,
    options: Options | None = None,
    device: int | str | None = None,
    seed: int = 0,
    on_step: OnStep | None = None,
    start: Drawing | None = None,
    lock: Sequence[int] = (),
    control: Control | None = None,
) -> Result:
    """Vectorize a picture at its full size; :func:`livecl.vectorize` does so at its working size.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) float32
        Straight RGB or RGBA in [0, 1].
    paths, schedule, options, device, seed, on_step, start, lock, control
        As for :func:`livecl.vectorize`; `start` of the picture's size.

    Returns
    -------
    Result

    Raises
    ------
    ValueError, DeviceError, KernelBuildError, CheckpointError, RunError
        As :func:`livecl.vectorize`.
    """
    options = Options() if options is None else options
    if paths == "auto":
        options = options.choosing_paths()
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise ValueError(f"seed: got {seed!r}, wanted a whole number of at least 0")
    begin = time.perf_counter()
    control = Control() if control is None else control
    watch = Watch(control)  # its clock starts
    progress = _first(image, paths, schedule, options, seed, start, lock)
    run = Run(image, progress, device, watch.check)
    info = run.rasterizer.device.info
    identity = identity_of(progress, run.target, seed, info)
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
            options=options,
            stopped=stopped,
        )

    try:
        loop.train()
        return result_of(loop.stages(), loop.stopped)
    except (LiveclError, MemoryError) as error:
        message = str(error) or "out of memory"
        stages = loop.salvaged_stages()
        raise RunError(message, result_of(stages, message) if stages else None) from error


def _first(
    image: NDArray[np.float32],
    paths: int | Literal["auto"] | None,
    schedule: str | Sequence[int] | None,
    options: Options,
    seed: int,
    start: Drawing | None,
    lock: Sequence[int],
) -> Progress:
    """Return the progress before the first stage."""
    size = image.shape[0], image.shape[1]
    if start is None:
        if len(lock):
            raise ValueError("lock: names layers of a drawing; give the drawing as start")
        drawing = empty_drawing(size, background_for(options.background, image))
        options = placed_by(options, image, drawing, sum(_stages(paths, schedule, options)))
        return Progress.start(drawing, options, _stages(paths, schedule, options), seed)
    if start.size != size:
        raise ValueError(f"start: a canvas of {start.size} px, wanted the picture's {size}")
    if options.variant == "released":
        raise ValueError("start: variant 'released' trains the newest paths only, so it starts from nothing")
    refines = start.num_layers > 0
    stages = _stages(paths, schedule, options) if schedule or paths or not refines else ()
    drawing = start.replace(background=background_for(options.background, image, start.background))
    locked = np.zeros(start.num_layers, bool)
    try:
        locked[np.array(lock, dtype=np.intp)] = True
    except (IndexError, TypeError, ValueError):
        raise ValueError(f"lock: got {lock!r}, wanted numbers of the {start.num_layers} layers, from 0 on") from None
    options = dataclasses.replace(options, placement="region") if options.placement == "structure" else options
    return Progress.start(drawing, options, (0, *stages) if refines else stages, seed, locked)


def _stages(
    paths: int | Literal["auto"] | None, schedule: str | Sequence[int] | None, options: Options
) -> tuple[int, ...]:
    """Return the paths of each stage; where nothing is said and paths are judged by what they gain, by the picture."""
    if paths is None and schedule is None and options.path_gain:
        return growing_schedule(MAX_AUTO_PATHS if options.placement == "structure" else MAX_DEFAULT_PATHS)
    return parse_schedule(schedule, paths)


def placed_by(options: Options, image: NDArray[np.float32], drawing: Drawing, count: int) -> Options:
    """Return the options with the placement that suits a picture and a number of paths: structure or regions.

    Structure where the picture is flat and has not many more shapes: one path paints one shape there.

    Structure stays as it is found: there are no revisions, which trade it for error, and no merging.
    """
    if options.placement != "structure":
        return options
    if options.shape == "outline" and options.background != TRAIN and options.new_color == "target":
        from livecl.layering.structure import structured  # loads SciPy

        if structured(target_over(image, drawing.background), drawing.background, count):
            opacity: Literal["opaque", "train"] = "train" if options.opacity == "train" else "opaque"
            return dataclasses.replace(
                options, revisions=0, merge=False, opacity=opacity, color_learning_rate=STRUCTURE_COLOR_RATE
            )
    return dataclasses.replace(options, placement="region")
