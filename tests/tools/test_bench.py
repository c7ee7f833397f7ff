# SPDX-License-Identifier: Apache-2.0
"""The benchmark: what it counts, computes and refuses. No test asserts a time: machines differ, and are busy."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmark import breakdown, calibration, cases, checks, counts, floor, repeats, report, results, scene_file, table
from benchmark.limit import REFERENCE_GFLOPS, Floor

from livecl.drawing.drawing import Drawing
from livecl.opencl.device import open_device
from livecl.options import Options
from livecl.rendering.rasterizer import Gradients, Rasterizer
from livecl.training.state import State

ROOT = Path(__file__).resolve().parents[2]
#: Rates of a made-up machine, twice as slow as the reference.
MACHINE = {
    "reference_gflops": REFERENCE_GFLOPS / 2,
    "peak_gflops": 100.0,
    "copy_gigabytes": {"1000": 50.0, "8000": 10.0},
}


def polygon(*corners: tuple[float, float]) -> np.ndarray:
    """Straight segments between corners, (M, 3, 2): handles at thirds, so that one line flattens each."""
    start = np.array(corners, float)
    end = np.roll(start, -1, axis=0)
    return np.stack([start, start + (end - start) / 3, start + 2 * (end - start) / 3], axis=1)


def square(low: float, high: float) -> np.ndarray:
    return polygon((low, low), (high, low), (high, high), (low, high))


def scene(*squares: tuple[float, float], opacity: float = 1.0, side: int = 32) -> counts.Counts:
    points = np.concatenate([square(*ends) for ends in squares])
    colors = np.tile([0.2, 0.4, 0.6, opacity], (len(squares), 1))
    drawing = Drawing(points=points, colors=colors, size=(side, side))
    return counts.counts(drawing, np.ones(len(points), int), tau=10.0)


def test_counts_of_a_square() -> None:
    # From 4.5 to 27.5: each side crosses 24 pixels; of the 4x4 tiles the outline passes the outer ring, and the four
    # inner tiles each have a pixel within 10 px of it.
    found = scene((4.5, 27.5))
    assert (found.layers, found.segments, found.lines) == (1, 4, 4)
    assert found.cells == 4 * 24
    assert found.edge_tiles == 12
    assert found.band_tiles == found.lit_tiles == 16
    assert (found.blended_tiles, found.flat_tiles) == (12, 4)


def test_band_is_no_wider_than_tau() -> None:
    # A small square in the corner of a large canvas: 2.5 to 5.5 and 10 px more, to 15.5, which is two tiles.
    found = scene((2.5, 5.5), side=64)
    assert (found.edge_tiles, found.band_tiles, found.lit_tiles) == (1, 4, 4)
    assert (found.blended_tiles, found.flat_tiles) == (1, 0)


def test_what_an_opaque_layer_hides_is_not_blended() -> None:
    # The small square lies in tile (1, 1), inside the large one above it.
    below, above = (10.5, 13.5), (4.5, 27.5)
    hidden, shown = scene(below, above), scene(below, above, opacity=0.5)
    assert (hidden.blended_tiles, hidden.flat_tiles) == (12, 4)
    assert (shown.blended_tiles, shown.flat_tiles) == (12 + 2, 3)
    assert hidden.edge_tiles == shown.edge_tiles == 13


def test_parts_off_the_canvas_are_not_counted() -> None:
    before, into, beside = np.array([[-20, 4.5, -3, 4.5], [-4, 4.5, 3.5, 4.5], [40.5, -9, 40.5, 90]])
    assert counts.crossed_cells(before[None], (32, 32)) == 0
    assert counts.crossed_cells(into[None], (32, 32)) == 4
    assert not counts.near_tiles(beside.reshape(2, 2), (32, 32), reach=8.0).any()


def test_holes_are_outside() -> None:
    outer, hole = square(1, 31)[:, 0], square(9, 23)[::-1, 0]
    lines = [np.concatenate([corners, np.roll(corners, -1, axis=0)], axis=1) for corners in (outer, hole)]
    inside = counts.inner_tiles(np.concatenate(lines), (4, 4))
    assert inside.sum() == 12
    assert not inside[1:3, 1:3].any()


def test_floor_of_a_square() -> None:
    found = scene((4.5, 27.5))
    operations = floor.operations(found)
    assert operations["flatten"] == 4 * floor.LINE
    assert operations["coverage"] == 96 * floor.CELL_FORWARD + 12 * 64 * floor.EDGE_PIXEL
    assert operations["outline gradient"] == 96 * floor.CELL_BACKWARD
    assert operations["distance weight"] == 16 * 64 * floor.BAND_PIXEL
    assert operations["compositing"] == (12 * 64 + 4) * floor.BLEND_PIXEL
    assert operations["error"] == 16 * 64 * floor.ERROR_PIXEL
    assert operations["Xing, Adam"] == 4 * floor.XING_SEGMENT + (6 * 4 + 4) * floor.PARAMETER
    whole = floor.floor(found)
    assert whole.operations == sum(operations.values())
    assert whole.bytes == 16 * 64 * (floor.TARGET_PIXEL + floor.CLOSENESS_PIXEL) + 28 * floor.PARAMETER_BYTES


def test_limit_is_the_slower_of_computing_and_moving() -> None:
    # On the reference machine the peak is 200 GFLOP/s. 1 800 bytes are what a copy of 1 000 moves, more is not.
    assert Floor(2e9, 0, 0).limit_ms(MACHINE) == pytest.approx(10)
    assert Floor(0, 1800, 1800).limit_ms(MACHINE) == pytest.approx(1800 / 50e6)
    assert Floor(0, 2200, 2200).limit_ms(MACHINE) == pytest.approx(2200 / 10e6)
    assert Floor(0, 99000, 99000).limit_ms(MACHINE) == pytest.approx(99000 / 10e6)
    both = Floor(2e6, 1800, 1800).times(3) + Floor(1e6, 2200, 2200)
    assert both == Floor(7e6, 7600, 2200)


def test_calibration_is_positive(device: int | None) -> None:
    opened = open_device(device)
    for sums in (calibration.REFERENCE_SUMS, calibration.PEAK_SUMS):
        assert calibration.MultiplyAdd(opened, sums).rate() > 0
    assert calibration.copy_rate(opened, calibration.COPY_BYTES[0]) > 0


def test_times_are_scaled_by_the_rate_beside_them() -> None:
    rates = iter([30.0, 30.0, 60.0, 60.0])
    seconds = iter([0.04, 0.02])

    def work() -> float:
        time.sleep(1.1 * repeats.BLOCK)  # a block each
        return next(seconds)

    found = repeats.repeated(work, lambda: next(rates), 2).summary()
    # 0.04 s between 30 and 30 GFLOP/s, 0.02 s between 30 and 60.
    assert found["repeats"] == 2
    assert found["median_ms"] == pytest.approx(30)
    assert found["minimum_ms"] == pytest.approx(20)
    assert found["scaled_ms"] == pytest.approx((40 * 30 + 20 * 45) / 2 / REFERENCE_GFLOPS)


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


def _small_state() -> tuple[np.ndarray, State]:
    drawing = Drawing(points=square(6.3, 25.8), colors=[[0.8, 0.2, 0.1, 0.9]], size=(32, 32))
    return np.full((32, 32, 3), 0.5, np.float32), State.start(drawing, Options.paper(), (1,), 0)


def test_check_passes_what_is_right(device: int | None) -> None:
    image, state = _small_state()
    found = checks.check_step(image, state, device)
    assert found["loss"] < checks.LOSS_TOLERANCE
    assert all(math.isfinite(error) for error in found.values())


def test_scene_files_keep_what_a_step_needs(tmp_path: Path) -> None:
    _, state = _small_state()
    rng = np.random.default_rng(0)
    for adam in (state.points, state.colors):
        adam.mean, adam.square = rng.normal(size=adam.mean.shape), rng.uniform(size=adam.mean.shape)
        adam.ages += 7
    state.iteration = 7
    scene_file.save_scene(tmp_path / "scene.npz", state)
    found = scene_file.load_scene(tmp_path / "scene.npz")
    assert (found.schedule, found.stage, found.iteration) == ((1,), 0, 7)
    assert found.options == state.options
    np.testing.assert_array_equal(found.drawing.points, state.drawing.points)
    np.testing.assert_array_equal(found.drawing.stages, state.drawing.stages)
    for name in ("points", "colors", "background"):
        for moment, values in vars(getattr(state, name)).items():
            np.testing.assert_array_equal(getattr(getattr(found, name), moment), values)


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
    image, state = _small_state()
    with pytest.raises(checks.CheckError, match=wrong):
        checks.check_step(image, state, device)


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
    ("value", "text"), [(None, "-"), (0, "0"), (1234.5, "1234"), (12.345, "12.3"), (0.0000123, "0.0000123")]
)
def test_numbers(value: float | None, text: str) -> None:
    assert table.number(value) == text


def test_tables() -> None:
    found = table.Table("Times", ["case", "ms"], [["one", "1"], ["twelve", "12"]])
    assert found.text() == "Times\ncase    ms\none      1\ntwelve  12"
    assert found.markdown() == "**Times**\n\n| case | ms |\n| --- | --: |\n| one | 1 |\n| twelve | 12 |"


def _results(scaled_ms: float) -> results.Results:
    times = {"repeats": 3, "median_ms": 8.0, "minimum_ms": 7.0, "mean_ms": 8.5, "scaled_ms": scaled_ms, "gflops": 30.0}
    machine = {
        **dict.fromkeys(("livecl", "commit", "device", "driver", "processor", "system", "python"), "?"),
        **MACHINE,
        "packages": {"numpy": "2"},
        "compute_units": 2,
        "cores": 2,
        "load": 0.0,
    }
    step = {"floor": dataclasses.asdict(Floor(2e8, 0, 0)), "time": times, "checked": {}}
    return {
        "format": results.FORMAT,
        "when": "now",
        "machine": machine,
        "cases": {"8": step, "import": {"failed": "no module"}},
    }


def test_report_states_limit_ratio_and_failure(tmp_path: Path) -> None:
    results.save(_results(8.0), tmp_path / "kept" / "before.json")
    now = _results(4.0)
    results.put_limits(now)
    assert now["cases"]["8"]["limit_ms"] == pytest.approx(1)
    assert now["cases"]["8"]["times_limit"] == pytest.approx(4)
    now["compared"] = {"name": "before", "cases": results.load(tmp_path / "kept" / "before.json")["cases"]}
    text = report.text(now, markdown=False)
    assert results.failures(now) == ["import: no module"]
    assert "import: no module" in text
    row = next(line.split() for line in text.splitlines() if line.startswith("8 paths"))
    assert row[-2:] == ["8", "0.5"]
    assert "| 8 paths, 240x240 | 8 | 7 |" in report.text(now, markdown=True)


@pytest.mark.parametrize("text", ["", "[]", '{"format": 0}'])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "other.json").write_text(text)
    with pytest.raises(ValueError, match=r"other\.json"):
        results.load(tmp_path / "other.json")


def _bench(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(ROOT / "tools" / "bench.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def test_bad_arguments() -> None:
    for arguments in (["--cases", "7"], ["--compare", "none"], ["--repeats", "0"], ["--compare-checkout", "nowhere"]):
        ended = _bench(*arguments)
        assert ended.returncode == 2, ended.stderr
        assert "Traceback" not in ended.stderr


@pytest.mark.slow
def test_run_of_the_smallest_cases(tmp_path: Path, device: int | None) -> None:
    written = tmp_path / "found.json"
    chosen = [] if device is None else ["--device", str(device)]
    ended = _bench("--cases", "1,import", "--repeats", "2", "--json", str(written), *chosen)
    assert ended.returncode == 0, ended.stderr
    found = json.loads(written.read_text())
    assert found["format"] == results.FORMAT
    assert found["machine"]["packages"]["numpy"] == np.__version__
    step = found["cases"]["1"]
    assert step["time"]["repeats"] == 2
    assert 0 < step["time"]["minimum_ms"] <= step["time"]["median_ms"]
    assert step["limit_ms"] > 0
    assert step["memory_mb"] > 0
    assert step["checked"]["loss"] < checks.LOSS_TOLERANCE
    assert step["host"]["missing"] == []
    assert step["kernels"]["ms"]
    assert all(ms >= 0 for ms in step["kernels"]["ms"].values())
    assert step["placement"]["paths"] == 1
    assert found["cases"]["import"]["time"]["repeats"] == 2
    assert "1 path, 240x240" in ended.stdout
