# SPDX-License-Identifier: Apache-2.0
"""SIGKILL at random moments: the run goes on, ends with the same bytes, and no file is ever half of one.

``python tests/test_kills.py [kills] [seed]`` does the same with as many kills as are asked for, and prints figures.
"""

from __future__ import annotations

import dataclasses
import logging
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from support.commands import COMMAND, OUTPUTS, ended, make_picture, start, written

import livecl
from livecl.run.checkpoint import is_checkpoint

#: A checkpoint after each step: most kills hit one that is being written.
COMMAND = [*COMMAND, *OUTPUTS, "-q", "--checkpoint-period", "0", "--resume"]
#: Changes of it for a run of a second.
SHORT = ["--iterations", "40", "--revisions", "1"]
CHECKPOINT = "out.svg.checkpoint"

_log = logging.getLogger(__name__)


@dataclasses.dataclass
class Figures:
    """What happened: kills, those that left a temporary file (of a writing) and runs that went on from a checkpoint."""

    kills: int = 0
    in_writing: int = 0
    resumed: int = 0
    runs: int = 0


def run_with_kills(
    folder: Path, command: list[str], rng: np.random.Generator, most: float, left: int, figures: Figures
) -> int:
    """Start the command again and again, killing it after up to `most` s, `left` times at most, until it has ended.

    Returns
    -------
    int
        Kills.
    """
    old = livecl.Drawing(points=np.zeros((0, 3, 2)), colors=np.zeros((0, 4)), size=(64, 64))
    old.save_svg(folder / "out.svg")
    before = (folder / "out.svg").read_bytes()
    kills = 0
    while True:
        figures.resumed += (folder / CHECKPOINT).exists()
        leftovers = set(folder.glob(".livecl-*.tmp"))
        process = start(folder, *command)
        if kills < left:
            time.sleep(rng.uniform(0, most))
        if kills == left or process.poll() is not None:
            code, said = ended(process)
            assert (code, said) == (0, "")
            return kills
        process.kill()
        ended(process)
        kills += 1
        figures.in_writing += len(set(folder.glob(".livecl-*.tmp")) - leftovers)
        if (folder / CHECKPOINT).exists():
            assert is_checkpoint(folder / CHECKPOINT)
        now = (folder / "out.svg").read_bytes()
        assert now == before or livecl.read_svg(folder / "out.svg").num_layers > 0, "the old file, or a whole new one"


def check(folder: Path, kills: int, seed: int, command: list[str] = COMMAND) -> Figures:
    """Kill so often, in as many runs as that takes, and compare each with a run that was let be."""
    whole = folder / "whole"
    whole.mkdir()
    make_picture(whole)
    begin = time.monotonic()
    assert ended(start(whole, *command))[0] == 0
    most = 0.6 * (time.monotonic() - begin)
    rng, figures = np.random.default_rng(seed), Figures()
    while figures.kills < kills:
        killed = folder / f"run-{figures.runs}"
        killed.mkdir()
        make_picture(killed)
        figures.kills += run_with_kills(killed, command, rng, most, min(kills - figures.kills, 10), figures)
        figures.runs += 1
        assert written(killed) == written(whole)
        _log.info("%s", figures)
        # Leftovers of the checkpoint and the SVG are gone; those of other outputs would only lie there, hidden.
        assert {file.name for file in killed.iterdir() if not file.name.startswith(".livecl-")} == {
            *("in.png", "out.svg", "out.json", "stages")
        }
    return figures


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is POSIX's")
def test_a_run_that_is_killed_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    assert check(tmp_path, kills=2, seed=1, command=[*COMMAND, *SHORT]).kills == 2


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is POSIX's")
def test_sixty_kills(tmp_path: Path) -> None:
    figures = check(tmp_path, kills=60, seed=2)
    assert figures.kills == 60 and figures.resumed >= 20


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO)
    with tempfile.TemporaryDirectory() as made:
        asked = [int(word) for word in sys.argv[1:3]]
        check(Path(made), *asked, *(60, 2)[len(asked) :])
