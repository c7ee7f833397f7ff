# SPDX-License-Identifier: Apache-2.0
"""Sheets of stages, and the plot of the error."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest
from support.results import result_of, sample

from livecl import LiveclError, Rasterizer, read_image
from livecl.drawing.assembly import empty_drawing
from livecl.views.sheet import (
    CHECKERBOARD,
    count_of,
    fitted_size,
    over_checkerboard,
    resized,
    save_plot,
    save_sheet,
    stage_sheet,
)


def pictures_in(sheet: np.ndarray, size: tuple[int, int], wanted: np.ndarray) -> int:
    """Return how often a picture occurs in a sheet, as it is but for rounding to 8 bits."""
    windows = np.lib.stride_tricks.sliding_window_view(sheet, (*size, 3))[:, :, 0]
    corner = np.all(np.abs(windows[:, :, 0, 0] - wanted[0, 0]) <= 1 / 255, axis=-1)
    return sum(bool(np.abs(windows[y, x] - wanted).max() <= 0.6 / 255) for y, x in np.argwhere(corner))


@pytest.mark.parametrize("background", [(0.9, 0.9, 0.8), None])
def test_sheet_shows_target_and_stages(background: tuple[float, ...] | None) -> None:
    image, result = sample(background)
    sheet = stage_sheet(image, result)
    assert sheet.dtype == np.float32
    assert sheet.shape[2] == 3
    assert 0 <= sheet.min() < sheet.max() == 1
    rasterizer = Rasterizer(result.drawing.size)
    for stage in result.stages:
        # Of one size with the cell: rendered as it is.
        wanted = over_checkerboard(rasterizer.forward(stage.drawing))
        assert pictures_in(sheet, stage.drawing.size, wanted) == 1


def test_sheet_wraps_and_scales() -> None:
    image, result = sample()
    cell = stage_sheet(image, dataclasses.replace(result, stages=()))
    many = dataclasses.replace(result, stages=result.stages * 4)
    shape = np.array(stage_sheet(image, many).shape[:2])  # 9 pictures: 5 and 4
    single = np.array(stage_sheet(image, many, columns=1).shape[:2])
    assert shape.tolist() == [2 * single[0] // 9, 5 * single[1]]
    assert cell.shape[0] == single[0] // 9
    assert stage_sheet(image, many, columns=20).shape[1] == 9 * single[1]
    small = stage_sheet(image, result, cell=48)
    assert pictures_in(small, (48, 40), over_checkerboard(np.asarray(resized(image, (48, 40))) / np.float32(255))) == 1


def test_sheet_is_saved(tmp_path: Path) -> None:
    image, result = sample()
    save_sheet(tmp_path / "a.png", image, result, cell=100)
    np.testing.assert_allclose(read_image(tmp_path / "a.png"), stage_sheet(image, result, cell=100), atol=1e-6)


def test_sheet_of_odd_shapes() -> None:
    for size in ((1, 1), (2, 300), (300, 2)):
        image = np.full((*size, 3), 0.25)
        sheet = stage_sheet(image, result_of(empty_drawing(size), image))
        assert np.isfinite(sheet).all()
        assert np.any(np.abs(sheet - 0.25).max(axis=2) < 1 / 255)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"cell": 0}, "cell: got 0"), ({"columns": 1.5}, "columns: got 1.5"), ({"cell": True}, "cell: got True")],
)
def test_bad_arguments(arguments: dict[str, int], message: str) -> None:
    image, result = sample()
    with pytest.raises(ValueError, match=message):
        stage_sheet(image, result, **arguments)
    with pytest.raises(ValueError, match=r"image: .* wanted the drawing's \(240, 200\)"):
        stage_sheet(image[1:], result)


def test_checkerboard() -> None:
    clear = over_checkerboard(np.zeros((17, 17, 4), np.float32))
    light, dark = CHECKERBOARD
    assert clear[[0, 0, 8, 8, 16], [0, 8, 0, 8, 16], 0].tolist() == pytest.approx([light, dark, dark, light, light])
    opaque = np.concatenate([np.full((3, 3, 3), 0.3), np.ones((3, 3, 1))], axis=2)
    np.testing.assert_allclose(over_checkerboard(opaque), 0.3, rtol=1e-6)


def test_fitting() -> None:
    assert fitted_size((100, 50), 240) == (240, 120)
    assert fitted_size((1, 1000), 100) == (1, 100)
    squares = np.asarray(resized(np.array([[[0, 0, 0.0], [1, 1, 1]]]), (2, 4)))
    assert squares[:, :, 0].tolist() == [[0, 0, 255, 255]] * 2
    assert [count_of(0, "path"), count_of(1, "path"), count_of(2, "path")] == ["0 paths", "1 path", "2 paths"]


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_plot(tmp_path: Path, suffix: str) -> None:
    pytest.importorskip("matplotlib")
    _, result = sample()
    for name in ("a", "b"):
        save_plot(tmp_path / f"{name}.{suffix}", result)
    content = (tmp_path / f"a.{suffix}").read_bytes()
    assert content == (tmp_path / f"b.{suffix}").read_bytes()
    if suffix == "svg":
        assert b"mean squared error" in content
        assert b"dc:date" not in content
    else:
        assert read_image(content)[..., 2].min() < 0.9
    exact = dataclasses.replace(result, stages=tuple(dataclasses.replace(s, mse=0.0) for s in result.stages))
    save_plot(tmp_path / f"c.{suffix}", exact)
    assert (tmp_path / f"c.{suffix}").read_bytes() != content


def test_plot_of_another_kind(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"path: .*a.pdf', wanted a file name that ends in .png or .svg"):
        save_plot(tmp_path / "a.pdf", sample()[1])


def test_plot_without_matplotlib(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(LiveclError, match=r"pip install 'livecl\[plots\]'"):
        save_plot(tmp_path / "a.png", sample()[1])
    assert not (tmp_path / "a.png").exists()
