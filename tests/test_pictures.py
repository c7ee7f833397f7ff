# SPDX-License-Identifier: Apache-2.0
"""Stage sheets and plots."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from livecl import LiveclError, Options, Result, vectorize
from livecl.image import read_image
from livecl.pictures import CHECKERBOARD, SQUARE, fitted_size, over_checkerboard, save_plot, save_sheet, stage_sheet

SIZE = (48, 48)


def square() -> NDArray[np.float32]:
    image = np.ones((*SIZE, 3), np.float32)
    image[10:38, 14:40] = 0.8, 0.2, 0.2
    image[18:28, 4:24] = 0.2, 0.4, 0.8
    return image


@pytest.fixture(scope="module")
def result() -> Result:
    options = Options(iterations=6, revisions=0, prune=0.0, background="white")
    return vectorize(square(), paths=2, schedule=[1, 1], options=options)


def holds(sheet: NDArray[np.float32], picture: NDArray[np.float32]) -> bool:
    """Whether a picture is somewhere in a sheet, to within a level of 8 bits."""
    height, width = picture.shape[:2]
    rows, columns = sheet.shape[0] - height + 1, sheet.shape[1] - width + 1
    return any(
        np.abs(sheet[row : row + height, column : column + width] - picture).max() < 1.01 / 255
        for row in range(rows)
        for column in range(columns)
    )


def test_sheet_holds_the_target_and_each_stage(result: Result) -> None:
    from livecl.rasterizer import Rasterizer

    sheet = stage_sheet(square(), result, cell=48)
    assert sheet.dtype == np.float32 and sheet.shape[2] == 3
    assert sheet.min() >= 0 and sheet.max() <= 1
    rasterizer = Rasterizer(SIZE)
    assert holds(sheet, square())
    for stage in result.stages:
        assert holds(sheet, rasterizer.forward(stage.drawing))


def test_sheet_wraps(result: Result) -> None:
    one_row, one_column = (stage_sheet(square(), result, cell=48, columns=count) for count in (3, 1))
    assert one_row.shape == (one_column.shape[0] // 3, one_column.shape[1] * 3, 3)
    # Without a wish three pictures make one row, and eight two rows of four.
    np.testing.assert_array_equal(stage_sheet(square(), result, cell=48), one_row)
    many = dataclasses.replace(result, stages=(result.stages * 4)[:7])
    cell = one_row.shape[0], one_row.shape[1] // 3
    assert stage_sheet(square(), many, cell=48).shape[:2] == (2 * cell[0], 4 * cell[1])


def test_sheet_as_file(result: Result, tmp_path: Path) -> None:
    path = tmp_path / "sheet.png"
    save_sheet(path, square(), result, cell=48)
    expected = np.rint(stage_sheet(square(), result, cell=48) * 255)
    np.testing.assert_array_equal(np.rint(read_image(path)[..., :3] * 255), expected)


def test_transparent_parts_show_a_checkerboard(result: Result) -> None:
    clear = dataclasses.replace(result, stages=())
    target = np.dstack([square(), np.zeros(SIZE, np.float32)])
    board = over_checkerboard(np.zeros((*SIZE, 4)))
    assert board[0, 0, 0] == np.float32(CHECKERBOARD[0]) and board[0, SQUARE, 0] == np.float32(CHECKERBOARD[1])
    assert holds(stage_sheet(target, clear, cell=48), board)
    # Half of the light of a premultiplied grey, half of the white square beneath it.
    assert over_checkerboard(np.full((1, 1, 4), 0.5))[0, 0].tolist() == [1.0, 1.0, 1.0]
    np.testing.assert_array_equal(over_checkerboard(square()), square())


@pytest.mark.parametrize(("size", "fit"), [((48, 48), (96, 96)), ((100, 300), (32, 96)), ((1, 1000), (1, 96))])
def test_fitted_size(size: tuple[int, int], fit: tuple[int, int]) -> None:
    assert fitted_size(size, 96) == fit


@pytest.mark.parametrize("wrong", [{"cell": 0}, {"columns": 0}, {"columns": 1.5}, {"cell": True}])
def test_sheet_refuses(result: Result, wrong: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(wrong))}: got .*, wanted a whole number of at least 1"):
        stage_sheet(square(), result, **wrong)


def test_sheet_refuses_other_sizes(result: Result) -> None:
    from livecl.rasterizer import Rasterizer

    with pytest.raises(ValueError, match=r"image: .* wanted the drawing's"):
        stage_sheet(square()[:40], result)
    with pytest.raises(ValueError, match=r"rasterizer: size \(48, 48\), wanted \(96, 96\)"):
        stage_sheet(square(), result, cell=96, rasterizer=Rasterizer(SIZE))


def test_plot_by_suffix(result: Result, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    save_plot(tmp_path / "plot.svg", result)
    save_plot(tmp_path / "plot.PNG", result)
    assert ElementTree.parse(tmp_path / "plot.svg").getroot().tag == "{http://www.w3.org/2000/svg}svg"
    with Image.open(tmp_path / "plot.PNG") as picture:
        assert picture.format == "PNG" and picture.size == (720, 518)
    for name in ("plot.svg", "plot.PNG"):
        again = tmp_path / f"again-{name}"
        save_plot(again, result)
        assert again.read_bytes() == (tmp_path / name).read_bytes()


def test_plot_of_no_error(result: Result, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    exact = dataclasses.replace(result, stages=(dataclasses.replace(result.stages[0], mse=0.0),))
    save_plot(tmp_path / "plot.svg", exact)
    assert (tmp_path / "plot.svg").stat().st_size > 0


def test_plot_refuses_other_suffixes(result: Result, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"path: got .*plot\.pdf', wanted a file name that ends in \.png or \.svg"):
        save_plot(tmp_path / "plot.pdf", result)
    assert not (tmp_path / "plot.pdf").exists()


def test_plot_names_its_extra(result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(LiveclError, match=r"livecl\[plots\]"):
        save_plot(tmp_path / "plot.png", result)
