# SPDX-License-Identifier: Apache-2.0
"""From arguments to a job: the picture read, and all that can be wrong found, before the work starts."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

from livecl.cli_arguments import BadInputError
from livecl.cli_outputs import check_outputs
from livecl.errors import DeviceError, ImageError
from livecl.schedule import DEFAULT_PATHS

if TYPE_CHECKING:
    from livecl.options import Options

#: The arguments that are fields of `Options` under the same name.
OPTION_NAMES = (
    "iterations",
    "segments",
    "max_segments",
    "loss",
    "xing_weight",
    "placement",
    "shape",
    "revisions",
    "target_mse",
    "background",
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Job:
    """A request whose arguments have been checked."""

    image: Any
    output: Path
    json: Path | None
    stages: Path | None
    schedule: tuple[int, ...]
    options: Options
    device: str | None
    seed: int
    quiet: bool


def checked(arguments: argparse.Namespace) -> Job:
    """Read the picture and check all else that is asked for, without touching a file."""
    missing = [name for name, value in (("IN", arguments.input), ("-o", arguments.output)) if not value]
    if missing:
        raise BadInputError(f"nothing to do without {' and '.join(missing)}: livecl IN -o OUT.svg (see --help)")
    schedule = _checked_schedule(arguments)
    options = _checked_options(arguments)
    output = Path(arguments.output)
    stages = None if arguments.stages is None else Path(arguments.stages)
    report = None if arguments.json is None else Path(arguments.json)
    image = _checked_image(arguments.input)
    check_outputs(Path(arguments.input), output, report, stages, len(schedule))
    check_device(arguments.device)
    return Job(
        image=image,
        output=output,
        json=report,
        stages=stages,
        schedule=schedule,
        options=options,
        device=arguments.device,
        seed=arguments.seed,
        quiet=arguments.quiet,
    )


def _checked_schedule(arguments: argparse.Namespace) -> tuple[int, ...]:
    from livecl.schedule import parse_schedule

    paths, schedule = arguments.paths, arguments.schedule
    if arguments.preset == "diffvg" and schedule is None:
        schedule = str(paths or DEFAULT_PATHS)
    try:
        return parse_schedule(schedule, paths)
    except ValueError as error:
        raise BadInputError(str(error)) from error


def _checked_options(arguments: argparse.Namespace) -> Options:
    from livecl.options import PRESETS

    make = PRESETS[arguments.preset]
    given = {name: getattr(arguments, name) for name in OPTION_NAMES if getattr(arguments, name) is not None}
    if arguments.placement == "random" and make().shape == "outline":  # there is no region to fit an outline to
        given.setdefault("shape", "circle")
    try:
        options = make(**given)
        return options.choosing_paths() if arguments.paths == "auto" else options
    except ValueError as error:
        raise BadInputError(str(error)) from error


def _checked_image(path: str) -> Any:
    from livecl.drawing import empty_drawing
    from livecl.image import read_image

    try:
        image = read_image(path)
    except ImageError as error:
        raise BadInputError(str(error)) from error
    try:
        empty_drawing(image.shape[:2])
    except ValueError as error:
        raise BadInputError(f"{path}: {error}") from error
    return image


def check_device(device: str | None) -> None:
    """Refuse a device that is not there."""
    from livecl.device import choose_device

    try:
        choose_device(device)
    except DeviceError as error:
        raise BadInputError(str(error)) from error
