# SPDX-License-Identifier: Apache-2.0
"""The fuzzer: planted defects are found and made small, and a short search finds none that is real.

Bounds on the shrunk cases are not the smallest possible: which cases Hypothesis tries depends on its version, and on
constants of the modules that are loaded, so on the tests before.
"""

from __future__ import annotations

import dataclasses
import itertools
import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzz import KINDS, module_of
from fuzzing.search import Finding, Search
from fuzzing.worker import hunt, kind_of
from support.fuzz_trial import WAYS

from livecl import Drawing

TOOL = Path(__file__).resolve().parents[2] / "tools" / "fuzz.py"


@pytest.mark.slow
def test_what_goes_wrong_is_found() -> None:
    """Also where the worker does not live to tell: its place is taken by another."""
    counts, found = hunt("support.fuzz_trial", seed=1, cases=24)
    words = {
        "error": "ZeroDivisionError: planted",
        "abort": "worker ended with code -6; File",
        "loop": "TooLongError",
        "memory": "MemoryError",
        "sleep": "hangs in native code",
    }
    assert {one.case for one in found.values()} == set(words)
    for one in found.values():
        assert words[one.case] in one.what
    assert set(counts) <= set(WAYS) - set(words)


def smallest(name: str, check: Callable[[Any], str], most: int) -> list[Finding]:
    """Return what a search with another check finds, ordered by what went wrong."""
    search = Search(dataclasses.replace(kind_of(module_of(name)), check=check))
    search.run(seed=0, most=most)
    return sorted(search.found.values(), key=lambda one: one.what)


@pytest.mark.slow
def test_a_drawing_is_made_small() -> None:
    def check(case: dict[str, Any]) -> str:
        try:
            drawing = Drawing(**case)
        except ValueError:
            return "refused"
        if drawing.num_layers >= 2 and drawing.points[..., 0].max() >= 5:
            raise ZeroDivisionError("planted")
        return "taken"

    (found,) = smallest("drawings", check, 600)
    assert found.always and found.what == "ZeroDivisionError: planted"
    assert len(found.case["points"]) <= 4  # a segment or two a layer
    assert np.count_nonzero(found.case["points"]) <= 3


@pytest.mark.slow
def test_a_document_is_made_small() -> None:
    def check(data: bytes) -> str:
        if b"<circle" in data:
            raise ZeroDivisionError("planted")
        return "read"

    (found,) = smallest("svgs", check, 800)
    # How many elements there are is drawn before they are, so that Hypothesis does not always leave one out.
    _, *elements = re.findall(rb"<(\w+)([^>]*)>", found.case)
    assert len(elements) <= 10 and len(found.case) < 600, found.case  # each with a title; 190 bytes are the root's


def test_of_two_defects_each_has_its_case() -> None:
    def check(case: tuple[str, Any]) -> str:
        if case[0] == "Options":
            raise KeyError("planted")
        if case[0] == "command line" and len(case[1]) >= 3:
            raise ZeroDivisionError("planted")
        return "taken"

    found = smallest("options", check, 600)
    assert [one.what for one in found] == ["KeyError: 'planted'", "ZeroDivisionError: planted"]
    assert [one.case[0] for one in found] == ["Options", "command line"]
    assert len(found[0].case[1]) <= 3  # fields, of more than twenty
    assert len(found[1].case[1]) <= 6  # words


def test_a_second_defect_is_found_however_slow_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hypothesis looks no further than ten seconds after the first finding: here these are over at once."""
    clock = itertools.count(0, 100)
    monkeypatch.setattr("hypothesis.internal.conjecture.engine.time.monotonic", lambda: next(clock))

    def check(case: tuple[str, Any]) -> str:
        if case[0] in ("Options", "schedule"):
            raise KeyError(case[0]) if case[0] == "Options" else ZeroDivisionError(case[0])
        return "taken"

    assert [one.what for one in smallest("options", check, 100)] == [
        "KeyError: 'Options'",
        "ZeroDivisionError: schedule",
    ]


def test_what_goes_wrong_only_once_is_said_to() -> None:
    seen: list[bytes] = []

    def check(case: bytes) -> str:
        seen.append(case)
        if len(seen) == 7:
            raise ZeroDivisionError("planted")
        return "read"

    (found,) = smallest("svgs", check, 20)
    assert not found.always and found.case == seen[6]


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_tries_the_same(kind: str) -> None:
    tried: list[list[bytes]] = [[], []]
    for cases in tried:
        assert not smallest(kind, lambda case, cases=cases: cases.append(pickle.dumps(case)) or "read", 20)
    assert tried[0] == tried[1] and len(set(tried[0])) > 10


def test_without_hypothesis_the_extra_is_named() -> None:
    lines = (
        "import runpy, sys",
        "sys.modules['hypothesis'] = None",
        f"sys.argv = [{str(TOOL)!r}, '--kind', 'svgs']",
        f"sys.path.insert(0, {str(TOOL.parent)!r})",
        f"runpy.run_path({str(TOOL)!r}, run_name='__main__')",
    )
    done = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stderr.startswith("fuzz: error: "), done.stderr
    assert done.stderr.endswith("install the extra test: pip install -e '.[test]'\n")


def run(kind: str, cases: int, seed: int, folder: Path) -> None:
    command = [sys.executable, str(TOOL), "--kind", kind, "--cases", str(cases), "--seed", str(seed)]
    done = subprocess.run([*command, "--out", str(folder)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    line = re.compile(rf"(\w+): \d+ cases, seed {seed}, \d+ s: .+; findings at 0 places")
    matches = [line.fullmatch(text) for text in done.stdout.splitlines()]
    assert [match and match[1] for match in matches] == (list(KINDS) if kind == "all" else [kind]), done.stdout
    assert not folder.exists()


def test_a_short_search_finds_nothing(tmp_path: Path) -> None:
    run("all", 250, 20, tmp_path / "found")


@pytest.mark.full
@pytest.mark.parametrize(
    ("kind", "cases"), [("pictures", 6000), ("svgs", 6000), ("options", 4000), ("drawings", 2000), ("runs", 60)]
)
def test_a_long_search_finds_nothing(kind: str, cases: int, tmp_path: Path) -> None:
    run(kind, cases, 21, tmp_path / "found")


def test_a_kept_case_is_tried_again(tmp_path: Path) -> None:
    for kind, case, content in (
        ("svgs", "kept.svg", b"<svg"),
        ("options", "kept.pickle", pickle.dumps(("schedule", ("1,1", 2)))),
    ):
        file = tmp_path / case
        file.write_bytes(content)
        command = [sys.executable, str(TOOL), "--kind", kind, "--case", str(file)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert done.stdout.startswith("case: ") and done.stdout.splitlines()[-1] in ("refused", "schedule taken")
