# SPDX-License-Identifier: Apache-2.0
"""Pictures of kinds that vectorizers get wrong: codes, logos in JPEG, shaded scans, banners of text, pale shapes."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from support.shapes import build, circle, rectangle

import livecl
from livecl import Drawing


@pytest.fixture(scope="module")
def cases(data_dir: pathlib.Path) -> pathlib.Path:
    """Return the folder of small inputs beside the sample pictures; skip where it is absent."""
    folder = data_dir.parent / "cases"
    if not folder.is_dir():
        pytest.skip("the small inputs (../shared/cases) are not here")
    return folder


def lost_marks(drawing: Drawing, image: NDArray[np.float32]) -> int:
    """Return how many dark marks of a picture, connected and of 8 px and more, the drawing shows less than half of."""
    marks, count = ndimage.label(image.mean(axis=2) < 0.4, np.ones((3, 3)))
    shown = ndimage.mean(livecl.render(drawing).mean(axis=2) < 0.55, marks, np.arange(1, count + 1))
    sizes = np.bincount(marks.ravel())[1:]
    assert (sizes >= 8).any()
    return int(((np.asarray(shown) < 0.5) & (sizes >= 8)).sum())


@pytest.mark.parametrize("levels", ["08", "12"])
def test_pale_shapes_stay_two(levels: str, cases: pathlib.Path) -> None:
    result = livecl.vectorize(cases / f"c27_low_contrast_{levels}.png")
    assert result.drawing.num_layers == 2 and result.mse < 1e-6


@pytest.mark.parametrize(("ground", "pale"), [((255, 255, 255), (253, 253, 253)), ((40, 80, 160), (44, 80, 160))])
def test_two_levels_from_the_ground_are_enough(ground: tuple[int, ...], pale: tuple[int, ...], device: int) -> None:
    shapes = [
        ([circle((26, 36), 18)], (*np.array(pale) / 255, 1)),
        ([rectangle(48, 18, 84, 54)], (*np.array(pale) / 255, 1)),
    ]
    image = np.round(livecl.render(build(shapes, (72, 96), np.array(ground) / 255), device) * 255) / 255
    result = livecl.vectorize(image.astype(np.float32))
    assert result.drawing.num_layers == 2 and result.mse < 1e-7


def test_ringing_of_a_jpeg_buys_no_paths(cases: pathlib.Path) -> None:
    result = livecl.vectorize(cases / "c10_logo_q30.jpg")
    assert result.drawing.num_layers <= 3 and result.mse < 1.5e-3


@pytest.mark.slow
def test_modules_of_a_code_are_all_right(cases: pathlib.Path) -> None:
    image = livecl.read_image(cases / "c08_qr.png")[..., :3]
    result = livecl.vectorize(image)
    assert result.mse < 3e-4
    assert ((livecl.render(result.drawing).mean(axis=2) < 0.5) == (image.mean(axis=2) < 0.5)).mean() > 0.999


@pytest.mark.slow
def test_marks_on_shaded_paper_survive_with_few_paths(cases: pathlib.Path) -> None:
    image = livecl.read_image(cases / "c12_scan_grey.png")[..., :3]
    result = livecl.vectorize(image, 8)
    assert lost_marks(result.drawing, image) == 0 and result.mse < 6e-4


@pytest.mark.slow
def test_letters_of_a_banner_survive(cases: pathlib.Path) -> None:
    image = livecl.read_image(cases / "c17_banner_text.png")[..., :3]
    result = livecl.vectorize(image)
    assert lost_marks(result.drawing, image) == 0 and result.mse < 1e-3
