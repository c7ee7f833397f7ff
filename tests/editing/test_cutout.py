# SPDX-License-Identifier: Apache-2.0
"""Layers that do not overlap: the same picture, exact where edges are seen, with a trap below neighbours."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support import drawings, shapes

from livecl import cli
from livecl.cli.arguments import layers_of
from livecl.drawing import Drawing, Fills, Strokes
from livecl.drawing.fills import concatenate_fills
from livecl.editing import cutout
from livecl.rendering import Rasterizer, render
from livecl.run.recipe import Recipe
from livecl.svg import read_svg

RED, BLUE, GREEN, CLEAR = (1, 0, 0, 1), (0, 0, 1, 1), (0, 0.6, 0, 1), (0, 0, 0, 0.5)

needs_pathops = pytest.mark.skipif(importlib.util.find_spec("pathops") is None, reason="skia-pathops is not installed")


def overlap(drawing: Drawing) -> float:
    """Area, px^2, that is covered twice."""
    return float(np.maximum(Rasterizer(drawing.size).coverages(drawing).sum(axis=0) - 1, 0).sum())


def random_scene(seed: int) -> Drawing:
    rng = np.random.default_rng(seed)
    layers = []
    for k in range(8):
        center, radius = rng.uniform(20, 80, 2), float(rng.uniform(6, 30))
        outline = [drawings.blob(seed + k, (float(center[0]), float(center[1])), radius)]
        layers.append((outline if k % 2 else [shapes.circle(tuple(center), radius)], (*rng.random(3), 1.0)))
    return drawings.build(layers, (100, 100))


@needs_pathops
def test_a_layer_that_cannot_be_cut_stays_whole_and_is_named(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    import pathops

    def fails(*_: object) -> None:
        raise pathops.PathOpsError("no curve")

    monkeypatch.setattr(pathops, "op", fails)
    drawing = drawings.build([([shapes.circle((30, 30), 15)], RED), ([shapes.circle((42, 30), 15)], BLUE)], (60, 70))
    cut = cutout.cut_out(drawing, 0)
    np.testing.assert_array_equal(render(cut), render(drawing))
    assert "layer 0 could not be cut, and stays whole" in caplog.text


@needs_pathops
@pytest.mark.parametrize("seed", range(8))
def test_nothing_overlaps_and_the_picture_stays(seed: int) -> None:
    drawing = random_scene(seed)
    cut = cutout.cut_out(drawing, 0)
    assert overlap(drawing) > 100 and overlap(cut) < 0.3
    coverages = Rasterizer(drawing.size).coverages
    np.testing.assert_allclose(coverages(cut).sum(axis=0), coverages(drawing).max(axis=0), atol=0.5)
    union = 1 - np.prod(1 - coverages(drawing).astype(np.float64), axis=0)
    assert coverages(cut).sum() == pytest.approx(union.sum(), rel=0.01)
    trapped = cutout.cut_out(drawing, 1.0)
    assert np.mean(np.square(render(trapped) - render(drawing))) < 2e-5
    assert trapped.num_segments < 4 * drawing.num_segments


@needs_pathops
def test_the_trap_is_as_wide_as_asked_for() -> None:
    """A disc on a larger one: the overlap is a ring of the trap's width within its edge, to .02 px."""
    drawing = drawings.build([([shapes.circle((40, 40), 30)], RED), ([shapes.circle((45, 40), 12)], BLUE)], (80, 80))
    for trap in (0.25, 0.5, 2.0):
        ring = np.pi * (12**2 - (12 - trap) ** 2)
        assert overlap(cutout.cut_out(drawing, trap)) == pytest.approx(ring, abs=0.02 * 2 * np.pi * 12)


@needs_pathops
def test_what_is_not_cut_stays_as_it_is_and_what_is_hidden_goes() -> None:
    layers = [
        ([shapes.circle((30, 30), 10)], GREEN),  # hidden
        ([drawings.rectangle(10, 10, 50, 50)], RED),
        ([drawings.rectangle(40, 5, 70, 30)], BLUE),
        ([shapes.circle((20, 45), 12)], CLEAR),  # translucent: neither cut nor cutting
        ([shapes.circle((90, 60), 8)], GREEN),
    ]
    shade = Fills.linear((10, 0), (50, 0), [(1, 0, 0, 1), (1, 1, 0, 1)])
    drawing = drawings.build(layers, (80, 110)).replace(
        fills=concatenate_fills([Fills.solid(1), shade, Fills.solid(3)]),
        groups=[["a"], ["a"], ["b", "c"], [], []],
        stages=[0, 1, 2, 3, 4],
    )
    cut = cutout.cut_out(drawing)
    assert cut.names == drawing.labels[1:]  # of the whole shapes
    assert cut.groups == drawing.groups[1:] and cut.stages.tolist() == [1, 2, 3, 4]
    assert cut.fills.kinds.tolist() == [1, 0, 0, 0]
    for layer in (1, 2, 3):
        rows, before = cut.subpaths(layer)[0], drawing.subpaths(layer + 1)[0]
        np.testing.assert_array_equal(cut.points[rows], drawing.points[before])
    corners = cut.points[cut.subpaths(0)[0], 0]
    assert len(corners) == 6  # a square without a corner: lines stay lines
    np.testing.assert_allclose(sorted(corners.tolist())[-2:], [[50, 29.5], [50, 50]], atol=1e-4)


@needs_pathops
def test_strokes_cut_and_become_outlines_where_they_are_cut() -> None:
    line = np.array([[[5, 20], [25, 20], [45, 20]], [[75, 20], [75, 20], [75, 20]]], float)
    layers = [([drawings.rectangle(5, 30, 75, 50)], RED), ([line], BLUE), ([drawings.rectangle(30, 5, 50, 26)], GREEN)]
    lower = line + np.array([0, 20])
    drawing = drawings.build([*layers, ([lower], BLUE)], (60, 80)).replace(
        strokes=Strokes(widths=[0, 4, 0, 4], is_open=[False, True, False, True])
    )
    cut = cutout.cut_out(drawing, 0)
    assert cut.strokes.widths.tolist() == [0, 0, 0, 4]
    assert overlap(cut) < 0.1
    assert np.diff(cut.layer_offsets).tolist() == [2, 2, 1, 1]  # the rectangle and the first line are in two parts
    np.testing.assert_allclose(render(cut), render(drawing), atol=2e-3)


@needs_pathops
def test_the_command_writes_cut_layers(tmp_path: Path) -> None:
    image = render(
        drawings.build([([shapes.circle((30, 30), 22)], RED), ([shapes.circle((36, 30), 9)], BLUE)], (60, 60))
    )
    Image.fromarray(np.rint(image * 255).astype(np.uint8)).save(tmp_path / "in.png")
    base = [str(tmp_path / "in.png"), "--preset", "draft", "--iterations", "5", "-q"]
    for layers, name in (("cutout", "a.svg"), ("plain,cutout", "b.svg"), ("stacked", "c.svg")):
        assert cli.main([*base, "-o", str(tmp_path / name), "--layers", layers, "--json", str(tmp_path / "j")]) == 0
        drawing, facts = read_svg(tmp_path / name), json.loads((tmp_path / "j").read_text())
        assert drawing.num_layers == 2
        trap = np.pi * (9**2 - 8.5**2)
        assert overlap(drawing) == pytest.approx(np.pi * 81 if layers == "stacked" else trap, rel=0.06)
        assert ("inkscape" in (tmp_path / name).read_text()) == (layers != "plain,cutout")
        assert facts["mse"] < 1e-3


def test_words_of_layers() -> None:
    assert layers_of("inkscape") == layers_of("stacked") == ("inkscape", False)
    assert layers_of("cutout,plain") == ("plain", True)


@pytest.mark.parametrize("text", ["plain,inkscape", "cutout,stacked", "flat", ""])
def test_other_words_of_layers_are_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["in.png", "-o", "out.svg", f"--layers={text}"]) == 2
    assert "wanted inkscape or plain, stacked or cutout, or both, as plain,cutout" in capsys.readouterr().err


def test_without_the_module_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutout.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=re.escape("layers: cutout needs skia-pathops: pip install 'livecl[cutout]'")):
        Recipe(cutout=True)
    Recipe()
