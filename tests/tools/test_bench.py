# SPDX-License-Identifier: Apache-2.0
"""The benchmark: what it counts, computes and refuses. No test asserts a time: machines differ, and are busy."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import subprocess
import sys
import time
import types
from pathlib import Path
from typing import Any

import bench
import numpy as np
import pytest
from benchmark import breakdown, calibration, cases, checks, package, report, scenes

from livecl.drawing.drawing import Drawing
from livecl.opencl.device import open_device
from livecl.rendering.rasterizer import Gradients, Rasterizer

ROOT = Path(__file__).resolve().parents[2]


def polygon(*corners: tuple[float, float]) -> np.ndarray:
    """Straight segments between corners, (M, 3, 2): handles at thirds, so that one line flattens each."""
    start = np.array(corners, float)
    end = np.roll(start, -1, axis=0)
    return np.stack([start, start + (end - start) / 3, start + 2 * (end - start) / 3], axis=1)


def square(low: float, high: float) -> np.ndarray:
    return polygon((low, low), (high, low), (high, high), (low, high))


def test_calibration_is_positive(device: int | None) -> None:
    assert calibration.MultiplyAdd(open_device(device)).rate() > 0


def test_times_are_scaled_by_the_rate_beside_them() -> None:
    rates = iter([30.0, 30.0, 60.0, 60.0])
    seconds = iter([0.04, 0.02])

    def work() -> float:
        time.sleep(1.1 * calibration.BLOCK)  # a block each
        return next(seconds)

    found = calibration.repeated(work, lambda: next(rates), 2).summary()
    assert 0 <= found["processor_ms"] < 30  # it sleeps
    # 0.04 s between 30 and 30 GFLOP/s, 0.02 s between 30 and 60.
    assert found["repeats"] == 2
    assert found["median_ms"] == pytest.approx(30)
    assert found["minimum_ms"] == pytest.approx(20)
    assert found["scaled_ms"] == pytest.approx((40 * 30 + 20 * 45) / 2 / calibration.REFERENCE_GFLOPS)


def test_own_times_of_nested_steps_add_up() -> None:
    clock = breakdown.Clock()
    inner = clock.timed("inner", lambda: time.sleep(0.02))

    def outer() -> None:
        inner()
        time.sleep(0.01)

    start = time.perf_counter()
    clock.timed("outer", outer)()
    whole = time.perf_counter() - start
    assert set(clock.seconds) == {"inner", "outer"}
    assert all(seconds > 0 for seconds in clock.seconds.values())
    assert sum(clock.seconds.values()) <= whole


def test_time_within_revisions_is_apart() -> None:
    class Revise:
        pass

    clock = breakdown.Clock()
    step = clock.timed("iterations", lambda run: None)
    for phase in (Revise(), object()):
        step(types.SimpleNamespace(phase=phase))
    assert list(clock.seconds) == ["iterations of revisions", "iterations"]


def test_pictures_of_whole_runs(tmp_path: Path) -> None:
    pixels = scenes.picture("pixels", 64)
    assert pixels.shape == (64, 64, 3)
    assert np.array_equal(pixels, np.kron(pixels[::2, ::2], np.ones((2, 2, 1), np.float32)))
    scenes.save_variants(scenes.picture("face", 16), tmp_path / "faces", count=8)
    files = sorted((tmp_path / "faces").iterdir())
    assert len({file.read_bytes() for file in files}) == len(files) == 8


def test_wrapping_is_undone_and_tells_what_is_missing() -> None:
    import livecl.training.xing

    before = livecl.training.xing.xing_loss
    clock = breakdown.Clock()
    steps = (
        ("Xing", "livecl.training.xing", "xing_loss"),
        ("none", "livecl.training.xing", "Nothing.at_all"),
        ("no", "livecl.no", "x"),
    )
    with breakdown.wrapped(clock, steps) as missing:
        assert livecl.training.xing.xing_loss is not before
        livecl.training.xing.xing_loss(np.zeros((1, 4, 2)))
    assert livecl.training.xing.xing_loss is before
    assert missing == ["livecl.training.xing.Nothing.at_all", "livecl.no.x"]
    assert list(clock.seconds) == ["Xing"]


def _small() -> tuple[np.ndarray, Drawing]:
    drawing = Drawing(points=square(6.3, 25.8), colors=[[0.8, 0.2, 0.1, 0.9]], size=(32, 32))
    return np.full((32, 32, 3), 0.5, np.float32), drawing


def test_check_passes_what_is_right(device: int | None) -> None:
    found = checks.check_step(*_small(), device)
    assert found["loss"] < checks.LOSS_TOLERANCE
    assert all(math.isfinite(error) for error in found.values())


def test_scene_files_keep_a_drawing_to_the_last_bit(tmp_path: Path) -> None:
    _, drawing = _small()
    drawing = drawing.replace(points=drawing.points + 1e-9)
    scenes.save_scene(tmp_path / "scene.npz", drawing)
    found = scenes.load_scene(tmp_path / "scene.npz")
    assert found.size == drawing.size
    for name in ("points", "colors", "subpath_offsets", "layer_offsets"):
        np.testing.assert_array_equal(getattr(found, name), getattr(drawing, name))


@pytest.mark.parametrize("wrong", ["loss", "points", "colors"])
def test_check_finds_what_is_wrong(device: int | None, monkeypatch: pytest.MonkeyPatch, wrong: str) -> None:
    if not open_device(device).device.double_fp_config and wrong != "loss":
        pytest.skip("gradients are compared with the double build")
    right = Rasterizer.loss_and_gradients

    def changed(rasterizer: Rasterizer, *arguments: Any, **keywords: Any) -> tuple[float, Gradients]:
        loss, gradients = right(rasterizer, *arguments, **keywords)
        if rasterizer.dtype == np.float64:
            return loss, gradients
        if wrong == "loss":
            return 1.01 * loss, gradients
        return loss, dataclasses.replace(gradients, **{wrong: 1.01 * getattr(gradients, wrong)})

    monkeypatch.setattr(Rasterizer, "loss_and_gradients", changed)
    with pytest.raises(checks.CheckError, match=wrong):
        checks.check_step(*_small(), device)


def test_doubtful_pixels_are_those_at_a_kink() -> None:
    # A bow tie: left of the crossing the winding is 1, right of it -1; in the crossing's pixel they all but cancel.
    bow = Drawing(points=polygon((1, 1), (8, 4 - 1e-4), (8, 1), (1, 4)), colors=np.ones((1, 4)), size=(5, 10))
    pieces = np.ones(4, np.int32)
    assert np.argwhere(checks.doubtful_pixels(bow, pieces, 1e-3)).tolist() == [[2, 4]]
    assert not checks.doubtful_pixels(bow, pieces, 1e-8).any()


@pytest.mark.parametrize("mse", [0.2, math.nan])
def test_check_of_a_run(mse: float) -> None:
    assert checks.check_error(0.05, 0.1) == {"mse": 0.05}
    with pytest.raises(checks.CheckError, match="squared error"):
        checks.check_error(mse, 0.1)


def test_cases_by_name() -> None:
    assert [case.name for case in cases.chosen_cases("256@512, emoji")] == ["256@512", "emoji"]
    assert not set(cases.EXTREME) & {case.name for case in cases.chosen_cases(None)}
    with pytest.raises(ValueError, match="no case '7'"):
        cases.chosen_cases("5,7")


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (0, "0"), (1234.5, "1230"), (12.345, "12.3"), (-0.0996, "-0.0996"), (0.0000123, "0.0000123")],
)
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert report.number(value) == text


def _times(*scaled_ms: float) -> dict[str, Any]:
    rows = [{"repeats": 3, "median_ms": 8.0, "minimum_ms": ms, "scaled_ms": ms, "gflops": 30.0} for ms in scaled_ms]
    turns = {"turns_ms": list(scaled_ms), "turns_processor_ms": [ms / 2 for ms in scaled_ms[:2]]}
    return {"time": bench.merged(rows), **turns, "checked": {"mse": 1e-4 * scaled_ms[0]}}


def test_report_states_ratios_and_failures() -> None:
    words = dict.fromkeys(("device", "driver", "system"), "?")
    machine = {**words, "commit": "here", "packages": {"numpy": "2"}, "cores": 2, "load": 0.0, "gflops": 30.0}
    found = {
        "when": "now",
        "machine": machine,
        "cases": {"8": _times(4.0, 6.0, 3.0), "import": {"failed": "no module"}},
        "other": {"commit": "there", "cases": {"8": _times(8.0, 8.0, 8.0), "import": {}}},
    }
    assert report.failures(found) == ["import: no module"]
    text = report.text(found)
    assert "import: no module" in text
    rows = [re.findall(r"[^| ][^|]*[^| ]|\d|-", line) for line in text.splitlines() if line.startswith("| 8 paths")]
    assert rows[0][1:5] == ["8.00", "3.00", "4.00", "1.20"]  # median, minimum, scaled, wanted
    # The median of the turns' ratios, the lowest, the highest: of processor time, and of time.
    assert rows[1][1:7] == ["0.625", "0.500", "0.750", "0.500", "0.375", "0.750"]
    assert rows[1][7:] == ["-", "4.0e-04", "8.0e-04"]  # no goal; the errors


def _bench(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(ROOT / "tools" / "bench.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def test_bad_arguments() -> None:
    for arguments in (["--cases", "7"], ["--repeats", "0"], ["--compare-checkout", "nowhere"]):
        ended = _bench(*arguments)
        assert ended.returncode == 2, ended.stderr
        assert "Traceback" not in ended.stderr


@pytest.mark.slow
def test_run_of_the_smallest_cases(tmp_path: Path, device: int | None) -> None:
    written = tmp_path / "found.json"
    chosen = [] if device is None else ["--device", str(device)]
    ended = _bench("--cases", "1,emoji,import", "--repeats", "1", "--json", str(written), *chosen)
    assert ended.returncode == 0, ended.stderr
    found = json.loads(written.read_text(encoding="utf-8"))
    assert found["machine"]["packages"]["numpy"] == np.__version__
    step, whole = found["cases"]["1"], found["cases"]["emoji"]
    assert step["time"]["repeats"] == 1
    assert 0 < step["time"]["minimum_ms"] <= step["time"]["median_ms"]
    assert step["memory_mb"] > 0
    assert step["checked"]["loss"] < checks.LOSS_TOLERANCE
    assert step["host"]["missing"] == []
    assert step["kernels"]["ms"]
    assert all(ms >= 0 for ms in step["kernels"]["ms"].values())
    assert {"placement", "iterations", "pruning"} <= set(whole["parts"])
    assert all(whole["parts"][output] > 0 for output in ("saving", "report", "sheet", "GIF"))
    assert whole["checked"]["mse"] <= cases.CASES["emoji"].mse_at_most
    assert found["cases"]["import"]["time"]["repeats"] == 1
    assert "1 path, 240x240" in ended.stdout


def test_checks_import_from_flat_checkouts_by_the_names_of_today(tmp_path: Path) -> None:
    flat = tmp_path / "livecl"
    flat.mkdir()
    names = {"device": "open_device", "drawing": "Drawing", "losses": "xing_loss", "options": "Options"}
    names["rasterizer"] = "Gradients = Rasterizer"
    for name in {"__init__", "options", *package.FLAT.values()}:
        text = f"NAME = {name!r}\n{names.get(name, 'other')} = object\n"
        (flat / f"{name}.py").write_text(text, encoding="utf-8")
    script = (
        f"import pathlib, sys; sys.path[:0] = {[str(tmp_path), str(ROOT / 'tools'), str(ROOT / 'tests')]}\n"
        f"from benchmark.package import use_checkout; use_checkout(pathlib.Path({str(tmp_path)!r}))\n"
        "from livecl.training.step import NAME; print(NAME)\nfrom livecl.run.run import NAME; print(NAME)\n"
        "import benchmark.checks, benchmark.scenes\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["training", "vectorizer"]
