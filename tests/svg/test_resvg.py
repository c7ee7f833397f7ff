# SPDX-License-Identifier: Apache-2.0
"""What is read is what another renderer shows: drawn files, one for each feature of SVG that is read."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import compare_svg
import numpy as np
import pytest
import sweep_svg
from support import drawings, shapes

import livecl
from livecl.image import save_image
from livecl.svg import LayerStyle, format_svg

FILES = sorted((Path(__file__).parent / "files").glob("*.svg"))


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_shown_as_resvg_shows_it(path: Path) -> None:
    """Read without a warning; the tool derives the bounds. The files' edges lie anywhere: a third of the worst."""
    pytest.importorskip("resvg_py")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawing = livecl.read_svg(path)
    picture = compare_svg.shown_by_resvg(path.read_text(encoding="utf-8"))
    assert picture.shape[:2] == drawing.size
    assert (picture[..., 3] > 0).mean() > 0.05
    _, edge, flat = compare_svg.differences(drawing, picture)
    assert edge < compare_svg.EDGE / 3
    assert flat < compare_svg.FLAT


@pytest.mark.parametrize("layers", ["inkscape", "plain"])
def test_drawn_files_come_back_the_same(layers: LayerStyle) -> None:
    for path in FILES:
        text = format_svg(livecl.read_svg(path), layers=layers)
        assert format_svg(livecl.read_svg(text.encode()), layers=layers) == text, path.stem


def test_the_measure_sees_what_is_wrong() -> None:
    """A quarter of a pixel, a missing hole and a wrong colour; and nothing in a drawing's own picture."""
    ring = [shapes.circle((20, 20), 15), drawings.reverse(shapes.circle((20, 20), 6))]
    drawing = drawings.build([(ring, (0.2, 0.4, 0.6, 1.0))], (40, 40), None)
    picture = compare_svg.rendered(drawing)
    assert compare_svg.differences(drawing, picture) == (0, 0, 0)
    moved = drawing.replace(points=drawing.points + 0.25)
    assert compare_svg.differences(moved, picture)[1] > compare_svg.EDGE
    filled = drawings.build([(ring[:1], (0.2, 0.4, 0.6, 1.0))], (40, 40), None)
    assert compare_svg.differences(filled, picture)[2] == 255
    colors = drawing.colors + np.array([0.02, 0, 0, 0])
    assert compare_svg.differences(drawing.replace(colors=colors), picture)[2] == pytest.approx(0.02 * 255, rel=1e-3)


def test_sweep(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A file of each outcome: where a PNG lies beside a file, it is the reference; a suite's frame is taken out."""
    pytest.importorskip("resvg_py")
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="20" height="20">'
    frame = '<rect id="frame" x="1" y="1" width="18" height="18" fill="none" stroke="black"/>'
    files = {
        "right": f'{head}<circle cx="9" cy="9" r="5"/></svg>',
        "framed": f'{head}<circle cx="9" cy="9" r="5"/>{frame}</svg>',
        "masked": f'{head}<circle cx="9" cy="9" r="5" mask="url(#m)"/><mask id="m"/></svg>',
        "cut": f"{head}<circle",
        "wrong": f'{head}<circle cx="9" cy="9" r="5"/></svg>',
    }
    for name, text in files.items():
        (tmp_path / f"{name}.svg").write_text(text)
    save_image(tmp_path / "framed.png", framed := shown(files["framed"], 40))
    save_image(tmp_path / "wrong.png", framed)
    row = f"| {tmp_path} | 5 | {{}} | 1 (0) | 1 | {{}} | 0 |"
    monkeypatch.setattr(sys, "argv", ["sweep_svg.py", str(tmp_path)])
    assert sweep_svg.main() == 1
    output = capsys.readouterr().out
    assert row.format(2, 1) in output
    assert f"wrong: {tmp_path / 'wrong.svg'} (1 layers" in output
    (tmp_path / "known.txt").write_text("wrong.svg  # its picture has a frame\n")
    monkeypatch.setattr(sys, "argv", ["sweep_svg.py", str(tmp_path), "--known", str(tmp_path / "known.txt")])
    assert sweep_svg.main() == 0
    assert row.format(3, 0) in capsys.readouterr().out


def shown(text: str, side: int) -> np.ndarray:
    """Return resvg's picture of an SVG in straight RGBA."""
    picture = compare_svg.shown_by_resvg(text, None, side, side)
    alpha = picture[..., 3:]
    return np.concatenate([picture[..., :3] / np.maximum(alpha, 1 / 255), alpha], axis=2)
