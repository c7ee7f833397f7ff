# SPDX-License-Identifier: Apache-2.0
"""Vectorize one picture on the command line: its run, its outputs, and a summary however the run ended."""

from __future__ import annotations

import dataclasses
import math
import tempfile
import time
from pathlib import Path

from livecl.cli.common import FAILED
from livecl.cli.hints import hint
from livecl.cli.interrupts import Interrupted, Interrupts
from livecl.cli.messages import complain, say
from livecl.cli.outputs import STANDARD, Finished, Output, write_svg
from livecl.cli.progress import RunProgress
from livecl.cli.request import Job, beginning, going_on
from livecl.errors import LiveclError
from livecl.files import remove_leftovers, write_atomically
from livecl.image.resizing import DETAIL_IS_LOST, detail_lost, working_size, working_size_of
from livecl.run.checkpoint import discard_checkpoint
from livecl.run.control import TIME_LIMIT
from livecl.run.result import Result, RunError

#: Outputs that take longer than this, seconds, are named in the summary.
SLOW_OUTPUT = 1.0


def run_job(job: Job, interrupts: Interrupts) -> int:
    """Vectorize a picture, write the outputs, and return the exit code.

    Until the SVG is written, a first signal ends the run cleanly and a second one aborts; afterwards, the first aborts.
    """
    if not job.quiet:
        _announce(job)
    with interrupts.waiting():
        finished, failure = _worked(job, interrupts)
        reason = str(failure) if finished is None else finished.result.stopped
        code = _exit_code(failure, reason, interrupts)
        if finished is None or (reason not in (None, TIME_LIMIT) and not finished.result.drawing.num_layers):
            complain(f"{reason}; there was no path yet, and nothing was written{going_on(job.control)}")
            return code or FAILED
        saved = _write_svg(job, finished)
    try:
        written, slow = [], []
        for kind, path in job.outputs:
            begin = time.monotonic()
            written.append(_write(kind, path, finished))
            if (seconds := time.monotonic() - begin) >= SLOW_OUTPUT:
                slow.append(f"{kind.name} {seconds:.1f} s")
    except Interrupted as interrupted:
        complain(f"{interrupted}; {job.output_name} is written, other outputs may be missing{going_on(job.control)}")
        return interrupted.exit_code
    if not saved:
        return code or FAILED
    if reason is None and all(written):
        _clean_up(job)
    line = "; ".join([_line(job, finished.result, reason), *slow])
    if code:
        complain(line)
    elif not job.quiet:
        say(line)
        if more := hint(job.recipe, finished.result, job.image):
            say(more)
    return code if all(written) else code or FAILED


def _announce(job: Job) -> None:
    """Warn about reduced size and restarts."""
    height, width = job.image.shape[:2]
    smaller = working_size_of(job.image, job.recipe.size)
    if smaller != (height, width):
        say(f"{job.name}: {width}x{height} px, reduced to {smaller[1]}x{smaller[0]} px (--size full keeps all pixels)")
        usual = working_size((height, width), job.recipe.size)
        if smaller == usual and detail_lost(job.image, smaller) > DETAIL_IS_LOST:  # the cells of pixel art are all kept
            say(f"{job.name}: fine detail, such as small print, is lost at that size; a larger --size keeps it")
    if line := beginning(job.control):
        say(line)
    elif job.control.resume and any(kind.shows_course for kind, _ in job.outputs):
        say("the film will begin where the run resumes")


def _worked(job: Job, interrupts: Interrupts) -> tuple[Finished | None, RunError | None]:
    """Run, and return the finished run and the failure; either may be None."""
    course, failure, result = None, None, None
    control = dataclasses.replace(job.control, stop=interrupts.reason)
    with RunProgress(quiet=job.quiet) as progress:
        if any(kind.shows_course for kind, _ in job.outputs):
            from livecl.views.course import Course

            course = Course(job.frame_step, on_step=progress)
        try:
            result = job.recipe.vectorize(job.image, job.device, course or progress, control)
        except RunError as error:
            result, failure = error.result, error
    if result is None:
        return None, failure
    return Finished(job.name, job.image, job.recipe, result, job.command, course, job.device, job.quiet), failure


def _exit_code(failure: RunError | None, reason: str | None, interrupts: Interrupts) -> int:
    if failure is not None:
        return FAILED
    if interrupts.pending is not None and reason == str(interrupts.pending):
        return interrupts.pending.exit_code
    return 0


def _write_svg(job: Job, finished: Finished) -> bool:
    """Write the SVG; if that fails, save it in a temporary folder, with a message."""
    try:
        write_svg(job.output, finished)
    except OSError as error:
        kept = f"{_rescue(job, finished)}{going_on(job.control)}"
        complain(f"{job.output_name}: cannot be written ({_why(error)}); {kept}")
        return False
    return True


def _rescue(job: Job, finished: Finished) -> str:
    """Write the SVG into a new temporary folder; return a message that says where it is."""
    name = "drawing.svg" if job.output == STANDARD else Path(job.output).name
    try:
        file = Path(tempfile.mkdtemp(prefix="livecl-")) / name
        write_atomically(file, finished.recipe.svg(finished.result.drawing))
    except OSError as error:
        return f"nor can it be in {tempfile.gettempdir()} ({_why(error)})"
    return f"the drawing is in {file}"


def _write(kind: Output, path: Path, finished: Finished) -> bool:
    """Write an output; if that fails, report it."""
    try:
        kind.write(path, finished)
    except OSError as error:
        complain(f"--{kind.name}: {path}: cannot be written ({_why(error)})")
        return False
    except (LiveclError, MemoryError, ArithmeticError, ValueError) as error:
        complain(f"--{kind.name}: {path}: {error or type(error).__name__}")
        return False
    return True


def _clean_up(job: Job) -> None:
    """Delete the checkpoint and leftover temporary files."""
    if job.output != STANDARD:
        remove_leftovers(job.output)
    if job.control.checkpoint is not None:
        discard_checkpoint(job.control.checkpoint)


def _line(job: Job, result: Result, reason: str | None) -> str:
    """Return the summary line."""
    error = "unknown" if math.isnan(result.mse) else f"{result.mse:.3g}"
    smaller = result.working_size
    at = "" if smaller in (None, result.drawing.size) else f" at {smaller[1]}x{smaller[0]} px"
    figures = f"{result.drawing.num_layers} paths, MSE {error}{at}, {result.seconds:.1f} s"
    if reason is None:
        return f"{job.output_name}: {figures}"
    best = "the best drawing so far" if result.drawing.num_layers else "no path yet, give it more time"
    return f"{reason}; {job.output_name} has {best}: {figures}{going_on(job.control)}"


def _why(error: OSError) -> str:
    return error.strerror or str(error)
