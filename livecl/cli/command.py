# SPDX-License-Identifier: Apache-2.0
"""The command ``livecl``: arguments, checks, work, exit codes.

Errors in a request are found before the work starts: one line on standard error, exit code 2, and no file touched. Exit
code 1 is a failure while working, 130 and 143 are interruptions.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence

from livecl.cli.arguments import build_parser, parse_arguments
from livecl.cli.common import BAD_INPUT, FAILED
from livecl.cli.config import format_config
from livecl.cli.folder import run_batch
from livecl.cli.interrupts import Interrupted, Interrupts
from livecl.cli.messages import complain, messages, write_standard
from livecl.cli.picture import run_job
from livecl.cli.request import BatchJob, Job, checked, recipe_of, settings_of
from livecl.errors import CheckpointError, LiveclError

__all__ = ["build_parser", "main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name (default: those of the process).

    Returns
    -------
    int
        Exit code: 0 done, 1 failed while working, 2 bad arguments or input, 130 interrupted, 143 terminated.
    """
    try:
        arguments = parse_arguments(argv)
    except ValueError as error:
        complain(str(error))
        return BAD_INPUT
    except SystemExit:  # --help and --version have been printed
        if code := _tell(""):
            return code
        raise
    with messages(quiet=arguments.quiet, verbose=arguments.verbose), Interrupts() as interrupts:
        return _run(arguments, interrupts)


def _run(arguments: argparse.Namespace, interrupts: Interrupts) -> int:
    if arguments.threads is not None:  # PoCL reads it once, when OpenCL is first used
        os.environ["POCL_MAX_PTHREAD_COUNT"] = str(arguments.threads)
    try:
        if text := _information(arguments):
            return _tell(text)
        job = checked(arguments)
    except (ValueError, LiveclError, OSError, MemoryError) as error:
        complain(str(error) or type(error).__name__)
        return BAD_INPUT
    except Interrupted as interrupted:
        complain(str(interrupted))
        return interrupted.exit_code
    try:
        return _work(job, interrupts)
    except Interrupted as interrupted:
        complain(f"{interrupted}; {job.kept}")
        return interrupted.exit_code
    except CheckpointError as error:
        complain(str(error))
        return BAD_INPUT
    except (LiveclError, OSError, MemoryError, ArithmeticError) as error:
        complain(str(error) or type(error).__name__)
        return FAILED


def _tell(text: str) -> int:
    try:
        write_standard(text.encode())
    except OSError as error:
        complain(f"standard output: cannot be written ({error.strerror or error})")
        return FAILED
    return 0


def _information(arguments: argparse.Namespace) -> str:
    """Return the information requested instead of work (devices, options), else ""."""
    if arguments.show_options:
        return format_config(settings_of(recipe_of(arguments), arguments))
    if arguments.list_devices:
        from livecl.opencl.device import choose_device, list_devices

        devices = list_devices()
        if not devices:
            choose_device()  # says how to get one
        return "".join(f"{device}\n" for device in devices)
    return ""


def _work(job: Job | BatchJob, interrupts: Interrupts) -> int:
    if isinstance(job, Job):
        return run_job(job, interrupts)
    return 0 if run_batch(job) else FAILED
