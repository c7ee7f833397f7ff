# SPDX-License-Identifier: Apache-2.0
"""The command line: what it writes, what it refuses, and how it says so."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import LIVECL, ROOT, SHORT, run

import livecl
from livecl.cli import command as cli
from livecl.drawing.colors import format_rgb
from livecl.image.reading import save_image


def test_writes_svg(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["in.png", "-o", "out.svg", *SHORT]) == 0
    assert livecl.read_svg("out.svg").size == (32, 32)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(r"out\.svg: \d paths, MSE \S+, \S+ s\n", captured.err)
    assert sorted(file.name for file in folder.iterdir()) == ["in.png", "out.svg"]


def test_quiet(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["in.png", "-o", "out.svg", "-q", *SHORT]) == 0
    assert capsys.readouterr() == ("", "")


def test_json(folder: Path) -> None:
    arguments = ["in.png", "-o", "out.svg", "--json", "out.json", "--schedule", "1,2", "--iterations", "3"]
    arguments += ["--preset", "paper"]
    assert (
        cli.main([*arguments, "--seed", "7", "--segments", "3", "--xing-weight", "0.5", "--background", "#ff8000"]) == 0
    )
    report = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert set(report) == {
        "width",
        "height",
        "working_width",
        "working_height",
        "device",
        "colors",
        "layers",
        "version",
        "options",
        "paths",
        "mse",
        "stopped",
        "seconds",
        "compile_seconds",
        "stages",
    }
    assert (report["width"], report["height"], report["version"]) == (32, 32, livecl.__version__)
    given = {"schedule": [1, 2], "seed": 7, "iterations": 3, "segments": 3, "xing_weight": 0.5, "background": "#ff8000"}
    assert given.items() <= report["options"].items()
    assert [set(stage) for stage in report["stages"]] == [{"paths", "mse", "iterations", "seconds"}] * 2
    assert [stage["iterations"] for stage in report["stages"]] == [3, 3]
    assert report["paths"] == report["stages"][-1]["paths"]
    drawing = livecl.read_svg("out.svg")
    assert report["paths"] == drawing.num_layers == len(report["layers"])
    assert [layer["fill"] for layer in report["layers"]] == [
        {"kind": "solid", "color": format_rgb(rgba), "opacity": rgba[3]} for rgba in drawing.colors
    ]
    assert [layer["nodes"] for layer in report["layers"]] == np.diff(drawing.segment_offsets).tolist()
    assert sorted(layer["stage"] for layer in report["layers"]) == [1, 2, 2]
    assert {"label", "groups", "shape", "fill", "nodes", "subpaths"} < set(report["layers"][0])
    difference = livecl.render(drawing) - livecl.read_image("in.png")
    assert report["mse"] == pytest.approx(np.mean(np.square(difference, dtype=np.float64)), rel=1e-5)


def test_json_width_and_height(folder: Path) -> None:
    save_image("wide.png", np.zeros((5, 9, 3)))
    assert cli.main(["wide.png", "-o", "out.svg", "--json", "out.json", "--paths", "1", "--iterations", "1"]) == 0
    report = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert (report["width"], report["height"]) == (9, 5)


def test_stages(folder: Path) -> None:
    arguments = ["in.png", "-o", "out.svg", "--preset", "paper", "--schedule", "1,1,1", "--iterations", "2"]
    assert cli.main([*arguments, "--stages", "made"]) == 0
    Path("there").mkdir()
    assert cli.main([*arguments, "--stages", "there"]) == 0
    for name in ("made", "there"):
        assert sorted(file.name for file in Path(name).iterdir()) == ["stage-1.svg", "stage-2.svg", "stage-3.svg"]
        assert [livecl.read_svg(f"{name}/stage-{i}.svg").num_layers for i in (1, 2, 3)] == [1, 2, 3]
        assert Path(name, "stage-3.svg").read_bytes() == Path("out.svg").read_bytes()


def test_existing_output_is_replaced(folder: Path) -> None:
    Path("out.svg").write_text("old", encoding="utf-8")
    assert cli.main(["in.png", "-o", "out.svg", *SHORT]) == 0
    assert livecl.read_svg("out.svg").num_layers


def test_one_pixel(folder: Path) -> None:
    save_image("dot.png", np.zeros((1, 1, 3)))
    assert cli.main(["dot.png", "-o", "out.svg", *SHORT]) == 0
    assert livecl.read_svg("out.svg").size == (1, 1)


def test_alpha_is_laid_over_the_background(folder: Path) -> None:
    save_image("clear.png", np.zeros((8, 8, 4)))
    arguments = ["clear.png", "-o", "out.svg", "--paths", "1", "--iterations", "1", "--background", "#336699"]
    assert cli.main(arguments) == 0
    assert livecl.read_svg("out.svg").background == pytest.approx([0.2, 0.4, 0.6])


@pytest.mark.parametrize("preset", ["default", "paper", "released", "diffvg"])
def test_presets(folder: Path, preset: str) -> None:
    from livecl.options import PRESETS

    arguments = ["in.png", "-o", "out.svg", "--json", "out.json", "--paths", "3", "--preset", preset]
    assert cli.main([*arguments, "--iterations", "2", "--shape", "random"]) == 0
    report = json.loads(Path("out.json").read_text(encoding="utf-8"))
    expected = vars(PRESETS[preset](iterations=2, shape="random"))
    assert {name: report["options"][name] for name in expected} == expected
    assert report["options"]["schedule"] == ([3] if preset == "diffvg" else [1, 2])


def test_random_placement_starts_as_circles(folder: Path) -> None:
    arguments = ["in.png", "-o", "out.svg", "--json", "out.json", *SHORT, "--placement", "random"]
    for more, shape in (([], "circle"), (["--shape", "random"], "random"), (["--preset", "diffvg"], "random")):
        assert cli.main([*arguments, *more]) == 0
        assert json.loads(Path("out.json").read_text(encoding="utf-8"))["options"]["shape"] == shape
    assert cli.main([*arguments, "--shape", "outline"]) == 2


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["--paths", "1"], "that is far from the picture: try more than 1 paths (--paths 4)"),
        (["--path-gain", "0.3"], "that is far from the picture, and further paths gained too little each, "),
        ([], ""),
    ],
)
def test_a_drawing_far_from_the_picture_is_said_to_be_so(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], hint: str
) -> None:
    stripes = np.ones((32, 32, 3))
    stripes[:, 4:8], stripes[:, 14:18], stripes[:, 24:28] = 0.0, (0.9, 0.1, 0.1), (0.1, 0.1, 0.9)
    save_image("stripes.png", stripes)
    assert cli.main(["stripes.png", "-o", "out.svg", "--iterations", "20", "--revisions", "0", *arguments]) == 0
    summary, *hints = capsys.readouterr().err.splitlines()
    assert summary.startswith("out.svg: ")
    assert [line[: len(hint)] for line in hints] == ([hint] if hint else [])


def test_schedules(folder: Path) -> None:
    def schedule(*arguments: str) -> Any:
        command = ["in.png", "-o", "out.svg", "--json", "out.json", "--iterations", "1", *arguments]
        assert cli.main(command) == 0
        return json.loads(Path("out.json").read_text(encoding="utf-8"))["options"]["schedule"]

    assert schedule() == [1, 2, 4, 8, 16, *[32] * 7, 1]
    assert schedule("--preset", "paper") == [1, 2, 4, 1]
    assert schedule("--schedule", "exp", "--paths", "5") == [1, 2, 2]
    assert schedule("--schedule", "2,1") == [2, 1]
    assert schedule("--schedule", "2,1", "--paths", "3") == [2, 1]


@pytest.mark.parametrize("command", [LIVECL, [sys.executable, str(ROOT / "tools" / "vectorize.py")]])
def test_same_file_from_every_entry(folder: Path, command: list[str]) -> None:
    assert cli.main(["in.png", "-o", "here.svg", *SHORT]) == 0
    done = run(*command, "in.png", "-o", "out.svg", *SHORT)
    assert (done.returncode, done.stdout) == (0, "")
    assert Path("out.svg").read_bytes() == Path("here.svg").read_bytes()


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    for option, text in (("--version", f"livecl {livecl.__version__}\n"), ("--help", "-o OUT.svg")):
        with pytest.raises(SystemExit) as stop:
            cli.main([option])
        captured = capsys.readouterr()
        assert stop.value.code == 0
        assert text in captured.out
        assert captured.err == ""


def test_list_devices(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--list-devices"]) == 0
    captured = capsys.readouterr()
    assert captured.out.splitlines() == [str(device) for device in livecl.list_devices()]
    assert captured.err == ""


def test_device_by_name_and_index(folder: Path) -> None:
    device = livecl.list_devices()[0]
    for choice in ("0", device.name):
        assert cli.main(["in.png", "-o", "out.svg", "--json", "out.json", "--device", choice, *SHORT]) == 0
        assert json.loads(Path("out.json").read_text(encoding="utf-8"))["device"] == str(device)


def test_special_files_are_written_to(folder: Path) -> None:
    assert cli.main(["in.png", "-o", "/dev/null", "--json", "/dev/null", *SHORT]) == 0
    assert Path("/dev/null").is_char_device()


@pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
class TestTerminal:
    """A run whose standard error is a terminal."""

    @staticmethod
    def start(*arguments: str) -> tuple[subprocess.Popen[bytes], int]:
        import pty

        master, slave = pty.openpty()
        process = subprocess.Popen(
            [*LIVECL, "in.png", "-o", "out.svg", *arguments],
            env={**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "120"},
            stdout=subprocess.PIPE,
            stderr=slave,
        )
        os.close(slave)
        return process, master

    @staticmethod
    def read(master: int) -> str:
        """Return the terminal's next output; nothing when the process has closed it."""
        try:
            return os.read(master, 4096).decode()
        except OSError:  # how Linux reports that the other end is closed
            return ""

    def read_all(self, process: subprocess.Popen[bytes], master: int, text: str = "") -> str:
        while part := self.read(master):
            text += part
        stdout, _ = process.communicate(timeout=60)
        os.close(master)
        assert stdout == b""
        return text

    def test_progress(self, folder: Path) -> None:
        text = self.read_all(
            *self.start("--schedule", "1,1", "--iterations", "600", "--revisions", "0", "--preset", "paper")
        )
        assert re.search(r"stage 2/2: +\d+%\|[^\r]*/1200 \[\d\d:\d\d<\d\d:\d\d, [^\r]*, paths 2, MSE \d", text)
        assert re.search(r"out\.svg: \d paths, MSE \S+, \S+ s\r\n$", text)

    def test_quiet(self, folder: Path) -> None:
        assert self.read_all(*self.start("-q", *SHORT)) == ""

    def test_interrupted(self, folder: Path) -> None:
        process, master = self.start("--iterations", "1000000")
        text = ""
        while "MSE" not in text:
            part = self.read(master)
            assert part, text
            text += part
        process.send_signal(signal.SIGINT)
        text = self.read_all(process, master, text)
        assert process.returncode == 130
        assert re.search(
            r"livecl: error: interrupted; out\.svg has the best drawing so far: \d paths, [^\n]+\r\n$", text
        )
        assert "Traceback" not in text
        assert livecl.read_svg("out.svg").num_layers


def test_threads_change_nothing_but_the_cores(folder: Path) -> None:
    command = [sys.executable, "-m", "livecl", "in.png", "--paths", "2", "--iterations", "3", "-q"]
    for threads in ("1", "2"):
        script = [*command, "-o", f"{threads}.svg", "--threads", threads]
        assert subprocess.run(script, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False).returncode == 0
    assert Path("1.svg").read_bytes() == Path("2.svg").read_bytes()
    assert cli.main(["in.png", "-o", "3.svg", "--threads", "0"]) == 2


@pytest.mark.parametrize(("given", "taken"), [(None, "1"), ("3", "3")])
def test_linear_algebra_has_one_thread_unless_told(given: str | None, taken: str) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    if given is not None:
        environment["OPENBLAS_NUM_THREADS"] = given
    script = (
        "import livecl.cli, os, sys; early = 'numpy' not in sys.modules; import livecl.cli.command; "
        "print(early, os.environ['OPENBLAS_NUM_THREADS'])"
    )
    found = subprocess.run([sys.executable, "-c", script], env=environment, cwd=ROOT, capture_output=True, check=True)
    assert found.stdout.decode().split() == ["True", taken]
