# SPDX-License-Identifier: Apache-2.0
"""The command line as a process of its own, for tests that stop or kill it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from livecl.image.reading import save_image
from support.runs import three_shapes

ROOT = Path(__file__).resolve().parents[2]
#: Longest time that is waited for something, s: never reached but where it does not come at all.
PATIENCE = 120
#: A run of a few seconds, in which each of many stages is placed, trained, closed and merged.
COMMAND = [
    "in.png",
    "-o",
    "out.svg",
    "--schedule",
    "1,1,1",
    "--iterations",
    "120",
    "--revisions",
    "6",
    "--placement",
    "region",
]
#: Outputs that are checked, beside the SVG.
OUTPUTS = ["--stages", "stages", "--json", "out.json"]


def make_picture(folder: Path) -> None:
    """Write the picture of three shapes, in.png."""
    save_image(folder / "in.png", three_shapes(64))


def start(folder: Path, *arguments: str, **streams: Any) -> subprocess.Popen[str]:
    """Start the command line in a folder."""
    return subprocess.Popen(
        [sys.executable, "-m", "livecl", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": ""},  # standard output as it usually is
        text=True,
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
    )


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Wait, and return the exit code and the text on standard error."""
    _, said = process.communicate(timeout=PATIENCE)
    return process.returncode, said


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until something is so."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def written(folder: Path) -> dict[str, Any]:
    """Return what a run has written, without what says how long it took."""
    found: dict[str, Any] = {"out.svg": (folder / "out.svg").read_bytes()}
    found |= {file.name: file.read_bytes() for file in (folder / "stages").glob("*.svg")}
    facts = json.loads((folder / "out.json").read_text(encoding="utf-8"))
    for part in (facts, *facts["stages"]):
        part.pop("seconds")
    facts.pop("compile_seconds")
    return {**found, "out.json": facts}
