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
from evaluation import runs, tables
from evaluation.measures import measure, resvg_picture
from evaluation.methods import METHODS, parse_method
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
    red, blue = np.ones((32, 32, 3)), np.zeros((32, 32, 4))
    red[8:24, 10:26] = (0.8, 0.1, 0.1)
    save_image(tmp_path / "in" / "clip_red.png", red)
    blue[4:20, 6:28] = (0.1, 0.2, 0.8, 1.0)
    save_image(tmp_path / "in" / "photo_blue.png", blue)
    return tmp_path


def tool(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, evaluate.__file__, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)


def run_of(folder: Path, **changes: Any) -> runs.Run:
    return runs.Run(
        **{
            "picture": folder / "in" / "clip_red.png",
            "method": parse_method("quick:preset=paper,iterations=2"),
            "asked": 2,
            "seed": 0,
            "device": None,
            "output": folder / "out",
            **changes,
        }
    )


def true_of(folder: Path) -> Path:
    """Write the SVG of the red square, with two black bars of 1x4 px as one shape beneath it."""
    true = folder / "in" / "clip_red.svg"
    spots = [rectangle(0, 0, 1, 4), rectangle(30, 0, 31, 4)]
    drawing = build([(spots, (0.0, 0.0, 0.0, 1.0)), ([rectangle(10, 8, 26, 24)], (0.8, 0.1, 0.1, 1.0))], (32, 32))
    drawing.save_svg(true)
    return true


def test_plan() -> None:
    arguments: dict[str, Any] = {"seed": 0, "device": None, "output": Path("out")}
    methods = [METHODS["live"], METHODS["diffvg"], METHODS["vtracer"]]
    planned = runs.plan([Path("in/a.png")], methods, (4, 8, "auto"), **arguments)
    assert [(run.method.name, run.asked) for run in planned] == [
        *(("live", asked) for asked in (4, 8, "auto")),
        *(("diffvg", asked) for asked in (4, 8, "auto")),
        ("vtracer", None),
    ]
    assert [run.schedule for run in planned] == [(1, 2, 1), (1, 2, 4, 1), None, (4,), (8,), None, None]
    assert len({run.folder for run in planned}) == 7
    with pytest.raises(ValueError, match=r"paths 'things' need its SVG, a.svg beside it"):
        runs.plan([Path("in/a.png")], methods, ("things",), **arguments)


def test_numbers_of_a_true_svg(folder: Path) -> None:
    true_of(folder)
    assert [run_of(folder, asked=word).schedule for word in ("things", "shapes")] == [(1, 2), (1, 1)]
    assert run_of(folder, asked="things").key() != run_of(folder, asked="shapes").key()


def test_scores_by_the_true_svg(folder: Path) -> None:
    """The drawing has the square and not the two bars, which are one shape; the artist's three parts have 12 cubics."""
    svg, true = folder / "a.svg", true_of(folder)
    drawing = build([([rectangle(10, 8, 26, 24)], (0.8, 0.1, 0.1, 1.0))], (32, 32))
    drawing.save_svg(svg)
    found = measure(svg, livecl.render(drawing), Rasterizer((32, 32)), true)
    assert (found["things"], found["found"], found["missed"], found["extra"]) == (3, 1, 2, 0)
    assert (found["overlap"], found["true_segments"]) == (pytest.approx(1 / 3), 12)
    assert (found["shapes"], found["shapes_drawn"], found["true_numbers"] > found["numbers"] > 0) == (3, 1, True)
    # 8 of the 32 x 32 px are black in one and white in the other: a difference of 100 each.
    assert found["delta_e"] == pytest.approx(8 / 32**2 * 100, rel=1e-3)
    assert (found["colored"], found["opaque"], found["gradients"]) == (1, 1, 0)


def test_disturbed_runs_are_measured_by_the_clean_picture(folder: Path) -> None:
    clean, noisy = (
        runs.execute(run_of(folder, method=method), {})[0]
        for method in (parse_method("q:iterations=9"), parse_method("q:iterations=9").under("noise"))
    )
    assert (noisy["method"], noisy["asked"], noisy["mse"] < 1e-3) == ("q+noise", 2, True)
    assert clean["mse"] < 1e-3


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
            {"asked": 1},
            {"asked": "auto"},
            {"method": parse_method("quick:preset=paper,iterations=2").under("jpeg")},
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
    assert (found["mse"], found["own_mse"], found["renders_mse"]) == (0, 0, 0)
    assert "overlap" not in found
    assert (found["psnr"], found["ssim"]) == (None, pytest.approx(1))
    assert (found["in_one_region"], found["needless"], found["mergeable"]) == (2, 0, 0)
    other = np.array(target)
    other[0, 0] = 0
    assert measure(svg, other, rasterizer)["mse"] == pytest.approx(1 / 256)


def test_resvg_picture_of_a_transparent_svg_is_over_white() -> None:
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="3" height="2"><rect width="1" height="2" fill="#f00"/></svg>'
    assert resvg_picture(svg)[0].tolist() == [[1, 0, 0], [1, 1, 1], [1, 1, 1]]


def row_of(**changes: Any) -> dict[str, Any]:
    numbers = dict.fromkeys(("segments", "seconds", "ssim", "mse", "gradients", "colored", "opaque"), 1.0)
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
    assert (first["in_one_region"], first["needless"], first["overlap"]) == (12 / 20, 3, None)
    head, _, *lines = tables.format_summary(summary).splitlines()[2:]
    assert len(lines) == 4 and lines[0].startswith("| clip | 8 | live | 3 | 3.00e-02 | 2.00e-02 |")
    assert "IoU" not in head  # no true SVGs, no such column
    assert tables.summarize([]) == []


def test_summary_of_things_weighs_them_alike_and_growth_is_of_sums() -> None:
    scores = {"things": 1, "hidden": 0, "hidden_overlap": 0.0, "found": 1, "missed": 0, "extra": 0, "overlap": 1.0}
    many = {"things": 3, "hidden": 1, "hidden_overlap": 0.3, "found": 0, "missed": 1, "extra": 2, "overlap": 0.6}
    rows = [
        row_of(picture="a", segments=10, true_segments=5, delta_e=1.0, **scores),
        row_of(picture="b", segments=30, true_segments=15, delta_e=3.0, **many),
        row_of(picture="a", method="live+noise", paths=12, segments=30, true_segments=5, delta_e=1.0, **scores),
        row_of(picture="b", method="live+noise", paths=12, segments=50, true_segments=15, delta_e=1.0, **many),
    ]
    clean, noisy = tables.summarize(rows)
    assert (clean["overlap"], clean["hidden_overlap"]) == (pytest.approx((1 + 3 * 0.6) / 4), 0.3)
    assert (clean["found"], clean["missed"], clean["extra"]) == (1 / 4, 1 / 4, 1 / 2)
    assert (clean["layers_a_thing"], clean["cubics_ratio"], clean["delta_e_mean"]) == (16 / 4, 2, 2)
    assert (noisy["more_layers"], noisy["more_cubics"]) == (24 / 16, 2)
    assert clean["more_layers"] is None


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
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert len(results["failures"]) == 4
    assert all("clip_bad.png" in failure and "ImageError" in failure for failure in results["failures"])
    assert done.stdout.count("failed: ") == 4
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

    # Again: nothing but the failures is tried, and the results are the same.
    again = tool(folder, *command)
    assert "8 runs are done already, 4 to do" in again.stderr
    assert json.loads((out / "results.json").read_text(encoding="utf-8"))["rows"] == results["rows"]

    # Other options, and a result that was not finished: these are made anew.
    next((out / "runs" / "once" / "in").rglob("result.json")).unlink()
    (folder / "in" / "clip_bad.png").unlink()
    last = tool(folder, *(argument.replace("iterations=5", "iterations=4") for argument in command))
    assert last.returncode == 0
    assert "3 runs are done already, 5 to do" in last.stderr
    assert json.loads((out / "results.json").read_text(encoding="utf-8"))["failures"] == []


def test_results_of_another_program_are_not_kept(folder: Path) -> None:
    run = run_of(folder)
    assert run.kept_rows() is None
    rows = runs.execute(run, {**run.key(), "source": "another"})
    assert [(row["asked"], row["stages"]) for row in rows] == [(2, [1, 2])]
    assert run.kept_rows() is None
    assert run.kept_rows() is None and runs.execute(run, run.key()) == run.kept_rows() != rows
    assert run_of(folder, seed=1).kept_rows() is None
    (run.folder / "result.json").write_text("{")
    assert run.kept_rows() is None


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
    (row,) = runs.execute(run_of(folder, method=METHODS["vtracer"], asked=None), {})
    assert row["asked"] is None
    assert row["stages"] == [row["paths"]]
    assert row["mse"] < 1e-3


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


def test_a_picture_of_rounded_proportions_has_the_size_asked_for() -> None:
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="257" height="229"><path d="M0 0H257V229H0Z"/></svg>'
    picture = resvg_picture(svg, (916, 1024))  # 257 : 229 is 1024 : 912.4
    assert picture.shape == (916, 1024, 3) and picture[1:-1, 1:-1].max() < 0.01


def test_missing_package_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "vtracer" else object())
    evaluate.check_packages([METHODS["live"]])
    with pytest.raises(ValueError, match=r"vtracer is not installed: pip install 'livecl\[vtracer\]'"):
        evaluate.check_packages([METHODS["live"], METHODS["vtracer"]])


def test_path_counts() -> None:
    assert evaluate.path_counts("16,8,8") == (8, 16)
    assert evaluate.path_counts("auto,things,8") == (8, "auto", "things")
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
