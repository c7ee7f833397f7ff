# SPDX-License-Identifier: Apache-2.0
"""What the command line refuses, and how it says what went wrong."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import LIVECL, refusal, run

import livecl
from livecl.cli import command as cli
from livecl.cli.interrupts import Interrupted
from livecl.image.reading import save_image


def make_bad_inputs(folder: Path) -> None:
    """Put files that are no pictures, and folders, beside the picture."""
    picture = (folder / "in.png").read_bytes()
    (folder / "text.png").write_text("not a picture")
    (folder / "empty.png").write_bytes(b"")
    (folder / "drawing.svg").write_text("<?xml version='1.0'?>\n<!-- <b> -->\n<svg viewBox='0 0 2 2'/>")
    (folder / "cut.png").write_bytes(picture[: len(picture) // 2])
    (folder / "folder").mkdir()
    (folder / "link.png").symlink_to("in.png")
    os.link(folder / "in.png", folder / "hard.png")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("", "IN and -o"),
        ("in.png", "without -o"),
        ("-o out.svg", "without IN"),
        ("in.png -o ''", "-o/--output: got '', wanted a path"),
        ("'' -o out.svg", "IN: got '', wanted a path"),
        ("in.png '' -o svgs", "IN: got '', wanted a path"),
        *(
            (f"in.png -o out.svg {option} ''", f"{option}: got '', wanted a path")
            for option in ("--stages", "--json", "--start", "--masks", "--checkpoint", "--config")
        ),
        ("in.png -o out.svg --path 3", "--path 3; did you mean --paths?"),
        ("drawing.svg -o out.svg", "drawing.svg: is an SVG, a drawing and not a picture"),
        ("missing.png -o out.svg", "missing.png"),
        ("text.png -o out.svg", "text.png"),
        ("empty.png -o out.svg", "empty.png"),
        ("cut.png -o out.svg", "cut.png"),
        ("folder -o out.svg", "folder"),
        ("in.png -o missing/out.svg", "does not exist"),
        ("in.png -o text.png/out.svg", "is not a folder"),
        ("in.png -o folder", "is a folder"),
        ("in.png -o in.png", "would be overwritten"),
        ("in.png -o link.png", "would be overwritten"),
        ("in.png -o hard.png", "would be overwritten"),
        ("in.png -o out.svg --json missing/out.json", "does not exist"),
        ("in.png -o out.svg --json folder", "is a folder"),
        ("in.png -o out.svg --json in.png", "would be overwritten"),
        ("in.png -o out.svg --json out.svg", "two outputs"),
        ("in.png -o folder/stage-1.svg --stages folder", "two outputs"),
        ("in.png -o out.svg --stages missing/folder", "does not exist"),
        ("in.png -o out.svg --stages text.png", "is a file"),
        ("in.png -o out.svg --paths 0", "--paths: got '0'"),
        ("in.png -o out.svg --paths -3", "--paths: got '-3'"),
        ("in.png -o out.svg --paths 2.5", "--paths: got '2.5'"),
        ("in.png -o out.svg --segments 0", "--segments: got '0'"),
        ("in.png -o out.svg --segments -1", "--segments: got '-1'"),
        ("in.png -o out.svg --iterations 0", "--iterations: got '0'"),
        ("in.png -o out.svg --iterations -1", "--iterations: got '-1'"),
        ("in.png -o out.svg --max-segments 0", "--max-segments: got '0'"),
        ("in.png -o out.svg --revisions -1", "--revisions: got '-1'"),
        ("in.png -o out.svg --seed -1", "--seed: got '-1'"),
        ("in.png -o out.svg --xing-weight nan", "--xing-weight: got 'nan'"),
        ("in.png -o out.svg --xing-weight -1", "--xing-weight: got '-1'"),
        ("in.png -o out.svg --schedule 1,x", "schedule"),
        ("in.png -o out.svg --schedule 1,0", "schedule"),
        ("in.png -o out.svg --schedule ''", "schedule"),
        ("in.png -o out.svg --schedule 1,1 --paths 3", "schedule"),
        ("in.png -o out.svg --background #12", "--background"),
        ("in.png -o out.svg --background colour", "--background"),
        ("in.png -o out.svg --loss l1", "--loss"),
        ("in.png -o out.svg --preset best", "--preset"),
        ("in.png -o out.svg --device nothing-like-it", "nothing-like-it"),
        ("in.png -o out.svg --device 99", "99"),
        ("in.png -o out.svg --unknown", "--unknown"),
        ("in.png -o out.svg --path 3", "--path"),
    ],
)
def test_refusals(folder: Path, capsys: pytest.CaptureFixture[str], arguments: str, message: str) -> None:
    make_bad_inputs(folder)
    (folder / "out.svg").write_text("old")
    before = {file.name: file.is_dir() or file.read_bytes() for file in folder.iterdir()}
    words = ["" if word == "''" else word for word in arguments.split()]
    assert message in refusal(capsys, *words)
    assert {file.name: file.is_dir() or file.read_bytes() for file in folder.iterdir()} == before


def test_refuses_folder_without_write_access(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    locked = folder / "locked"
    locked.mkdir(mode=0o500)
    if os.access(locked, os.W_OK):  # root may write anywhere, but not into /proc
        locked = Path("/proc")
    assert "cannot write into" in refusal(capsys, "in.png", "-o", str(locked / "out.svg"))


def test_refuses_picture_wider_than_a_canvas(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_image("wide.png", np.zeros((1, 40000, 3)))
    assert "wide.png" in refusal(capsys, "wide.png", "-o", "out.svg")


def test_refuses_without_device(folder: Path) -> None:
    for arguments in (["in.png", "-o", "out.svg"], ["--list-devices"]):
        done = run(*LIVECL, *arguments, OCL_ICD_VENDORS=str(folder / "none"), LIVECL_DEVICE="")
        assert (done.returncode, done.stdout) == (2, "")
        assert re.fullmatch(r"livecl: error: no OpenCL device [^\n]+\n", done.stderr)
    assert not Path("out.svg").exists()


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (livecl.LiveclError("loss is not finite"), 1),
        (OSError("disk full"), 1),
        (MemoryError(), 1),
        (Interrupted(signal.SIGINT), 130),
        (Interrupted(signal.SIGTERM), 143),
    ],
)
def test_failure_while_working(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    code: int,
) -> None:
    def vectorize(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr("livecl.run.vectorization.vectorize_pixels", vectorize)
    Path("out.svg").write_text("old", encoding="utf-8")
    assert cli.main(["in.png", "-o", "out.svg"]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(r"livecl: error: [^\n]+\n", captured.err)
    assert Path("out.svg").read_text(encoding="utf-8") == "old"
