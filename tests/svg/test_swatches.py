# SPDX-License-Identifier: Apache-2.0
"""Swatches: one a colour, shown as the colour by every renderer, and read back as one."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from support import chromium, drawings, shapes

from livecl.drawing import Drawing, Fills, Strokes
from livecl.drawing.fills import concatenate_fills
from livecl.image.reading import over_background, read_image
from livecl.rendering import render
from livecl.svg import format_svg, quantize, read_svg

ORANGE, BLUE = (1.0, 0.5, 0.0, 1.0), (0.0, 0.2, 0.8, 128 / 255)


def sample() -> Drawing:
    """Two discs of one colour, a translucent one, a gradient, and a level stroke, which has no height."""
    layers = [
        ([shapes.circle((20, 20), 12)], ORANGE),
        ([shapes.circle((60, 20), 12)], ORANGE),
        ([shapes.circle((40, 25), 15)], BLUE),
        ([drawings.rectangle(5, 45, 75, 55)], ORANGE),
        ([np.array([[[8, 65], [30, 65], [50, 65]], [[72, 65], [72, 65], [72, 65]]], float)], ORANGE),
    ]
    shade = Fills.linear((5, 45), (75, 45), [(1, 1, 0, 1), (1, 0, 0, 1)])
    drawing = drawings.build(layers, (75, 80), (0.9, 0.95, 1.0))
    return quantize(
        drawing.replace(
            fills=concatenate_fills([Fills.solid(3), shade, Fills.solid(1)]),
            strokes=Strokes(widths=[0, 0, 0, 0, 4], is_open=[False] * 4 + [True]),
        )
    )


def test_a_swatch_for_each_colour_and_read_back_equal() -> None:
    drawing = sample()
    text = format_svg(drawing, swatches=True)
    swatches = dict(re.findall(r'id="(swatch-[^"]+)" inkscape:swatch="solid".*?stop-color="(#\w+)"', text))
    assert swatches == {"swatch-light-blue": "#e6f2ff", "swatch-orange": "#ff8000", "swatch-blue": "#0033cc"}
    assert text.count("url(#swatch-orange)") == 3 and text.count("url(#swatch-blue)") == 1
    assert 'fill="#' not in text and 'stroke="#' not in text
    back = read_svg(text.encode())
    for name in ("points", "colors", "background"):
        np.testing.assert_array_equal(getattr(back, name), getattr(drawing, name))
    np.testing.assert_array_equal(back.fills.kinds, drawing.fills.kinds)
    assert format_svg(back, swatches=True) == text
    assert back.names == read_svg(format_svg(drawing).encode()).names


def test_one_change_of_a_swatch_recolours_all_that_has_it() -> None:
    text = format_svg(sample(), swatches=True).replace('stop-color="#ff8000"', 'stop-color="#00ff00"')
    back = read_svg(text.encode())
    np.testing.assert_array_equal(back.colors[[0, 1, 4], :3], [(0, 1, 0)] * 3)
    np.testing.assert_array_equal(back.colors[2], sample().colors[2])


def test_none_by_default_nor_in_plain_files() -> None:
    assert "swatch" not in format_svg(sample())
    assert format_svg(sample(), layers="plain", swatches=True) == format_svg(sample(), layers="plain")


@pytest.mark.parametrize("program", ["resvg", "cairo"])
def test_renderers_show_swatches_as_their_colours(program: str) -> None:
    import cairosvg
    import resvg_py

    def shown(text: str) -> np.ndarray:
        data = bytes(resvg_py.svg_to_bytes(svg_string=text)) if program == "resvg" else cairosvg.svg2png(text.encode())
        return read_image(data)

    np.testing.assert_array_equal(shown(format_svg(sample(), swatches=True)), shown(format_svg(sample())))


@pytest.mark.full
def test_chromium_and_inkscape_show_swatches_as_their_colours(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(format_svg(sample(), swatches=True))
    (tmp_path / "b.svg").write_text(format_svg(sample()))
    size = sample().size
    pictures = [chromium.screenshot(tmp_path / name, size) for name in ("a.svg", "b.svg")]
    np.testing.assert_allclose(*pictures, rtol=0, atol=1.01 / 255)  # blended by another path: one level
    if (inkscape := shutil.which("inkscape")) is None:
        pytest.skip("Inkscape is not installed")
    command = [inkscape, "--export-area-page", f"--export-filename={tmp_path / 'a.png'}", str(tmp_path / "a.svg")]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    image = over_background(read_image(tmp_path / "a.png"), np.ones(3))
    assert np.mean(np.square(image - render(sample()))) < 1e-4
    saved = [inkscape, "--export-type=svg", f"--export-filename={tmp_path / 'c.svg'}", str(tmp_path / "a.svg")]
    subprocess.run(saved, check=True, capture_output=True, timeout=120)
    np.testing.assert_array_equal(read_svg(tmp_path / "c.svg").colors, sample().colors)
