# SPDX-License-Identifier: Apache-2.0
"""The golden set: numbers of fixed drawings and runs are what they were when they were last put down on purpose."""

from __future__ import annotations

from pathlib import Path

import pytest
import renew_golden
from support import golden_set

#: Largest folder of golden numbers, bytes.
MAX_BYTES = 100_000


@pytest.mark.slow
@pytest.mark.parametrize("kind", golden_set.KINDS)
def test_numbers_are_as_they_were(kind: str, device: int) -> None:
    found = golden_set.KINDS[kind](device)
    wanted = golden_set.stored()[kind]
    assert sorted(found) == sorted(wanted), "the set was changed: renew it (tools/renew_golden.py)"
    missed = golden_set.misses(kind, found, wanted)
    if missed:
        golden_set.write_got(kind, found)
    assert not missed, "\n".join([f"its numbers are in {golden_set.GOT}; tools/renew_golden.py says more", *missed])


def test_the_set_is_small() -> None:
    assert golden_set.FILE.stat().st_size < MAX_BYTES


def test_a_change_is_seen() -> None:
    wanted = golden_set.stored()
    for kind, names in wanted.items():
        assert golden_set.misses(kind, names, names) == []
    name = next(iter(wanted["renders"]))
    moved = {name: {**wanted["renders"][name], "d_points": wanted["renders"][name]["d_points"] * (1 + 1e-5)}}
    assert len(golden_set.misses("renders", moved, wanted["renders"])) == 1
    name = next(iter(wanted["beginnings"]))
    begun = wanted["beginnings"][name]
    assert len(golden_set.misses("beginnings", {name: {**begun, "layers": 1}}, wanted["beginnings"])) == 1
    losses = [*begun["losses"][:-1], begun["losses"][-1] * 1.001]
    assert len(golden_set.misses("beginnings", {name: {**begun, "losses": losses}}, wanted["beginnings"])) == 1
    name = next(iter(wanted["outcomes"]))
    worse = {name: {"mse": wanted["outcomes"][name]["most"] * 1.3}}
    assert len(golden_set.misses("outcomes", worse, wanted["outcomes"])) == 1
    assert golden_set.misses("renders", {name: {"mean": float("nan")}}, {name: {"mean": 1.0}})


def test_what_was_got_is_written_beside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(golden_set, "GOT", tmp_path / "got.json")
    golden_set.write_got("renders", {"a": {"mean": 1.0}})
    golden_set.write_got("outcomes", {"a": {"mse": 0.1}})
    assert '"renders"' in golden_set.GOT.read_text(encoding="utf-8") and '"outcomes"' in golden_set.GOT.read_text(
        encoding="utf-8"
    )


def test_the_command_writes_only_when_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = {"renders": lambda device=None: {"one": {"mean": 0.5}}}
    file = tmp_path / "golden.json"
    monkeypatch.setattr(golden_set, "KINDS", calls)
    monkeypatch.setattr(golden_set, "FILE", file)
    assert renew_golden.main([]) == 1
    assert not file.exists()
    assert renew_golden.main(["--write"]) == 0
    assert golden_set.stored() == {"renders": {"one": {"mean": 0.5}}}
    assert renew_golden.main([]) == 0
