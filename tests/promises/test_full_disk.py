# SPDX-License-Identifier: Apache-2.0
"""Full disks, folders that cannot be written to, readers that have gone: neither drawing nor old file is lost."""

from __future__ import annotations

import errno
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.commands import PATIENCE, ROOT, ended, make_picture, start

from livecl import files
from livecl.cli import command as cli
from livecl.run.run import Run

COMMAND = ["in.png", "-o", "out.svg", "--paths", "2", "--iterations", "20", "--revisions", "1"]
SAVED = ["--checkpoint-period", "0"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    make_picture(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rescued").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "rescued"))
    return tmp_path


def no_space(*_: Any, **__: Any) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_an_svg_that_cannot_be_written_is_saved_elsewhere_and_written_later(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([*COMMAND, "-q"]) == 0
    whole = Path("out.svg").read_bytes()
    Path("out.svg").write_text("old", encoding="utf-8")
    with monkeypatch.context() as full:
        full.setattr("livecl.cli.outputs.write_atomically", no_space)
        assert cli.main([*COMMAND, *SAVED, "--json", "out.json", "-q"]) == 1
    said = capsys.readouterr().err
    saved = re.search(
        r"^livecl: error: out\.svg: cannot be written \(No space left on device\); the drawing is in (\S+out\.svg); "
        r"--resume continues from out\.svg\.checkpoint$",
        said,
        re.MULTILINE,
    )
    assert saved, said
    assert "livecl: error: --json: out.json: cannot be written (No space left on device)\n" in said
    assert Path(saved[1]).read_bytes() == whole and Path("out.svg").read_text(encoding="utf-8") == "old"

    def step(run_: Run) -> None:
        raise AssertionError("there is nothing left to do")

    monkeypatch.setattr(Run, "step", step)
    assert cli.main([*COMMAND, "--resume", "-q"]) == 0
    assert Path("out.svg").read_bytes() == whole
    assert not Path("out.svg.checkpoint").exists()


def test_another_output_that_cannot_be_written_leaves_the_rest(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("livecl.views.report.page.write_report", no_space)
    assert cli.main([*COMMAND, *SAVED, "-q", "--report", "out.html", "--sheet", "out.png"]) == 1
    assert capsys.readouterr().err.splitlines()[0] == (
        "livecl: error: --report: out.html: cannot be written (No space left on device)"
    )
    assert Path("out.svg").exists() and Path("out.png").exists() and Path("out.svg.checkpoint").exists()


def test_a_checkpoint_that_cannot_be_written_is_one_warning(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("livecl.training.archive.write_atomically", no_space)
    assert cli.main([*COMMAND, *SAVED]) == 0
    said = capsys.readouterr().err
    assert said.count("warning") == 1
    assert said.startswith("livecl: warning: out.svg.checkpoint: cannot be written (No space left on device); the run ")
    assert sorted(file.name for file in folder.iterdir()) == ["in.png", "out.svg", "rescued"]


def test_a_full_disk_is_found_before_the_work(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Full:
        def __enter__(self) -> Full:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        write = staticmethod(no_space)

    monkeypatch.setattr(files.tempfile, "TemporaryFile", lambda **_: Full())
    assert cli.main(COMMAND) == 2
    assert re.search(r"out\.svg: cannot write into .*: No space left on device\n$", capsys.readouterr().err)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_standard_output_that_is_full(folder: Path) -> None:
    with Path("/dev/full").open("wb") as full:
        code, said = ended(start(folder, "in.png", "-o", "-", *COMMAND[3:], "-q", stdout=full))
    assert code == 1
    assert re.fullmatch(
        r"livecl: error: standard output: cannot be written \(No space left on device\); the drawing is in \S+\.svg\n",
        said,
    )
    saved = Path(said.split()[-1])
    assert saved.read_text(encoding="utf-8").rstrip().endswith("</svg>")
    saved.unlink()
    saved.parent.rmdir()


@pytest.mark.skipif(os.name != "posix", reason="pipes are POSIX's")
@pytest.mark.parametrize("command", [["--list-devices"], ["--version"], ["in.png", "-o", "-", *COMMAND[3:], "-q"]])
def test_a_reader_that_has_gone_is_no_traceback(command: list[str], folder: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    process = start(folder, *command, stdout=writing)
    os.close(writing)
    code, said = ended(process)
    assert code == 1
    assert re.fullmatch(r"livecl: error: standard output: cannot be written \(Broken pipe\)[^\n]*\n", said), said


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 256 KiB."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", place], check=False).returncode == 0
    if not mounted:
        pytest.skip("needs the right to mount a small disk")
    try:
        yield place
    finally:
        subprocess.run(["umount", place], check=True)


@pytest.mark.full
def test_a_disk_that_fills_up_while_the_run_is_under_way(small_disk: Path, tmp_path: Path) -> None:
    make_picture(tmp_path)
    whole, out = tmp_path / "whole.svg", small_disk / "out.svg"
    command = ["in.png", *COMMAND[3:], "-q"]
    assert ended(start(tmp_path, *command, "-o", str(whole)))[0] == 0
    out.write_text("old")
    fill = "import os, sys; from livecl import cli; from livecl.run.run import Run\n"
    fill += "begin = Run.begin\ndef full(*arguments):\n"
    fill += f"    open({str(small_disk / 'filling')!r}, 'wb', buffering=0).write(bytes(1 << 20))\n"
    fill += "    return begin(*arguments)\nRun.begin = full\nsys.exit(cli.main(sys.argv[1:]))\n"
    process = subprocess.run(
        [sys.executable, "-c", fill, *command, "-o", str(out), *SAVED],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert process.returncode == 1
    assert "Traceback" not in process.stderr and "cannot be written (No space left on device)" in process.stderr
    (saved,) = re.findall(r"the drawing is in (\S+\.svg)", process.stderr)
    assert Path(saved).read_bytes() == whole.read_bytes() and out.read_text(encoding="utf-8") == "old"
    code, said = ended(start(tmp_path, *command, "-o", str(out)))
    assert code == 2 and "No space left on device" in said, "found before the work"
    (small_disk / "filling").unlink()
    assert ended(start(tmp_path, *command, "-o", str(out), "--resume"))[0] == 0
    assert out.read_bytes() == whole.read_bytes()
