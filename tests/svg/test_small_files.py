# SPDX-License-Identifier: Apache-2.0
"""SVG files that readers get wrong without a word, or refuse whole: each is right, or a warning says so."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from livecl import read_svg, render

GREEN, BLUE = (0.0, 0.5, 0.0), (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("name", "color", "warning"),
    [
        ("s02_style_comment", (0.0, 160 / 255, 0.0), ""),
        ("s03_background_color", (1.0, 1.0, 0.0), ""),
        ("s04_systemlanguage", GREEN, ""),
        ("s05_style_type", GREEN, ""),
        ("s06_illustrator_entities", None, ""),
        ("s07_only_height", None, "side"),
        ("s08_em_size", (0.0, 0.0, 0.0), ""),
        ("s09_self_use", None, "uses of"),
        ("s10_no_path_data", BLUE, ""),
        ("s12_bad_tail", BLUE, "errors"),
    ],
)
def test_small_files(
    name: str, color: tuple[float, ...] | None, warning: str, data_dir: pathlib.Path, recwarn: pytest.WarningsRecorder
) -> None:
    file = data_dir.parent / "cases" / f"{name}.svg"
    if not file.is_file():
        pytest.skip("the small inputs (../shared/cases) are not here")
    drawing = read_svg(file)
    said = [str(entry.message) for entry in recwarn]
    assert len(said) == bool(warning) and all(warning in text for text in said)
    assert drawing.num_layers == 1
    image = render(drawing)
    middle = image[image.shape[0] // 2, image.shape[1] // 2]
    if color is not None:
        np.testing.assert_allclose(middle[:3] / (middle[3] if len(middle) == 4 else 1), color, atol=0.01)
    if name.startswith("s03"):
        np.testing.assert_allclose(image[0, 0], (0, 0, 85 / 255), atol=0.01)
