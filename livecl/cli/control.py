# SPDX-License-Identifier: Apache-2.0
"""What watches over a run of the command line: its time limit, and its checkpoint, checked before the work."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from livecl.cli.outputs import STANDARD
from livecl.run.checkpoint import is_checkpoint
from livecl.run.control import Control


def control_of(arguments: argparse.Namespace) -> Control:
    """Return what watches over the run of one picture.

    Raises
    ------
    ValueError
        If it would overwrite what is no checkpoint, or is to go on from none.
    """
    path = _checkpoint(arguments)
    if path is None and arguments.resume:
        wanted = "leave out --no-checkpoint" if arguments.checkpoint is False else "name one with --checkpoint"
        raise ValueError(f"--resume: goes on from a checkpoint, and there is to be none; {wanted}")
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
    """Return the file that was named, or one beside the output, where that is a file."""
    if arguments.checkpoint is False:
        return None
    if arguments.checkpoint is not None:
        return Path(arguments.checkpoint)
    output = Path(arguments.output)
    if arguments.output == STANDARD or (output.exists() and not output.is_file()):
        return None
    return Path(f"{os.fspath(output)}.checkpoint")


def beginning(control: Control) -> str:
    """Return a line that says from where a run begins, where that may not be what was meant; else nothing."""
    if control.checkpoint is None or Path(control.checkpoint).exists() == control.resume:
        return ""
    if control.resume:
        return f"there is no {control.checkpoint} to go on from: the run begins anew"
    return f"{control.checkpoint} is of a run that was stopped: --resume would go on from it, this one begins anew"


def going_on(control: Control) -> str:
    """Return the part of a message that says how to go on; nothing where there is no checkpoint."""
    if control.checkpoint is None or not Path(control.checkpoint).exists():
        return ""
    return f"; --resume goes on from {control.checkpoint}"
