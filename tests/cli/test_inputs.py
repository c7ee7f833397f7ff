# SPDX-License-Identifier: Apache-2.0
"""What the command line takes and gives: standard input and output, large pictures, drawings to start from, folders."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from support.batches import make_pictures, svgs

import livecl
from livecl.cli import command as cli
from livecl.image.reading import save_image

ROOT = Path(__file__).resolve().parents[2]
SHORT = ["--paths", "2", "--iterations", "3", "--revisions", "0"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with three pictures in the folder ``in``."""
    make_pictures(tmp_path / "in", 3)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def start(*arguments: str) -> subprocess.Popen[bytes]:
    """Start the command in a process group of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "livecl", *arguments],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def group_exists(number: int) -> bool:
    try:
        os.killpg(number, 0)
    except ProcessLookupError:
        return False
    return True


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return the line that the command line refuses arguments with."""
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(r"livecl: error: [^\n]+\n", captured.err), captured.err
    return captured.err


def test_standard_input_and_output(folder: Path) -> None:
    assert cli.main(["in/picture-0.png", "-o", "out.svg", *SHORT]) == 0
    process = start("-", "-o", "-", *SHORT)
    stdout, stderr = process.communicate(Path("in/picture-0.png").read_bytes(), timeout=120)
    assert process.returncode == 0
    assert stdout == Path("out.svg").read_bytes()
    assert re.fullmatch(rb"standard output: \d paths, MSE \S+, \S+ s\n", stderr)


def test_standard_input_that_is_no_picture(folder: Path) -> None:
    process = start("-", "-o", "-", *SHORT)
    stdout, stderr = process.communicate(b"", timeout=120)
    assert (process.returncode, stdout) == (2, b"")
    assert re.fullmatch(rb"livecl: error: <stdin>: the file is empty[^\n]+\n", stderr)


def test_large_pictures_are_worked_on_small(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    image = np.ones((60, 90, 3))
    image[20:40, 30:60] = 0.2
    save_image("large.png", image)
    arguments = ["large.png", "-o", "out.svg", "--json", "out.json", *SHORT]
    assert cli.main([*arguments, "--size", "30"]) == 0
    first, last = capsys.readouterr().err.splitlines()
    assert first == "large.png: 90x60 px, reduced to 36x24 px (--size full keeps all pixels)"
    assert re.fullmatch(r"out\.svg: \d paths, MSE \S+ at 36x24 px, \S+ s", last)
    assert livecl.read_svg("out.svg").size == (60, 90)
    report = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert [report[name] for name in ("width", "height", "working_width", "working_height")] == [90, 60, 36, 24]
    # The square is where it is in the picture: anywhere else, the error would be above that of a blank canvas.
    assert np.mean((livecl.render(livecl.read_svg("out.svg")) - image) ** 2) < np.mean((1 - image) ** 2) / 4
    for size in ("full", "0", "90"):
        assert cli.main([*arguments, "--size", size]) == 0
        assert len(capsys.readouterr().err.splitlines()) == 1


def test_precision_and_layers(folder: Path) -> None:
    arguments = ["in/picture-0.png", "-o", "out.svg", *SHORT]
    assert cli.main([*arguments, "--precision", "0"]) == 0
    anchors = livecl.read_svg("out.svg").points[:, 0]  # handles of straight sides lie at their thirds
    np.testing.assert_array_equal(anchors, np.round(anchors))
    assert "inkscape" in Path("out.svg").read_text(encoding="utf-8")
    assert cli.main([*arguments, "--layers", "plain"]) == 0
    assert "inkscape" not in Path("out.svg").read_text(encoding="utf-8")


def test_start_and_lock(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["in/picture-0.png", "-o", "start.svg", *SHORT, "--schedule", "1,1"]) == 0
    before = livecl.read_svg("start.svg")
    arguments = ["in/picture-1.png", "-o", "out.svg", "--start", "start.svg", "--iterations", "3", "--revisions", "0"]
    assert cli.main([*arguments, "--paths", "1", "--lock", "0", "--json", "out.json"]) == 0
    after = livecl.read_svg("out.svg")
    np.testing.assert_array_equal(after.layer_subset([0]).points, before.layer_subset([0]).points)
    assert json.loads(Path("out.json").read_text(encoding="utf-8"))["options"]["schedule"] == [0, 1]
    assert cli.main([*arguments, "--stages", "stages"]) == 0
    assert [file.name for file in Path("stages").iterdir()] == ["stage-1.svg"]
    assert livecl.read_svg("out.svg").num_layers == before.num_layers
    capsys.readouterr()
    save_image("wide.png", np.ones((20, 90, 3)))
    assert "start: a canvas of 48x48 px" in refusal(capsys, "wide.png", *arguments[1:])
    assert "nothing-like-it" in refusal(capsys, *arguments, "--lock", "nothing-like-it")
    assert "--lock: names layers of a drawing" in refusal(capsys, "in/picture-0.png", "-o", "out.svg", "--lock", "0")
    assert "none.svg" in refusal(capsys, "in/picture-0.png", "-o", "out.svg", "--start", "none.svg")


def test_verbose_tells_of_each_stage(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [
        "in/picture-0.png",
        "-o",
        "out.svg",
        "--schedule",
        "1,1",
        "--iterations",
        "3",
        "--revisions",
        "0",
        "--placement",
        "region",
    ]
    assert cli.main([*arguments, "-v"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert [re.sub(r"MSE \S+", "MSE", line) for line in lines[:2]] == [
        "livecl: stage 1/2: 1 paths, MSE",
        "livecl: stage 2/2: 2 paths, MSE",
    ]
    assert lines[2].startswith("out.svg: ")


def test_a_folder_gives_a_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("in/broken.png").write_text("no picture", encoding="utf-8")
    assert cli.main(["in", "-o", "out", *SHORT, "--workers", "1", "--size", "24"]) == 1
    assert capsys.readouterr().err.splitlines() == [
        "livecl: error: in/broken.png: not a picture of a kind that can be read; give a whole PNG, JPEG, GIF, WebP, "
        "TIFF or BMP file",
        "3 larger than 24 px, reduced to that size (--size full keeps all pixels)",
        "out: 3 done, 1 failed",
    ]
    assert sorted(svgs(Path("out"))) == ["picture-0", "picture-1", "picture-2"]
    assert cli.main(["in/picture-1.png", "-o", "one.svg", *SHORT, "--size", "24"]) == 0
    assert Path("one.svg").read_bytes() == Path("out/picture-1.svg").read_bytes()
    Path("in/broken.png").unlink()
    capsys.readouterr()
    assert cli.main(["in", "-o", "out", *SHORT, "--workers", "1", "--size", "24"]) == 0
    assert capsys.readouterr().err == "out: 3 done before\n"
    assert cli.main(["in/*-1.png", "-o", "out", *SHORT, "--workers", "1", "--size", "24", "--redo", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    with Path("out/summary.csv").open(encoding="utf-8", newline="") as file:
        assert [row["output"] for row in csv.DictReader(file)] == [f"picture-{index}.svg" for index in range(3)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("in in/picture-0.png missing.png -o out", "missing.png: there is no such file"),
        ("in -o missing/out", "does not exist"),
        ("in -o in/picture-0.png", "is a file, wanted a folder"),
        ("in -o -", "need a folder, not standard output"),
        ("in - -o out", "standard input is one picture"),
        ("in -o out --json out.json", "--json: goes with one picture"),
        ("in -o out --stages stages", "--stages: goes with one picture"),
        ("in -o out --workers 0", "--workers: got '0'"),
        ("in -o out --device nothing-like-it", "nothing-like-it"),
        ("in/picture-0.png -o out.svg --workers 2", "--workers: goes with several pictures"),
        ("in/picture-0.png -o out.svg --size -1", "--size: got '-1'"),
        ("in/picture-0.png -o out.svg --size 1", "--size: got '1', wanted a whole number of at least 16, or full"),
        ("in/picture-0.png -o out.svg --palette missing.gpl", "--palette: missing.gpl: there is no such file"),
        ("in/picture-0.png -o out.svg --palette in", "--palette: in: there is no such file"),
        ("in/picture-0.png -o out.svg --precision 10", "--precision"),
        ("in/picture-0.png -o out.svg --config none.toml", "none.toml: cannot be read"),
        ("empty -o out", "empty: the folder holds no pictures"),
        ("in/*.gif -o out", "the pattern matches no picture"),
    ],
)
def test_refusals(folder: Path, capsys: pytest.CaptureFixture[str], arguments: str, message: str) -> None:
    Path("empty").mkdir()
    before = sorted(folder.rglob("*"))
    assert message in refusal(capsys, *arguments.split())
    assert sorted(folder.rglob("*")) == before


def test_a_scheduler_that_does_not_answer(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("livecl.batch.cluster.CONNECT_SECONDS", 0.5)
    line = refusal(capsys, "in", "-o", "out", "--scheduler", "tcp://127.0.0.1:9")
    assert "scheduler: no Dask scheduler answers at 'tcp://127.0.0.1:9'" in line
    assert not Path("out").exists()


@pytest.mark.skipif(os.name != "posix", reason="needs signals to process groups")
def test_an_interrupted_batch_keeps_what_is_finished(folder: Path) -> None:
    save_image("in/zz-long.png", np.random.default_rng(0).random((200, 200, 3)))
    arguments = ["in", "-o", "out", "--paths", "2", "--iterations", "20000", "--revisions", "0", "--workers", "2"]
    for file in Path("in").glob("picture-*"):
        save_image(file, np.ones((1, 1, 3)) * 0.5)
    process = start(*arguments)
    while len(svgs(Path("out"))) < 1 and process.poll() is None:
        time.sleep(0.05)
    assert process.poll() is None
    os.killpg(process.pid, signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert (process.returncode, stdout) == (130, b"")
    assert stderr == b"livecl: error: interrupted; finished pictures are in out\n"
    finished = svgs(Path("out"))
    assert finished and "zz-long" not in finished
    with Path("out/summary.csv").open(encoding="utf-8", newline="") as file:
        assert {row["output"].removesuffix(".svg") for row in csv.DictReader(file)} == set(finished)
    deadline = time.monotonic() + 10  # for the helper process of multiprocessing, which ends after its parent
    while group_exists(process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not group_exists(process.pid)
