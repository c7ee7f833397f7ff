# SPDX-License-Identifier: Apache-2.0
"""The command line: arguments, files, progress and exit codes around :func:`livecl.vectorize`.

Everything that can be wrong with a request is found before the work starts: one line on standard error, exit code 2,
and no file touched. Exit code 1 is a failure while working, 130 an interruption.
"""

from __future__ import annotations

import dataclasses
import json
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from livecl import __version__
from livecl.cli_arguments import BadInputError, build_parser
from livecl.cli_outputs import stage_path
from livecl.cli_request import Job, check_device, checked
from livecl.errors import LiveclError
from livecl.progress import RunProgress

if TYPE_CHECKING:
    from livecl.result import Result

#: Exit codes, beside 0.
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


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
        job = checked(arguments)
    except BadInputError as error:
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


def _list_devices() -> None:
    from livecl.device import list_devices

    devices = list_devices()
    if not devices:
        check_device(None)
    for device in devices:
        print(device)  # noqa: T201


def _work(job: Job) -> None:
    from livecl.files import write_atomically
    from livecl.vectorizer import vectorize

    with RunProgress(len(job.schedule), job.options, quiet=job.quiet) as progress:
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
            stage.drawing.save_svg(stage_path(job.stages, index))
    result.save_svg(job.output)
    if job.json is not None:
        write_atomically(job.json, json.dumps(_report(job, result), indent=2, allow_nan=False) + "\n")
    if not job.quiet:
        _say(f"{job.output}: {result.drawing.num_layers} paths, MSE {result.mse:.3g}, {result.seconds:.1f} s")


def _report(job: Job, result: Result) -> dict[str, Any]:
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


def _say(message: str) -> None:
    print(message, file=sys.stderr)  # noqa: T201


def _complain(message: str) -> None:
    _say(f"livecl: error: {message}")
