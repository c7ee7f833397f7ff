# SPDX-License-Identifier: Apache-2.0
"""Vectorize several pictures on the command line: their batch, its progress and its summary."""

from __future__ import annotations

from typing import TYPE_CHECKING

from livecl.cli.messages import complain, say
from livecl.cli.progress import BatchProgress
from livecl.cli.request import BatchJob

if TYPE_CHECKING:
    from livecl.batch.summary import Outcome


def run_batch(job: BatchJob) -> bool:
    """Vectorize pictures into a folder; return whether all are done."""
    with BatchProgress(len(job.batch.pictures), quiet=job.quiet) as progress:
        outcomes = job.batch.run(progress.show)
    failed = [outcome for outcome in outcomes if outcome.status == "failed"]
    for outcome in failed:
        complain(_named(outcome))
    if not job.quiet:
        reduced = sum(outcome.width != outcome.working_width for outcome in outcomes if outcome.status == "done")
        if reduced:
            size = job.batch.recipe.size
            say(f"{reduced} larger than {size} px, reduced to that size (--size full keeps all pixels)")
        counts = [(status, sum(outcome.status == status for outcome in outcomes)) for status in STATUS_WORDS]
        say(f"{job.folder}: " + ", ".join(f"{count} {STATUS_WORDS[status]}" for status, count in counts if count))
    return not failed


#: Words for the outcomes in the summary of a batch.
STATUS_WORDS = {"done": "done", "skipped": "done before", "failed": "failed"}


def _named(outcome: Outcome) -> str:
    """Return an outcome's message, which names the picture."""
    return outcome.message if outcome.file in outcome.message else f"{outcome.file}: {outcome.message}"
