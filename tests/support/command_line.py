# SPDX-License-Identifier: Apache-2.0
"""The command line within this process or as one of its own, for tests of what it writes and says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from livecl.cli import command as cli

ROOT = Path(__file__).resolve().parents[2]


#: Arguments of runs that take a moment.
SHORT = ["--paths", "2", "--iterations", "3"]


LIVECL = [sys.executable, "-m", "livecl"]


def run(*command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command of its own process, with the checkout on the path."""
    return subprocess.run(
        command,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return the line that the command line refuses arguments with."""
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(r"livecl: error: [^\n]+\n", captured.err), captured.err
    return captured.err
