# SPDX-License-Identifier: Apache-2.0
"""What the command line writes beside the SVG: report, sheet, plot, films; and what it refuses before the work."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from livecl.cli import command as cli
from livecl.cli.progress import OutputProgress
from livecl.image.reading import save_image
from livecl.rendering.rasterizer import Rasterizer

SHORT = ["in.png", "-o", "out.svg", "--paths", "2", "--iterations", "6", "--revisions", "0", "-q"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    image = np.ones((24, 30, 3))
    image[5:18, 4:20] = (0.9, 0.2, 0.1)
    image[9:14, 14:27] = (0.1, 0.2, 0.8)
    save_image("in.png", image)
    return tmp_path


def test_the_summary_names_outputs_that_took_long(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("livecl.cli.picture.SLOW_OUTPUT", 0.0)
    arguments = ["in.png", "-o", "out.svg", "--paths", "1", "--iterations", "2", "--revisions", "0"]
    assert cli.main([*arguments, "--json", "out.json", "--sheet", "out.png"]) == 0
    summary = r"^out\.svg: 1 paths, MSE \S+, \S+ s(; (json|sheet) \d+\.\d s){2}$"
    assert re.search(summary, capsys.readouterr().err, re.MULTILINE)


def test_all_are_written(folder: Path) -> None:
    outputs = ["--report", "r.html", "--sheet", "s.png", "--gif", "g.gif", "--frame-step", "3", "--plot", "p.svg"]
    assert cli.main([*SHORT, *outputs, "--mp4", "m.mp4"]) == 0
    page = Path("r.html").read_text(encoding="utf-8")
    assert "in.png" in page
    assert "--frame-step" in page  # the command to repeat it
    with Image.open("s.png") as sheet:
        assert sheet.width > 2 * 30
    with Image.open("g.gif") as film:
        # Steps 1, 3 and 6 of both stages, and the result; pictures that are equal are one.
        assert 3 <= getattr(film, "n_frames", 1) <= 7
    assert "<svg" in Path("p.svg").read_text(encoding="utf-8")
    assert Path("m.mp4").read_bytes()[4:8] == b"ftyp"


def test_all_are_rendered_on_the_device_asked_for(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    create = Rasterizer.__init__

    def created(rasterizer: Rasterizer, size: tuple[int, int], device: object = None, **keywords: Any) -> None:
        asked.append(device)
        create(rasterizer, size, 0, **keywords)

    monkeypatch.setattr(Rasterizer, "__init__", created)
    outputs = ["--report", "r.html", "--sheet", "s.png", "--gif", "g.gif", "--mp4", "m.mp4", "--stages", "stages"]
    assert cli.main([*SHORT, *outputs, "--device", "0"]) == 0
    assert len(asked) >= 5 and set(map(str, asked)) == {"0"}


def test_progress_of_a_film(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with OutputProgress("out.gif", "frame", quiet=False) as progress:
        for done in range(1, 4):
            progress.show(done, 3)
        assert progress._bar.n == progress._bar.total == 3
    assert "out.gif" in capsys.readouterr().err
    with OutputProgress("out.gif", "frame", quiet=True) as progress:
        progress.show(1, 3)
    assert capsys.readouterr().err == ""


def test_each_output_has_a_bar_in_its_unit(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    units = {"r.html": "picture", "s.png": "picture", "p.svg": "plot", "g.gif": "frame"}
    arguments = ["--report", "r.html", "--sheet", "s.png", "--plot", "p.svg", "--gif", "g.gif"]
    assert cli.main([word for word in SHORT if word != "-q"] + arguments) == 0
    shown = capsys.readouterr().err
    for file, unit in units.items():
        assert re.search(rf"\r{file}: +0%.*0/1 \[00:00<\?, \?{unit}/s\]", shown), shown


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--gif", "g.png"], "--gif: got g.png, wanted a name that ends in .gif"),
        (["--plot", "p.pdf"], "--plot: got p.pdf, wanted a name that ends in .png or .svg"),
        (["--sheet", "in.png"], "in.png: is the picture itself"),
        (["--report", "out.svg"], "out.svg: two outputs would go to this file"),
        (["--report", "no/r.html"], "no/r.html: the folder "),
        (["--frame-step", "0"], "wanted a whole number of at least 1"),
    ],
)
def test_what_cannot_be_written_is_refused_first(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([*SHORT, *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not Path("out.svg").exists()


@pytest.mark.parametrize(
    ("arguments", "extra"), [(["--plot", "p.png"], "livecl[plots]"), (["--mp4", "m.mp4"], "livecl[video]")]
)
def test_a_missing_extra_is_named(
    arguments: list[str], extra: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert cli.main([*SHORT, *arguments]) == 2
    assert f"pip install '{extra}'" in capsys.readouterr().err
