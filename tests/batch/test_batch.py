# SPDX-License-Identifier: Apache-2.0
"""Batches in worker processes: every picture arrives, once, as a single run makes it, whatever dies on the way."""

from __future__ import annotations

import csv
import dataclasses
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from support.batches import QUICK, SLOW, Deadly, NeverArriving, TellsThreads, make_pictures, single_runs, svgs

import livecl
from livecl.batch.batch import Batch, vectorize_files
from livecl.batch.pool import MAX_ATTEMPTS
from livecl.batch.summary import Outcome
from livecl.batch.worker import Request
from livecl.errors import DeviceError, LiveclError
from livecl.run.recipe import Recipe

ROOT = Path(__file__).resolve().parents[2]


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "summary.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_each_svg_is_that_of_a_single_run(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 3)
    seen: list[Outcome] = []
    outcomes = livecl.vectorize_files(
        tmp_path / "in", tmp_path / "out", recipe=QUICK, workers=2, on_outcome=seen.append
    )
    assert svgs(tmp_path / "out") == single_runs(files, QUICK)
    assert [outcome.file for outcome in outcomes] == [str(file) for file in files]
    assert sorted(seen, key=lambda outcome: outcome.file) == outcomes
    assert {outcome.status for outcome in outcomes} == {"done"}
    rows = table(tmp_path / "out")
    assert list(rows[0])[:7] == ["file", "output", "status", "paths", "mse", "seconds", "width"]
    for row, outcome in zip(rows, outcomes, strict=True):
        drawing = livecl.read_svg(tmp_path / "out" / row["output"])
        assert int(row["paths"]) == drawing.num_layers
        assert float(row["mse"]) == outcome.mse
        assert (row["status"], row["width"], row["height"], row["message"]) == ("done", "48", "48", "")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "picture-0.svg",
        "picture-1.svg",
        "picture-2.svg",
        "summary.csv",
    ]


def test_workers_have_one_thread_each(tmp_path: Path) -> None:
    from livecl.batch.pool import Task, work_locally
    from livecl.batch.worker import Request

    (file,) = make_pictures(tmp_path / "in", 1)
    work = Request(TellsThreads(**{field.name: getattr(QUICK, field.name) for field in dataclasses.fields(QUICK)}))
    ((_, answer),) = work_locally([Task(0, file.read_bytes(), "one")], work, workers=1)
    assert answer == "threads: 1"


def test_a_killed_worker_loses_no_picture(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    files = make_pictures(tmp_path / "in", 4)
    killed: list[int] = []

    def kill_all_once(_: Outcome) -> None:
        for process in [] if killed else multiprocessing.active_children():
            assert process.pid is not None
            process.kill()
            killed.append(process.pid)

    outcomes = vectorize_files(files, tmp_path / "out", recipe=SLOW, workers=2, on_outcome=kill_all_once)
    assert len(killed) == 2
    assert any("died (exit code -9); the picture is tried again" in record.getMessage() for record in caplog.records)
    assert [outcome.status for outcome in outcomes] == ["done"] * 4
    assert svgs(tmp_path / "out") == single_runs(files, SLOW)
    assert not multiprocessing.active_children()


def test_a_picture_that_kills_its_workers_is_given_up(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 3)
    deadly = Deadly(paths=QUICK.paths, options=QUICK.options)
    outcomes = vectorize_files(files, tmp_path / "out", recipe=deadly, workers=2)
    assert [outcome.status for outcome in outcomes] == ["failed", "done", "done"]
    assert outcomes[0].message == f"the worker process died {MAX_ATTEMPTS} times (exit code -9)"
    assert svgs(tmp_path / "out") == single_runs(files[1:], QUICK)


def test_workers_that_do_not_start(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 2)
    with pytest.raises(LiveclError, match=r"worker processes do not start \(exit code 3\); a script .*__main__"):
        vectorize_files(files, tmp_path / "out", recipe=NeverArriving(), workers=1)
    assert not multiprocessing.active_children()


def test_a_bad_picture_does_not_stop_the_others(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 2)
    bad = tmp_path / "in" / "a-bad.png"
    bad.write_bytes(files[0].read_bytes()[:60])
    outcomes = vectorize_files(tmp_path / "in", tmp_path / "out", recipe=QUICK, workers=1)
    assert [outcome.status for outcome in outcomes] == ["failed", "done", "done"]
    assert outcomes[0].message.startswith(f"{bad}: ") and "\n" not in outcomes[0].message
    assert svgs(tmp_path / "out") == single_runs(files, QUICK)
    row = table(tmp_path / "out")[0]
    assert (row["status"], row["message"]) == ("failed", outcomes[0].message)


def test_warnings_of_pictures_come_back(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (file,) = make_pictures(tmp_path / "in", 1)
    with Image.open(file) as image:
        image.save(file, icc_profile=b"no profile")
    (outcome,) = vectorize_files(file, tmp_path / "out", recipe=QUICK, workers=1)
    assert outcome.status == "done"
    messages = [record.getMessage() for record in caplog.records]
    assert messages == [f"{file}: its colour profile cannot be applied; colours are taken as sRGB"]


def test_what_is_done_is_skipped(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 2)
    out = tmp_path / "out"

    def statuses(recipe: Recipe = QUICK, **options: Any) -> list[str]:
        return [outcome.status for outcome in vectorize_files(files, out, recipe=recipe, workers=1, **options)]

    assert statuses() == ["done", "done"]
    first = table(out)
    assert statuses() == ["skipped", "skipped"]
    assert [{**row, "status": "done"} for row in table(out)] == first
    (out / "picture-0.svg").write_text("cut off")
    assert statuses() == ["done", "skipped"]
    (out / "picture-1.svg").unlink()
    assert statuses() == ["skipped", "done"]
    files[0].write_bytes(files[1].read_bytes())
    assert statuses() == ["done", "skipped"]
    assert statuses(dataclasses.replace(QUICK, seed=1)) == ["done", "done"]
    assert statuses(dataclasses.replace(QUICK, seed=1), skip_done=False) == ["done", "done"]
    (out / "summary.csv").unlink()
    assert statuses() == ["done", "done"]


def test_an_interruption_between_an_svg_and_its_row_loses_no_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def written_and_interrupted(path: Path, text: str) -> None:
        path.write_text(text, encoding="utf-8")
        raise KeyboardInterrupt

    make_pictures(tmp_path / "in", 1)
    monkeypatch.setattr("livecl.batch.batch.write_atomically", written_and_interrupted)
    with pytest.raises(KeyboardInterrupt):
        vectorize_files(tmp_path / "in", tmp_path / "out", recipe=QUICK, workers=1)
    assert [row["output"] for row in table(tmp_path / "out")] == ["picture-0.svg"]
    monkeypatch.undo()
    assert vectorize_files(tmp_path / "in", tmp_path / "out", recipe=QUICK, workers=1)[0].status == "skipped"


def test_the_table_keeps_what_other_batches_did(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 2)
    for file in files:
        vectorize_files(file, tmp_path / "out", recipe=QUICK, workers=1)
    assert [row["output"] for row in table(tmp_path / "out")] == ["picture-0.svg", "picture-1.svg"]
    outcomes = vectorize_files(files, tmp_path / "out", recipe=QUICK, workers=1)
    assert [outcome.status for outcome in outcomes] == ["skipped", "skipped"]


def test_a_damaged_table_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 2)
    vectorize_files(files, tmp_path / "out", recipe=QUICK, workers=1)
    summary = tmp_path / "out" / "summary.csv"
    summary.write_text(summary.read_text(encoding="utf-8")[:-100])
    outcomes = vectorize_files(files, tmp_path / "out", recipe=QUICK, workers=1)
    assert [outcome.status for outcome in outcomes] == ["skipped", "done"]


def test_refuses_before_any_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("livecl.batch.cluster.CONNECT_SECONDS", 0.5)
    files = make_pictures(tmp_path / "in", 1)
    out = tmp_path / "out"
    cases: list[tuple[dict[str, Any], type[Exception], str]] = [
        ({"workers": 0}, ValueError, "workers: got 0"),
        ({"threads": True}, ValueError, "threads: got True"),
        ({"inputs": tmp_path / "none.png"}, ValueError, ".*none.png: there is no such file"),
        ({"output_folder": files[0]}, ValueError, ".*is a file, wanted a folder"),
        ({"output_folder": tmp_path / "no" / "out"}, ValueError, ".*does not exist"),
        ({"device": "nothing-like-it"}, DeviceError, ".*nothing-like-it"),
        ({"scheduler": "tcp://127.0.0.1:9"}, ValueError, "scheduler: no Dask scheduler answers"),
    ]
    for changes, error, message in cases:
        arguments: dict[str, Any] = {"inputs": files, "output_folder": out, "recipe": QUICK, **changes}
        with pytest.raises(error, match=f"^{message}"):
            vectorize_files(**arguments)
        assert not out.exists()


def test_another_s_table_is_not_overwritten(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 1)
    (tmp_path / "summary.csv").write_text("sales,2024\n")
    with pytest.raises(ValueError, match=r"summary\.csv: is not the table of a batch and would be overwritten"):
        Batch(files, tmp_path, Request(QUICK))
    assert (tmp_path / "summary.csv").read_text(encoding="utf-8") == "sales,2024\n"


def test_an_svg_that_cannot_be_written_fails_alone(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 2)
    (tmp_path / "out" / "picture-0.svg").mkdir(parents=True)
    outcomes = vectorize_files(files, tmp_path / "out", recipe=QUICK, workers=1)
    assert [outcome.status for outcome in outcomes] == ["failed", "done"]
    assert "picture-0.svg: cannot be written" in outcomes[0].message


def test_a_script_without_main_guard_is_told(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 1)
    script = tmp_path / "script.py"
    script.write_text(
        f"import livecl\nlivecl.vectorize_files({str(files[0])!r}, {str(tmp_path / 'out')!r}, workers=1)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    assert "LiveclError: worker processes do not start" in done.stderr
