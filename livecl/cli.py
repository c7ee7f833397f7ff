# SPDX-License-Identifier: Apache-2.0
"""The command line: arguments, files, progress and exit codes around :func:`livecl.vectorize`.

Everything that can be wrong with a request is found before the work starts: one line on standard error, exit code 2,
and no file touched. Exit code 1 is a failure while working, 130 an interruption.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, get_args, get_type_hints

from livecl import __version__
from livecl.errors import DeviceError, ImageError, LiveclError
from livecl.schedule import DEFAULT_PATHS

if TYPE_CHECKING:
    from tqdm import tqdm

    from livecl.options import Options
    from livecl.result import Result
    from livecl.vectorizer import Step

#: Exit codes, beside 0.
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130
#: Seconds between two renders for the error that the progress bar shows.
MSE_INTERVAL = 0.5
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

DESCRIPTION = "Turn a picture into a layered SVG of few closed Bézier paths."
EPILOG = """\
examples:
  livecl face.png -o face.svg --schedule 1,1,1,1,1,1 --stages stages --json face.json
  livecl photo.jpg -o photo.svg --paths 64

exit codes: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
An existing output file is replaced only when the new one is complete.
"""


class _BadInputError(Exception):
    """What is asked for cannot be done; the message is one line for the user."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        raise _BadInputError(f"{message} (see --help)")


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Job:
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


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process where not given.

    Returns
    -------
    int
        Exit code: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted.
    """
    try:
        arguments = build_parser().parse_args(argv)
        if arguments.threads is not None:  # PoCL reads it once, when OpenCL is first used
            os.environ["POCL_MAX_PTHREAD_COUNT"] = str(arguments.threads)
        if arguments.list_devices:
            _list_devices()
            return 0
        job = _checked(arguments)
    except _BadInputError as error:
        _complain(" ".join(str(error).split()))
        return BAD_INPUT
    except KeyboardInterrupt:
        _complain("interrupted")
        return INTERRUPTED
    try:
        _work(job)
    except KeyboardInterrupt:
        _complain("interrupted; nothing was written")
        return INTERRUPTED
    except (LiveclError, OSError, MemoryError, ArithmeticError) as error:
        _complain(str(error) or type(error).__name__)
        return FAILED
    return 0


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    from livecl.options import PRESETS, Options

    parser = _Parser(
        prog="livecl",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    choices = {name: get_args(hint) for name, hint in get_type_hints(Options).items()}
    add("input", metavar="IN", nargs="?", help="the picture: PNG, JPEG or another file that Pillow reads")
    add("-o", "--output", metavar="OUT.svg", help="the SVG to write; required, unless devices are listed")
    add(
        "--paths",
        type=_paths,
        metavar="N",
        help=f"number of paths, at most, or auto: as many as gain enough (default: {DEFAULT_PATHS})",
    )
    add("--target-mse", type=_weight, metavar="X", help="begin no further stage once the error is that low")
    add("--schedule", metavar="LIST", help="paths that each stage adds, as 1,1,2, or exp: 1, 2, 4 ... 32, 32 ...")
    add(
        "--preset",
        choices=tuple(PRESETS),
        default="default",
        help="default: what measures best; paper: exactly the published text; released: the authors' program; diffvg: "
        "the paper's comparison, random paths in one stage; the options below change single points of it",
    )
    add("--iterations", type=_whole(1), metavar="N", help="iterations of each stage")
    add("--segments", type=_whole(1), metavar="N", help="cubic segments of each path")
    add("--max-segments", type=_whole(1), metavar="N", help="most segments of a path that is fitted to a region")
    add("--loss", choices=choices["loss"], help="pixel loss weighted near the outlines, or plain mean squared error")
    add("--xing-weight", type=_weight, metavar="X", help="weight of the loss against self-crossing")
    add(
        "--placement",
        choices=choices["placement"],
        help="where new paths start: on the regions that matter most, on the largest components of the error (the "
        "paper's rule), or anywhere (then as circles, unless --shape says otherwise)",
    )
    add("--shape", choices=choices["shape"], help="what new paths start as")
    add("--revisions", type=_whole(0), metavar="N", help="rounds at the end that place the least useful paths anew")
    add(
        "--background",
        type=_background,
        metavar="COLOR",
        help="a colour as white or #rrggbb; none: transparent; auto: the colour of the border; train to learn it; "
        "picture: none for a picture with alpha, white for others (default)",
    )
    add("--seed", type=_whole(0), default=0, metavar="N", help="seed of all random choices (default: 0)")
    add("--device", metavar="D", help="OpenCL device: its index or a part of its name (default: $LIVECL_DEVICE)")
    add("--threads", type=_whole(1), metavar="N", help="processor cores that PoCL may use (default: all)")
    add("--list-devices", action="store_true", help="list the OpenCL devices and exit")
    add("--stages", metavar="DIR", help="also write the drawing after each stage: DIR/stage-1.svg ...")
    add("--json", metavar="FILE", help="also write size, options, error and seconds as JSON")
    add("-q", "--quiet", action="store_true", help="show no progress and no summary")
    add("--version", action="version", version=f"livecl {__version__}")
    return parser


def _whole(least: int) -> Callable[[str], int]:
    def convert(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"got {text!r}, wanted a whole number of at least {least}")
        return value

    return convert


def _paths(text: str) -> int | str:
    return text if text == "auto" else _whole(1)(text)


def _weight(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise argparse.ArgumentTypeError(f"got {text!r}, wanted a number of at least 0")
    return value


def _background(text: str) -> str:
    from livecl.background import check_background

    try:
        check_background(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("background: ")) from error
    return text


def _list_devices() -> None:
    from livecl.device import list_devices

    devices = list_devices()
    if not devices:
        _check_device(None)
    for device in devices:
        print(device)  # noqa: T201


def _checked(arguments: argparse.Namespace) -> _Job:
    """Read the picture and check all else that is asked for, without touching a file."""
    missing = [name for name, value in (("IN", arguments.input), ("-o", arguments.output)) if not value]
    if missing:
        raise _BadInputError(f"nothing to do without {' and '.join(missing)}: livecl IN -o OUT.svg (see --help)")
    schedule = _checked_schedule(arguments)
    options = _checked_options(arguments)
    output = Path(arguments.output)
    stages = None if arguments.stages is None else Path(arguments.stages)
    report = None if arguments.json is None else Path(arguments.json)
    image = _checked_image(arguments.input)
    _check_outputs(Path(arguments.input), output, report, stages, len(schedule))
    _check_device(arguments.device)
    return _Job(
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
        raise _BadInputError(str(error)) from error


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
        raise _BadInputError(str(error)) from error


def _checked_image(path: str) -> Any:
    from livecl.drawing import empty_drawing
    from livecl.image import read_image

    try:
        image = read_image(path)
    except ImageError as error:
        raise _BadInputError(str(error)) from error
    try:
        empty_drawing(image.shape[:2])
    except ValueError as error:
        raise _BadInputError(f"{path}: {error}") from error
    return image


def _check_device(device: str | None) -> None:
    from livecl.device import choose_device

    try:
        choose_device(device)
    except DeviceError as error:
        raise _BadInputError(str(error)) from error


def _check_outputs(source: Path, output: Path, report: Path | None, stages: Path | None, num_stages: int) -> None:
    """Refuse what could not be written at the end, and what would overwrite the picture or another output."""
    files = [output] if report is None else [output, report]
    for file in files:
        _check_file(file)
    if stages is not None:
        if not stages.exists():
            _check_folder(stages.parent, stages)
        elif not stages.is_dir():
            raise _BadInputError(f"{stages}: is a file, wanted a folder for the stages")
        for index in range(num_stages if stages.exists() else 0):
            _check_file(_stage_path(stages, index))
        files += [_stage_path(stages, index) for index in range(num_stages)]
    places = [os.path.realpath(file) for file in files]
    for file, place in zip(files, places, strict=True):
        if file.exists() and file.samefile(source):
            raise _BadInputError(f"{file}: is the picture itself and would be overwritten")
        if places.count(place) > 1 and not file.is_char_device():
            raise _BadInputError(f"{file}: two outputs would go to this file")


def _check_file(file: Path) -> None:
    if file.is_dir():
        raise _BadInputError(f"{file}: is a folder, wanted a file to write")
    if not file.exists() or file.is_file():
        _check_folder(Path(os.path.realpath(file)).parent, file)


def _check_folder(folder: Path, wanted: Path) -> None:
    """Refuse a folder in which no file can be made; access rights alone do not tell (root, read-only disks)."""
    if not folder.exists():
        raise _BadInputError(f"{wanted}: the folder {folder} does not exist")
    if not folder.is_dir():
        raise _BadInputError(f"{wanted}: {folder} is not a folder")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _BadInputError(f"{wanted}: cannot write into {folder}: {error.strerror or error}") from error


def _stage_path(folder: Path, index: int) -> Path:
    return folder / f"stage-{index + 1}.svg"


def _work(job: _Job) -> None:
    from livecl.files import write_atomically
    from livecl.vectorizer import vectorize

    with _Progress(job) as progress:
        result = vectorize(
            job.image,
            schedule=job.schedule,
            options=job.options,
            device=job.device,
            seed=job.seed,
            on_step=progress.show,
        )
    if job.stages is not None:
        job.stages.mkdir(exist_ok=True)
        for index, stage in enumerate(result.stages):
            stage.drawing.save_svg(_stage_path(job.stages, index))
    result.save_svg(job.output)
    if job.json is not None:
        write_atomically(job.json, json.dumps(_report(job, result), indent=2, allow_nan=False) + "\n")
    if not job.quiet:
        _say(f"{job.output}: {result.drawing.num_layers} paths, MSE {result.mse:.3g}, {result.seconds:.1f} s")


def _report(job: _Job, result: Result) -> dict[str, Any]:
    """Return what ``--json`` writes; seconds are without compilation, which stands apart."""
    height, width = result.drawing.size
    return {
        "width": width,
        "height": height,
        "device": result.device,
        "version": __version__,
        "options": {**dataclasses.asdict(result.options), "schedule": list(job.schedule), "seed": job.seed},
        "paths": result.drawing.num_layers,
        "mse": result.mse,
        "seconds": result.seconds,
        "compile_seconds": result.compile_seconds,
        "stages": [
            {"paths": stage.paths, "mse": stage.mse, "iterations": stage.iterations, "seconds": stage.seconds}
            for stage in result.stages
        ],
    }


class _Progress:
    """A progress bar over all iterations of all stages; off when standard error is no terminal."""

    def __init__(self, job: _Job) -> None:
        from tqdm import tqdm

        width, height = shutil.get_terminal_size()  # a size also where the terminal has none
        self._bar: tqdm[NoReturn] = tqdm(
            total=(len(job.schedule) + job.options.revisions) * job.options.iterations,
            disable=True if job.quiet else None,
            unit="it",
            ncols=width - 1,
            nrows=height,
            leave=False,
        )
        self._num_stages = len(job.schedule)
        self._next_mse = 0.0
        self._mse = ""

    def __enter__(self) -> _Progress:
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


def _say(message: str) -> None:
    print(message, file=sys.stderr)  # noqa: T201


def _complain(message: str) -> None:
    _say(f"livecl: error: {message}")
