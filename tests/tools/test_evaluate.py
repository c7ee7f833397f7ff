# SPDX-License-Identifier: Apache-2.0
"""The evaluation tool: its plan, its measures, and small evaluations from the command line."""

from __future__ import annotations

import csv
import importlib.util
import json
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import evaluate
import numpy as np
import pytest
from evaluation import runs, sheets, tables
from evaluation.measures import measure, resvg_picture
from evaluation.methods import METHODS, parse_method
from PIL import Image
from support.drawings import build, rectangle

import livecl
from livecl.image.reading import read_image, save_image
from livecl.rendering.rasterizer import Rasterizer

#: Arguments of runs that take a moment.
QUICK = ["--method", "quick:preset=paper,iterations=5", "--processes", "1"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder `in` with two pictures of 32x32: a red square, and a blue one on a transparent ground."""
    (tmp_path / "in").mkdir()
    red = np.ones((32, 32, 3))
    red[8:24, 10:26] = (0.8, 0.1, 0.1)
    save_image(tmp_path / "in" / "clip_red.png", red)
    blue = np.zeros((32, 32, 4))
    blue[4:20, 6:28] = (0.1, 0.2, 0.8, 1.0)
    save_image(tmp_path / "in" / "photo_blue.png", blue)
    return tmp_path


def tool(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, evaluate.__file__, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def run_of(folder: Path, **changes: Any) -> runs.Run:
    return runs.Run(
        **{
            "picture": folder / "in" / "clip_red.png",
            "method": parse_method("quick:preset=paper,iterations=2"),
            "counts": (1, 2),
            "seed": 0,
            "device": None,
            "output": folder / "out",
            **changes,
        }
    )


def test_plan() -> None:
    arguments: dict[str, Any] = {"seed": 0, "device": None, "output": Path("out")}
    methods = [METHODS["live"], METHODS["diffvg"], METHODS["vtracer"]]
    planned = runs.plan([Path("in/a.png")], methods, (4, 8), separate=False, **arguments)
    assert [(run.method.name, run.counts) for run in planned] == [
        ("live", (4, 8)),
        ("diffvg", (4,)),
        ("diffvg", (8,)),
        ("vtracer", ()),
    ]
    assert [run.schedule for run in planned] == [(1, 2, 1, 4), (4,), (8,), ()]
    planned = runs.plan([Path("in/a.png")], methods[:1], (4, 8), separate=True, **arguments)
    assert [run.schedule for run in planned] == [(1, 2, 1), (1, 2, 4, 1)]
    assert len({run.folder for run in planned}) == 2


def test_groups_of_pictures() -> None:
    assert runs.picture_group(Path("pics/photo_coffee.png")) == "photo"
    assert runs.picture_group(Path("/data/emoji/1f600.png")) == "emoji"
    assert runs.picture_group(Path("/data/emoji/_x.png")) == "emoji"


def test_key_tells_runs_apart(folder: Path) -> None:
    keys = [
        run_of(folder, **changes).key()
        for changes in (
            {},
            {"seed": 1},
            {"counts": (2,)},
            {"method": parse_method("quick:iterations=3")},
            {"method": parse_method("quick:iterations=2,stages=one")},
            {"picture": folder / "in" / "photo_blue.png"},
        )
    ]
    assert len({json.dumps(key) for key in keys}) == len(keys)


def test_measure(tmp_path: Path) -> None:
    red, blue = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
    drawing = build([([rectangle(2, 2, 10, 10)], red), ([rectangle(4, 4, 6, 6)], blue)], (16, 16))
    rasterizer = Rasterizer(drawing.size)
    target = rasterizer.forward(drawing)
    svg = tmp_path / "a.svg"
    drawing.save_svg(svg)
    found = measure(svg, target, rasterizer)
    assert (found["paths"], found["segments"], found["parameters"]) == (2, 8, 2 * (4 * 6 + 4))
    assert found["bytes"] == svg.stat().st_size
    # Edges on pixel borders and colours of 0 and 1: both renderers are exact.
    assert (found["mse"], found["own_mse"], found["renders_mse"], found["renders_max"]) == (0, 0, 0, 0)
    assert (found["psnr"], found["ssim"]) == (None, pytest.approx(1))
    assert (found["in_one_region"], found["needless"], found["mergeable"]) == (2, 0, 0)
    other = np.array(target)
    other[0, 0] = 0
    assert measure(svg, other, rasterizer)["mse"] == pytest.approx(1 / 256)


def test_resvg_picture_of_a_transparent_svg_is_over_white() -> None:
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="3" height="2"><rect width="1" height="2" fill="#f00"/></svg>'
    assert resvg_picture(svg)[0].tolist() == [[1, 0, 0], [1, 1, 1], [1, 1, 1]]


def row_of(**changes: Any) -> dict[str, Any]:
    numbers = dict.fromkeys(tables.COLUMNS, 1.0)
    words = {"picture": "in/a.png", "group": "clip", "method": "live", "asked": 8, "svg": "a.svg"}
    counts = {"paths": 8, "in_one_region": 6, "self_crossing": 0, "needless": 1, "mergeable": 0, "nearly_opaque": 0}
    return {**numbers, **words, **counts, "stages": [1, 3, 7, 8], **changes}


def test_summary() -> None:
    rows = [
        row_of(mse=0.01, psnr=20.0),
        row_of(mse=0.02, psnr=None, paths=4, in_one_region=0),
        row_of(mse=0.06, psnr=10.0),
        row_of(mse=0.5, group="photo", method="vtracer", asked=None),
    ]
    summary = tables.summarize(rows)
    assert [(row["group"], row["asked"], row["method"]) for row in summary] == [
        ("clip", 8, "live"),
        ("photo", None, "vtracer"),
        ("all", 8, "live"),
        ("all", None, "vtracer"),
    ]
    first = summary[0]
    assert (first["pictures"], first["mse_mean"], first["mse_median"]) == (3, pytest.approx(0.03), 0.02)
    assert (first["psnr_mean"], first["in_one_region"], first["needless"]) == (15, 12 / 20, 3)
    lines = tables.format_summary(summary).splitlines()
    assert len(lines) == 5
    assert len({len(line) for line in lines}) == 1
    assert tables.summarize([]) == []


@pytest.mark.slow
def test_evaluation(folder: Path) -> None:
    (folder / "in" / "clip_bad.png").write_bytes(b"no picture")
    (folder / "in" / "notes.txt").write_text("not looked at")
    command = ["in", "-o", "out", "--paths", "2,1", *QUICK, "--method", "once:preset=diffvg,iterations=3"]
    done = tool(folder, *command)
    assert done.returncode == 1, done.stderr
    out = folder / "out"
    with (out / "results.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert {(row["picture"], row["method"], row["asked"]) for row in table} == {
        (f"in/{picture}.png", method, asked)
        for picture in ("clip_red", "photo_blue")
        for method in ("quick", "once")
        for asked in "12"
    }
    assert tuple(table[0]) == tables.COLUMNS
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert len(results["failures"]) == 3
    assert all("clip_bad.png" in failure and "ImageError" in failure for failure in results["failures"])
    assert done.stdout.count("failed: ") == 3
    assert {row["group"] for row in results["summary"]} == {"clip", "photo", "all"}
    for row in results["rows"]:
        target = read_image(folder / row["picture"])
        rgb = target if target.shape[2] == 3 else target[..., :3] * target[..., 3:] + 1 - target[..., 3:]
        picture = resvg_picture((out / row["svg"]).read_bytes())
        assert row["mse"] == pytest.approx(np.mean(np.square(picture.astype(float) - rgb)), rel=1e-5)
        assert row["stages"][-1] == row["paths"]
        assert len(row["stages"]) == (row["asked"] if row["method"] == "quick" else 1)
    assert sorted(file.name for file in (out / "sheets").iterdir()) == [
        f"{method}-{count}-01.png" for method in ("once", "quick") for count in "12"
    ]
    assert (out / "mse-against-paths.png").is_file() == (importlib.util.find_spec("matplotlib") is not None)

    # Again: nothing but the failures is tried, and the results are the same.
    again = tool(folder, *command)
    assert "6 runs are done already, 3 to do" in again.stderr
    assert json.loads((out / "results.json").read_text(encoding="utf-8"))["rows"] == results["rows"]

    # Other options, and a result that was not finished: these are made anew.
    next((out / "runs" / "once" / "in").rglob("result.json")).unlink()
    (folder / "in" / "clip_bad.png").unlink()
    last = tool(folder, *(argument.replace("iterations=5", "iterations=4") for argument in command))
    assert last.returncode == 0
    assert "3 runs are done already, 3 to do" in last.stderr
    assert json.loads((out / "results.json").read_text(encoding="utf-8"))["failures"] == []


def test_results_of_another_program_are_kept_on_demand(folder: Path) -> None:
    run = run_of(folder)
    assert run.kept_rows() is None
    rows = runs.execute(run, {**run.key(), "source": "another"})
    assert [(row["asked"], row["stages"]) for row in rows] == [(1, [1]), (2, [1, 2])]
    assert run.kept_rows() is None
    assert run.kept_rows(any_source=True) == rows
    assert run_of(folder, seed=1).kept_rows(any_source=True) is None
    (run.folder / "result.json").write_text("{")
    assert run.kept_rows(any_source=True) is None


class DyingRun(runs.Run):
    """A run whose process is killed as soon as it begins."""

    @property
    def folder(self) -> Path:
        if multiprocessing.parent_process() is not None:
            os._exit(9)
        return super().folder


def test_a_process_that_dies_takes_no_other_run_along(folder: Path) -> None:
    arguments = vars(run_of(folder))
    planned = [DyingRun(**arguments), run_of(folder)]
    outcomes = {type(run): outcome for run, outcome in runs.execute_all(planned, [{}, {}], processes=1)}
    assert isinstance(outcomes[DyingRun], BaseException)
    assert isinstance(outcomes[runs.Run], list)


def test_vtracer(folder: Path) -> None:
    pytest.importorskip("vtracer")
    (row,) = runs.execute(run_of(folder, method=METHODS["vtracer"], counts=()), {})
    assert row["asked"] is None
    assert row["stages"] == [row["paths"]]
    assert row["mse"] < 1e-3


def test_outlines_keep_the_size() -> None:
    drawing = build([([rectangle(2, 2, 10, 10)], (1.0, 0.0, 0.0, 1.0))], (16, 24))
    assert sheets.outlines(drawing, Image.new("RGB", (48, 32), "white")).size == (48, 32)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["in", "--methods", "best"], "no method best; there are live"),
        (["in", "--method", "x:iterations=0"], "method x: iterations"),
        (["nothing"], "nothing: there is no such file or folder"),
        (["."], "no pictures in this folder"),
        (["in", "also/in"], "have the same name"),
    ],
)
def test_bad_arguments(
    folder: Path,
    arguments: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(folder)
    (folder / "also" / "in").mkdir(parents=True)
    save_image(folder / "also" / "in" / "clip_red.png", np.ones((4, 4, 3)))
    assert evaluate.main([*arguments, "-o", "out"]) == 2
    assert message in capsys.readouterr().err
    assert not Path("out").exists()


def test_missing_package_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "vtracer" else object())
    evaluate.check_packages([METHODS["live"]])
    with pytest.raises(ValueError, match=r"vtracer is not installed: pip install 'livecl\[vtracer\]'"):
        evaluate.check_packages([METHODS["live"], METHODS["vtracer"]])


def test_path_counts() -> None:
    assert evaluate.path_counts("16,8,8") == (8, 16)
    with pytest.raises(SystemExit):
        evaluate.main(["in", "-o", "out", "--paths", "8,0"])


def test_digest_changes_with_any_module_that_decides_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "livecl"
    for name in ("run/loop.py", "views/sheet.py"):
        (package / name).parent.mkdir(parents=True)
        (package / name).write_text("1", encoding="utf-8")
    monkeypatch.setattr(livecl, "__file__", str(package / "__init__.py"))
    digests = [runs.source_digest.__wrapped__()]
    for name in ("run/loop.py", "views/sheet.py"):
        (package / name).write_text("2", encoding="utf-8")
        digests.append(runs.source_digest.__wrapped__())
    assert digests[0] != digests[1] == digests[2]
