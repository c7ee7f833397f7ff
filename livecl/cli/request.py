# SPDX-License-Identifier: Apache-2.0
"""Checked requests: find and read the pictures, and report anything wrong before the work starts."""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from livecl.batch.inputs import is_pattern
from livecl.cli.arguments import layers_of
from livecl.cli.method import given_options
from livecl.cli.outputs import OUTPUTS, STANDARD, Output, check_outputs
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.drawing import Drawing
from livecl.image.masks import read_masks
from livecl.image.reading import read_image
from livecl.options import PRESET_PATHS
from livecl.run.checkpoint import is_checkpoint
from livecl.run.control import Control
from livecl.run.recipe import Recipe
from livecl.schedule import DEFAULT_PATHS

if TYPE_CHECKING:
    from livecl.batch.batch import Batch


@dataclasses.dataclass(frozen=True, kw_only=True)
class Job:
    """A request for one picture, which has been read."""

    name: str
    image: NDArray[np.float32]
    recipe: Recipe
    output: str
    outputs: list[tuple[Output, Path]]
    frame_step: int
    command: tuple[str, ...]
    device: str | None
    quiet: bool
    control: Control

    @property
    def output_name(self) -> str:
        """Name of the SVG in messages."""
        return "standard output" if self.output == STANDARD else self.output

    @property
    def kept(self) -> str:
        """Message on the outputs of an aborted run."""
        return f"nothing was written{going_on(self.control)}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class BatchJob:
    """A request for several pictures in one folder."""

    batch: Batch
    folder: str
    quiet: bool

    @property
    def kept(self) -> str:
        """Message on the outputs of an aborted batch."""
        return f"finished pictures are in {self.folder}"


def checked(arguments: argparse.Namespace) -> Job | BatchJob:
    """Check a request without touching a file: read the picture, or find the pictures.

    Raises ValueError or LiveclError if it cannot be done; the message is one line for the user.
    """
    from livecl.opencl.device import choose_device

    missing = [name for name, value in (("IN", arguments.inputs), ("-o", arguments.output)) if not value]
    if missing:
        raise ValueError(f"nothing to do without {' and '.join(missing)}: livecl IN -o OUT.svg (see --help)")
    recipe = recipe_of(arguments)
    inputs: list[str] = arguments.inputs
    if len(inputs) > 1 or Path(inputs[0]).is_dir() or is_pattern(inputs[0]):
        return _checked_batch(arguments, recipe)
    for name in ("workers", "scheduler"):
        if getattr(arguments, name) is not None:
            raise ValueError(f"--{name}: goes with several pictures, or a folder of them")
    (source,) = inputs
    image = _checked_image(source)
    chosen = [(kind, Path(path)) for kind in OUTPUTS if (path := getattr(arguments, kind.name)) is not None]
    recipe.start_on((image.shape[0], image.shape[1]))
    if recipe.masks is not None:
        recipe.masks.on((image.shape[0], image.shape[1]), (1, 1))
    control = _control_of(arguments)
    check_outputs(source, arguments.output, chosen, len(recipe.stages), control.checkpoint)
    choose_device(arguments.device)
    return Job(
        name="standard input" if source == STANDARD else source,
        image=image,
        recipe=recipe,
        output=arguments.output,
        outputs=chosen,
        frame_step=arguments.frame_step,
        command=arguments.command,
        device=arguments.device,
        quiet=arguments.quiet,
        control=control,
    )


def recipe_of(arguments: argparse.Namespace) -> Recipe:
    """Return the recipe: paths, options and size for each picture."""
    paths, schedule = arguments.paths, arguments.schedule
    start = None
    if arguments.start is not None:
        from livecl.svg import read_svg

        start = read_svg(arguments.start)
    if paths is None and schedule is None and start is None:
        paths = PRESET_PATHS.get(arguments.preset)
    if arguments.preset == "diffvg" and schedule is None and start is None:
        schedule = str(paths or DEFAULT_PATHS)
    layers, cutout = layers_of(arguments.layers)
    return Recipe(
        paths=paths,
        schedule=schedule,
        options=given_options(arguments),
        seed=arguments.seed,
        size=arguments.size,
        precision=arguments.precision,
        layers=layers,
        cutout=cutout,
        trap=arguments.trap,
        groups=arguments.groups,
        swatches=arguments.swatches,
        start=start,
        lock=_locked(start, arguments.lock or ()),
        masks=None if arguments.masks is None else read_masks(arguments.masks),
    )


def _locked(start: Drawing | None, specs: Sequence[str]) -> tuple[int, ...]:
    """Return the indices of the layers named by ``--lock``, each once."""
    if start is None:
        if specs:
            raise ValueError("--lock: names layers of a drawing; give the drawing with --start")
        return ()
    return tuple(sorted({int(layer) for spec in specs for layer in start.select(spec)}))


def settings_of(recipe: Recipe, arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the settings that, in a --config file, lead to the same recipe."""
    return {
        **({} if recipe.chooses_paths else _said_of_paths(recipe)),
        "size": recipe.size,
        "precision": recipe.precision,
        "layers": f"{recipe.layers},cutout" if recipe.cutout else recipe.layers,
        "trap": recipe.trap,
        "groups": recipe.groups,
        "swatches": recipe.swatches,
        "seed": recipe.seed,
        **dataclasses.asdict(recipe.options),
        **{name: getattr(arguments, name) for name in ("device", "threads", "workers", "scheduler", "time_limit")},
    }


def _said_of_paths(recipe: Recipe) -> dict[str, Any]:
    return {"paths": "auto"} if recipe.paths == "auto" else {"schedule": list(recipe.stages)}


def _control_of(arguments: argparse.Namespace) -> Control:
    """Return time limit and checkpoint of the run of one picture.

    Raises ValueError if it would overwrite a file other than a checkpoint, or resume without one.
    """
    path = _checkpoint(arguments)
    if path is None and arguments.resume:
        wanted = "leave out --no-checkpoint" if arguments.checkpoint is False else "name one with --checkpoint"
        raise ValueError(f"--resume: needs a checkpoint; {wanted}")
    if path is not None and path.is_file() and not arguments.resume and not is_checkpoint(path):
        raise ValueError(
            f"{path}: is no checkpoint that can be read, and would be overwritten; move it, or name another file with "
            "--checkpoint"
        )
    return Control(
        time_limit=arguments.time_limit,
        checkpoint=path,
        period=arguments.checkpoint_period,
        resume=arguments.resume,
    )


def _checkpoint(arguments: argparse.Namespace) -> Path | None:
    """Return the file given by --checkpoint, or the one beside the output if that is a file; else None."""
    if arguments.checkpoint is False:
        return None
    if arguments.checkpoint is not None:
        return Path(arguments.checkpoint)
    output = Path(arguments.output)
    if arguments.output == STANDARD or (output.exists() and not output.is_file()):
        return None
    return Path(f"{os.fspath(output)}.checkpoint")


def _checked_batch(arguments: argparse.Namespace, recipe: Recipe) -> BatchJob:
    if STANDARD in arguments.inputs:
        raise ValueError("-: standard input is one picture, and cannot be combined with others")
    if arguments.output == STANDARD:
        raise ValueError("-: several SVGs need a folder, not standard output")
    for kind in OUTPUTS:
        if getattr(arguments, kind.name) is not None:
            raise ValueError(f"--{kind.name}: goes with one picture, and there are several, or a folder")
    for name in ("checkpoint", "checkpoint_period", "resume"):
        if getattr(arguments, name):
            option = name.replace("_", "-")
            raise ValueError(f"--{option}: goes with one picture; a folder of SVGs goes on by itself where it was left")
    if recipe.masks is not None:
        raise ValueError("--masks: goes with one picture, and there are several, or a folder")
    from livecl.batch.batch import Batch, Workers
    from livecl.batch.worker import Request

    request = Request(recipe, arguments.device, arguments.time_limit)
    workers = Workers(arguments.workers, arguments.threads or 1, arguments.scheduler)
    batch = Batch(arguments.inputs, arguments.output, request, workers, skip_done=not arguments.redo)
    return BatchJob(batch=batch, folder=arguments.output, quiet=arguments.quiet)


def _checked_image(source: str) -> NDArray[np.float32]:
    image = read_image(sys.stdin.buffer if source == STANDARD else source)
    try:
        empty_drawing((image.shape[0], image.shape[1]))
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from error
    return image


def beginning(control: Control) -> str:
    """Return a warning if a run starts anew in spite of --resume or an existing checkpoint, else ""."""
    if control.checkpoint is None or Path(control.checkpoint).exists() == control.resume:
        return ""
    if control.resume:
        return f"there is no {control.checkpoint} to resume from: the run starts anew"
    return f"{control.checkpoint} is of a run that was stopped: --resume would continue it, this one starts anew"


def going_on(control: Control) -> str:
    """Return the end of a message that tells how to resume; "" without a checkpoint."""
    if control.checkpoint is None or not Path(control.checkpoint).exists():
        return ""
    return f"; --resume continues from {control.checkpoint}"
