# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C, SIGTERM and the time limit: the best drawing is written, and the exit code says what happened."""

from __future__ import annotations

import itertools
import json
import os
import re
import signal
import subprocess
import sys
import types
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pyopencl as cl
import pytest
from support.batches import make_pictures
from support.commands import COMMAND, OUTPUTS, ended, make_picture, start, wait_for, written
from support.device_work import opencl_error

import livecl
from livecl import Options, Recipe, vectorize_files
from livecl.batch.pool import Task
from livecl.batch.worker import Request, make
from livecl.cli import command as cli
from livecl.cli.interrupts import Interrupted, Interrupts
from livecl.opencl.launcher import Launcher
from livecl.run.run import Run

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")

CHECKPOINT = Path("out.svg.checkpoint")
#: A run that does not end by itself, of which there soon is a checkpoint.
ENDLESS = ["in.png", "-o", "out.svg", "--schedule", "1,1", "--iterations", "1000000", "--checkpoint-period", "0"]
SHORT = ["in.png", "-o", "out.svg", "--paths", "2", "--iterations", "20", "--revisions", "1", "--placement", "region"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    make_picture(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_run_with_the_best_drawing(number: signal.Signals, code: int, folder: Path) -> None:
    process = start(folder, *ENDLESS, "--report", "out.html", *OUTPUTS)
    wait_for(CHECKPOINT.exists)
    process.send_signal(number)
    exit_code, said = ended(process)
    reason = {130: "interrupted", 143: "terminated"}[code]
    assert exit_code == code
    assert said.startswith(f"livecl: error: {reason}; out.svg has the best drawing so far: 1 paths, MSE 0.")
    assert said.endswith(" s; --resume continues from out.svg.checkpoint\n") and said.count("\n") == 1
    facts = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert facts["stopped"] == reason and facts["paths"] == 1 and facts["stages"][0]["iterations"] > 0
    assert livecl.read_svg("out.svg").num_layers == livecl.read_svg("stages/stage-1.svg").num_layers == 1
    assert "</html>" in Path("out.html").read_text(encoding="utf-8")
    assert CHECKPOINT.exists() and not list(folder.glob(".livecl-*"))


@pytest.mark.slow
def test_a_run_that_was_interrupted_goes_on_to_the_same_bytes(folder: Path) -> None:
    command = [*COMMAND, *OUTPUTS, "--iterations", "50", "--revisions", "1", "-q"]
    assert cli.main(command) == 0
    whole = written(folder)
    assert not CHECKPOINT.exists()
    process = start(folder, *command, "--checkpoint-period", "0")
    wait_for(CHECKPOINT.exists)
    process.send_signal(signal.SIGTERM)
    assert ended(process)[0] == 143
    assert written(folder)["out.svg"] != whole["out.svg"]
    assert cli.main([*command, "--resume"]) == 0
    assert written(folder) == whole
    assert not CHECKPOINT.exists()


@pytest.mark.slow
def test_a_batch_that_is_terminated_keeps_what_is_finished(folder: Path) -> None:
    make_pictures(folder / "pictures", 3)
    process = start(folder, "pictures", "-o", "svgs", "--workers", "1", "--paths", "2", "--iterations", "400")
    wait_for(lambda: bool(list(folder.glob("svgs/*.svg"))))
    process.send_signal(signal.SIGTERM)
    code, said = ended(process)
    assert code == 143
    assert "livecl: error: terminated; finished pictures are in svgs" in said and "Traceback" not in said
    done = {file.name for file in folder.glob("svgs/*.svg")}
    assert all(name in Path("svgs/summary.csv").read_text(encoding="utf-8") for name in done)


@pytest.fixture
def slow_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that only goes on, by a quarter of a second, when a time limit is looked at: no test has real time."""
    monkeypatch.setattr("livecl.run.control.time", types.SimpleNamespace(monotonic=itertools.count(0, 0.25).__next__))


@pytest.mark.usefixtures("slow_clock")
def test_the_time_limit(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [*ENDLESS[:-2], "--time-limit", "100", "--json", "out.json"]
    assert cli.main(command) == 0
    said = capsys.readouterr().err
    assert said.startswith("time limit; out.svg has the best drawing so far: 1 paths, MSE 0.")
    assert said.endswith("; --resume continues from out.svg.checkpoint\n")
    assert json.loads(Path("out.json").read_text(encoding="utf-8"))["stopped"] == "time limit"
    assert livecl.read_svg("out.svg").num_layers == 1
    assert cli.main([*command, "-q", "--no-checkpoint"]) == 0
    assert capsys.readouterr().err == ""


def test_a_time_limit_before_there_is_a_path(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The background is the best drawing so far."""
    assert cli.main([*SHORT, "--time-limit", "0", "--json", "out.json"]) == 0
    said = capsys.readouterr().err
    assert said.startswith("time limit; out.svg has no path yet, give it more time: 0 paths, MSE 0.")
    facts = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert facts["stopped"] == "time limit" and 0 < facts["mse"] < 1
    drawing = livecl.read_svg("out.svg")
    assert drawing.num_layers == 0 and drawing.size == livecl.read_image("in.png").shape[:2]


@pytest.mark.usefixtures("slow_clock")
def test_the_time_limit_of_a_batch_is_that_of_each_picture(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def work_here(tasks: Iterable[Task], work: Request, **_: Any) -> Iterator[tuple[int, Any]]:
        for task in tasks:
            yield task.number, make(task.data, task.name, work)

    monkeypatch.setattr("livecl.batch.batch.work_locally", work_here)
    files, recipe = (
        make_pictures(folder / "pictures", 2),
        Recipe(options=Options(iterations=1_000_000, placement="region")),
    )

    def made(limit: float) -> list[tuple[str, str]]:
        outcomes = vectorize_files(files, "svgs", recipe=recipe, time_limit=limit)
        return [(outcome.status, outcome.message) for outcome in outcomes]

    assert made(100) == [("done", "time limit")] * 2
    assert made(100) == [("skipped", "time limit")] * 2, "done, for this limit"
    assert made(101) == [("done", "time limit")] * 2, "and made again for another"
    assert all(livecl.read_svg(file).num_layers for file in Path("svgs").glob("*.svg"))
    assert made(0) == [("done", "time limit")] * 2
    assert not any(livecl.read_svg(file).num_layers for file in Path("svgs").glob("*.svg"))


@pytest.mark.usefixtures("slow_clock")
def test_resuming(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*SHORT, "--resume"]) == 0
    assert "there is no out.svg.checkpoint to resume from: the run starts anew\n" in capsys.readouterr().err
    assert cli.main([*SHORT, "--time-limit", "50", "-q"]) == 0
    capsys.readouterr()
    before = CHECKPOINT.read_bytes()
    assert cli.main([*SHORT, "--resume", "--seed", "3"]) == 2
    assert capsys.readouterr().err == (
        "livecl: error: out.svg.checkpoint: is a checkpoint of another run: seed was 0, is 3\n"
    )
    assert CHECKPOINT.read_bytes() == before
    assert cli.main(SHORT) == 0
    assert "out.svg.checkpoint is of a run that was stopped: --resume would continue it" in capsys.readouterr().err
    assert cli.main([*SHORT, "--time-limit", "50", "--checkpoint", "mine", "-q"]) == 0
    assert cli.main([*SHORT, "--checkpoint", "mine", "--resume", "-q"]) == 0
    assert sorted(file.name for file in folder.iterdir()) == ["in.png", "out.svg"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--checkpoint", "in.png"], "in.png: is no checkpoint that can be read, and would be overwritten"),
        (["--checkpoint", "in.png", "--resume"], "in.png: is the picture itself"),
        (["--checkpoint", "out.svg"], "out.svg: two outputs would go to this file"),
        (["--checkpoint", "no/file"], "no/file: the folder "),
        (["--checkpoint", "cut"], "cut: is no checkpoint that can be read, and would be overwritten"),
        (["--checkpoint", "cut", "--resume"], "cut: is no checkpoint that can be read: "),
        (["--resume", "--no-checkpoint"], "--resume: needs a checkpoint; leave out --no-checkpoint"),
        (["-o", "-", "--resume"], "--resume: needs a checkpoint; name one with --checkpoint"),
        (["--time-limit", "-1"], "--time-limit: got '-1', wanted a number of seconds"),
        (["--time-limit", "inf"], "--time-limit: got 'inf'"),
        (["--checkpoint-period", "often"], "--checkpoint-period: got 'often'"),
        (["in.png", "--resume"], "--resume: goes with one picture"),
        (["in.png", "--checkpoint", "file"], "--checkpoint: goes with one picture"),
    ],
)
@pytest.mark.usefixtures("slow_clock")
def test_refusals(arguments: list[str], message: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*SHORT, "--time-limit", "50", "--checkpoint", "cut", "-q"]) == 0
    Path("out.svg").unlink()
    capsys.readouterr()
    Path("cut").write_bytes(Path("cut").read_bytes()[:-9])
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    command = [*SHORT, *arguments] if arguments[0] != "in.png" else ["in.png", "in.png", "-o", "svgs", *arguments[1:]]
    assert cli.main(command) == 2
    assert message in capsys.readouterr().err
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before


class TestInterrupts:
    """The handlers by themselves."""

    def test_the_first_waits_and_the_second_does_not(self) -> None:
        with Interrupts() as interrupts:
            assert interrupts.reason() is None
            with interrupts.waiting():
                signal.raise_signal(signal.SIGTERM)
                assert interrupts.reason() == "terminated"
                with pytest.raises(Interrupted) as caught:
                    signal.raise_signal(signal.SIGINT)
            assert caught.value.exit_code == 130
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL, "a third ends the process"

    def test_without_waiting_the_first_ends_at_once(self) -> None:
        with Interrupts() as interrupts:
            with interrupts.waiting():
                pass
            with pytest.raises(KeyboardInterrupt, match="terminated"):
                signal.raise_signal(signal.SIGTERM)

    def test_handlers_are_given_back(self) -> None:
        def mine(*_: Any) -> None:
            pass

        before = signal.signal(signal.SIGTERM, mine)
        try:
            with Interrupts():
                assert signal.getsignal(signal.SIGTERM) is not mine
            assert signal.getsignal(signal.SIGTERM) is mine
        finally:
            signal.signal(signal.SIGTERM, before)

    def test_what_is_ignored_stays_ignored(self) -> None:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as of a job that a shell has put in the background
        try:
            with Interrupts() as interrupts, interrupts.waiting():
                signal.raise_signal(signal.SIGINT)
                assert interrupts.reason() is None
        finally:
            signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(("step", "known"), [(3, False), (30, True)])
def test_a_device_that_fails(
    step: int, known: bool, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([*SHORT, "-q"]) == 0
    whole = Path("out.svg").read_bytes()
    launch, work, steps = Launcher.__call__, Run.step, itertools.count(1)

    def fail(*_: Any) -> None:
        raise opencl_error(cl.RuntimeError, cl.status_code.INVALID_COMMAND_QUEUE)

    def work_until(run_: Run) -> float:
        if next(steps) == step:
            monkeypatch.setattr(Launcher, "__call__", fail)
        return work(run_)

    monkeypatch.setattr(Run, "step", work_until)
    assert cli.main([*SHORT, "-q", "--json", "out.json", "--sheet", "out.png"]) == 1
    last, *lines = capsys.readouterr().err.splitlines()[::-1]
    assert re.match(r"livecl: error: .* failed: clEnqueueNDRangeKernel failed: INVALID_COMMAND_QUEUE; out\.svg ", last)
    error = "0." if known else "unknown, "
    assert f"has the best drawing so far: 1 paths, MSE {error}" in last
    assert last.endswith("; --resume continues from out.svg.checkpoint")
    assert lines[0].startswith("livecl: error: --sheet: out.png: "), "it is rendered"
    facts = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert "INVALID_COMMAND_QUEUE" in facts["stopped"] and (facts["mse"] is not None) == known
    assert livecl.read_svg("out.svg").num_layers == 1
    monkeypatch.setattr(Launcher, "__call__", launch)
    assert cli.main([*SHORT, "-q", "--resume"]) == 0
    assert Path("out.svg").read_bytes() == whole


def raising(number: signal.Signals) -> Callable[..., None]:
    def raise_(*_: Any, **__: Any) -> None:
        signal.raise_signal(number)

    return raise_


def test_a_second_signal_while_outputs_are_written(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("livecl.views.report.page.write_report", raising(signal.SIGINT))
    assert cli.main([*SHORT, "-q", "--report", "out.html"]) == 130
    assert capsys.readouterr().err == "livecl: error: interrupted; out.svg is written, other outputs may be missing\n"
    assert livecl.read_svg("out.svg").num_layers


def test_a_signal_while_the_picture_is_read(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("livecl.cli.request.read_image", raising(signal.SIGTERM))
    assert cli.main(SHORT) == 143
    assert capsys.readouterr().err == "livecl: error: terminated\n"


def test_two_signals_in_the_run_end_it_at_once(folder: Path) -> None:
    script = (
        "import signal, sys\nfrom livecl.cli import command as cli\nfrom livecl.run import loop\n"
        "def step(*_):\n    signal.raise_signal(signal.SIGINT)\n    signal.raise_signal(signal.SIGINT)\n"
        "loop.Run.step = step\nsys.exit(cli.main(sys.argv[1:]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *SHORT],
        env={**os.environ, "PYTHONPATH": str(Path(livecl.__file__).parents[1])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (130, "livecl: error: interrupted; nothing was written\n")
    assert not Path("out.svg").exists()
