# SPDX-License-Identifier: Apache-2.0
"""The work that was asked for, its progress, and the lines that say what came of it."""

from __future__ import annotations

from livecl.batch_record import Outcome
from livecl.cli_messages import complain, say
from livecl.cli_outputs import STANDARD, Finished, write_svg
from livecl.cli_request import BatchJob, Job
from livecl.progress import BatchProgress, RunProgress
from livecl.scaling import working_size


def run_job(job: Job) -> None:
    """Vectorize a picture and write what is to be written."""
    height, width = job.image.shape[:2]
    smaller = working_size((height, width), job.recipe.size)
    if not job.quiet and smaller != (height, width):
        say(
            f"{job.name}: {width}x{height} px, worked on at {smaller[1]}x{smaller[0]} px "
            f"(--size full works on all pixels)"
        )
    with RunProgress(job.recipe.options.revisions, quiet=job.quiet) as progress:
        course = None
        if any(kind.shows_course for kind, _ in job.outputs):
            from livecl.course import Course

            course = Course(job.frame_step, on_step=progress.show)
        result = job.recipe.vectorize(job.image, job.device, course or progress.show)
    finished = Finished(job.name, job.image, job.recipe, result, job.command, course, job.device, job.quiet)
    write_svg(job.output, finished)
    for kind, path in job.outputs:
        kind.write(path, finished)
    if not job.quiet:
        name = "standard output" if job.output == STANDARD else job.output
        at = "" if smaller == (height, width) else f" at {smaller[1]}x{smaller[0]} px"
        say(f"{name}: {result.drawing.num_layers} paths, MSE {result.mse:.3g}{at}, {result.seconds:.1f} s")


def run_batch(job: BatchJob) -> bool:
    """Vectorize pictures into a folder; return whether all are there."""
    with BatchProgress(len(job.batch.pictures), quiet=job.quiet) as progress:
        outcomes = job.batch.run(progress.show)
    failed = [outcome for outcome in outcomes if outcome.status == "failed"]
    for outcome in failed:
        complain(_named(outcome))
    if not job.quiet:
        reduced = sum(outcome.width != outcome.working_width for outcome in outcomes if outcome.status == "done")
        if reduced:
            size = job.batch.recipe.size
            say(f"{reduced} larger than {size} px, worked on at that size (--size full works on all pixels)")
        counts = [(status, sum(outcome.status == status for outcome in outcomes)) for status in STATUS_WORDS]
        say(f"{job.folder}: " + ", ".join(f"{count} {STATUS_WORDS[status]}" for status, count in counts if count))
    return not failed


#: How the summary of a batch names what became of pictures.
STATUS_WORDS = {"done": "done", "skipped": "done before", "failed": "failed"}


def _named(outcome: Outcome) -> str:
    """Return an outcome's message, which names the picture."""
    return outcome.message if outcome.file in outcome.message else f"{outcome.file}: {outcome.message}"
