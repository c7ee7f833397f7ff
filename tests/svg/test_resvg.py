# SPDX-License-Identifier: Apache-2.0
"""What is read is what another renderer shows: drawn files, one for each feature of SVG that is read."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import compare_svg
import numpy as np
import pytest
from support import drawings

import livecl
from livecl.svg import LayerStyle, format_svg

FILES = sorted((Path(__file__).parent / "files").glob("*.svg"))


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_shown_as_resvg_shows_it(path: Path) -> None:
    """Read without a warning; the tool derives the bounds. The files' edges lie anywhere: a third of the worst."""
    pytest.importorskip("resvg_py")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawing = livecl.read_svg(path)
    picture = compare_svg.shown_by_resvg(path.read_text())
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
    ring = [drawings.circle((20, 20), 15), drawings.reverse(drawings.circle((20, 20), 6))]
    drawing = drawings.build([(ring, (0.2, 0.4, 0.6, 1.0))], (40, 40), None)
    picture = compare_svg.rendered(drawing)
    assert compare_svg.differences(drawing, picture) == (0, 0, 0)
    moved = drawing.replace(points=drawing.points + 0.25)
    assert compare_svg.differences(moved, picture)[1] > compare_svg.EDGE
    filled = drawings.build([(ring[:1], (0.2, 0.4, 0.6, 1.0))], (40, 40), None)
    assert compare_svg.differences(filled, picture)[2] == 255
    colors = drawing.colors + np.array([0.02, 0, 0, 0])
    assert compare_svg.differences(drawing.replace(colors=colors), picture)[2] == pytest.approx(0.02 * 255, rel=1e-3)


def test_table(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("resvg_py")
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="20" height="20">'
    (tmp_path / "good.svg").write_text(f'{head}<circle cx="9" cy="9" r="5"/></svg>')
    (tmp_path / "text.svg").write_text(f"{head}<text>a</text></svg>")
    (tmp_path / "cut.svg").write_text(f"{head}<circle")
    monkeypatch.setattr(sys, "argv", ["compare_svg.py", str(tmp_path)])
    assert compare_svg.main() == 0
    output = capsys.readouterr().out
    assert "3 files: 1 read in full, 0 of them shown otherwise; 1 with a warning, 1 refused, 0 not compared." in output
    rows = [line.split(" | ") for line in output.splitlines() if line.startswith(f"| {tmp_path}")]
    assert [Path(row[0][2:]).name for row in rows] == ["good.svg", "cut.svg", "text.svg"]
    assert [row[5].strip(" |") for row in rows][2] == "text (1)"
    monkeypatch.setattr(compare_svg, "EDGE", 0.0)
    assert compare_svg.main() == 1
