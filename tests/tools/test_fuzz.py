# SPDX-License-Identifier: Apache-2.0
"""The fuzzer: finds what goes wrong, makes the same cases again, and finds nothing in a short run."""

from __future__ import annotations

import collections
import re
import subprocess
import sys
from pathlib import Path

import pytest
from fuzz import KINDS, module_of
from fuzzing.kind import source
from fuzzing.worker import Finding, kind_of, watched
from support.fuzz_trial import WAYS

TOOL = Path(__file__).resolve().parents[2] / "tools" / "fuzz.py"


@pytest.mark.slow
def test_what_goes_wrong_is_found() -> None:
    """Also where the worker does not live to tell: its place is taken by another, and no case is left out."""
    trial, numbers, seed = "fuzz_trial", range(9), 790  # a seed that gives each way
    cases = {number: kind_of(trial).make(source(trial, seed, number)) for number in numbers}
    assert set(cases.values()) == set(WAYS)
    findings, counts = {}, collections.Counter[str]()
    for report in watched(trial, seed, numbers):
        if isinstance(report, Finding):
            findings[report.number] = report.what
        else:
            counts += report
    words = {
        "error": "ZeroDivisionError: planted",
        "abort": "worker ended with code -6; File",
        "loop": "TooLongError",
        "memory": "MemoryError",
        "sleep": "hangs in native code",
    }
    assert set(findings) == {number for number, case in cases.items() if case in words}
    for number, what in findings.items():
        assert words[cases[number]] in what
    # Those that went well before a worker was lost are lost with it.
    assert set(counts) <= {"well", "refused"}


@pytest.mark.parametrize("kind", KINDS)
def test_cases_are_made_again(kind: str) -> None:
    module = module_of(kind)
    found = kind_of(module)
    for number in range(5):
        dumps = {found.dump(found.make(source(module, 3, number))) for _ in range(2)}
        assert len(dumps) == 1
    assert len({found.dump(found.make(source(module, 3, number))) for number in range(20)}) > 10


def run(kind: str, cases: int, seed: int, folder: Path) -> None:
    command = [sys.executable, str(TOOL), "--kind", kind, "--cases", str(cases)]
    done = subprocess.run(
        [*command, "--seed", str(seed), "--out", str(folder)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.fullmatch(rf"{kind}: {cases} cases, seed {seed}, \d+ s: .+; 0 findings at 0 places\n", done.stdout)
    assert not folder.exists()


@pytest.mark.parametrize(
    ("kind", "cases"), [("pictures", 250), ("svgs", 250), ("options", 150), ("drawings", 25), ("runs", 2)]
)
def test_a_short_run_finds_nothing(kind: str, cases: int, tmp_path: Path) -> None:
    run(kind, cases, 20, tmp_path / "found")


@pytest.mark.full
@pytest.mark.parametrize(
    ("kind", "cases"), [("pictures", 5000), ("svgs", 5000), ("options", 3000), ("drawings", 1000), ("runs", 50)]
)
def test_a_long_run_finds_nothing(kind: str, cases: int, tmp_path: Path) -> None:
    run(kind, cases, 21, tmp_path / "found")
